//! The corpus of seeded faults: every example with one inserted mistake is rejected, and the message points at the
//! mistake.
//!
//! The faults are data. `corpus/faults.txt` contains those written by hand, `corpus/slips.txt` the words that are
//! misspelt wherever the examples use them. The figures are in `docs/src/internals/diagnostics.md`; this test computes
//! and compares them.

mod fault;
mod judge;
mod read;
mod sweep;

use compiler::resolve::Meaning;
use fault::Fault;
use judge::{Mending, Outcome, Verdict};

/// Reads a file of this repository.
fn text_of(path: &str) -> String {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn all_faults() -> Vec<Fault> {
    let mut all = read::faults("tests/corpus/faults.txt");
    all.extend(sweep::slips("tests/corpus/slips.txt"));
    all
}

/// Returns one row of the table in the book.
fn row(name: &str, outcomes: &[&Outcome]) -> String {
    let count = |f: &dyn Fn(&Outcome) -> bool| outcomes.iter().filter(|o| f(o)).count();
    let found = count(&|o| !matches!(o.verdict, Verdict::Silent | Verdict::Panicked));
    let exact = count(&|o| o.verdict == Verdict::Exact);
    let alone = count(&|o| o.diagnostics == 1);
    let restored = count(&|o| o.restored);
    let mended = count(&|o| o.mended == Mending::Restored);
    format!("| {name} | {} | {found} | {exact} | {alone} | {restored} | {mended} |\n", outcomes.len())
}

/// Returns the text between the two marks in the book: figures by class, and the faults with an inexact place.
fn figures(outcomes: &[Outcome]) -> String {
    let mut classes: Vec<&str> = Vec::new();
    for o in outcomes {
        if !classes.contains(&o.class.as_str()) {
            classes.push(&o.class);
        }
    }
    let mut out = String::from(
        "| class | faults | found | exact place | one message | a fix restores | `--fix` restores |\n|---|---:|---:|---:|---:|---:|---:|\n",
    );
    for class in classes {
        out.push_str(&row(class, &outcomes.iter().filter(|o| o.class == class).collect::<Vec<_>>()));
    }
    let (by_hand, swept): (Vec<&Outcome>, Vec<&Outcome>) =
        outcomes.iter().partition(|o| o.origin.starts_with("faults.txt"));
    out.push_str(&row("**written by hand**", &by_hand));
    out.push_str(&row("**swept**", &swept));
    out.push_str(&row("**all**", &outcomes.iter().collect::<Vec<_>>()));
    out.push_str("\n| not exact | in | faulty | shown |\n|---|---|---|---|\n");
    for o in outcomes.iter().filter(|o| o.verdict == Verdict::Inexact) {
        let [faulty, shown] = [&o.faulty, &o.shown].map(|t| clipped(t));
        out.push_str(&format!("| {} | `{}` | {faulty} | {shown} |\n", o.origin, o.file));
    }
    out
}

/// Returns a piece of a spec for a cell of a table.
fn clipped(text: &str) -> String {
    let line = text.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "/");
    match line.chars().count() {
        0 => "nothing".to_string(),
        1..=40 => format!("`{line}`"),
        _ => format!("`{} ..`", line.chars().take(38).collect::<String>().trim_end()),
    }
}

/// Compares the figures with those of the book; `HIERARQ_UPDATE_DOCS=1` writes them instead.
fn published(figures: &str) {
    const PAGE: &str = "docs/src/internals/diagnostics.md";
    let (begin, end) = ("<!-- figures: written by tests/corpus.rs -->\n", "<!-- end of figures -->");
    let page = text_of(PAGE);
    let parts = page.split_once(begin).and_then(|(head, rest)| Some((head, rest.split_once(end)?)));
    let (head, (is, tail)) = parts.expect("the page has the marks of the figures");
    if std::env::var_os("HIERARQ_UPDATE_DOCS").is_some() {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(PAGE);
        std::fs::write(path, format!("{head}{begin}{figures}{end}{tail}")).expect("writable");
    } else {
        assert!(is == figures, "{PAGE} is stale: run `HIERARQ_UPDATE_DOCS=1 cargo test --test it corpus`");
    }
}

