//! Ages of readings, `age(SIGNAL)`: each signal whose age an expression of the spec reads is followed by a number that
//! the controller sets.

use std::collections::BTreeSet;

use dsl::tree::{
    Block, Entry, Expect, Formula, FormulaKind, MemberTask, StateBody, TaskDefinition, Trigger, Value, ValueKind,
};

use super::Lowerer;
use crate::expand::{Expanded, Named};
use crate::expr::AGE;
use crate::forms::target;

impl Lowerer<'_> {
    /// Declares the age of a signal behind it, if the spec reads it: the age itself, or that of its person.
    pub(super) fn declare_age(&mut self, signal: usize, person: Option<&str>) {
        let Some(name) = self.interface.signals.get(signal).map(|s| s.name.clone()) else { return };
        if !self.aged.contains(person.unwrap_or(&name)) {
            return;
        }
        let age = self.interface.declare_age(signal);
        self.params.ages.insert(name, self.interface.signals[age].at);
    }
}

/// Names of the signals and people whose ages a spec reads.
pub(super) fn aged(spec: &Expanded) -> BTreeSet<String> {
    let mut found = Found::default();
    for value in &spec.values {
        match value {
            Named::Param(p) => found.value(&p.value),
            Named::Let(l) => found.value(&l.value),
            Named::Signal(s) => found.block(&s.settings),
            Named::Block(b) => found.block(&b.body),
            Named::Variable(v) => v.value.iter().for_each(|v| found.value(v)),
        }
    }
    spec.robots.iter().for_each(|r| found.block(&r.body));
    spec.tasks.iter().for_each(|t| found.definition(&t.definition));
    for level in spec.stacks.iter().flat_map(|s| &s.levels) {
        for member in &level.members {
            if let MemberTask::Inline(definition) = &member.task {
                found.definition(definition);
            }
            member.weight.iter().for_each(|w| found.value(w));
        }
    }
    spec.machines.iter().for_each(|m| found.state(&m.body));
    for (scenario, _) in &spec.scenarios {
        found.block(&scenario.body);
        found.expects(&scenario.expects);
    }
    found.0
}

/// Names so far.
#[derive(Default)]
struct Found(BTreeSet<String>);

impl Found {
    fn value(&mut self, value: &Value) {
        if let ValueKind::Call(function, args) = &value.kind
            && function.value == AGE
            && let [one] = args.as_slice()
        {
            let of = if let ValueKind::Field(person, _) = &one.kind { person } else { one };
            if let ValueKind::Name(name) = &of.kind {
                self.0.insert(target(name).to_string());
            }
        }
        value.parts().into_iter().for_each(|part| self.value(part));
    }

    fn entries(&mut self, entries: &[Entry]) {
        entries.iter().for_each(|e| self.value(&e.value));
    }

    fn block(&mut self, block: &Block) {
        self.entries(&block.entries);
    }

    fn definition(&mut self, of: &TaskDefinition) {
        of.args.iter().for_each(|v| self.value(v));
        self.entries(&of.named);
        self.block(&of.body);
    }

    fn state(&mut self, body: &StateBody) {
        self.block(&body.settings);
        for action in &body.actions {
            action.args.iter().for_each(|v| self.value(v));
            self.entries(&action.named);
        }
        for transition in &body.transitions {
            self.block(&transition.settings);
            match &transition.trigger {
                Trigger::On(value) | Trigger::After(value) => self.value(value),
                Trigger::When { condition, hold } => {
                    self.value(condition);
                    hold.iter().for_each(|v| self.value(v));
                }
                Trigger::Missing => {}
            }
        }
        self.expects(&body.properties);
        body.states.iter().for_each(|s| self.state(&s.body));
    }

    fn expects(&mut self, all: &[Expect]) {
        all.iter().for_each(|e| self.formula(&e.formula));
    }

    fn formula(&mut self, formula: &Formula) {
        match &formula.kind {
            FormulaKind::Always(_, a)
            | FormulaKind::Eventually(_, a)
            | FormulaKind::Never(_, a)
            | FormulaKind::Not(a) => {
                self.formula(a);
            }
            FormulaKind::Until(a, _, b)
            | FormulaKind::After(a, b)
            | FormulaKind::And(a, b)
            | FormulaKind::Or(a, b)
            | FormulaKind::Implies(a, b) => {
                self.formula(a);
                self.formula(b);
            }
            FormulaKind::Value(value) => self.value(value),
            FormulaKind::Missing => {}
        }
    }
}
