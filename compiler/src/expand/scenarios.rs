//! Copies the scenarios of the spec and renames values to their names in the program. Scenarios of imported files are
//! ignored.

use dsl::tree::{Expect, Formula, FormulaKind, ItemKind, Scenario, Window};

use super::Expander;
use super::substitute::Frame;

impl Expander<'_> {
    /// Adds the scenarios of the spec to the program.
    pub(super) fn scenarios(&mut self) {
        let written = self.modules[0].items.iter().filter_map(|item| match &item.kind {
            ItemKind::Scenario(scenario) => Some(scenario.clone()),
            _ => None,
        });
        for scenario in written.collect::<Vec<_>>() {
            let texts = scenario.expects.iter().map(|e| dsl::formula_text(&e.formula)).collect();
            let copy = self.copied_scenario(&scenario, &mut Frame::of(0));
            self.out.scenarios.push((copy, texts));
        }
    }

    pub(super) fn copied_scenario(&mut self, s: &Scenario, frame: &mut Frame) -> Scenario {
        let expects = s.expects.iter().map(|e| self.expect(e, frame)).collect();
        Scenario { name: self.name(&s.name, frame), body: self.block(&s.body, frame), expects }
    }

    /// Copies an expectation, or a property of a machine.
    pub(super) fn expect(&mut self, e: &Expect, frame: &mut Frame) -> Expect {
        Expect {
            label: e.label.as_ref().map(|label| self.name(label, frame)),
            formula: self.formula(&e.formula, frame),
            span: self.at(e.span, frame),
            comments: Default::default(),
        }
    }

    fn formula(&mut self, f: &Formula, frame: &mut Frame) -> Formula {
        use FormulaKind::{After, Always, And, Eventually, Implies, Missing, Never, Not, Or, Until, Value};
        let span = self.at(f.span, frame);
        let kind = match &f.kind {
            Always(w, a) => Always(self.window(w, frame), self.operand(a, frame)),
            Eventually(w, a) => Eventually(self.window(w, frame), self.operand(a, frame)),
            Never(w, a) => Never(self.window(w, frame), self.operand(a, frame)),
            Until(a, w, b) => Until(self.operand(a, frame), self.window(w, frame), self.operand(b, frame)),
            After(a, b) => After(self.operand(a, frame), self.operand(b, frame)),
            Not(a) => Not(self.operand(a, frame)),
            And(a, b) => And(self.operand(a, frame), self.operand(b, frame)),
            Or(a, b) => Or(self.operand(a, frame), self.operand(b, frame)),
            Implies(a, b) => Implies(self.operand(a, frame), self.operand(b, frame)),
            Value(v) => Value(self.value(v, frame)),
            Missing => Missing,
        };
        Formula { kind, span }
    }

    fn operand(&mut self, f: &Formula, frame: &mut Frame) -> Box<Formula> {
        Box::new(self.formula(f, frame))
    }

    fn window(&mut self, w: &Window, frame: &mut Frame) -> Window {
        let from = w.from.as_ref().map(|v| self.value(v, frame));
        let to = w.to.as_ref().map(|v| self.value(v, frame));
        Window { from, to, span: self.at(w.span, frame) }
    }
}
