//! Compiles the specs of the corpus, and judges what the compiler says of them.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use dsl::{Severity, SourceId, Syntax};
use hierarq_compiler::{Input, compile};

use super::read::Sample;

/// The judgement of a spec.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// An error or a warning is on a marked line.
    Exact,
    /// There is an error or a warning, on other lines.
    Elsewhere,
    /// Nothing is said of the mistake.
    Silent,
    /// A good spec is accepted without a word.
    Quiet,
    /// A good spec has an error or a warning.
    FalseAlarm,
    /// The compiler panicked.
    Panicked,
}

/// A diagnostic of a spec.
pub struct Found {
    pub code: &'static str,
    pub error: bool,
    /// First and last line of the primary place, from 1; 0 in another file.
    pub lines: (usize, usize),
    /// The text there.
    pub text: String,
    pub message: String,
    /// True if one of its lines is marked.
    pub marked: bool,
    /// True if it is about something else than the mistake.
    pub aside: bool,
}

/// A spec with its judgement.
pub struct Outcome {
    pub name: String,
    pub mistake: String,
    pub provable: String,
    pub verdict: Verdict,
    pub found: Vec<Found>,
    /// Description for a person who looks into a verdict.
    pub story: String,
}

impl Outcome {
    /// The verdict and the places of all diagnostics, without the words of their messages.
    pub fn line(&self) -> String {
        let mut out = format!("{}: {:?}\n", self.name, self.verdict);
        for f in &self.found {
            let aside = if f.aside { ", aside" } else { "" };
            let severity = if f.error { "error" } else { "warning" };
            out.push_str(&format!("    {} {severity}, line {} «{}»{aside}\n", f.code, f.lines.0, f.text));
        }
        out
    }
}

/// Judges all specs, on all processors.
pub fn all(samples: &[Sample]) -> Vec<Outcome> {
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    let share = samples.len().div_ceil(workers).max(1);
    std::thread::scope(|scope| {
        let parts: Vec<_> =
            samples.chunks(share).map(|part| scope.spawn(move || part.iter().map(one).collect::<Vec<_>>())).collect();
        parts.into_iter().flat_map(|p| p.join().expect("panics are caught")).collect()
    })
}

fn one(sample: &Sample) -> Outcome {
    let found = catch_unwind(AssertUnwindSafe(|| diagnostics(sample)));
    let counts = |f: &&Found| !f.aside;
    let verdict = match &found {
        Err(_) => Verdict::Panicked,
        Ok(found) if sample.good && found.iter().any(|f| counts(&f)) => Verdict::FalseAlarm,
        Ok(_) if sample.good => Verdict::Quiet,
        Ok(found) if found.iter().filter(counts).any(|f| f.marked) => Verdict::Exact,
        Ok(found) if found.iter().any(|f| counts(&f)) => Verdict::Elsewhere,
        Ok(_) => Verdict::Silent,
    };
    let found = found.unwrap_or_default();
    let said = found.iter().map(|f| format!("\n    {} line {} «{}»: {}", f.code, f.lines.0, f.text, f.message));
    Outcome {
        name: sample.name.clone(),
        mistake: sample.mistake.clone(),
        provable: sample.provable.clone(),
        verdict,
        story: format!("{verdict:?} {}: {}{}", sample.name, sample.mistake, said.collect::<String>()),
        found,
    }
}

/// Compiles a spec in the folder of the examples.
fn diagnostics(sample: &Sample) -> Vec<Found> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let text = sample.text.as_str();
    let input = Input { name: "spec.hq", text, syntax: Syntax::Native, folder: &folder, set: &[], package_paths: &[] };
    let report = compile(&input).report;
    let line = |at: usize| text[..at.min(text.len())].matches('\n').count() + 1;
    let found = report.diagnostics.into_iter().map(|d| {
        let (span, range) = (d.primary.span, d.primary.span.range());
        let here = span.source == SourceId(0);
        let shown = text.get(range.clone()).filter(|_| here).unwrap_or("").split_whitespace().collect::<Vec<_>>();
        let lines = if here { (line(range.start), line(range.end.max(range.start + 1) - 1)) } else { (0, 0) };
        Found {
            code: d.code,
            error: d.severity == Severity::Error,
            marked: (lines.0..=lines.1).any(|l| sample.lines.contains(&l)),
            lines,
            text: clipped(&shown.join(" ")),
            message: d.message.to_string(),
            aside: sample.aside.iter().any(|c| c == d.code),
        }
    });
    found.collect()
}

/// At most forty characters of a text.
fn clipped(text: &str) -> String {
    match text.chars().count() {
        0..=40 => text.to_string(),
        _ => format!("{}..", text.chars().take(38).collect::<String>().trim_end()),
    }
}
