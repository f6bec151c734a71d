//! User files: reads specs and compiled programs.

use std::path::{Path, PathBuf};

use compiler::{Compiled, Deep, Input, Report};
use dsl::{Diagnostic, Span, Syntax};
use mission::kinds::KINDS;
use runtime::program::{CompiledFile, MissionProgram};

/// Maximum size of a compiled program (bytes).
const MAX_COMPILED: u64 = 256 << 20;

/// Settings of the compilation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Settings {
    /// Overridden params, as `(name, value)`.
    pub set: Vec<(String, String)>,
    /// Folders for `package://` addresses, in addition to the usual ones.
    pub package_paths: Vec<PathBuf>,
}

/// Creates a report with one diagnostic about a file as a whole.
fn about(name: &str, text: &str, code: &'static str, message: String, help: &str) -> Report {
    let mut report = Report::default();
    let source = report.sources.add(name, text);
    report.diagnostics.push(Diagnostic::error(code, Span::new(source, 0, 0), message).help(help));
    report
}

/// Reads the syntax and text of a file.
///
/// # Errors
/// A report with the reason why it cannot be read.
pub fn read(path: &Path) -> Result<(Syntax, String), Box<Report>> {
    let name = path.display().to_string();
    let Some(syntax) = Syntax::of_path(path) else {
        return Err(Box::new(about(
            &name,
            "",
            "HQ0401",
            format!("`{name}` is no spec: its name ends neither in .hq nor in .yaml"),
            "rename the file, or give a spec",
        )));
    };
    // One byte more than the language allows: enough to be rejected as too large, for any size of the file.
    let most = dsl::limits::MAX_BYTES as u64 + 1;
    let bytes = match files::read_up_to(path, most) {
        Ok(bytes) => bytes,
        Err(e) => {
            let help = similar(path).map_or_else(|| "check the path".to_string(), |n| format!("did you mean `{n}`?"));
            return Err(Box::new(about(&name, "", "HQ0401", format!("cannot read `{name}`: {e}"), &help)));
        }
    };
    let mut report = Report::default();
    let source = report.sources.add(&name, String::from_utf8_lossy(&bytes));
    match dsl::limits::decode(source, &bytes) {
        Ok(text) => Ok((syntax, text.to_string())),
        Err(d) => {
            report.diagnostics.push(*d);
            Err(Box::new(report))
        }
    }
}

fn similar(path: &Path) -> Option<String> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let wanted = path.file_name()?.to_str()?;
    let mut names: Vec<String> =
        std::fs::read_dir(folder).ok()?.filter_map(|e| e.ok()?.file_name().into_string().ok()).collect();
    names.sort();
    let near = compiler::names::suggest(wanted, names.iter().map(String::as_str))?;
    Some(path.with_file_name(near).display().to_string())
}

/// Returns the files that were read for a spec, as far as their names are paths. Outputs must not overwrite them.
pub fn sources(path: &Path, report: &Report) -> Vec<PathBuf> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let named = report.sources.iter().flat_map(|(_, source)| [folder.join(&source.name), PathBuf::from(&source.name)]);
    std::iter::once(path.to_path_buf()).chain(named).collect()
}

/// Calls a function with a spec file as its input.
fn given<T>(path: &Path, settings: &Settings, reader: impl FnOnce(&Input) -> T) -> Result<T, Box<Report>> {
    let (syntax, text) = read(path)?;
    let name = path.display().to_string();
    Ok(reader(&Input {
        name: &name,
        text: &text,
        syntax,
        folder: path.parent().unwrap_or(Path::new("")),
        set: &settings.set,
        package_paths: &settings.package_paths,
    }))
}

/// Compiles a spec file.
pub fn compile(path: &Path, settings: &Settings) -> Compiled {
    given(path, settings, compiler::compile).unwrap_or_else(|report| Compiled::refused(*report))
}

