//! Applies the certain fixes of a spec's diagnostics to its text: the work of `hierarq check --fix`.

use std::path::Path;

use compiler::{Compiled, Input, Report};
use dsl::{Applicability, Fix, Severity};

use crate::project::{Settings, read};

/// Maximum number of compilations: a fix may reveal a mistake behind the one it mends.
const MOST_ROUNDS: usize = 50;

/// A spec whose certain fixes are applied.
pub struct Mended {
    /// The text as it was read.
    pub before: String,
    /// The text, after the fixes.
    pub text: String,
    /// Titles of the applied fixes with their lines, in order.
    pub applied: Vec<(usize, String)>,
    /// The result of its compilation.
    pub compiled: Compiled,
}

/// Reads a spec and applies the fixes that its author certainly means, and that leave fewer mistakes. The file is not
/// written.
///
/// # Errors
/// A report with the reason why the file cannot be read.
pub fn mend(path: &Path, settings: &Settings) -> Result<Mended, Box<Report>> {
    let (syntax, text) = read(path)?;
    let name = path.display().to_string();
    let compile = |text: &str| {
        compiler::compile(&Input {
            name: &name,
            text,
            syntax,
            folder: path.parent().unwrap_or(Path::new("")),
            set: &settings.set,
            package_paths: &settings.package_paths,
        })
    };
    Ok(mend_text(text, compile))
}

/// Applies the certain fixes of a text that `compile` compiles.
pub fn mend_text(before: String, compile: impl Fn(&str) -> Compiled) -> Mended {
    let (mut text, mut compiled) = (before.clone(), compile(&before));
    let mut applied = Vec::new();
    for _ in 0..MOST_ROUNDS {
        let fixes = certain(&compiled.report);
        // All at once, or else the first that helps alone: one of them may not mend anything.
        let at_once = std::iter::once(fixes.clone());
        let alone = fixes.iter().map(|fix| vec![*fix]);
        let better = at_once.chain(alone).filter(|some| !some.is_empty()).find_map(|some| {
            let (new, done) = dsl::fix::apply(&text, some);
            let after = compile(&new);
            let titles: Vec<_> = done.iter().map(|fix| (line(&text, fix), fix.title().into_owned())).collect();
            (mistakes(&after.report) < mistakes(&compiled.report)).then_some((new, titles, after))
        });
        let Some((new, titles, after)) = better else { break };
        applied.extend(titles);
        (text, compiled) = (new, after);
    }
    Mended { before, text, applied, compiled }
}

/// Returns the certain fixes of the spec's own text: the best one of each diagnostic.
pub fn certain(report: &Report) -> Vec<&Fix> {
    let own = |fix: &&Fix| fix.edits().iter().all(|edit| edit.span.source.0 == 0);
    let certain = |fix: &&Fix| fix.applicability == Applicability::Certain;
    report.diagnostics.iter().filter_map(|d| d.fixes.iter().filter(own).find(certain)).collect()
}

/// Measure of the mistakes of a text. Those of form come first: behind one the meaning is not examined, so that to mend
/// it may add mistakes of meaning to the report.
fn mistakes(report: &Report) -> (usize, usize, usize) {
    let form = report.diagnostics.iter().filter(|d| d.severity == Severity::Error);
    (form.filter(|d| dsl::codes::explain(d.code).is_some()).count(), report.errors(), report.warnings())
}

fn line(text: &str, fix: &Fix) -> usize {
    let start = fix.edits().first().map_or(0, |edit| edit.span.range().start);
    text.get(..start).map_or(1, |before| before.matches('\n').count() + 1)
}
