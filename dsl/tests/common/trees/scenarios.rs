//! Scenarios and what they expect.

use super::expressions::*;
use hierarq_dsl::Span;
use hierarq_dsl::tree::*;
use proptest::prelude::*;

fn window() -> BoxedStrategy<Window> {
    let some = (prop::option::of(expr()), prop::option::of(expr()));
    let some = some.prop_map(|(from, to)| Window { from, to, span: Span::default() });
    prop_oneof![1 => Just(Window::default()), 1 => some].boxed()
}

/// False where a value begins with a word of formulas.
fn may_stand(f: &Formula) -> bool {
    const WORDS: &[&str] = &["always", "eventually", "never", "within", "from", "to", "after", "until", "implies"];
    fn first(value: &Value) -> &str {
        match &value.kind {
            ValueKind::Name(name) => name,
            ValueKind::Call(name, _) => name,
            ValueKind::Unit(of, _) | ValueKind::Field(of, _) | ValueKind::In(of, _) => first(of),
            ValueKind::Binary(_, left, _) => first(left),
            _ => "",
        }
    }
    match &f.kind {
        FormulaKind::Value(value) => !WORDS.contains(&first(value)),
        FormulaKind::Not(a) => may_stand(a),
        FormulaKind::And(a, b) | FormulaKind::Or(a, b) => may_stand(a) && may_stand(b),
        _ => true,
    }
}

pub fn formula() -> BoxedStrategy<Formula> {
    let made = |kind| Formula { kind, span: Span::default() };
    let word = prop::sample::select(&["expect", "in", "on", "for", "m"][..]);
    let leaf = prop_oneof![
        4 => expr().prop_map(Formula::of).prop_filter("a word of formulas", may_stand),
        1 => word.prop_map(|n| Formula::of(value(ValueKind::Name(n.to_owned())))),
    ];
    leaf.prop_recursive(5, 16, 3, move |inner| {
        let f = inner.prop_map(Box::new).boxed();
        prop_oneof![
            (window(), f.clone()).prop_map(|(w, f)| FormulaKind::Always(w, f)),
            (window(), f.clone()).prop_map(|(w, f)| FormulaKind::Eventually(w, f)),
            (window(), f.clone()).prop_map(|(w, f)| FormulaKind::Never(w, f)),
            (f.clone(), window(), f.clone()).prop_map(|(a, w, b)| FormulaKind::Until(a, w, b)),
            (f.clone(), f.clone()).prop_map(|(a, b)| FormulaKind::After(a, b)),
            f.clone().prop_map(FormulaKind::Not),
            (f.clone(), f.clone()).prop_map(|(a, b)| FormulaKind::And(a, b)),
            (f.clone(), f.clone()).prop_map(|(a, b)| FormulaKind::Or(a, b)),
            (f.clone(), f).prop_map(|(a, b)| FormulaKind::Implies(a, b)),
        ]
        .prop_map(made)
    })
    .boxed()
}

/// An expectation, or a property of a machine.
pub(super) fn expect(formula: BoxedStrategy<Formula>) -> BoxedStrategy<Expect> {
    (prop::option::of(text()), formula, comments())
        .prop_map(|(label, formula, comments)| Expect {
            label: label.map(spanned),
            formula,
            span: Span::default(),
            comments,
        })
        .boxed()
}

pub(super) fn scenario() -> BoxedStrategy<Scenario> {
    let name = prop_oneof![name(), text().prop_filter("a name", |t| !t.is_empty())];
    (name, settings(&["expect"], any_value(), true), prop::collection::vec(expect(formula()), 0..3))
        .prop_map(|(name, body, expects)| Scenario { name: spanned(name), body, expects })
        .boxed()
}
