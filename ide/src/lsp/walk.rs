//! Indexes the declarations of a spec: the meaning of each key and each name.

use compiler::sections::{
    Holds, Key, LEVEL, MEMBER, Named, OUTCOME, PARAM, ROBOT, RUN, RUNS, SAFETY_FIELD, SCENARIO, SPEC, STACK, Section,
    WAYPOINT,
};
use dsl::Span;
use dsl::tree::{Block, Entry, Item, ItemKind, Level, Member, MemberTask, Spec, Stack, Value, ValueKind};

use super::mentions::{Class, MARKER, Slot, Walker, What};
use super::walk_reuse::{added, replaced, taken};

/// Keys of a block.
pub(super) fn used(block: &Block) -> Vec<String> {
    block.entries.iter().map(|e| e.key.value.clone()).collect()
}

/// Items of a list, or the value itself.
pub(super) fn items(value: &Value) -> &[Value] {
    match &value.kind {
        ValueKind::List(items) => items,
        _ => std::slice::from_ref(value),
    }
}

/// Name or text of a value.
pub(super) fn word(value: &Value) -> Option<&str> {
    match &value.kind {
        ValueKind::Name(n) | ValueKind::Text(n) => Some(n),
        _ => None,
    }
}

/// Entries of a block.
pub(super) fn entries(value: &Value) -> &[Entry] {
    match &value.kind {
        ValueKind::Block(b) => &b.entries,
        _ => &[],
    }
}

