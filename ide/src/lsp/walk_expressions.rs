//! Indexes the words of expressions.

use compiler::expr::{MEASURES, TRAJECTORIES, Trajectory};
use dsl::tree::{Value, ValueKind};
use stdlib_tasks::task::Actual;

use super::mentions::{Class, MARKER, Slot, Walker, What};
use super::vocabulary::{CALLED, WRENCH_FIELDS, find};
use super::walk::{items, word};

impl Walker<'_> {
    /// Indexes an expression outside of tasks, which have no values to capture.
    pub(super) fn expression(&mut self, value: &Value) {
        self.typed(value, &[]);
    }

    /// Indexes an expression; `actuals` are the values that `initial(..)` can capture in it.
    pub(super) fn typed(&mut self, value: &Value, actuals: &'static [Actual]) {
        match &value.kind {
            ValueKind::Name(name) => {
                let slot = self.expression_slot();
                if self.marked(name, || slot) || self.scoped(name, value.span) {
                } else if self.has(Class::Let, name) {
                    self.note(name, value.span, What::Declared(Class::Let, name.clone()));
                } else if self.has(Class::Signal, name) {
                    self.note(name, value.span, What::Declared(Class::Signal, name.clone()));
                } else if self.has(Class::Human, name) {
                    self.note(name, value.span, What::Declared(Class::Human, name.clone()));
                } else if self.has(Class::Field, name) {
                    self.note(name, value.span, What::Declared(Class::Field, name.clone()));
                } else if self.expected && self.has(Class::Mission, name) {
                    self.note(name, value.span, What::Declared(Class::Mission, name.clone()));
                } else if find(name).is_some() && !CALLED.contains(&name.as_str()) {
                    self.note(name, value.span, What::BuiltIn(name.clone()));
                } else {
                    self.note(name, value.span, What::Declared(Class::Param, name.clone()));
                }
            }
            ValueKind::Unit(inner, unit) => {
                self.typed(inner, actuals);
                if unit.factors.iter().any(|f| f.0 == MARKER) {
                    self.found.slot = Some(Slot::Unit);
                } else {
                    self.found.all.push(super::mentions::Mention {
                        place: unit.span.range(),
                        exact: false,
                        declares: false,
                        what: What::Unit(unit.clone()),
                    });
                }
            }
            ValueKind::Call(function, args) => {
                let slot = self.expression_slot();
                if self.marked(&function.value, || slot) {
                    return;
                }
                self.note(&function.value, function.span, What::BuiltIn(function.value.clone()));
                match (function.value.as_str(), args.as_slice()) {
                    ("initial", [one]) => self.captured(one, actuals),
                    ("present", [one]) => self.signal_name(one),
                    ("uncertainty", [one]) => self.uncertain(one),
                    ("field", [one]) => {
                        if let Some(name) = word(one)
                            && !self.marked(name, || Slot::Field)
                        {
                            self.note(name, one.span, What::Declared(Class::Field, name.to_string()));
                        }
                    }
                    ("frame", [one]) => self.frame(one),
                    ("joint", [one]) => self.joints(one),
                    (name, [one]) if MEASURES.contains(&name) => self.measured(name, one),
                    ("point", [frame, offset]) => {
                        self.frame(frame);
                        self.typed(offset, actuals);
                    }
                    ("distance", parts) => parts.iter().for_each(|p| match &p.kind {
                        ValueKind::Call(..) => self.typed(p, actuals),
                        _ => items(p).iter().for_each(|one| self.part_or_person(one)),
                    }),
                    (name, args) => match TRAJECTORIES.iter().find(|t| t.name == name) {
                        Some(of) => self.trajectory(of, args, actuals),
                        None => args.iter().for_each(|a| self.typed(a, actuals)),
                    },
                }
            }
            ValueKind::Field(inner, field) => {
                if self.member_field(inner, field) || self.human_field(inner, field) {
                    return;
                }
                if let Some(name) = word(inner)
                    && self.has(Class::Task, name)
                    && !self.found.types.contains_key(name)
                {
                    let kind = self.found.kinds.get(name).and_then(|kind| stdlib_tasks::find(kind));
                    if !self.marked(&field.value, || Slot::Tells(kind.map_or(&[], |k| k.tells)))
                        && let Some(kind) = kind
                        && let Some(told) = kind.tells.iter().find(|t| t.name == field.value)
                    {
                        self.note(&field.value, field.span, What::Told(kind, told));
                    }
                    self.note(name, inner.span, What::Declared(Class::Task, name.to_string()));
                    return;
                }
                if matches!(&inner.kind, ValueKind::Call(f, _) if f.value == "frame") {
                    self.marked(&field.value, || Slot::FrameField);
                } else if word(inner).and_then(|n| self.found.types.get(n)).is_some_and(|ty| ty == "wrench") {
                    self.marked(&field.value, || Slot::Words(WRENCH_FIELDS));
                } else {
                    self.marked(&field.value, || Slot::ValueField);
                }
                self.typed(inner, actuals);
            }
            ValueKind::List(list) => list.iter().for_each(|v| self.typed(v, actuals)),
            ValueKind::In(inner, frame) => {
                self.typed(inner, actuals);
                if frame.value != "world" {
                    self.frame(&Value { kind: ValueKind::Name(frame.value.clone()), span: frame.span });
                }
            }
            ValueKind::Named(_, inner) | ValueKind::Negate(inner) | ValueKind::Not(inner) => self.typed(inner, actuals),
            ValueKind::Binary(_, left, right) => {
                self.typed(left, actuals);
                self.typed(right, actuals);
            }
            ValueKind::Block(_) => self.anything(value),
            ValueKind::Number(_) | ValueKind::Text(_) | ValueKind::Missing => {}
        }
    }

    /// Indexes a part of the robot, a person, or a point of a person.
    fn part_or_person(&mut self, value: &Value) {
        if self.mission.is_some() {
            return self.member_name(value, &["robot", "human", "worker"]);
        }
        if word(value).is_some_and(|name| self.marked(name, || Slot::PartOrPerson)) || self.human_name(value) {
            return;
        }
        self.geometries(value);
    }

    /// Indexes the arguments of a trajectory.
    fn trajectory(&mut self, of: &'static Trajectory, args: &[Value], actuals: &'static [Actual]) {
        let named = args.iter().filter_map(|a| match &a.kind {
            ValueKind::Named(name, _) => Some(name.value.clone()),
            _ => None,
        });
        let given: Vec<String> = named.collect();
        for arg in args {
            let (state, slot) = (self.state, || Slot::Limits(of, given.clone()));
            match &arg.kind {
                ValueKind::Named(name, value) => {
                    if !self.marked(&name.value, slot) && of.named.iter().any(|n| n.name == name.value) {
                        self.note(&name.value, name.span, What::BuiltIn(format!("{}.{}", of.name, name.value)));
                    }
                    self.state = state || name.value == "from";
                    self.typed(value, actuals);
                    self.state = state;
                }
                ValueKind::Name(name) if self.marked(name, slot) => {}
                _ => self.typed(arg, actuals),
            }
        }
    }

    /// Completion context of an expression.
    fn expression_slot(&self) -> Slot {
        match &self.mission {
            Some(mission) if self.expected => self.of_mission(mission),
            _ if self.expected => Slot::Expected,
            _ if self.condition => Slot::Condition,
            _ => Slot::Expression { auto: false, state: self.state },
        }
    }

    /// Indexes the argument of `initial(..)`: a value of the task itself, or an expression of the robot's state.
    fn captured(&mut self, value: &Value, actuals: &'static [Actual]) {
        // Inside a group, the prefix of the group may be omitted.
        let own = |name: &str| actuals.iter().any(|a| a.name.rsplit('.').next() == Some(name));
        match &value.kind {
            ValueKind::Name(name) if name == MARKER || own(name) => {
                self.marked(name, || Slot::Captured(actuals, String::new()));
            }
            ValueKind::Field(inner, field) if matches!(inner.kind, ValueKind::Name(_)) => match word(inner) {
                Some("angle") => self.arm_name(&field.value, field.span),
                Some(first) => {
                    self.marked(&field.value, || Slot::Captured(actuals, format!("{first}.")));
                }
                None => {}
            },
            _ => {
                let before = std::mem::replace(&mut self.state, true);
                self.typed(value, actuals);
                self.state = before;
            }
        }
    }
}
