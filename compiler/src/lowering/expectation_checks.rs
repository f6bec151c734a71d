//! Expectations that say less than they seem to: judged at one tick alone, about an antecedent that is never true, or about
//! a comparison that has the same result whatever the robot does. Each is a warning: the formula is valid, and a run
//! that satisfies it proves nothing.

use dsl::tree::{BinaryOp, Expect, Formula, FormulaKind, Value, ValueKind};
use dsl::{Diagnostic, Fix};

use super::Lowerer;
use crate::expr::constants::Constants;

/// Measurements that are a size, so that they are zero or more.
const SIZES: &[&str] = &["error", "speed", "acceleration", "reversals", "norm", "abs"];

/// One side of an expression, from a comparison with a constant.
struct Bound<'v> {
    of: &'v Value,
    /// The constant (SI).
    at: f64,
    /// True for a lower bound, `of >= at`.
    lower: bool,
    comparison: &'v Value,
}

/// Warns of an expectation without a word of time, which is judged at the first tick alone.
pub(super) fn first_tick(expect: &Expect) -> Option<Diagnostic> {
    if !without_time(&expect.formula) {
        return None;
    }
    let at = expect.formula.span;
    let d = Diagnostic::warning("HQ0808", at, "this is judged at the first tick alone");
    let before = dsl::Span { end: at.start, ..at };
    Some(
        d.note("without `always`, `eventually`, `never` or `within` an expectation speaks of the start of the run")
            .help("write `always` or `eventually` before it; if the start is meant, write `within 0 s :`")
            .fix(Fix::edit("Write `always`", before, "always "))
            .fix(Fix::edit("Write `eventually`", before, "eventually ")),
    )
}

/// True for a formula that has a value at one time.
fn without_time(formula: &Formula) -> bool {
    use FormulaKind as F;
    match &formula.kind {
        F::Value(_) => true,
        F::Not(a) => without_time(a),
        F::And(a, b) | F::Or(a, b) | F::Implies(a, b) => without_time(a) && without_time(b),
        F::Always(..) | F::Eventually(..) | F::Never(..) | F::Until(..) | F::After(..) | F::Missing => false,
    }
}

/// True for a value with a `present(..)` in it.
pub(super) fn asks_for_presence(value: &Value) -> bool {
    match &value.kind {
        ValueKind::Call(name, args) => name.value == "present" || args.iter().any(asks_for_presence),
        ValueKind::Binary(_, a, b) => asks_for_presence(a) || asks_for_presence(b),
        ValueKind::Unit(a, _)
        | ValueKind::Field(a, _)
        | ValueKind::In(a, _)
        | ValueKind::Negate(a)
        | ValueKind::Not(a) => asks_for_presence(a),
        ValueKind::List(items) => items.iter().any(asks_for_presence),
        ValueKind::Named(_, a) => asks_for_presence(a),
        _ => false,
    }
}

