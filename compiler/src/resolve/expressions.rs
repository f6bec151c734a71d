//! References in expressions.

use dsl::Spanned;
use dsl::tree::{Value, ValueKind};
use stdlib_tasks::task::CurrentValue;

use super::symbols::SymbolKind as K;
use super::vocabulary::{CALLED, FRAME_FIELDS, TRACKED_FIELDS, VALUE_FIELDS, WRENCH_FIELDS, built_in};
use super::{Around, CURSOR, CompletionContext as C, Meaning, Reference, Resolver};
use crate::expand::Class;
use crate::expr::{AGE, MEASURES, REACHED, SETTLED, TRAJECTORIES, Trajectory};

impl Resolver<'_> {
    /// Resolves an expression outside of tasks, which have no values to capture.
    pub(super) fn expression(&mut self, value: &Value) {
        self.typed(value, &[]);
    }

    /// Resolves an expression; `current_values` are the values that `initial(..)` can capture in it.
    pub(super) fn typed(&mut self, value: &Value, current_values: &'static [CurrentValue]) {
        match &value.kind {
            ValueKind::Name(name) => {
                if self.is_cursor(name, Self::expression_context) || self.is_bound(name, value.span) {
                    return;
                }
                if let Some(own) = self.around.arguments.iter().find(|argument| argument.name == name) {
                    self.note(name, value.span, Meaning::Argument(own));
                    return;
                }
                let mission = |r: &Self| r.declared(Class::Mission, name).filter(|_| r.around.expected);
                let measured = self.around.expected && ["fault", "done"].contains(&name.as_str());
                match self.declared(Class::Value, name).or_else(|| mission(self)) {
                    None if measured => self.note(name, value.span, Meaning::BuiltIn(name.clone())),
                    None if built_in(name).is_some() && !CALLED.contains(&name.as_str()) => {
                        self.note(name, value.span, Meaning::BuiltIn(name.clone()));
                    }
                    found => self.refer(name, value.span, K::Param, found),
                }
            }
            ValueKind::Unit(inner, unit) => {
                self.typed(inner, current_values);
                if unit.factors.iter().any(|f| f.0 == CURSOR) {
                    self.out.context = Some(C::Unit);
                } else {
                    let (place, meaning) = (unit.span.range(), Meaning::Unit(unit.clone(), value.clone()));
                    self.out.references.push(Reference { place, exact: false, declares: false, meaning });
                }
            }
            ValueKind::Call(function, args) => {
                if self.is_cursor(&function.value, Self::expression_context) {
                    return;
                }
                self.note_built_in(function);
                match (function.value.as_str(), args.as_slice()) {
                    ("initial", [one]) => self.captured(one, current_values),
                    ("present" | AGE, [one]) => self.signal_or_human(one),
                    ("uncertainty", [one]) => self.uncertain(one),
                    ("field", [one]) => self.name_in(one, Class::Value, K::SafetyField, &[K::SafetyField]),
                    ("frame", [one]) => self.frame(one, &[K::Link, K::Arm]),
                    ("joint", [one]) => self.joints(one),
                    (SETTLED, [one, bounds @ ..]) => {
                        self.joints(one);
                        bounds.iter().for_each(|v| self.typed(v, current_values));
                    }
                    (REACHED, [task, bounds @ ..]) => self.target_task(task, bounds),
                    ("manipulability", [frame, rest @ ..]) => {
                        self.frame(frame, &[K::Link, K::Arm]);
                        let part = |v: &&Value| matches!(v.word(), Some("linear" | "angular"));
                        let skipped = usize::from(rest.first().filter(part).is_some());
                        rest[skipped..].iter().for_each(|joint| self.joints(joint));
                    }
                    (name, [one]) if MEASURES.contains(&name) => self.measured(name, one),
                    ("point", [frame, offset]) => {
                        self.frame(frame, &[K::Link, K::Arm]);
                        self.typed(offset, current_values);
                    }
                    ("distance", parts) => parts.iter().for_each(|p| match &p.kind {
                        ValueKind::Call(..) => self.typed(p, current_values),
                        _ => p.items().iter().for_each(|one| self.part_or_person(one)),
                    }),
                    (name, args) => match TRAJECTORIES.iter().find(|t| t.name == name) {
                        Some(of) => self.trajectory(of, args, current_values),
                        None => args.iter().for_each(|a| self.typed(a, current_values)),
                    },
                }
            }
            ValueKind::Field(inner, field) => {
                if self.member_field(inner, field) || self.human_field(inner, field) {
                    return;
                }
                if self.task_output(inner, field) {
                    return;
                }
                let value = inner.word().and_then(|name| self.declared(Class::Value, name));
                let of = value.map(|id| self.out.symbol(id));
                let is_signal =
                    |types: &[&str]| of.is_some_and(|s| s.kind == K::Signal && types.contains(&s.ty.as_str()));
                let fields = match &inner.kind {
                    ValueKind::Call(f, _) if f.value == "frame" => FRAME_FIELDS,
                    _ if is_signal(&["wrench"]) => WRENCH_FIELDS,
                    _ if is_signal(&["point", "pose"]) => TRACKED_FIELDS,
                    _ => VALUE_FIELDS,
                };
                self.is_cursor(&field.value, |_| C::Words(fields));
                self.typed(inner, current_values);
            }
            ValueKind::List(list) => list.iter().for_each(|v| self.typed(v, current_values)),
            ValueKind::In(inner, frame) => {
                self.typed(inner, current_values);
                if frame.value != "world" {
                    self.frame_name(&frame.value, frame.span, &[K::Link, K::Arm]);
                }
            }
            ValueKind::Named(_, inner) | ValueKind::Negate(inner) | ValueKind::Not(inner) => {
                self.typed(inner, current_values)
            }
            ValueKind::Binary(_, left, right) => {
                self.typed(left, current_values);
                self.typed(right, current_values);
            }
            ValueKind::Block(_) => self.anything(value),
            ValueKind::Number(_) | ValueKind::Text(_) | ValueKind::Missing => {}
        }
    }

    /// Resolves the output of a task, `guard.scaling`; returns false for other values.
    fn task_output(&mut self, inner: &Value, field: &Spanned<String>) -> bool {
        let Some(name) = inner.word().filter(|name| self.declared(Class::Value, name).is_none()) else { return false };
        let Some(task) = self.declared(Class::Task, name) else { return false };
        let kind = stdlib_tasks::find(&self.out.symbol(task).ty);
        if !self.is_cursor(&field.value, |_| C::Outputs(kind.map_or(&[], |k| k.outputs)))
            && let Some(kind) = kind
            && let Some(output) = kind.outputs.iter().find(|t| t.name == field.value)
        {
            self.note(&field.value, field.span, Meaning::Output(kind, output));
        }
        self.refer(name, inner.span, K::Task, Some(task));
        true
    }

    /// Resolves a part of the robot, a person, or a point of a person.
    fn part_or_person(&mut self, value: &Value) {
        match value.word() {
            Some(name) if self.around.of_mission => self.member(name, value.span, self.around.roles),
            _ if self.is_human(value) => {}
            _ => self.geometries(value, C::Geometry { arms: false, people: true }),
        }
    }

    /// Resolves the arguments of a trajectory.
    fn trajectory(&mut self, of: &'static Trajectory, args: &[Value], current_values: &'static [CurrentValue]) {
        let named = args.iter().filter_map(|a| match &a.kind {
            ValueKind::Named(name, _) => Some(name.value.clone()),
            _ => None,
        });
        let given: Vec<String> = named.collect();
        for arg in args {
            let context = |_: &Self| C::Limits(of, given.clone());
            match &arg.kind {
                ValueKind::Named(name, value) => {
                    if !self.is_cursor(&name.value, context) && of.named.iter().any(|n| n.name == name.value) {
                        self.note(&name.value, name.span, Meaning::BuiltIn(format!("{}.{}", of.name, name.value)));
                    }
                    let state = self.around.state || name.value == "from";
                    self.with(Around { state, ..self.around.clone() }, |r| r.typed(value, current_values));
                }
                ValueKind::Name(name) if self.is_cursor(name, context) => {}
                _ => self.typed(arg, current_values),
            }
        }
    }

    /// Resolves the argument of `initial(..)`: a value of the task itself, or an expression of the robot's state.
    fn captured(&mut self, value: &Value, current_values: &'static [CurrentValue]) {
        // Inside a group, the prefix of the group may be omitted.
        let own = |name: &str| current_values.iter().any(|a| a.name.rsplit('.').next() == Some(name));
        match &value.kind {
            ValueKind::Name(name) if name == CURSOR || own(name) => {
                self.is_cursor(name, |_| C::Captured(current_values, String::new()));
            }
            ValueKind::Field(inner, field) if matches!(inner.kind, ValueKind::Name(_)) => match inner.word() {
                Some("angle") => self.arm_name(&field.value, field.span),
                Some(first) => {
                    self.is_cursor(&field.value, |_| C::Captured(current_values, format!("{first}.")));
                }
                None => {}
            },
            _ => {
                self.with(Around { state: true, ..self.around.clone() }, |r| r.typed(value, current_values));
            }
        }
    }
}
