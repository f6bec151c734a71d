//! Specs read and compiled, as files or texts.

use std::path::{Path, PathBuf};

use compiler::{Compiled, Report, Style};
use dsl::Syntax;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use runs::project::{self, Settings};

use crate::program::Program;

/// Width of rendered diagnostics in characters.
const WIDTH: usize = 100;

/// A spec: a file, or a text with its syntax and the folder in which its files are.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Source {
    /// The path of a file, or the name of a text in diagnostics.
    pub name: PathBuf,
    /// The text, if it is no file.
    pub text: Option<String>,
    /// Syntax of the text: `hq` or `yaml`.
    pub syntax: String,
    /// Folder of the text.
    pub folder: PathBuf,
}

/// Settings of a compilation: overridden params, and folders of packages.
pub(crate) fn settings(set: Vec<(String, String)>, package_paths: Vec<PathBuf>) -> Settings {
    Settings { set, package_paths }
}

/// Compiles a spec, with the rows marked that can never become active.
pub(crate) fn compiled(source: &Source, settings: &Settings) -> Compiled {
    let Some(text) = &source.text else { return project::load(&source.name, settings) };
    let syntax = if source.syntax == "yaml" { Syntax::Yaml } else { Syntax::Native };
    let name = source.name.display().to_string();
    let mut compiled = compiler::compile(&compiler::Input {
        name: &name,
        text,
        syntax,
        folder: Path::new(&source.folder),
        set: &settings.set,
        package_paths: &settings.package_paths,
    });
    if let Some(program) = &mut compiled.program {
        compiler::mark_idle_rows(program);
    }
    compiled
}

/// Diagnostics of a spec, as data and as text.
#[derive(IntoPyObject)]
pub(crate) struct Rendered {
    /// JSON, as of `hierarq check --json`.
    pub json: String,
    /// What `hierarq check` prints.
    pub text: String,
}

impl Rendered {
    pub(crate) fn new(report: &Report) -> Rendered {
        Rendered { json: report.to_json().to_string(), text: report.render(Style::Plain, WIDTH) }
    }
}

/// The program of a spec, unless it has errors, and its diagnostics.
///
/// # Errors
/// There is no such syntax.
#[pyfunction]
pub(crate) fn compile(
    py: Python<'_>,
    source: Source,
    set: Vec<(String, String)>,
    package_paths: Vec<PathBuf>,
) -> PyResult<(Option<Program>, Rendered)> {
    if !matches!(source.syntax.as_str(), "hq" | "yaml") {
        return Err(PyValueError::new_err(format!("`{}` is no syntax: hq or yaml", source.syntax)));
    }
    let settings = settings(set, package_paths);
    let compiled = py.detach(|| compiled(&source, &settings));
    let rendered = Rendered::new(&compiled.report);
    let program = compiled.is_good().then(|| Program::new(source.name.display().to_string(), compiled));
    Ok((program, rendered))
}