impl Lowerer<'_> {
    /// Warns of antecedents that are never true, and of comparisons that are always or never true.
    pub(super) fn idle_conditions(&mut self, formula: &Formula, found: &mut Vec<Diagnostic>) {
        use FormulaKind as F;
        match &formula.kind {
            F::Value(value) => self.idle_comparison(value, found),
            F::Always(_, a) | F::Eventually(_, a) | F::Never(_, a) | F::Not(a) => self.idle_conditions(a, found),
            F::And(a, b) | F::Or(a, b) | F::Until(a, _, b) => {
                self.idle_conditions(a, found);
                self.idle_conditions(b, found);
            }
            F::Implies(a, b) | F::After(a, b) => {
                let before = found.len();
                self.idle_conditions(a, found);
                if found.len() == before {
                    found.extend(self.contradiction(a));
                }
                self.idle_conditions(b, found);
            }
            F::Missing => {}
        }
    }

    /// Warns of a comparison of a size with a number that it always or never passes.
    fn idle_comparison(&mut self, value: &Value, found: &mut Vec<Diagnostic>) {
        if let ValueKind::Binary(op, left, right) = &value.kind
            && matches!(op.value, BinaryOp::And | BinaryOp::Or)
        {
            self.idle_comparison(left, found);
            self.idle_comparison(right, found);
            return;
        }
        let Some(Bound { of, at, lower, .. }) = self.bound(value) else { return };
        let ValueKind::Call(name, _) = &of.kind else { return };
        if !SIZES.contains(&name.value.as_str()) {
            return;
        }
        let size = name.value.as_str();
        let d = match (lower, at) {
            // `>` and `>=` are equivalent, and zero is true.
            (true, at) if at <= 0.0 => {
                let d = Diagnostic::warning("HQ0811", value.span, "this is always true").here("zero or more");
                d.help(format!("`{size}` is zero or more: compare it with a number above zero"))
            }
            (false, at) if at < 0.0 => {
                let d = Diagnostic::warning("HQ0811", value.span, "this is never true").here("zero or more");
                d.help(format!("`{size}` is never negative: compare it with a number from zero on"))
            }
            _ => return,
        };
        found.push(d.note("an expectation on it holds or fails whatever the robot does"));
    }

    /// Warns of an antecedent whose comparisons contradict each other.
    fn contradiction(&mut self, antecedent: &Formula) -> Option<Diagnostic> {
        let mut parts = Vec::new();
        conjuncts(antecedent, &mut parts);
        let bounds: Vec<Bound> = parts.into_iter().filter_map(|part| self.bound(part)).collect();
        let lowers = || bounds.iter().filter(|b| b.lower);
        let pair = lowers().find_map(|low| {
            let high = bounds.iter().find(|high| !high.lower && high.of == low.of && high.at < low.at)?;
            Some((low, high))
        })?;
        let (low, high) = pair;
        let d = Diagnostic::warning("HQ0811", antecedent.span, "this is never true, so nothing is expected");
        Some(
            d.label(low.comparison.span, "above this")
                .label(high.comparison.span, "and below this")
                .help("correct one of the two numbers; for two cases write `or`"),
        )
    }

    /// Reads a comparison of an expression with a constant number.
    fn bound<'v>(&mut self, comparison: &'v Value) -> Option<Bound<'v>> {
        let ValueKind::Binary(op, left, right) = &comparison.kind else { return None };
        let less = match op.value {
            BinaryOp::Less | BinaryOp::LessEqual => true,
            BinaryOp::Greater | BinaryOp::GreaterEqual => false,
            _ => return None,
        };
        match (self.constant_number(left), self.constant_number(right)) {
            (None, Some(at)) => Some(Bound { of: left, at, lower: !less, comparison }),
            (Some(at), None) => Some(Bound { of: right, at, lower: less, comparison }),
            _ => None,
        }
    }

    /// Evaluates a number that depends on nothing; `None` for others.
    fn constant_number(&mut self, value: &Value) -> Option<f64> {
        let typed = Constants { graph: &mut self.graph, params: &mut self.params }.argument(value)?;
        let [node] = typed.nodes.as_slice() else { return None };
        self.graph.constant(*node)
    }
}

/// Collects the parts of a conjunction.
fn conjuncts<'f>(formula: &'f Formula, out: &mut Vec<&'f Value>) {
    match &formula.kind {
        FormulaKind::Value(value) => and_parts(value, out),
        FormulaKind::And(a, b) => {
            conjuncts(a, out);
            conjuncts(b, out);
        }
        _ => {}
    }
}

fn and_parts<'v>(value: &'v Value, out: &mut Vec<&'v Value>) {
    match &value.kind {
        ValueKind::Binary(op, left, right) if op.value == BinaryOp::And => {
            and_parts(left, out);
            and_parts(right, out);
        }
        _ => out.push(value),
    }
}
