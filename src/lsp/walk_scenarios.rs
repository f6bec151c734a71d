//! Scenarios, word by word: what expectations measure.

use dsl::tree::{Formula, FormulaKind, Value, ValueKind};

use super::mentions::{Class, Slot, Walker, What};
use super::walk::word;

impl Walker<'_> {
    /// A formula of an expectation.
    pub(super) fn formula(&mut self, f: &Formula) {
        use FormulaKind as F;
        match &f.kind {
            F::Always(w, a) | F::Eventually(w, a) | F::Never(w, a) => {
                w.from.iter().chain(&w.to).for_each(|v| self.expression(v));
                self.formula(a);
            }
            F::Until(a, w, b) => {
                self.formula(a);
                w.from.iter().chain(&w.to).for_each(|v| self.expression(v));
                self.formula(b);
            }
            F::After(a, b) | F::And(a, b) | F::Or(a, b) | F::Implies(a, b) => {
                self.formula(a);
                self.formula(b);
            }
            F::Not(a) => self.formula(a),
            F::Value(v) => {
                let before = (self.state, self.expected);
                (self.state, self.expected) = (true, true);
                self.expression(v);
                (self.state, self.expected) = before;
            }
            F::Missing => {}
        }
    }

    /// What `margin(..)` and the like are said of.
    pub(super) fn measured(&mut self, function: &str, value: &Value) {
        match (function, &value.kind) {
            ("margin" | "error", ValueKind::Field(inner, _)) => self.measured(function, inner),
            ("margin" | "error", _) => {
                let Some(name) = word(value) else { return };
                if !self.marked(name, || Slot::Task) && !self.scoped(name, value.span) {
                    self.note(name, value.span, What::Declared(Class::Task, name.to_string()));
                }
            }
            ("speed", _) => self.joints(value),
            ("fault", _) => {
                self.marked(word(value).unwrap_or(""), || Slot::Faults);
            }
            _ => {
                self.marked(word(value).unwrap_or(""), || Slot::Nothing);
            }
        }
    }
}
