//! `hierarq check SPEC ..`

use std::path::{Path, PathBuf};

use clap::Args;
use compiler::{Compiled, Deep};
use hierarq::{mend, project};
use serde_json::json;

use super::{Outcome, SpecOptions, coverage, output, sampled};

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
    /// Also look at random postures, which takes seconds: hard levels that cannot be met, links that can touch, freedom.
    #[arg(long, conflicts_with = "fix")]
    deep: bool,
    /// Number of random postures for each stack.
    #[arg(long, requires = "deep", default_value_t = 10_000, value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    postures: u32,
    /// Seed of the random postures.
    #[arg(long, requires = "deep", default_value_t = 0)]
    seed: u64,
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
            false if a.deep => (deep(path, a), Vec::new()),
            false => (project::compile(path, &a.options.settings()), Vec::new()),
        };
        let report = &compiled.report;
        let bad = report.errors() > 0 || (a.strict && report.warnings() > 0);
        failed |= bad;
        if a.json {
            let mut data = report.to_json();
            data["file"] = json!(path.display().to_string());
            data["ok"] = json!(!bad);
            if let Some(program) = &compiled.program {
                data["feasibility"] = json!(runtime::feasibility::of_stacks(program));
                data["stopping"] = json!(runtime::stopping::of_stacks(program));
            }
            if let Some(sampled) = &compiled.sampled {
                data["sampled"] = sampled::data(sampled, a.postures as usize);
            }
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
        if let Some(sampled) = &compiled.sampled {
            output::print(&sampled::text(sampled, a.postures as usize));
        }
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

/// Compiles a file, with the checks at random postures.
fn deep(path: &Path, a: &Arguments) -> Compiled {
    let bar = sampled::bar();
    let progress = |done: usize, total: usize| {
        bar.set_length(total as u64);
        bar.set_position(done as u64);
    };
    let deep = Deep { postures: a.postures as usize, seed: a.seed, progress: &progress };
    let compiled = project::compile_deep(path, &a.options.settings(), &deep);
    bar.finish_and_clear();
    compiled
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
