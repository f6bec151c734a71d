//! Damaged and hostile texts: no panic, no unbounded time, spans inside the text.

use crate::common;

use common::{HQ, YAML};
use hierarq_dsl::{SourceId, Syntax, limits, parse, print};
use proptest::prelude::*;
use std::time::{Duration, Instant};

/// Reads, checks that every place lies on characters of the text, and prints.
fn survive(text: &str, syntax: Syntax) -> usize {
    let (spec, diags) = parse(SourceId(0), text, syntax);
    assert!(diags.len() <= limits::MAX_DIAGNOSTICS + 1);
    for d in &diags {
        for span in std::iter::once(d.primary.span).chain(d.labels.iter().map(|l| l.span)) {
            assert!(text.get(span.range()).is_some(), "{d:?} points outside of {text:?}");
        }
        assert!(hierarq_dsl::codes::explain(d.code).is_some(), "{} is not in the table", d.code);
    }
    print(&spec, Syntax::Native);
    print(&spec, Syntax::Yaml);
    diags.len()
}

fn code(text: &str, syntax: Syntax) -> Vec<&'static str> {
    parse(SourceId(0), text, syntax).1.iter().map(|d| d.code).collect()
}

fn timed(text: &str, syntax: Syntax) {
    let start = Instant::now();
    survive(text, syntax);
    let limit = if cfg!(debug_assertions) { 15 } else { 2 };
    assert!(start.elapsed() < Duration::from_secs(limit), "{:?} for {} bytes", start.elapsed(), text.len());
}

