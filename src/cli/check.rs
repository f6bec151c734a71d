//! `hierarq check SPEC ..`

use std::path::{Path, PathBuf};

use clap::Args;
use compiler::Compiled;
use hierarq::{mend, project};
use serde_json::json;

use super::{Outcome, SpecOptions, coverage, output};

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
    /// Show the limits that each stack keeps, and what nothing limits.
    #[arg(long)]
    coverage: bool,
    /// Apply the fixes whose diagnostics leave no other reading, and write the files; the rest is reported.
    #[arg(long)]
    fix: bool,
    /// Treat warnings as errors.
    #[arg(long)]
    strict: bool,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let mut failed = false;
    let mut files = Vec::new();
    for path in &a.specs {
        let (compiled, applied) = match a.fix {
            true => mended(path, &a.options.settings())?,
            false => (project::compile(path, &a.options.settings()), Vec::new()),
        };
        let report = &compiled.report;
        let bad = report.errors() > 0 || (a.strict && report.warnings() > 0);
        failed |= bad;
        if a.json {
            let mut data = report.to_json();
            data["file"] = json!(path.display().to_string());
            data["ok"] = json!(!bad);
            if let Some(program) = compiled.program.as_ref().filter(|_| a.coverage) {
                data["coverage"] = coverage::data(program);
            }
            if a.fix {
                data["applied"] = applied.iter().map(|(line, title)| json!({ "line": line, "title": title })).collect();
            }
            files.push(data);
            continue;
        }
        let name = path.display();
        for (line, title) in &applied {
            output::print(&format!("{name}:{line}: {title}\n"));
        }
        output::show(report);
        output::print(&report.render_allowed());
        if let Some(program) = compiled.program.as_ref().filter(|_| a.coverage) {
            output::print(&coverage::text(program));
        }
        output::print(&match (output::count(report), bad) {
            (Some(count), _) => format!("{name}: {count}{}\n", output::allowed(report)),
            (None, _) => format!("{name}: good{}\n", output::allowed(report)),
        });
        // After `--fix`, those that are left mend nothing.
        match mend::certain(report).len() {
            0 => {}
            _ if a.fix => {}
            1 => output::print("1 of them has a certain fix: `hierarq check --fix` applies it\n"),
            count => {
                output::print(&format!("{count} of them have a certain fix: `hierarq check --fix` applies them\n"))
            }
        }
    }
    if a.json {
        let data = if files.len() == 1 { files.remove(0) } else { json!({ "version": 1, "files": files }) };
        output::data(&format!("{data:#}\n"));
    }
    Ok(Outcome::of(!failed))
}

/// Fixes that were applied, with their lines.
type Applied = Vec<(usize, String)>;

/// Applies the certain fixes of a file, and compiles what is then in it.
fn mended(path: &Path, settings: &project::Settings) -> Result<(Compiled, Applied), String> {
    let mended = match mend::mend(path, settings) {
        Ok(mended) => mended,
        Err(report) => return Ok((Compiled::refused(*report), Vec::new())),
    };
    if !mended.applied.is_empty() {
        files::replace(path, &mended.before, &mended.text)
            .map_err(|e| format!("cannot write {}: {e}", path.display()))?;
    }
    Ok((mended.compiled, mended.applied))
}
