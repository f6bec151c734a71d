//! Indexes the values of a spec: task parameters, and names of parts of the robot.

use dsl::tree::{Block, TaskDefinition, Value, ValueKind};
use dsl::{Span, Spanned};
use stdlib_tasks::kinds::safety_planner::{PATH, TURN};
use stdlib_tasks::params::{ParamInfo, ParamType};
use stdlib_tasks::task::TaskKind;

use super::mentions::{Class, MARKER, Slot, Walker, What};
use super::walk::{items, used, word};

impl Walker<'_> {
    /// Indexes a task type with its arguments and parameters.
    pub(super) fn definition(&mut self, definition: &TaskDefinition) {
        let name = &definition.kind;
        if self.marked(&name.value, || Slot::Kind) {
            return;
        }
        let Some(kind) = stdlib_tasks::find(&name.value) else {
            if self.has(Class::Task, &name.value) {
                self.note(&name.value, name.span, What::Declared(Class::Task, name.value.clone()));
            }
            self.arguments(&format!("task {}", name.value), &definition.args, &definition.named);
            definition.body.entries.iter().for_each(|e| self.anything(&e.value));
            return;
        };
        self.note(&name.value, name.span, What::Kind(kind));
        for (i, argument) in definition.args.iter().enumerate() {
            let last = kind.positional.len().saturating_sub(1);
            let info = kind.positional.get(i.min(last)).and_then(|n| kind.params.iter().find(|p| p.name == *n));
            let takes_all = |ty| matches!(ty, ParamType::Frames | ParamType::Geometries | ParamType::Joints);
            // Named arguments follow the positional ones.
            if i >= kind.positional.len()
                && !info.is_some_and(|info| takes_all(info.ty))
                && self.marked(word(argument).unwrap_or(""), || Slot::Named(kind.params, used(&definition.body)))
            {
                continue;
            }
            match info {
                Some(info) => self.parameter(kind, info, argument),
                None => self.anything(argument),
            }
        }
        // Named arguments are equivalent to entries in braces.
        let entries = definition.named.iter().chain(&definition.body.entries).cloned().collect();
        let placed = &kind.positional[..definition.args.len().min(kind.positional.len())];
        self.parameters(kind, kind.params, &Block { entries, ..definition.body.clone() }, placed);
    }

    /// Indexes parameters in braces. `placed` are those given by position before them.
    fn parameters(&mut self, kind: &'static TaskKind, infos: &'static [ParamInfo], block: &Block, placed: &[&str]) {
        let there = || placed.iter().map(|p| p.to_string()).chain(used(block)).collect();
        for e in &block.entries {
            if self.marked(&e.key.value, || Slot::Parameters(infos, there())) {
                continue;
            }
            match infos.iter().find(|p| p.name == e.key.value) {
                Some(info) => {
                    self.note(&e.key.value, e.key.span, What::Parameter(kind, info));
                    self.parameter(kind, info, &e.value);
                }
                None => self.anything(&e.value),
            }
        }
    }

    fn parameter(&mut self, kind: &'static TaskKind, info: &'static ParamInfo, value: &Value) {
        match info.ty {
            ParamType::Scalar(_) => self.typed(value, kind.actuals),
            ParamType::AutoScalar(_) => match word(value) {
                Some("auto") => {}
                Some(MARKER) => self.found.slot = Some(Slot::Expression { auto: true, state: false }),
                _ => self.typed(value, kind.actuals),
            },
            ParamType::Vector(_) | ParamType::Vectors(..) | ParamType::PerAxis(_) => self.typed(value, kind.actuals),
            ParamType::Rotation => self.typed(value, kind.actuals),
            ParamType::Gains(names) => match &value.kind {
                ValueKind::Block(b) => {
                    for e in &b.entries {
                        self.marked(&e.key.value, || Slot::Words(names));
                        self.typed(&e.value, kind.actuals);
                    }
                }
                _ => self.typed(value, kind.actuals),
            },
            ParamType::Frame => self.frame(value),
            ParamType::Frames => items(value).iter().for_each(|v| self.frame(v)),
            ParamType::Arm => self.arm(value),
            ParamType::Geometries => self.geometries(value),
            ParamType::Joints => self.joints(value),
            ParamType::JointPositions | ParamType::JointVelocities | ParamType::JointAccelerations => match &value.kind
            {
                ValueKind::Block(_) => self.joint_block(value, |w, v| w.typed(v, kind.actuals)),
                _ => self.typed(value, kind.actuals),
            },
            ParamType::PerArm(_) => match &value.kind {
                ValueKind::Block(b) => {
                    for e in &b.entries {
                        self.arm_name(&e.key.value, e.key.span);
                        self.typed(&e.value, kind.actuals);
                    }
                }
                _ => self.typed(value, kind.actuals),
            },
            ParamType::Choice(words) => {
                if let Some(said) = word(value) {
                    self.marked(said, || Slot::Words(words));
                }
            }
            ParamType::Expression(_) => {
                let before = std::mem::replace(&mut self.state, true);
                self.typed(value, kind.actuals);
                self.state = before;
            }
            ParamType::Task => self.named(value, Class::Task, Slot::Task),
            ParamType::Field => self.named(value, Class::Field, Slot::Field),
            ParamType::Deviations => self.deviations(kind, value),
            ParamType::Group(infos) => match &value.kind {
                ValueKind::Block(b) => self.parameters(kind, infos, b, &[]),
                _ => self.anything(value),
            },
        }
    }

    /// Indexes the name of a declaration.
    fn named(&mut self, value: &Value, class: Class, slot: Slot) {
        if let Some(name) = word(value)
            && !self.marked(name, || slot)
            && !self.scoped(name, value.span)
        {
            self.note(name, value.span, What::Declared(class, name.to_string()));
        }
    }

    /// Indexes deviations, in the groups of the other task; a block with a `speed` is a deviation.
    fn deviations(&mut self, kind: &'static TaskKind, value: &Value) {
        let ValueKind::Block(block) = &value.kind else { return self.anything(value) };
        for e in &block.entries {
            if self.marked(&e.key.value, || {
                Slot::Words(&["position", "orientation", "absolute", "relative", "left", "right"])
            }) {
                continue;
            }
            match &e.value.kind {
                ValueKind::Block(b) if e.key.value == "orientation" => self.parameters(kind, TURN, b, &[]),
                ValueKind::Block(b) if e.key.value == "position" || b.get("speed").is_some() => {
                    self.parameters(kind, PATH, b, &[]);
                }
                _ => self.deviations(kind, &e.value),
            }
        }
    }

    /// Indexes a value of unknown type; params are recognised in it nevertheless.
    pub(super) fn anything(&mut self, value: &Value) {
        match &value.kind {
            ValueKind::Block(b) => {
                for e in &b.entries {
                    self.marked(&e.key.value, || Slot::Nothing);
                    self.anything(&e.value);
                }
            }
            ValueKind::List(list) => list.iter().for_each(|v| self.anything(v)),
            // A task may be an argument: `guarded(left, hold(right))`.
            ValueKind::Call(name, args) if self.task(name) => args.iter().for_each(|v| self.anything(v)),
            ValueKind::Name(n)
                if n != MARKER
                    && ![Class::Param, Class::Let, Class::Signal, Class::Human, Class::Field]
                        .iter()
                        .any(|c| self.has(*c, n)) =>
            {
                if !self.scoped(n, value.span) && self.has(Class::Arm, n) {
                    self.note(n, value.span, What::Declared(Class::Arm, n.clone()));
                }
            }
            _ => self.expression(value),
        }
    }

    /// Records a task type or a declared task. Returns true if the name is one.
    fn task(&mut self, name: &Spanned<String>) -> bool {
        let what = match stdlib_tasks::find(&name.value) {
            Some(kind) => What::Kind(kind),
            None if self.has(Class::Task, &name.value) => What::Declared(Class::Task, name.value.clone()),
            None => return false,
        };
        self.note(&name.value, name.span, what);
        true
    }

    /// Indexes a link of the URDF.
    pub(super) fn link(&mut self, value: &Value) {
        let Some(name) = word(value) else { return };
        if !self.marked(name, || Slot::Link) && !self.scoped(name, value.span) {
            self.note(name, value.span, What::Link(name.to_string()));
        }
    }

    /// Indexes a link, or an arm for its tip; a link takes precedence.
    pub(super) fn frame(&mut self, value: &Value) {
        let Some(name) = word(value) else { return };
        if self.marked(name, || Slot::Frame) || self.scoped(name, value.span) {
            return;
        }
        let link = self.urdf.is_some_and(|u| u.links.contains_key(name));
        if !link && self.has(Class::Arm, name) {
            self.note(name, value.span, What::Declared(Class::Arm, name.to_string()));
        } else {
            self.note(name, value.span, What::Link(name.to_string()));
        }
    }

    /// Indexes links, arms, and parts that stand for the links that carry them.
    pub(super) fn links(&mut self, value: &Value) {
        for item in items(value) {
            match word(item) {
                Some(name) if name != MARKER && self.has(Class::Arm, name) => self.arm_name(name, item.span),
                Some(MARKER) => {
                    self.marked(MARKER, || Slot::Links);
                }
                _ => self.geometries(item),
            }
        }
    }

    pub(super) fn arm(&mut self, value: &Value) {
        if let Some(name) = word(value) {
            self.arm_name(name, value.span);
        }
    }

    pub(super) fn arm_name(&mut self, name: &str, span: Span) {
        if !self.marked(name, || Slot::Arm) && !self.scoped(name, span) {
            self.note(name, span, What::Declared(Class::Arm, name.to_string()));
        }
    }

    /// Indexes points, segments, groups, `arms`, `arms.NAME`, and links.
    pub(super) fn geometries(&mut self, value: &Value) {
        for item in items(value) {
            match &item.kind {
                ValueKind::Field(inner, field) => {
                    if word(inner) == Some("arms") {
                        self.arm_name(&field.value, field.span);
                    }
                }
                _ => {
                    let Some(name) = word(item) else { continue };
                    if self.marked(name, || Slot::Geometry) || self.scoped(name, item.span) {
                        continue;
                    }
                    // In YAML, `arms.left` may be a single word.
                    if let Some(arm) = name.strip_prefix("arms.") {
                        let (place, exact) = self.place(name, item.span);
                        let start = if exact { place.start + "arms.".len() } else { place.start };
                        self.arm_name(arm, Span::new(item.span.source, start, place.end));
                        continue;
                    }
                    let class = [Class::Group, Class::Point, Class::Segment].into_iter().find(|c| self.has(*c, name));
                    match class {
                        Some(class) => self.note(name, item.span, What::Declared(class, name.to_string())),
                        None if name == "arms" => {}
                        None => self.note(name, item.span, What::Link(name.to_string())),
                    }
                }
            }
        }
    }

    /// Indexes joints, groups of joints, and patterns.
    pub(super) fn joints(&mut self, value: &Value) {
        for item in items(value) {
            if let Some(name) = word(item)
                && !self.marked(name, || Slot::Joint)
            {
                self.joint(name, item.span);
            }
        }
    }

    fn joint(&mut self, name: &str, span: Span) {
        let known = self.urdf.is_some_and(|u| u.joints.contains_key(name));
        if name.contains(['*', '?']) || self.scoped(name, span) {
            return;
        }
        if !known && self.has(Class::JointGroup, name) {
            self.note(name, span, What::Declared(Class::JointGroup, name.to_string()));
        } else if known {
            self.note(name, span, What::Joint(name.to_string()));
        }
    }

    /// Indexes a block with joints as keys.
    pub(super) fn joint_block(&mut self, value: &Value, mut f: impl FnMut(&mut Self, &Value)) {
        match &value.kind {
            ValueKind::Block(block) => {
                for e in &block.entries {
                    if !self.marked(&e.key.value, || Slot::JointKey(used(block))) {
                        self.joint(&e.key.value, e.key.span);
                        f(self, &e.value);
                    }
                }
            }
            ValueKind::Name(n) => {
                self.marked(n, || Slot::Nothing);
            }
            _ => {}
        }
    }
}
