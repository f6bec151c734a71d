//! Compiles faulty examples, and compares the diagnostics with the expected ones.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::rc::Rc;

use compiler::resolve::{Resolution, read_urdf, resolve};
use dsl::{Diagnostic, Severity, SourceId, Syntax};
use hierarq::mend::mend_text;

use super::fault::Fault;

/// Result of the comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The right code at exactly the right place.
    Exact,
    /// The right code at another place.
    Inexact,
    /// Rejected (or warned) with another code.
    OtherCode,
    /// Accepted, or an error instead of a warning.
    Silent,
    /// The compiler panicked.
    Panicked,
}

/// Result of a fault.
pub struct Outcome {
    /// Class of the fault.
    pub class: String,
    /// File and line of the fault in the corpus.
    pub origin: String,
    /// The example with the fault.
    pub file: String,
    /// Result of the comparison.
    pub verdict: Verdict,
    /// The faulty text.
    pub faulty: String,
    /// Text under the first message with the right code.
    pub shown: String,
    /// Number of diagnostics, including warnings.
    pub diagnostics: usize,
    /// True if a fix of a diagnostic gives the example without the mistake.
    pub restored: bool,
    /// Result of the certain fixes.
    pub mended: Mending,
    /// Description of the fault and the diagnostics, for developers.
    pub story: String,
}

/// Result of the certain fixes of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mending {
    /// The example without the mistake.
    Restored,
    /// A spec without errors that is another one.
    Another,
    /// Errors are left, and no more than before.
    Partly,
    /// More errors than before.
    Worse,
    /// There is no certain fix, or none that helps.
    Nothing,
}

/// Compiles a text in the folder of the examples under the given name.
fn compiled(file: &str, text: &str) -> compiler::Compiled {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let syntax = Syntax::of_path(Path::new(file)).expect("an example is a spec");
    let input = compiler::Input { name: file, text, syntax, folder: &folder, set: &[], package_paths: &[] };
    compiler::compile(&input)
}

/// Returns the diagnostics of a text, compiled in the folder of the examples under the given name.
pub fn diagnostics(file: &str, text: &str) -> Vec<Diagnostic> {
    let compiled = compiled(file, text);
    assert_eq!(compiled.is_good(), compiled.report.errors() == 0, "refused without a reason, or the reverse");
    compiled.report.diagnostics
}

/// Returns the symbols and references of a text, in the folder of the examples under the given name.
pub fn names(file: &str, text: &str) -> Resolution {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let syntax = Syntax::of_path(Path::new(file)).expect("an example is a spec");
    let input = compiler::Input { name: file, text, syntax, folder: &folder, set: &[], package_paths: &[] };
    resolve(&input, &compiler::Texts::new(), &|path| read_urdf(path).map(Rc::new))
}

/// Evaluates all faults, on all processors.
pub fn all(faults: &[Fault]) -> Vec<Outcome> {
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    let share = faults.len().div_ceil(workers).max(1);
    std::thread::scope(|scope| {
        let parts: Vec<_> =
            faults.chunks(share).map(|part| scope.spawn(move || part.iter().map(one).collect::<Vec<_>>())).collect();
        parts.into_iter().flat_map(|p| p.join().expect("panics are caught")).collect()
    })
}

/// The tree of a text, which is what its author says.
fn tree(file: &str, text: &str) -> dsl::tree::Spec {
    dsl::parse(SourceId(0), text, Syntax::of_path(Path::new(file)).expect("an example is a spec")).0
}

/// Applies the certain fixes, and compares the result with the example.
fn mended(fault: &Fault, found: &[Diagnostic], good: &dsl::tree::Spec) -> Mending {
    let mended = mend_text(fault.text.clone(), |text| compiled(&fault.file, text));
    let errors = found.iter().filter(|d| d.severity == Severity::Error).count();
    match mended.compiled.report.errors() {
        _ if mended.applied.is_empty() => Mending::Nothing,
        _ if tree(&fault.file, &mended.text) == *good => Mending::Restored,
        0 => Mending::Another,
        left if left <= errors => Mending::Partly,
        _ => Mending::Worse,
    }
}

fn one(fault: &Fault) -> Outcome {
    let found = catch_unwind(AssertUnwindSafe(|| diagnostics(&fault.file, &fault.text)));
    let (verdict, found) = match found {
        Ok(found) => (verdict(fault, &found), found),
        Err(_) => (Verdict::Panicked, Vec::new()),
    };
    let line = |at: usize| fault.text[..at.min(fault.text.len())].matches('\n').count() + 1;
    let said = found.iter().map(|d| {
        let range = d.primary.span.range();
        let at = fault.text.get(range.clone()).unwrap_or("?");
        format!("\n    {} {:?} line {} «{at}»: {}", d.code, d.severity, line(range.start), d.message)
    });
    let wanted = fault.text.get(fault.place.clone()).unwrap_or("?");
    let story = format!(
        "{} {}: {} at line {} «{wanted}»{}",
        fault.origin,
        fault.file,
        fault.codes.join("/"),
        line(fault.place.start),
        said.collect::<String>()
    );
    let good = tree(&fault.file, &super::text_of(&format!("tests/corpus/specs/{}", fault.file)));
    let mut fixes = found.iter().flat_map(|d| &d.fixes);
    let restored = fixes.any(|fix| tree(&fault.file, &dsl::fix::apply(&fault.text, [fix]).0) == good);
    let mended = mended(fault, &found, &good);
    let first = found.iter().find(|d| fault.codes.iter().any(|c| c == d.code));
    let shown = first.and_then(|d| fault.text.get(d.primary.span.range())).unwrap_or("").to_string();
    Outcome {
        class: fault.class.clone(),
        origin: fault.origin.clone(),
        file: fault.file.clone(),
        verdict,
        faulty: wanted.to_string(),
        shown,
        diagnostics: found.len(),
        restored,
        mended,
        story,
    }
}

fn verdict(fault: &Fault, found: &[Diagnostic]) -> Verdict {
    let errors = found.iter().filter(|d| d.severity == Severity::Error).count();
    let wanted = if fault.warning { Severity::Warning } else { Severity::Error };
    if found.is_empty() || (errors > 0) == fault.warning {
        return Verdict::Silent;
    }
    let mut right = found.iter().filter(|d| d.severity == wanted && fault.codes.iter().any(|c| c == d.code)).peekable();
    if right.peek().is_none() {
        return Verdict::OtherCode;
    }
    // Spans in other files, for instance a URDF, never match the faulty text: source 0 is the spec.
    let exact = right.any(|d| d.primary.span.source.0 == 0 && d.primary.span.range() == fault.place);
    if exact { Verdict::Exact } else { Verdict::Inexact }
}
