//! References in tasks: their types, and their parameters by the types of these.

use dsl::Spanned;
use dsl::tree::{Block, Entry, TaskDefinition, Value, ValueKind};
use stdlib_tasks::axis_rows::AXES;
use stdlib_tasks::kinds::safety_planner::{PATH, TURN};
use stdlib_tasks::params::{Form, ParamInfo, ParamType};
use stdlib_tasks::task::TaskKind;

use super::context::used;
use super::symbols::SymbolKind as K;
use super::{Around, CURSOR, CompletionContext as C, Meaning, Resolver};
use crate::expand::Class;

impl Resolver<'_> {
    /// Resolves a task type with its arguments and parameters.
    pub(super) fn definition(&mut self, definition: &TaskDefinition) {
        let name = &definition.kind;
        if self.is_cursor(&name.value, |_| C::TaskType) || name.value.is_empty() {
            return;
        }
        let own = self.declared(Class::Task, &name.value);
        let Some(kind) = stdlib_tasks::find(&name.value).filter(|_| own.is_none()) else {
            self.refer(&name.value, name.span, K::Task, own);
            self.arguments(own, &definition.args, &definition.named);
            definition.body.entries.iter().for_each(|e| self.anything(&e.value));
            return;
        };
        self.note(&name.value, name.span, Meaning::TaskType(kind));
        for (i, argument) in definition.args.iter().enumerate() {
            let last = kind.positional.len().saturating_sub(1);
            let info = kind.positional.get(i.min(last)).and_then(|n| kind.params.iter().find(|p| p.name == *n));
            let takes_all =
                |ty| matches!(ty, ParamType::Frames | ParamType::Geometries | ParamType::Joints | ParamType::Obstacles);
            // Named arguments follow the positional ones.
            if i >= kind.positional.len()
                && !info.is_some_and(|info| takes_all(info.ty))
                && self.cursor_in(argument, |_| C::NamedParameters(kind.params, used(&definition.body)))
            {
                continue;
            }
            match info {
                Some(info) => self.parameter(kind, info, argument),
                None => self.anything(argument),
            }
        }
        // Named arguments are equivalent to entries in braces.
        let entries: Vec<&Entry> = definition.named.iter().chain(&definition.body.entries).collect();
        let positional = &kind.positional[..definition.args.len().min(kind.positional.len())];
        self.parameters(kind, kind.params, &entries, positional);
    }

    /// Resolves parameters in braces. `positional` are those given by position before them.
    fn parameters(
        &mut self,
        kind: &'static TaskKind,
        infos: &'static [ParamInfo],
        entries: &[&Entry],
        positional: &[&str],
    ) {
        let given = positional.iter().copied().chain(entries.iter().map(|e| e.key.value.as_str()));
        for e in entries {
            let there = || given.clone().map(str::to_string).collect();
            if self.is_cursor(&e.key.value, |_| C::Parameters(infos, there())) {
                continue;
            }
            match infos.iter().find(|p| p.name == e.key.value) {
                Some(info) => {
                    self.note(&e.key.value, e.key.span, Meaning::Parameter(kind, info));
                    self.parameter(kind, info, &e.value);
                }
                None => self.anything(&e.value),
            }
        }
    }

    /// Resolves the parameters of a group.
    fn group(&mut self, kind: &'static TaskKind, infos: &'static [ParamInfo], block: &Block) {
        self.parameters(kind, infos, &block.entries.iter().collect::<Vec<_>>(), &[]);
    }

    fn parameter(&mut self, kind: &'static TaskKind, info: &'static ParamInfo, value: &Value) {
        match info.ty {
            ParamType::Scalar(_) => self.typed(value, kind.current_values),
            ParamType::AutoScalar(_) => match value.word() {
                Some("auto") => {}
                Some(CURSOR) => self.out.context = Some(C::Expression { auto: true, state: false, arguments: &[] }),
                _ => self.typed(value, kind.current_values),
            },
            ParamType::Vector(_) | ParamType::Vectors { .. } | ParamType::PerAxis(_) => {
                self.typed(value, kind.current_values)
            }
            ParamType::Rotation => self.typed(value, kind.current_values),
            ParamType::Gains(names) => match &value.kind {
                ValueKind::Block(b) => {
                    for e in &b.entries {
                        self.is_cursor(&e.key.value, |_| C::Words(names));
                        self.typed(&e.value, kind.current_values);
                    }
                }
                _ => self.typed(value, kind.current_values),
            },
            ParamType::Frame => self.frame(value, &[K::Link, K::Arm]),
            ParamType::Frames => value.items().iter().for_each(|v| self.frame(v, &[K::Link, K::Arm])),
            ParamType::Arm => self.arm(value),
            ParamType::Geometries => self.geometries(value, C::Geometry { arms: false, people: false }),
            ParamType::Pairs(_) => {
                let sides = value.items().iter().flat_map(|pair| pair.items());
                sides.for_each(|side| self.geometries(side, C::Geometry { arms: false, people: false }));
            }
            ParamType::Joints => self.joints(value),
            ParamType::JointPositions => self.positions(value, |r, v| r.typed(v, kind.current_values)),
            ParamType::JointVelocities | ParamType::JointAccelerations => match &value.kind {
                ValueKind::Block(_) => self.joint_block(value, |w, v| w.typed(v, kind.current_values)),
                _ => self.typed(value, kind.current_values),
            },
            ParamType::PerArm(_) => match &value.kind {
                ValueKind::Block(b) => {
                    for e in &b.entries {
                        self.arm_name(&e.key.value, e.key.span);
                        self.typed(&e.value, kind.current_values);
                    }
                }
                _ => self.typed(value, kind.current_values),
            },
            ParamType::PerFrame(infos) => match &value.kind {
                ValueKind::Block(b) => {
                    for e in &b.entries {
                        self.frame_name(&e.key.value, e.key.span, &[K::Link, K::Arm]);
                        match &e.value.kind {
                            ValueKind::Block(inner) => self.group(kind, infos, inner),
                            _ => self.anything(&e.value),
                        }
                    }
                }
                _ => self.anything(value),
            },
            ParamType::Axes => value.items().iter().for_each(|axis| {
                self.cursor_in(axis, |_| C::Words(AXES));
            }),
            ParamType::Choice(words) => {
                self.cursor_in(value, |_| C::Words(words));
            }
            ParamType::Expression(Form::Size(_)) if value.word() == Some("auto") => {}
            ParamType::Expression(Form::Like(_)) if limits(value).iter().any(|item| is_none(&item)) => {
                self.with(Around { state: true, ..self.around.clone() }, |r| {
                    limits(value)
                        .iter()
                        .filter(|item| !is_none(item))
                        .for_each(|item| r.typed(item, kind.current_values));
                });
            }
            ParamType::Expression(_) => {
                self.with(Around { state: true, ..self.around.clone() }, |r| r.typed(value, kind.current_values));
            }
            ParamType::Task => self.name_in(value, Class::Task, K::Task, &[K::Task]),
            ParamType::Field => self.name_in(value, Class::Value, K::SafetyField, &[K::SafetyField]),
            ParamType::Obstacles => {
                value.items().iter().for_each(|item| self.name_in(item, Class::Value, K::Obstacle, &[K::Obstacle]));
            }
            ParamType::Deviations => self.deviations(kind, value),
            ParamType::Group(infos) => match &value.kind {
                ValueKind::Block(b) => self.group(kind, infos, b),
                _ => self.anything(value),
            },
        }
    }

    /// Resolves deviations, in the groups of the other task; a block with a `speed` is a deviation.
    fn deviations(&mut self, kind: &'static TaskKind, value: &Value) {
        let ValueKind::Block(block) = &value.kind else { return self.anything(value) };
        for e in &block.entries {
            const GROUPS: &[&str] = &["position", "orientation", "absolute", "relative", "left", "right"];
            if self.is_cursor(&e.key.value, |_| C::Words(GROUPS)) {
                continue;
            }
            match &e.value.kind {
                ValueKind::Block(b) if e.key.value == "orientation" => self.group(kind, TURN, b),
                ValueKind::Block(b) if e.key.value == "position" || b.get("speed").is_some() => {
                    self.group(kind, PATH, b);
                }
                _ => self.deviations(kind, &e.value),
            }
        }
    }

    /// Resolves a value of unknown type: names of values, of arms and other parts of
    /// the robot, and of parameters are recognised in it nevertheless.
    pub(super) fn anything(&mut self, value: &Value) {
        match &value.kind {
            ValueKind::Block(b) => {
                for e in &b.entries {
                    self.is_cursor(&e.key.value, |_| C::Nothing);
                    self.anything(&e.value);
                }
            }
            ValueKind::List(list) => list.iter().for_each(|v| self.anything(v)),
            // A task may be an argument: `guarded(left, hold(right))`.
            ValueKind::Call(name, args) if self.task_type(name) => args.iter().for_each(|v| self.anything(v)),
            ValueKind::Name(n) if n != CURSOR && self.declared(Class::Value, n).is_none() => {
                let kinds = [K::Arm, K::Group, K::Point, K::Segment].into_iter();
                let part = kinds.filter_map(|kind| Some((kind, self.part(kind, n)?))).next();
                if let Some((kind, found)) = part.filter(|_| !self.is_bound(n, value.span)) {
                    self.refer(n, value.span, kind, Some(found));
                }
            }
            _ => self.expression(value),
        }
    }

    /// Records a task type or a declared task. Returns true if the name is one.
    fn task_type(&mut self, name: &Spanned<String>) -> bool {
        let meaning = match (self.declared(Class::Task, &name.value), stdlib_tasks::find(&name.value)) {
            (Some(task), _) => Meaning::Symbol(task),
            (None, Some(kind)) => Meaning::TaskType(kind),
            (None, None) => return false,
        };
        self.note(&name.value, name.span, meaning);
        true
    }
}

/// Numbers of a vector of limits, also with one unit for all.
fn limits(value: &Value) -> &[Value] {
    match &value.kind {
        ValueKind::List(items) => items,
        ValueKind::Unit(inner, _) => limits(inner),
        _ => &[],
    }
}

/// True for a number of a vector that has no limit.
fn is_none(value: &&Value) -> bool {
    value.word() == Some("none")
}
