//! Places in the text of a scenario, and its expectations as formulas of predicates.

use dsl::tree::{Formula, FormulaKind, Value, ValueKind};
use dsl::{Diagnostic, Span};

use super::Scene;
use crate::analysis::played::Truths;

impl Scene<'_> {
    /// The value of a key of the script of a member: `humans`, `signals`.
    pub(super) fn script(&self, class: &str, name: &str) -> Option<&Value> {
        let ValueKind::Block(block) = &self.written.body.get(class)?.value.kind else { return None };
        block.get(name).map(|e| &e.value)
    }

    /// Span of the first of these keys in a script, or of the script.
    pub(super) fn of_script(&self, class: &str, name: &str, keys: &[&str]) -> Span {
        let Some(script) = self.script(class, name) else { return self.written.name.span };
        let parts = script.items().iter().filter_map(Value::block);
        let found = parts.flat_map(|block| keys.iter().filter_map(|key| block.get(key))).next();
        found.map_or(script.span, |e| e.value.span)
    }

    /// The predicate of a comparison or truth value.
    pub(super) fn predicate_of(&self, value: &Value) -> Option<usize> {
        self.played.places.atoms.iter().find(|atom| atom.at == value.span).map(|atom| atom.predicate)
    }

    /// Possible results of a formula, at some tick of the run.
    pub(super) fn truths(&self, f: &Formula) -> Truths {
        use FormulaKind as F;
        let both = |a: &Formula, b: &Formula| (self.truths(a), self.truths(b));
        match &f.kind {
            F::Value(value) => self.predicate_of(value).map_or(Truths::OPEN, |p| self.played.predicate(p)),
            F::Not(a) | F::Never(_, a) => {
                let of = self.truths(a);
                Truths { holds: of.fails, fails: of.holds }
            }
            F::And(a, b) => {
                let (a, b) = both(a, b);
                Truths { holds: a.holds && b.holds, fails: a.fails || b.fails }
            }
            F::Or(a, b) => {
                let (a, b) = both(a, b);
                Truths { holds: a.holds || b.holds, fails: a.fails && b.fails }
            }
            F::Implies(a, b) | F::After(a, b) => {
                let (a, b) = both(a, b);
                Truths { holds: a.fails || b.holds, fails: a.holds && b.fails }
            }
            F::Always(_, a) | F::Eventually(_, a) => self.truths(a),
            F::Until(_, _, b) => Truths { fails: true, ..self.truths(b) },
            F::Missing => Truths::OPEN,
        }
    }

    /// True if one of these codes was reported at a place.
    pub(super) fn is_reported(out: &[Diagnostic], codes: &[&str], at: Span) -> bool {
        let touches = |span: Span| span.source == at.source && span.start < at.end && at.start < span.end;
        out.iter().any(|d| codes.contains(&d.code) && touches(d.primary.span))
    }
}
