//! Damaged specs: whatever happens to the examples, the compiler answers, soon, and every place it names exists.

mod common;

use common::{compile_text, examples};
use dsl::Spelling;
use hierarq_compiler::Style;
use proptest::prelude::*;

/// Example specs in both spellings.
const SPECS: &[(&str, Spelling)] = &[
    ("hello.hq", Spelling::Hq),
    ("hello.yaml", Spelling::Yaml),
    ("safety_tasks.hq", Spelling::Hq),
    ("safety_tasks.yaml", Spelling::Yaml),
    ("swivel_angle.hq", Spelling::Hq),
    ("cooperative_motion.hq", Spelling::Hq),
    ("cooperative_motion.yaml", Spelling::Yaml),
    ("uncooperative_motion.hq", Spelling::Hq),
    ("both_arms.hq", Spelling::Hq),
    ("both_arms.yaml", Spelling::Yaml),
];

/// What is written in the place of a word.
const WORDS: &[&str] = &[
    "0",
    "-1",
    "1e308",
    "1e-300",
    "99999999999",
    "{",
    "}",
    "[",
    "]",
    "(",
    ")",
    "initial(position)",
    "t",
    "pi",
    "\"x\"",
    "[1, 2, 3] m",
    "5 deg",
    "frame(x).position",
    "rpy(1, 2, 3)",
    "hard",
    "all",
    "base",
    "auto",
    "1/0",
    "m",
    "é",
    "[]",
    "{ }",
    "- ",
    ": ",
    "stack",
    "sqrt(-t)",
    "\"*\"",
    "${side}",
    "1..4",
    "for i in 1..3 {",
    "from both",
    "import",
    "swing_out(left, [0, 0, 0])",
];

/// One change to a text.
#[derive(Clone, Debug)]
enum Change {
    Delete(usize),
    Double(usize),
    Swap(usize, usize),
    Replace(usize, usize),
    Byte(usize, u8),
}

fn change() -> impl Strategy<Value = Change> {
    let place = 0..100_000_usize;
    prop_oneof![
        place.clone().prop_map(Change::Delete),
        place.clone().prop_map(Change::Double),
        (place.clone(), place.clone()).prop_map(|(a, b)| Change::Swap(a, b)),
        (place.clone(), 0..WORDS.len()).prop_map(|(a, w)| Change::Replace(a, w)),
        (place, any::<u8>()).prop_map(|(a, b)| Change::Byte(a, b)),
    ]
}

/// Words, signs and the blanks between them; all together give the text.
fn tokens(text: &str) -> Vec<String> {
    let kind = |c: char| match c {
        c if c.is_alphanumeric() || c == '_' || c == '.' => 0,
        c if c.is_whitespace() => 1,
        c => 2 + c as u32,
    };
    let mut out: Vec<String> = Vec::new();
    for c in text.chars() {
        match out.last_mut() {
            Some(last) if last.chars().last().map(kind) == Some(kind(c)) => last.push(c),
            _ => out.push(c.to_string()),
        }
    }
    out
}

fn damaged(text: &str, changes: &[Change]) -> String {
    let mut tokens = tokens(text);
    for c in changes {
        let n = tokens.len().max(1);
        match *c {
            _ if tokens.is_empty() => break,
            Change::Delete(i) => {
                tokens.remove(i % n);
            }
            Change::Double(i) => tokens.insert(i % n, tokens[i % n].clone()),
            Change::Swap(i, k) => tokens.swap(i % n, k % n),
            Change::Replace(i, w) => tokens[i % n] = WORDS[w].to_string(),
            Change::Byte(i, b) => tokens[i % n] = char::from(b).to_string(),
        }
    }
    tokens.concat()
}

/// The number of cases: few in the suite; `HIERARQ_FUZZ_CASES` asks for more.
fn cases() -> u32 {
    std::env::var("HIERARQ_FUZZ_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(48)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_examples_are_answered(which in 0..SPECS.len(), changes in prop::collection::vec(change(), 1..5)) {
        let (name, spelling) = SPECS[which];
        let text = std::fs::read_to_string(examples().join(name)).expect("an example");
        let text = damaged(&text, &changes);
        let compiled = compile_text(&text, spelling, &examples(), &[]);
        prop_assert_eq!(compiled.program.is_some(), compiled.report.errors() == 0);
        for d in &compiled.report.diagnostics {
            prop_assert!(hierarq_compiler::codes::explain(d.code).is_some(), "{}", d.code);
            for span in d.labels.iter().map(|l| l.span).chain([d.primary.span]) {
                let source = compiled.report.sources.get(span.source);
                let source = source.ok_or_else(|| TestCaseError::fail("no such source"))?;
                prop_assert!(source.text.get(span.range()).is_some(), "{:?} does not fit", span);
                prop_assert!(source.name != "a default of the task library", "points into a default: {}", d.message);
            }
        }
        let shown = compiled.report.render(Style::Plain, 80);
        prop_assert_eq!(shown.is_empty(), compiled.report.diagnostics.is_empty());
        // A program that was accepted can be built.
        if let Some(program) = &compiled.program {
            prop_assert!(runtime::Controller::new(program).is_ok());
        }
    }

    #[test]
    fn values_from_outside_are_answered(text in "[ -~é]{0,24}") {
        let spec = std::fs::read_to_string(examples().join("hello.hq")).expect("an example");
        let spec = spec.replacen("hierarq 1", "hierarq 1\nparam outside = 1", 1);
        let set = [("outside".to_string(), text)];
        let compiled = compile_text(&spec, Spelling::Hq, &examples(), &set);
        prop_assert_eq!(compiled.program.is_some(), compiled.report.errors() == 0);
    }
}

#[test]
fn a_level_that_begins_with_a_wide_blank() {
    let text = "hierarq: 1\nstacks:\n  s:\n    levels:\n      - \u{a0}: limits\n        hard: true\n";
    let compiled = compile_text(text, Spelling::Yaml, &examples(), &[]);
    for d in &compiled.report.diagnostics {
        assert!(text.get(d.primary.span.range()).is_some(), "{}", d.message);
    }
    assert!(compiled.report.errors() > 0);
}
