//! Scenarios: the events of the environment in a run, and the expected behaviour, in signal temporal logic.

use super::{Block, Comments, Value, ValueKind};
use crate::span::{Span, Spanned};

/// `scenario "bunch hidden by leaves" { machine harvest  expect always margin(arms_apart) >= 0 m }`
#[derive(Clone, Debug, PartialEq)]
pub struct Scenario {
    /// Its name: a word, or a text.
    pub name: Spanned<String>,
    /// Settings and events of the environment.
    pub body: Block,
    /// Expectations, in the order written.
    pub expects: Vec<Expect>,
}

/// `expect "hands stay" always error(hands) < 0.5 mm`
#[derive(Clone, Debug)]
pub struct Expect {
    /// Name in reports.
    pub label: Option<Spanned<String>>,
    /// The expected property.
    pub formula: Formula,
    /// The whole expectation.
    pub span: Span,
    /// Comments before and after it.
    pub comments: Comments,
}

equal_by!(Expect: label, formula);

/// A formula of signal temporal logic.
#[derive(Clone, Debug)]
pub struct Formula {
    /// Content.
    pub kind: FormulaKind,
    /// Location.
    pub span: Span,
}

equal_by!(Formula: kind);

/// The kinds of formula, in rising precedence: `implies`, `until`, `or`, `and`, then `not` and the temporal operators.
/// Both `implies` and `until` are right-associative. The operand of a temporal operator extends up to `until` or
/// `implies`: `always a and b` is `always (a and b)`.
#[derive(Clone, Debug, PartialEq)]
pub enum FormulaKind {
    /// `always from 2 s to 5 s : f`
    Always(Window, Box<Formula>),
    /// `eventually within 140 s : f`, `within 140 s : f`
    Eventually(Window, Box<Formula>),
    /// `never f`
    Never(Window, Box<Formula>),
    /// `f until within 20 s : g`
    Until(Box<Formula>, Window, Box<Formula>),
    /// `after f : g`: whenever `f` becomes true, `g` holds from then on.
    After(Box<Formula>, Box<Formula>),
    /// `not f`
    Not(Box<Formula>),
    /// `f and g`
    And(Box<Formula>, Box<Formula>),
    /// `f or g`
    Or(Box<Formula>, Box<Formula>),
    /// `f implies g`
    Implies(Box<Formula>, Box<Formula>),
    /// A comparison or a truth value; never `and`, `or` or `not`, which are kinds of their own.
    Value(Value),
    /// No readable formula; a diagnostic has reported it.
    Missing,
}

/// The time window of a temporal operator, relative to now: `within D`, `from A`, `from A to B`, `to B`.
#[derive(Clone, Debug, Default)]
pub struct Window {
    /// Start of the window; now if there is none.
    pub from: Option<Value>,
    /// End of the window; the end of the run if there is none.
    pub to: Option<Value>,
    /// Location; empty if no window was written.
    pub span: Span,
}

equal_by!(Window: from, to);

impl Window {
    /// Returns true if no window was written: all times from now on.
    pub fn is_open(&self) -> bool {
        self.from.is_none() && self.to.is_none()
    }
}

impl Formula {
    /// Converts a truth value to a formula: `and`, `or`, `not`, and calls such as `always(f)`, become kinds of their
    /// own.
    pub fn of(value: Value) -> Formula {
        let span = value.span;
        let of = |value: Box<Value>| Box::new(Formula::of(*value));
        let kind = match value.kind {
            ValueKind::Missing => FormulaKind::Missing,
            ValueKind::Not(inner) => FormulaKind::Not(of(inner)),
            ValueKind::Binary(op, a, b) if op.value == super::BinaryOp::And => FormulaKind::And(of(a), of(b)),
            ValueKind::Binary(op, a, b) if op.value == super::BinaryOp::Or => FormulaKind::Or(of(a), of(b)),
            ValueKind::Call(name, mut args)
                if args.len() == 1 && matches!(name.as_str(), "always" | "eventually" | "never") =>
            {
                let inner = args.pop().map_or(Formula { kind: FormulaKind::Missing, span }, Formula::of);
                let (window, inner) =
                    (Window { span: Span { end: span.start, ..span }, ..Window::default() }, Box::new(inner));
                match name.as_str() {
                    "always" => FormulaKind::Always(window, inner),
                    "never" => FormulaKind::Never(window, inner),
                    _ => FormulaKind::Eventually(window, inner),
                }
            }
            kind => FormulaKind::Value(Value { kind, span }),
        };
        Formula { kind, span }
    }
}
