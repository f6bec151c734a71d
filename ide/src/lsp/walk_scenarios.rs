//! Indexes scenarios: the measures in expectations.

use dsl::tree::{Formula, FormulaKind, Value, ValueKind};

use super::mentions::{Class, MARKER, Slot, Walker, What};
use super::walk::word;

impl Walker<'_> {
    /// Indexes a formula of an expectation.
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

    /// Indexes the argument of `margin(..)` and other measures.
    pub(super) fn measured(&mut self, function: &str, value: &Value) {
        match (function, &value.kind) {
            ("margin" | "error", ValueKind::Field(inner, _)) => self.measured(function, inner),
            ("margin" | "error", _) => {
                let Some(name) = word(value) else { return };
                if !self.marked(name, || Slot::Task) && !self.scoped(name, value.span) {
                    self.note(name, value.span, What::Declared(Class::Task, name.to_string()));
                }
            }
            ("in", _) if self.mission.is_some() => self.state_of_worker(value),
            ("in", _) => self.state_path(value),
            ("reversals", _) => self.joints(value),
            ("speed" | "acceleration", _) => match word(value) {
                Some(name) if name != MARKER && self.urdf.is_some_and(|u| !u.joints.contains_key(name)) => {
                    self.frame(value)
                }
                _ => self.joints(value),
            },
            ("fault", _) => {
                self.marked(word(value).unwrap_or(""), || Slot::Faults);
            }
            _ => {
                self.marked(word(value).unwrap_or(""), || Slot::Nothing);
            }
        }
    }

    /// Indexes a state by its path from the machine, `outer.inner`.
    fn state_path(&mut self, value: &Value) {
        let (mut parts, mut rest) = (Vec::new(), value);
        while let ValueKind::Field(inner, field) = &rest.kind {
            parts.push((field.value.as_str(), field.span));
            rest = inner;
        }
        let Some(first) = word(rest) else { return };
        parts.push((first, rest.span));
        parts.reverse();
        let machines: Vec<String> = self.found.names(Class::Machine).map(str::to_string).collect();
        if let Some(((MARKER, _), before)) = parts.split_last() {
            let holder = |m: &String| before.iter().fold(m.clone(), |path, part| format!("{path}.{}", part.0));
            let names = machines.iter().flat_map(|m| self.inside(&holder(m)));
            self.found.slot = Some(Slot::Offered(names.map(|n| (n, Class::State.word())).collect()));
            return;
        }
        let known = machines.into_iter().find(|m| self.has(Class::State, &format!("{m}.{first}")));
        let Some(mut key) = known else { return };
        for (part, span) in parts {
            key = format!("{key}.{part}");
            self.note(part, span, What::Declared(Class::State, key.clone()));
        }
    }
}
