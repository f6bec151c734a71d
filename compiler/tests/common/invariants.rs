//! Invariants of every text, however broken. Used by the tests, which damage examples, and by the fuzzer (`fuzz/`),
//! which includes this file.

use std::collections::BTreeSet;
use std::path::Path;

use dsl::tree::{Item, ItemKind};
use dsl::{Diagnostic, SourceId, Sources, Syntax, limits, parse, print};
use hierarq_compiler::resolve::{CURSOR, resolve};
use hierarq_compiler::{Input, Style, Texts, codes, compile};
use runtime::{Controller, Observation};

/// Every span covers whole characters of an existing text, and every code has a page.
fn points_into(diagnostics: &[Diagnostic], sources: &Sources) {
    for d in diagnostics {
        assert!(codes::explain(d.code).is_some(), "{} has no page", d.code);
        for span in d.labels.iter().map(|l| l.span).chain([d.primary.span]) {
            let text = sources.get(span.source).and_then(|s| s.text.get(span.range()));
            assert!(text.is_some(), "{d:?} points outside of its text");
        }
    }
}

/// Parsing a text never panics, and reports a bounded number of diagnostics with valid spans.
pub fn reads(text: &str, syntax: Syntax) {
    let mut sources = Sources::default();
    let source = sources.add("text", text);
    let (spec, diagnostics) = parse(source, text, syntax);
    assert!(diagnostics.len() <= limits::MAX_DIAGNOSTICS + 1);
    points_into(&diagnostics, &sources);
    // The language server prints broken trees, too.
    print(&spec, Syntax::Native);
    print(&spec, Syntax::Yaml);
}

/// A text without mistakes, printed in either syntax, parses to the same spec, and is printed identically again.
pub fn formats(text: &str, syntax: Syntax) {
    let (spec, diagnostics) = parse(SourceId(0), text, syntax);
    if !diagnostics.is_empty() {
        return;
    }
    // YAML cannot represent duplicate names or a second `run`; the compiler rejects both.
    if declares_twice(&spec.items) {
        return;
    }
    let spec = spec.normalised();
    for to in [Syntax::Native, Syntax::Yaml] {
        let printed = print(&spec, to);
        let (read, diagnostics) = parse(SourceId(0), &printed, to);
        if diagnostics.iter().any(|d| matches!(d.code, "HQ0190" | "HQ0191" | "HQ0195")) {
            // The other syntax may exceed the size limits.
            continue;
        }
        assert!(diagnostics.is_empty(), "{to:?} cannot be read back: {diagnostics:?}\n{printed}");
        assert_eq!(read.clone().normalised(), spec, "{to:?} says something else\n{printed}");
        assert_eq!(print(&read, to), printed, "{to:?} is not printed as it was");
    }
}

/// The symbols and references of a text cover whole characters of existing texts, at the cursor of an editor too.
fn names(input: &Input) {
    let middle = (input.text.len() / 2..=input.text.len()).find(|&i| input.text.is_char_boundary(i)).unwrap_or(0);
    let at_cursor = [&input.text[..middle], CURSOR, &input.text[middle..]].concat();
    for text in [input.text, &at_cursor] {
        let names = resolve(&Input { text, ..input.clone() }, &Texts::new(), &|_| None);
        for r in &names.references {
            assert!(text.get(r.place.clone()).is_some(), "{r:?} points outside of its text");
        }
        for symbol in &names.symbols {
            let there = names.text(&names.files[symbol.file.0]);
            assert!(there.get(symbol.place.clone()).is_some(), "{symbol:?} points outside of its text");
        }
    }
}

/// True if two declarations of one kind have the same name, here or inside a repetition.
fn declares_twice(items: &[Item]) -> bool {
    let mut seen = BTreeSet::new();
    items.iter().any(|item| {
        let declared = match &item.kind {
            ItemKind::Import(_) | ItemKind::Coverage(_) => return false,
            ItemKind::For(f) => return declares_twice(&f.body),
            ItemKind::Run(_) => ("run", String::new()),
            ItemKind::Allow(_) => ("allow", String::new()),
            ItemKind::Param(p) => ("param", p.name.value.clone()),
            ItemKind::Let(l) => ("let", l.name.value.clone()),
            ItemKind::Robot(r) => ("robot", r.name.value.clone()),
            ItemKind::Task(t) => ("task", t.name.value.clone()),
            ItemKind::Stack(s) => ("stack", s.name.value.clone()),
            ItemKind::Signal(s) => ("signal", s.name.value.clone()),
            ItemKind::Block(b) => (b.kind.keyword(), b.name.value.clone()),
            ItemKind::Variable(v) => ("variable", v.name.value.clone()),
            ItemKind::Machine(m) => ("machine", m.name.value.clone()),
            ItemKind::Mission(m) => ("mission", m.name.value.clone()),
            ItemKind::Scenario(s) => ("scenario", s.name.value.clone()),
        };
        !seen.insert(declared)
    })
}

/// Compiling a text never panics; there is a program if and only if there is no error; all diagnostics can be rendered;
/// and a program can be built and returns finite commands, or a fault with zero velocity.
pub fn checks(text: &str, syntax: Syntax, folder: &Path) {
    let input = Input { name: "spec", text, syntax, folder, set: &[], package_paths: &[] };
    let compiled = compile(&input);
    names(&input);
    let report = &compiled.report;
    assert_eq!(compiled.is_good(), report.errors() == 0, "{:?}", report.diagnostics);
    points_into(&report.diagnostics, &report.sources);
    assert_eq!(report.render(Style::Plain, 80).is_empty(), report.diagnostics.is_empty());
    for d in &report.diagnostics {
        let place = report.sources.get(d.primary.span.source).map(|s| s.name.as_str());
        assert_ne!(place, Some("a default of the task library"), "points into a default: {}", d.message);
    }
    let Some(program) = &compiled.program else { return };
    let mut controller = Controller::new(program).expect("a program that was accepted can be built");
    let q = program.robot.home.clone();
    for tick in 0..3 {
        let time = f64::from(tick) * program.robot.period;
        let command = controller.step(&Observation { time, q: &q });
        assert!(command.velocity.iter().all(|v| v.is_finite()), "a command that is not finite");
    }
}