#[test]
fn every_seeded_fault_is_found_where_it_is() {
    let outcomes = judge::all(&all_faults());
    let of = |verdict: Verdict| outcomes.iter().filter(move |o| o.verdict == verdict);
    for o in outcomes.iter().filter(|o| o.verdict != Verdict::Exact) {
        println!("{:?} {}", o.verdict, o.story);
    }
    let figures = figures(&outcomes);
    println!("{figures}");

    assert!(outcomes.len() >= 250, "{} faults are too few", outcomes.len());
    assert_eq!(of(Verdict::Panicked).count(), 0, "a fault makes the compiler panic");
    assert_eq!(of(Verdict::Silent).count(), 0, "a fault is accepted in silence");
    assert_eq!(of(Verdict::OtherCode).count(), 0, "a fault is taken for another one");
    let exact = of(Verdict::Exact).count();
    let mending =
        |what: Mending| outcomes.iter().filter(move |o| o.mended == what).map(|o| &o.story).collect::<Vec<_>>();
    assert!(mending(Mending::Another).is_empty(), "a certain fix gives another spec: {:#?}", mending(Mending::Another));
    assert!(mending(Mending::Worse).is_empty(), "a certain fix makes it worse: {:#?}", mending(Mending::Worse));
    assert!(exact * 100 >= outcomes.len() * 97, "only {exact} of {} are pointed at exactly", outcomes.len());
    published(&figures);
}

/// The corpus is only meaningful if its examples are valid before the fault is inserted.
#[test]
fn the_examples_are_good_before_they_are_spoilt() {
    for file in fault::files() {
        let found = judge::diagnostics(&file, &text_of(&format!("tests/corpus/specs/{file}")));
        assert!(found.is_empty(), "{file}: {found:?}");
    }
}

/// The judge is only meaningful if it rejects a wrong place and a wrong code.
#[test]
fn the_judge_tells_right_from_wrong() {
    let text = text_of("tests/corpus/specs/hello.hq").replace("joint_velocity_limits", "joint_velocity_limit");
    let at = text.find("joint_velocity_limit").expect("it is there");
    let place = at..at + "joint_velocity_limit".len();
    let verdict = |code: &str, range: std::ops::Range<usize>, text: &str| {
        let fault = Fault::new("a class", "the judge", "hello.hq", text, range, code);
        judge::all(&[fault])[0].verdict
    };
    assert_eq!(verdict("HQ0201", place.clone(), &text), Verdict::Exact);
    assert_eq!(verdict("HQ0201", place.start..place.end - 1, &text), Verdict::Inexact);
    assert_eq!(verdict("HQ0204", place.clone(), &text), Verdict::OtherCode);
    assert_eq!(verdict("HQ0201", place, &text_of("tests/corpus/specs/hello.hq")), Verdict::Silent);
}

/// Messages of unknown words that name nothing declared: words of the language, fields of values, measures of missions.
const OTHER_WORDS: &[&str] = &[
    "there is no function",
    "there is no kind of mission",
    "there is no distribution",
    "there is no skill",
    "`makspan` is not a measure",
    // A pattern names several joints.
    "no joint of robot `canopies` that moves by itself fits",
    // The arms exist, and have no `points`.
    "there is no point, segment, group or link `arms",
];

/// Editors and the compiler agree: the place of an error of an unknown name is a reference that nothing declares, and a
/// text with such a reference has an error.
#[test]
fn unknown_names_are_unresolved_references() {
    let mut wrong = Vec::new();
    for fault in all_faults() {
        let names = judge::names(&fault.file, &fault.text);
        let unknown: Vec<_> = names.references.iter().filter(|r| matches!(r.meaning, Meaning::Unknown(..))).collect();
        let found = judge::diagnostics(&fault.file, &fault.text);
        let errors = || found.iter().filter(|d| d.severity == dsl::Severity::Error);
        if !unknown.is_empty() && errors().next().is_none() {
            wrong.push(format!("{}: unknown without an error: {:?}", fault.origin, unknown[0].meaning));
        }
        for d in errors().filter(|d| ["HQ0201", "HQ0204", "HQ0213"].contains(&d.code)) {
            let at = d.primary.span.range();
            let known = unknown.iter().any(|r| at.start <= r.place.start && r.place.end <= at.end);
            if d.primary.span.source.0 == 0 && !known && !OTHER_WORDS.iter().any(|w| d.message.starts_with(w)) {
                let text = fault.text.get(at).unwrap_or("?");
                wrong.push(format!("{} {}: {text}: {}", fault.origin, fault.file, d.message));
            }
        }
    }
    assert!(wrong.is_empty(), "{}\n{}", wrong.len(), wrong.join("\n"));
}