/// Compiles a spec file, with the checks at random postures.
pub fn compile_deep(path: &Path, settings: &Settings, deep: &Deep) -> Compiled {
    given(path, settings, |input| compiler::compile_deep(input, deep))
        .unwrap_or_else(|report| Compiled::refused(*report))
}

/// Returns the values of the params of a spec file; empty for an unreadable file, which [`compile`] reports.
pub fn params(path: &Path, settings: &Settings) -> Vec<compiler::ParamValue> {
    given(path, settings, compiler::params).unwrap_or_default()
}

/// Loads a file like [`load`], without the contents of the files of bytes that a spec names, for a command that makes these.
pub fn load_unread(path: &Path, settings: &Settings) -> Compiled {
    match is_compiled(path) {
        true => load(path, settings),
        false => given(path, settings, compiler::compile_unread).unwrap_or_else(|report| Compiled::refused(*report)),
    }
}

fn is_compiled(path: &Path) -> bool {
    path.extension().and_then(|e| e.to_str()) == Some("json")
}

/// Loads an executable file: a spec, or a compiled program (`*.json`). For a spec, rows that can never become active
/// are marked in the program.
pub fn load(path: &Path, settings: &Settings) -> Compiled {
    if !is_compiled(path) {
        let mut compiled = compile(path, settings);
        if let Some(program) = &mut compiled.program {
            compiler::mark_idle_rows(program);
        }
        for mission in &mut compiled.missions {
            mission.running.controllers.iter_mut().for_each(|c| compiler::mark_idle_rows(&mut c.program));
        }
        return compiled;
    }
    let name = path.display().to_string();
    let refuse = |message: String| {
        let help = "compile the spec again: `hierarq compile SPEC --format json`";
        Compiled::refused(about(&name, "", "HQ0607", message, help))
    };
    let text = match files::read(path, MAX_COMPILED) {
        Ok(bytes) => bytes,
        Err(e) => return refuse(format!("cannot read `{name}`: {e}")),
    };
    let Ok(text) = String::from_utf8(text) else { return refuse(format!("`{name}` is not UTF-8 text")) };
    if !settings.set.is_empty() {
        return refuse("`--set` changes a spec, and this is a program that was compiled already".to_string());
    }
    match CompiledFile::read(&text) {
        Ok(CompiledFile { program, missions }) => Compiled { program, missions, ..Compiled::default() },
        Err(why) => refuse(format!("`{name}` cannot be used: {why}")),
    }
}

/// Message for a spec that compiles but declares no robot to run.
pub fn missions_alone(path: &Path) -> String {
    let name = path.display();
    format!(
        "`{name}` declares missions and no robot, so there is nothing to run but their scenarios, `hierarq run {name} --scenario NAME`; plan them: `hierarq plan {name}`"
    )
}

/// Returns the mission of this name; without a name, the only mission of the spec.
///
/// # Errors
/// There is none, or several and no name; the message says which there are.
pub fn mission<'p>(missions: &'p [MissionProgram], name: Option<&str>) -> Result<&'p MissionProgram, String> {
    let names = || missions.iter().map(|m| m.name.as_str());
    let Some(name) = name else {
        return match missions {
            [one] => Ok(one),
            [] => {
                let kinds = compiler::names::list(KINDS.iter().map(|kind| kind.name), KINDS.len());
                Err(format!(
                    "it declares no mission: write one, `mission NAME : KIND {{ .. }}`, with a kind among {kinds}"
                ))
            }
            _ => Err(format!("it declares several missions: name one of {}", compiler::names::list(names(), 12))),
        };
    };
    missions.iter().find(|m| m.name == name).ok_or_else(|| {
        let help = match compiler::names::suggest(name, names()) {
            Some(near) => format!("did you mean `{near}`?"),
            None if missions.is_empty() => "it declares none".to_string(),
            None => format!("it has {}", compiler::names::list(names(), 12)),
        };
        format!("there is no mission `{name}`: {help}")
    })
}