impl Walker<'_> {
    pub(super) fn spec(&mut self, spec: &Spec) {
        for item in &spec.items {
            self.declarations(item);
        }
        if let Some(version) = &spec.version {
            let before = self.text.get(..version.span.range().start).map_or("", str::trim_end);
            let start = before.trim_end_matches(':').len().saturating_sub("hierarq".len());
            self.keyword("hierarq", start, version.span);
        }
        for item in &spec.items {
            self.item(item);
        }
    }

    /// Collects all declared names first, because names may be used before their declaration.
    fn declarations(&mut self, item: &Item) {
        let before = &item.comments.before;
        match &item.kind {
            ItemKind::Param(p) => {
                self.declare((Class::Param, p.name.value.clone()), &p.name, item.span, before);
            }
            ItemKind::Let(l) => self.declare((Class::Let, l.name.value.clone()), &l.name, item.span, before),
            ItemKind::Import(import) => self.imported(import),
            ItemKind::For(repeat) => repeat.body.iter().for_each(|item| self.declarations(item)),
            ItemKind::Task(t) => {
                self.found.takes.entry(format!("task {}", t.name.value)).or_insert_with(|| taken(&t.parameters));
                self.found.kinds.entry(t.name.value.clone()).or_insert_with(|| t.definition.kind.value.clone());
                self.declare((Class::Task, t.name.value.clone()), &t.name, item.span, before);
            }
            ItemKind::Stack(s) => {
                self.found.takes.entry(format!("stack {}", s.name.value)).or_insert_with(|| taken(&s.parameters));
                self.declare((Class::Stack, s.name.value.clone()), &s.name, item.span, before);
                for l in s.levels.iter().chain(added(s)) {
                    let name = format!("{}.{}", s.name.value, l.name.value);
                    self.declare((Class::Level, name), &l.name, l.span, &l.comments.before);
                }
            }
            ItemKind::Robot(r) => {
                self.declare((Class::Robot, r.name.value.clone()), &r.name, item.span, before);
                for (key, class) in [
                    ("arms", Class::Arm),
                    ("points", Class::Point),
                    ("segments", Class::Segment),
                    ("groups", Class::Group),
                    ("joints", Class::JointGroup),
                ] {
                    for e in r.body.get(key).map_or(&[][..], |e| entries(&e.value)) {
                        let whole = e.key.span.to(e.value.span);
                        self.declare((class, e.key.value.clone()), &e.key, whole, &e.comments.before);
                    }
                }
            }
            ItemKind::Signal(s) => self.declared_signal(s, item),
            ItemKind::Human(h) => self.declared_human(h, item),
            ItemKind::SafetyField(f) => {
                let before = &item.comments.before;
                self.declare((Class::Field, f.name.value.clone()), &f.name, item.span, before);
            }
            ItemKind::Variable(v) => self.declared_variable(v, item),
            ItemKind::Machine(m) => self.declared_machine(m, item),
            ItemKind::Mission(m) => self.declared_mission(m, item),
            ItemKind::Run(_) | ItemKind::Scenario(_) => {}
        }
    }

    /// Records the keyword of a declaration, if it is at this byte.
    fn keyword(&mut self, name: &str, start: usize, near: Span) {
        let stands = self.text.get(start..).is_some_and(|t| t.starts_with(name));
        if let Some(key) = SPEC.key(name, self.syntax).filter(|_| stands) {
            self.note(name, Span::new(near.source, start, start + name.len()), What::Key(key));
        }
    }

    fn item(&mut self, item: &Item) {
        let start = item.span.range().start;
        match &item.kind {
            ItemKind::Param(p) => {
                self.keyword("param", start, item.span);
                self.expression(&p.value);
                self.section(&p.range, &PARAM);
            }
            ItemKind::Let(l) => {
                self.keyword("let", start, item.span);
                let before = std::mem::replace(&mut self.state, true);
                self.expression(&l.value);
                self.state = before;
            }
            ItemKind::Import(_) => self.keyword("import", start, item.span),
            ItemKind::For(repeat) => {
                self.keyword("for", start, item.span);
                self.repeat(repeat, |w, item| w.item(item));
            }
            ItemKind::Robot(r) => {
                self.keyword("robot", start, item.span);
                if let Some(base) = &r.base {
                    self.robot_base(base);
                }
                self.section(&r.body, &ROBOT);
            }
            ItemKind::Task(t) => {
                self.keyword("task", start, item.span);
                let outer = self.scope.len();
                self.formals(&format!("task {}", t.name.value), &t.parameters);
                self.definition(&t.definition);
                self.scope.truncate(outer);
            }
            ItemKind::Stack(s) => {
                self.keyword("stack", start, item.span);
                let outer = self.scope.len();
                self.formals(&format!("stack {}", s.name.value), &s.parameters);
                self.stack(s);
                self.scope.truncate(outer);
            }
            ItemKind::Signal(s) => {
                self.keyword("signal", start, item.span);
                self.signal(s);
            }
            ItemKind::Human(h) => {
                self.keyword("human", start, item.span);
                self.human(h);
            }
            ItemKind::SafetyField(f) => {
                self.keyword("safety_field", start, item.span);
                self.section(&f.body, &SAFETY_FIELD);
            }
            ItemKind::Variable(v) => {
                self.keyword("variable", start, item.span);
                self.variable(v);
            }
            ItemKind::Machine(m) => {
                self.keyword("machine", start, item.span);
                self.machine(m);
            }
            ItemKind::Mission(m) => {
                self.keyword("mission", start, item.span);
                self.mission(m);
            }
            ItemKind::Scenario(s) => {
                self.keyword("scenario", start, item.span);
                self.mission = s.body.get("mission").and_then(|e| word(&e.value)).map(str::to_string);
                self.section(&s.body, &SCENARIO);
                s.expects.iter().for_each(|e| self.formula(&e.formula));
                self.mission = None;
            }
            ItemKind::Run(r) => {
                self.keyword("run", start, item.span);
                self.section(&r.body, &RUN);
            }
        }
    }

    /// Indexes a block with known keys.
    pub(super) fn section(&mut self, block: &Block, section: &'static Section) {
        for e in &block.entries {
            if e.key.value == MARKER {
                self.found.slot = Some(Slot::Keys(section, self.without(block, section)));
                continue;
            }
            if let Some(key) = section.key(&e.key.value, self.syntax) {
                self.note(&e.key.value, e.key.span, What::Key(key));
                match key.name {
                    "humans" => self.human_scripts(&e.value),
                    "feedback" if std::ptr::eq(section, &SCENARIO) => self.replies(&e.value),
                    _ => {
                        self.told(section, key, &e.value);
                        self.held(&key.holds, &e.value);
                    }
                }
            }
        }
    }

    /// Indexes blocks of a scenario whose keys are names of signals or events.
    fn told(&mut self, section: &'static Section, key: &'static Key, value: &Value) {
        let signals = match (section.name, key.name) {
            _ if !std::ptr::eq(section, &SCENARIO) && !std::ptr::eq(section, &OUTCOME) => return,
            (_, "signals" | "push" | "sets") => true,
            (_, "events") => false,
            _ => return,
        };
        for e in entries(value) {
            let name = e.key.value.as_str();
            let slot = if signals { Slot::Signal } else { Slot::Events { whole: false } };
            if self.marked(name, || slot) {
            } else if signals {
                self.note(name, e.key.span, What::Declared(Class::Signal, name.to_string()));
            } else {
                self.event(name, e.key.span);
            }
        }
    }

    /// Indexes the value of a key.
    fn held(&mut self, holds: &'static Holds, value: &Value) {
        match holds {
            Holds::Number(_)
            | Holds::Vector(_)
            | Holds::Pair(_)
            | Holds::Spread(_)
            | Holds::OfJoint { .. }
            | Holds::Bound
            | Holds::Value
            | Holds::People => {
                self.expression(value);
            }
            Holds::Spot => self.spot(value),
            Holds::List(Holds::Spot) => items(value).iter().for_each(|v| self.spot(v)),
            Holds::Sent => self.anything(value),
            Holds::Numbers(_) | Holds::Range(_) => items(value).iter().for_each(|v| self.expression(v)),
            Holds::Text | Holds::NewName => {
                self.marked(word(value).unwrap_or(""), || Slot::Nothing);
            }
            Holds::Urdf => {
                if let Some(path) = word(value)
                    && !self.marked(path, || Slot::Nothing)
                {
                    self.note(path, value.span, What::File);
                }
            }
            Holds::Spec => self.spec_path(value),
            Holds::Name(Named::SignalThere) => self.signal_there(value),
            Holds::Name(Named::StateThere) => self.state_there(value),
            Holds::Flag => {
                self.marked(word(value).unwrap_or(""), || Slot::Words(&["true", "false"]));
            }
            Holds::Choice(words) => {
                self.marked(word(value).unwrap_or(""), || Slot::Words(words));
            }
            Holds::Name(Named::Stack) => {
                if let Some(name) = word(value)
                    && !self.marked(name, || Slot::Stack)
                {
                    self.note(name, value.span, What::Declared(Class::Stack, name.to_string()));
                }
            }
            Holds::Name(Named::Machine) => self.machine_name(value),
            Holds::Name(Named::Mission) => self.mission_name(value),
            Holds::Name(Named::Member) if self.mission.is_some() => {
                self.member_name(value, &["robot", "human", "worker"])
            }
            Holds::Name(Named::Person) => self.member_name(value, &["human"]),
            Holds::Link => self.link(value),
            Holds::Geometries => self.geometries(value),
            Holds::Links => self.links(value),
            Holds::WordOr(words) | Holds::NumberOr(_, words) => match &value.kind {
                ValueKind::Name(name) if self.marked(name, || Slot::Words(words)) || words.contains(&name.as_str()) => {
                }
                _ => self.expression(value),
            },
            Holds::Joints => self.joints(value),
            Holds::Positions => self.joint_block(value, |w, v| w.expression(v)),
            Holds::Locks => match &value.kind {
                ValueKind::Block(_) => self.joint_block(value, |w, v| w.expression(v)),
                _ => self.joints(value),
            },
            Holds::Block(section) | Holds::LinkOr(section) => match (&value.kind, holds) {
                (ValueKind::Block(block), _) if std::ptr::eq(*section, &RUNS) => self.runs(block),
                (ValueKind::Block(block), _) => self.section(block, section),
                (_, Holds::LinkOr(_)) => self.link(value),
                _ => {
                    self.marked(word(value).unwrap_or(""), || Slot::Nothing);
                }
            },
            Holds::Blocks(section) => {
                for item in items(value) {
                    match &item.kind {
                        ValueKind::Block(block) => self.section(block, section),
                        _ => {
                            self.marked(word(item).unwrap_or(""), || Slot::Nothing);
                        }
                    }
                }
            }
            Holds::List(Holds::Block(section)) if std::ptr::eq(*section, &WAYPOINT) => {
                const PATH: &Holds = &Holds::Blocks(&WAYPOINT);
                self.held(PATH, value);
            }
            Holds::Each(inner) | Holds::Of(_, inner) => entries(value).iter().for_each(|e| self.held(inner, &e.value)),
            Holds::PerJoint(inner) => self.joint_block(value, |w, v| w.held(inner, v)),
            // The parser stores these in other parts of the tree.
            Holds::Name(
                Named::Point
                | Named::Signal
                | Named::Event
                | Named::Human
                | Named::Robot
                | Named::Level
                | Named::State
                | Named::Member,
            )
            | Holds::Values
            | Holds::List(_)
            | Holds::Tasks
            | Holds::Declarations => {}
        }
    }

    fn stack(&mut self, stack: &Stack) {
        self.section(&stack.settings, &STACK);
        if let Some(base) = &stack.base {
            if !self.marked(&base.name.value, || Slot::Stack) {
                self.note(&base.name.value, base.name.span, What::Declared(Class::Stack, base.name.value.clone()));
            }
            self.arguments(&format!("stack {}", base.name.value), &base.args, &base.named);
        }
        for level in stack.levels.iter().chain(added(stack)).chain(replaced(stack)) {
            self.level(level);
        }
        self.changed(stack);
    }

    fn level(&mut self, level: &Level) {
        if let (Some(span), Some(key)) = (level.hard, LEVEL.key("hard", self.syntax)) {
            self.note("hard", span, What::Key(key));
        }
        self.section(&level.settings, &LEVEL);
        for member in &level.members {
            self.member(member);
        }
    }

    fn member(&mut self, member: &Member) {
        match &member.task {
            MemberTask::Inline(definition) => self.definition(definition),
            MemberTask::For(repeat) => self.repeat(repeat, |w, member| w.member(member)),
            MemberTask::Name(name) => {
                if self.marked(&name.value, || Slot::Member) || self.scoped(&name.value, name.span) {
                    return;
                }
                match stdlib_tasks::find(&name.value) {
                    Some(kind) if !self.has(Class::Task, &name.value) => {
                        self.note(&name.value, name.span, What::Kind(kind));
                    }
                    _ => self.note(&name.value, name.span, What::Declared(Class::Task, name.value.clone())),
                }
            }
        }
        if let Some(weight) = &member.weight {
            let before = self.text.get(..weight.span.range().start).unwrap_or("");
            let before = before.trim_end().trim_end_matches([':', '=', '"', '\'', ' ']);
            let start = before.len().saturating_sub("weight".len());
            if let Some(key) = MEMBER.key("weight", self.syntax).filter(|_| before.ends_with("weight")) {
                self.note("weight", Span::new(weight.span.source, start, before.len()), What::Key(key));
            }
            self.expression(weight);
        }
    }
}
