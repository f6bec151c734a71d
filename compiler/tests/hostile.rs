//! Damaged specs: the compiler always terminates soon, and all its spans are valid.

use crate::common;

use common::{compile_text, examples, invariants};
use dsl::Syntax;
use proptest::prelude::*;

/// Example specs in both syntaxes.
const SPECS: &[(&str, Syntax)] = &[
    ("hello.hq", Syntax::Native),
    ("hello.yaml", Syntax::Yaml),
    ("safety_tasks.hq", Syntax::Native),
    ("safety_tasks.yaml", Syntax::Yaml),
    ("swivel_angle.hq", Syntax::Native),
    ("own_tasks.hq", Syntax::Native),
    ("cooperative_motion.hq", Syntax::Native),
    ("cooperative_motion.yaml", Syntax::Yaml),
    ("uncooperative_motion.hq", Syntax::Native),
    ("both_arms.hq", Syntax::Native),
    ("both_arms.yaml", Syntax::Yaml),
];

/// Replacements for a word.
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

/// Splits a text into words, signs and blanks; their concatenation is the text.
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

/// Number of cases: small in the suite; `HIERARQ_FUZZ_CASES` increases it.
fn cases() -> u32 {
    std::env::var("HIERARQ_FUZZ_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(48)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: cases(), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_examples_are_answered(which in 0..SPECS.len(), changes in prop::collection::vec(change(), 1..5)) {
        let (name, syntax) = SPECS[which];
        let text = std::fs::read_to_string(examples().join(name)).expect("an example");
        let text = damaged(&text, &changes);
        invariants::reads(&text, syntax);
        invariants::formats(&text, syntax);
        invariants::checks(&text, syntax, &examples());
    }

    /// Two examples cut and joined: a piece of one spec in the middle of another.
    #[test]
    fn joined_examples_are_answered(
        (a, b) in (0..SPECS.len(), 0..SPECS.len()),
        (cut, from, length) in (0..10_000_usize, 0..10_000_usize, 0..400_usize),
    ) {
        let text_of = |i: usize| std::fs::read_to_string(examples().join(SPECS[i].0)).expect("an example");
        let (one, other) = (tokens(&text_of(a)), tokens(&text_of(b)));
        let (cut, from) = (cut % one.len(), from % other.len());
        let piece = &other[from..other.len().min(from + length)];
        let text = [&one[..cut], piece, &one[cut..]].concat().concat();
        invariants::reads(&text, SPECS[a].1);
        invariants::formats(&text, SPECS[a].1);
        invariants::checks(&text, SPECS[a].1, &examples());
    }

    #[test]
    fn values_from_outside_are_answered(text in "[ -~é]{0,24}") {
        let spec = std::fs::read_to_string(examples().join("hello.hq")).expect("an example");
        let spec = spec.replacen("hierarq 1", "hierarq 1\nparam outside = 1", 1);
        let set = [("outside".to_string(), text)];
        let compiled = compile_text(&spec, Syntax::Native, &examples(), &set);
        prop_assert_eq!(compiled.is_good(), compiled.report.errors() == 0);
    }
}

#[test]
fn a_level_that_begins_with_a_wide_blank() {
    let text = "hierarq: 1\nstacks:\n  s:\n    levels:\n      - \u{a0}: limits\n        hard: true\n";
    let compiled = compile_text(text, Syntax::Yaml, &examples(), &[]);
    for d in &compiled.report.diagnostics {
        assert!(text.get(d.primary.span.range()).is_some(), "{}", d.message);
    }
    assert!(compiled.report.errors() > 0);
}