/// Replaces a few pieces of a valid text.
fn mutated(text: &'static str) -> impl Strategy<Value = String> {
    let piece = prop_oneof![
        Just(String::new()),
        "[\\[\\](){}\"':=,;#/*^+\\-.&|>%!@$\\\\\n\t ]{1,3}",
        "[a-z0-9_ ]{1,6}",
        "\\PC{1,2}",
        Just("task ".to_owned()),
        Just("\nrun {".to_owned()),
        Just(" m".to_owned()),
    ];
    proptest::collection::vec((0..text.len(), 0usize..6, piece), 1..6).prop_map(|edits| {
        let mut chars: Vec<char> = text.chars().collect();
        for (at, gone, new) in edits {
            let at = at.min(chars.len());
            let end = (at + gone).min(chars.len());
            chars.splice(at..end, new.chars());
        }
        chars.into_iter().collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn any_text(text in "\\PC{0,120}|[ -~\n\t]{0,200}") {
        survive(&text, Syntax::Native);
        survive(&text, Syntax::Yaml);
    }

    #[test]
    fn pieces_of_the_language(words in proptest::collection::vec("task|stack|level|run|param|robot|hard|weight|for|in|from|import|let|replace|add|remove|as|before|\\$\\{a\\}|\\.\\.|a|b|m|=|\\{|\\}|\\[|\\]|\\(|\\)|,|\\+|-|\\^|/|:|1|0.5|\"|\n| |  |- |//|#|'|&a|\\*a|<<", 0..60)) {
        let text = words.concat();
        survive(&text, Syntax::Native);
        survive(&text, Syntax::Yaml);
    }

    #[test]
    fn pieces_of_machines(words in proptest::collection::vec("signal |machine |scenario |state |final |stack |enter |do |exit |on |when |after |for |-> |expect |always |within |from |to |until |implies |never |and |not |a |b|m |3 s|\\?|\\{|\\}|\\[|\\]|\\(|\\)|, |: |\\.|<|-|\"|\n|  |- ", 0..60)) {
        let text = words.concat();
        survive(&text, Syntax::Native);
        survive(&format!("machine m {{\n{text}\n}}"), Syntax::Native);
        survive(&format!("scenario m {{\nexpect {text}\n}}"), Syntax::Native);
        survive(&text, Syntax::Yaml);
    }

    #[test]
    fn pieces_of_missions(words in proptest::collection::vec("mission |robot |human |place |layer |task |for |in |1\\.\\.2|a |b|\\$\\{a\\}|m |3 s|robots: |layers: |tasks: |for: |- |name: |schedule|\\{|\\}|\\[|\\]|\\(|, |: |= |\"|\n|  ", 0..60)) {
        let text = words.concat();
        survive(&text, Syntax::Native);
        survive(&format!("mission m : k {{\n{text}\n}}"), Syntax::Native);
        survive(&text, Syntax::Yaml);
        survive(&format!("missions: {{ m: {{ schedule: {{ {text}"), Syntax::Yaml);
        survive(&format!("missions:\n  m:\n    schedule:\n      {}", text.replace('\n', "\n      ")), Syntax::Yaml);
    }

    #[test]
    fn damaged_missions(hq in mutated(include_str!("common/missions.hq")), yaml in mutated(include_str!("common/missions.yaml"))) {
        survive(&hq, Syntax::Native);
        survive(&yaml, Syntax::Yaml);
    }

    #[test]
    fn damaged_machines(hq in mutated(include_str!("common/machines.hq")), yaml in mutated(include_str!("common/machines.yaml"))) {
        survive(&hq, Syntax::Native);
        survive(&yaml, Syntax::Yaml);
    }

    #[test]
    fn damaged_hq(text in mutated(HQ)) {
        survive(&text, Syntax::Native);
    }

    #[test]
    fn damaged_yaml(text in mutated(YAML)) {
        survive(&text, Syntax::Yaml);
    }
}

/// A letter of several bytes before every word: no place begins or ends inside of it.
#[test]
fn letters_of_several_bytes() {
    let texts = [
        (HQ, Syntax::Native),
        (YAML, Syntax::Yaml),
        (include_str!("common/machines.hq"), Syntax::Native),
        (include_str!("common/machines.yaml"), Syntax::Yaml),
        (include_str!("common/missions.hq"), Syntax::Native),
        (include_str!("common/missions.yaml"), Syntax::Yaml),
    ];
    for (text, syntax) in texts {
        let mut last = ' ';
        for (at, c) in text.char_indices() {
            if c.is_ascii_alphanumeric() && !last.is_ascii_alphanumeric() {
                survive(&format!("{}⺛{}", &text[..at], &text[at..]), syntax);
            }
            last = c;
        }
    }
}

#[test]
fn a_repetition_without_a_name_is_shown_at_its_first_letter() {
    let text = "hierarq: 1\nfor:\n  - ⺛name: side\n    in: [left, right]\n";
    let (_, diags) = parse(SourceId(0), text, Syntax::Yaml);
    let found: Vec<_> = diags.iter().map(|d| (d.code, &text[d.primary.span.range()])).collect();
    assert_eq!(found, [("HQ0125", "⺛"), ("HQ0135", "⺛name")]);
    let text = "hierarq 1\nfor ⺛side in [left, right] {\n}\n";
    assert!(survive(text, Syntax::Native) > 0);
}

#[test]
fn deep_brackets_are_refused() {
    for open in ["[", "(", "{", "f(", "{ a ", "-(", "a b {"] {
        for count in [100, 1_000_000] {
            let text = format!("hierarq 1\nrobot r {{ a {}", open.repeat(count));
            assert_eq!(code(&text, Syntax::Native), ["HQ0191"], "{open}");
            let text = format!("hierarq: 1\nparams: {{ a: \"{}\" }}", open.repeat(count));
            assert_eq!(code(&text, Syntax::Yaml), ["HQ0191"], "{open}");
        }
    }
    assert!(code(&format!("hierarq: 1\nparams:\n a: {}", "[".repeat(100_000)), Syntax::Yaml).contains(&"HQ0191"));
    assert!(code(&format!("hierarq: 1\nparams:\n {}", "- ".repeat(100_000)), Syntax::Yaml).contains(&"HQ0191"));
    // Sixty are fine, on a small stack too.
    let deep = format!("{}1{}", "[".repeat(60), "]".repeat(60));
    let text = format!("hierarq 1\nparam a = {deep}\n");
    let thread = std::thread::Builder::new().stack_size(1 << 20);
    let codes = thread.spawn(move || code(&text, Syntax::Native)).unwrap().join().unwrap();
    assert!(codes.is_empty(), "{codes:?}");
}

#[test]
fn long_chains_are_refused() {
    for chain in ["-", "1+", "a^", "2*-"] {
        let value = format!("{}1", chain.repeat(100_000));
        assert_eq!(code(&format!("hierarq 1\nparam a = {value}\n"), Syntax::Native), ["HQ0195"], "{chain}");
    }
    let fields = format!("hierarq 1\nparam a = x{}\n", ".y".repeat(50_000));
    assert_eq!(code(&fields, Syntax::Native), ["HQ0195"]);
}

#[test]
fn alias_bombs_are_refused() {
    let mut text = String::from("hierarq: 1\nrobots:\n  r:\n    a0: &a0 [x, x, x, x, x, x, x, x, x]\n");
    for i in 1..20 {
        let aliases = vec![format!("*a{}", i - 1); 9].join(", ");
        text.push_str(&format!("    a{i}: &a{i} [{aliases}]\n"));
    }
    timed(&text, Syntax::Yaml);
    assert!(code(&text, Syntax::Yaml).contains(&"HQ0134"));
    let mut text = String::from("hierarq: 1\nrobots:\n  r:\n    a0: &a0 { x: 1 }\n");
    for i in 1..40 {
        text.push_str(&format!("    a{i}: &a{i} {{ <<: [*a{0}, *a{0}, *a{0}] }}\n", i - 1));
    }
    timed(&text, Syntax::Yaml);
}

#[test]
fn large_texts_are_bounded() {
    let fill = |line: &str| line.repeat((8 << 20) / line.len() - 1);
    for line in [
        "a 1\n",
        "[ ",
        "} ",
        "// x\n",
        "run {\n",
        "\"",
        "task x = y { a }\n",
        "a: b\n",
        "- ",
        "'",
        "$ ",
        " robot r { a 1 }\n",
    ] {
        timed(&format!("hierarq 1\n{}", fill(line)), Syntax::Native);
    }
    for line in ["a: 1\n", "[ ", "# x\n", "\"", "- a\n", "{ ", "'", "a: [\n", "&a "] {
        timed(&format!("hierarq: 1\n{}", fill(line)), Syntax::Yaml);
    }
    timed(&format!("hierarq 1\nmission m : k {{\n{}}}\n", fill(" task a = b { c 1 }\n")), Syntax::Native);
    timed(&format!("hierarq 1\nmission m : k {{\n{}", " layer a { x 1\n".repeat(60)), Syntax::Native);
    let huge = " ".repeat(limits::MAX_BYTES + 1);
    assert_eq!(code(&huge, Syntax::Native), ["HQ0190"]);
    assert_eq!(code(&huge, Syntax::Yaml), ["HQ0190"]);
    assert_eq!(code(&format!("hierarq 1\n{}", "$\n".repeat(5000)), Syntax::Native).len(), 101);
}

#[test]
fn byte_order_marks_and_bad_bytes() {
    let text = "\u{feff}hierarq 1\nparam a = 1 mtr\n";
    let (spec, diags) = parse(SourceId(0), text, Syntax::Native);
    assert_eq!((spec.items.len(), &text[diags[0].primary.span.range()]), (1, "mtr"));
    let text = "\u{feff}hierarq: 1\nparams: { é: 2, a: 1 mtr }\n";
    let (_, diags) = parse(SourceId(0), text, Syntax::Yaml);
    assert_eq!(&text[diags[1].primary.span.range()], "mtr");
    let error = limits::decode(SourceId(0), b"hierarq 1\n\xff").unwrap_err();
    assert_eq!((error.code, error.primary.span.range()), ("HQ0193", 10..11));
    assert_eq!(code("hierarq 1\n// bell \u{7}\n", Syntax::Native), ["HQ0194"]);
}
