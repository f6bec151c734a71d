//! `hierarq fmt SPEC ..`

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use compiler::Report;
use dsl::{Severity, Syntax};
use hierarq::project;

use super::{Outcome, output};

#[derive(Args)]
pub struct Arguments {
    /// Specs (`*.hq`, `*.yaml`).
    #[arg(required = true)]
    specs: Vec<PathBuf>,
    /// Print in this syntax to standard output instead of formatting in place.
    #[arg(long, value_enum)]
    to: Option<To>,
    /// Change nothing; fail if a file is not formatted.
    #[arg(long, conflicts_with = "to")]
    check: bool,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum To {
    Hq,
    Yaml,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    if a.to.is_some() && a.specs.len() > 1 {
        return Err("`--to` takes exactly one spec".to_string());
    }
    let mut failed = false;
    for path in &a.specs {
        failed |= !one(a, path)?;
    }
    Ok(Outcome::of(!failed))
}

fn one(a: &Arguments, path: &Path) -> Result<bool, String> {
    let (syntax, text) = match project::read(path) {
        Ok(x) => x,
        Err(report) => {
            output::show(&report);
            return Ok(false);
        }
    };
    let mut report = Report::default();
    let source = report.sources.add(path.display().to_string(), text.clone());
    let (spec, diagnostics) = dsl::parse(source, &text, syntax);
    if diagnostics.iter().any(|d| d.severity == Severity::Error) {
        report.diagnostics = diagnostics;
        report.finish();
        output::show(&report);
        output::error_line(&format!("{}: not formatted, because it has syntax errors", path.display()));
        return Ok(false);
    }
    match a.to {
        Some(to) => {
            output::data(&dsl::print(&spec, if to == To::Hq { Syntax::Native } else { Syntax::Yaml }));
            Ok(true)
        }
        None => {
            let formatted = dsl::print(&spec, syntax);
            if formatted == text {
                return Ok(true);
            }
            if a.check {
                output::error_line(&format!("{}: not formatted", path.display()));
                return Ok(false);
            }
            files::replace(path, &text, &formatted).map_err(|e| format!("cannot write {}: {e}", path.display()))?;
            Ok(true)
        }
    }
}
