//! Unrolls `for`: repeated declarations, and the values of a repetition.

use dsl::Diagnostic;
use dsl::tree::{
    Coverage, Item, ItemKind, Let, Number, Param, Parameter, RepeatItems, Stack, Task, Value, ValueKind, Values,
};

use super::module::missing;
use super::substitute::Frame;
use super::{Expander, MAX_NODES};

impl Expander<'_> {
    /// Unrolls the repetitions among the declarations of a module, without the imports, which are resolved already.
    pub(super) fn unrolled(&mut self, module: usize, items: &[Item]) -> Vec<Item> {
        let mut out = Vec::new();
        for item in items {
            match &item.kind {
                ItemKind::Import(_) => {}
                ItemKind::For(repeat) => self.unroll(repeat, &mut Frame::unresolved(module), &mut out),
                _ => out.push(item.clone()),
            }
        }
        out
    }

    fn unroll(&mut self, repeat: &RepeatItems, frame: &mut Frame, out: &mut Vec<Item>) {
        for value in self.values(&repeat.values, frame).unwrap_or_default() {
            let at = value.span;
            let mut inner = frame.with(&repeat.variable.value, value, at);
            for item in &repeat.body {
                if !self.count(item.span) {
                    return;
                }
                let kind = match &item.kind {
                    ItemKind::Param(p) => ItemKind::Param(Param {
                        name: self.name(&p.name, &mut inner),
                        value: self.value(&p.value, &mut inner),
                        range: self.block(&p.range, &mut inner),
                    }),
                    ItemKind::Let(l) => ItemKind::Let(Let {
                        name: self.name(&l.name, &mut inner),
                        value: self.value(&l.value, &mut inner),
                    }),
                    ItemKind::Task(t) => ItemKind::Task(self.repeated_task(t, &mut inner)),
                    ItemKind::Stack(s) => ItemKind::Stack(self.repeated_stack(s, &mut inner)),
                    ItemKind::For(r) => {
                        self.unroll(r, &mut inner, out);
                        continue;
                    }
                    ItemKind::Signal(s) => ItemKind::Signal(self.copied_signal(s, &mut inner)),
                    ItemKind::Block(b) => ItemKind::Block(self.copied_block(b, &mut inner)),
                    ItemKind::Variable(v) => ItemKind::Variable(self.copied_variable(v, &mut inner)),
                    ItemKind::Machine(m) => ItemKind::Machine(self.copied_machine(m, &mut inner)),
                    ItemKind::Mission(m) => ItemKind::Mission(self.copied_mission(m, &mut inner)),
                    ItemKind::Scenario(s) => ItemKind::Scenario(self.copied_scenario(s, &mut inner)),
                    ItemKind::Coverage(c) => ItemKind::Coverage(Coverage { body: self.block(&c.body, &mut inner) }),
                    // The parser rejects the others.
                    ItemKind::Import(_) | ItemKind::Allow(_) | ItemKind::Robot(_) | ItemKind::Run(_) => continue,
                };
                out.push(Item { kind, span: self.at(item.span, &mut inner), comments: Default::default() });
            }
        }
    }

    fn repeated_task(&mut self, t: &Task, frame: &mut Frame) -> Task {
        let name = self.name(&t.name, frame);
        let parameters = self.repeated_parameters(&t.parameters, frame);
        Task { name, definition: self.copied(&t.definition, &mut hidden(frame, &parameters)), parameters }
    }

    fn repeated_parameters(&mut self, all: &[Parameter], frame: &mut Frame) -> Vec<Parameter> {
        let mut one = |p: &Parameter| Parameter {
            name: self.name(&p.name, frame),
            ty: self.name(&p.ty, frame),
            default: p.default.as_ref().map(|d| self.value(d, frame)),
            span: self.at(p.span, frame),
        };
        all.iter().map(&mut one).collect()
    }

    fn repeated_stack(&mut self, s: &Stack, frame: &mut Frame) -> Stack {
        let name = self.name(&s.name, frame);
        let parameters = self.repeated_parameters(&s.parameters, frame);
        let mut inner = hidden(frame, &parameters);
        let stack = self.stack_as_written(s, &mut inner);
        Stack { name, parameters, ..stack }
    }

    /// Copies the values of a repetition; `None` if they are wrong, which is reported.
    pub(super) fn values(&mut self, values: &Values, frame: &mut Frame) -> Option<Vec<Value>> {
        match values {
            Values::List(list) => {
                let list = self.value(list, frame);
                match list.kind {
                    ValueKind::List(items) => items.iter().all(|v| self.shallow(v)).then_some(items),
                    kind if missing(&kind) => None,
                    _ => {
                        let d = Diagnostic::error("HQ0219", list.span, "`for` runs over a list or a range");
                        self.fail(d.help("write the values, `[left, right]`, or whole numbers, `1..4`"));
                        None
                    }
                }
            }
            Values::Range(first, last) => {
                let (first, last) = (self.value(first, frame), self.value(last, frame));
                let (a, b) = (self.whole(&first), self.whole(&last));
                let (a, b) = (a?, b?);
                if b < a {
                    let d = Diagnostic::error(
                        "HQ0219",
                        first.span.to(last.span),
                        format!("the range from {a} to {b} is empty"),
                    );
                    self.fail(d.help("write the smaller number first; both ends belong to the range"));
                    return None;
                }
                if b - a >= MAX_NODES as i64 {
                    self.nodes = self.nodes.max(MAX_NODES);
                    self.count(first.span.to(last.span));
                    return None;
                }
                let one = |i: i64| Value {
                    kind: ValueKind::Number(Number { value: i as f64, text: i.to_string() }),
                    span: first.span.to(last.span),
                };
                Some((a..=b).map(one).collect())
            }
        }
    }

    /// Integer at the end of a range.
    fn whole(&mut self, value: &Value) -> Option<i64> {
        let number = |n: &Number| (n.value.fract() == 0.0 && n.value.abs() < 1e9).then_some(n.value as i64);
        let found = match &value.kind {
            ValueKind::Number(n) => number(n),
            ValueKind::Negate(of) => match &of.kind {
                ValueKind::Number(n) => number(n).map(|n| -n),
                _ => None,
            },
            ValueKind::Missing => return None,
            _ => None,
        };
        if found.is_some() {
            return found;
        }
        let d = Diagnostic::error("HQ0219", value.span, "the ends of a range are whole numbers, written out");
        self.fail(
            d.note("the number of repetitions must be known before values are evaluated")
                .help("write for instance `1..4`; inside a declaration, a parameter of type `number` is allowed too"),
        );
        None
    }
}

/// Frame inside a declaration with parameters, which shadow names of the enclosing frame.
fn hidden(frame: &Frame, parameters: &[Parameter]) -> Frame {
    let mut inner = frame.clone();
    inner.bound.retain(|name, _| !parameters.iter().any(|p| p.name.value == *name));
    inner
}
