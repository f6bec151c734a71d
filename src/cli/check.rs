//! `hierarq check SPEC ..`

use std::path::PathBuf;

use clap::Args;
use hierarq::project;
use serde_json::json;

use super::{Outcome, SpecOptions, output};

#[derive(Args)]
pub struct Arguments {
    /// Specs (`*.hq`, `*.yaml`).
    #[arg(required = true)]
    specs: Vec<PathBuf>,
    #[command(flatten)]
    options: SpecOptions,
    /// Print the diagnostics as JSON.
    #[arg(long)]
    json: bool,
    /// Treat warnings as errors.
    #[arg(long)]
    strict: bool,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let mut failed = false;
    let mut files = Vec::new();
    for path in &a.specs {
        let compiled = project::compile(path, &a.options.settings());
        let report = &compiled.report;
        let bad = report.errors() > 0 || (a.strict && report.warnings() > 0);
        failed |= bad;
        if a.json {
            let mut data = report.to_json();
            data["file"] = json!(path.display().to_string());
            data["ok"] = json!(!bad);
            files.push(data);
            continue;
        }
        output::show(report);
        let name = path.display();
        output::print(&match (output::count(report), bad) {
            (Some(count), _) => format!("{name}: {count}\n"),
            (None, _) => format!("{name}: good\n"),
        });
    }
    if a.json {
        let data = if files.len() == 1 { files.remove(0) } else { json!({ "version": 1, "files": files }) };
        output::data(&format!("{data:#}\n"));
    }
    Ok(Outcome::of(!failed))
}
