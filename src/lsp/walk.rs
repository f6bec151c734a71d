//! The declarations of a spec, word by word: what each key and each name in them means.

use dsl::tree::{Block, Entry, Item, ItemKind, Level, Member, MemberTask, Robot, Run, Spec, Stack, Value, ValueKind};
use dsl::{Span, Spanned, Spelling};

use super::mentions::{Class, Slot, Walker, What};
use super::vocabulary::{
    ARM, BASES, DECLARATIONS, Key, LEVEL, LEVEL_YAML, LIMIT, POINT, RANGE, ROBOT, RUN, SECTIONS, SEGMENT, SIMULATOR,
    STACK, STACK_YAML, WEIGHT, find,
};
use super::walk_reuse::{added, replaced};

/// The keys of a block.
pub(super) fn used(block: &Block) -> Vec<String> {
    block.entries.iter().map(|e| e.key.value.clone()).collect()
}

/// The items of a list, or the value itself.
pub(super) fn items(value: &Value) -> &[Value] {
    match &value.kind {
        ValueKind::List(items) => items,
        _ => std::slice::from_ref(value),
    }
}

/// A name or a text.
pub(super) fn word(value: &Value) -> Option<&str> {
    match &value.kind {
        ValueKind::Name(n) | ValueKind::Text(n) => Some(n),
        _ => None,
    }
}

/// The entries of a block.
fn entries(value: &Value) -> &[Entry] {
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

    /// First all names, so that those used before their declaration are known too.
    fn declarations(&mut self, item: &Item) {
        let before = &item.comments.before;
        match &item.kind {
            ItemKind::Param(p) => {
                self.declare((Class::Param, p.name.value.clone()), &p.name, item.span, before);
            }
            ItemKind::Let(l) => self.declare((Class::Let, l.name.value.clone()), &l.name, item.span, before),
            ItemKind::Import(import) => self.imported(import),
            ItemKind::For(repeat) => repeat.body.iter().for_each(|item| self.declarations(item)),
            ItemKind::Task(t) => self.declare((Class::Task, t.name.value.clone()), &t.name, item.span, before),
            ItemKind::Stack(s) => {
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
            ItemKind::Run(_) => {}
            // lowered separately
            ItemKind::Signal(_) | ItemKind::Machine(_) | ItemKind::Scenario(_) => {}
        }
    }

    /// Notes the word that begins a declaration, where it stands at this byte.
    fn keyword(&mut self, name: &str, start: usize, near: Span) {
        let keys = if self.spelling == Spelling::Hq { DECLARATIONS } else { SECTIONS };
        let stands = self.text.get(start..).is_some_and(|t| t.starts_with(name));
        if let Some(key) = find(keys, name).filter(|_| stands) {
            self.note(name, Span::new(near.source, start, start + name.len()), What::Key(key));
        }
    }

    fn item(&mut self, item: &Item) {
        let start = item.span.range().start;
        match &item.kind {
            ItemKind::Param(p) => {
                self.keyword("param", start, item.span);
                self.expression(&p.value);
                for e in &p.range.entries {
                    if self.key(&e.key, RANGE, &p.range) {
                        self.expression(&e.value);
                    }
                }
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
                self.robot(r);
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
            // lowered separately
            ItemKind::Signal(_) | ItemKind::Machine(_) | ItemKind::Scenario(_) => {}
            ItemKind::Run(r) => {
                self.keyword("run", start, item.span);
                self.run(r);
            }
        }
    }

    /// A key of a block with known keys; true where it is one.
    fn key(&mut self, key: &Spanned<String>, keys: &'static [Key], block: &Block) -> bool {
        if self.marked(&key.value, || Slot::Keys(keys, used(block))) {
            return false;
        }
        if let Some(known) = find(keys, &key.value) {
            self.note(&key.value, key.span, What::Key(known));
        }
        true
    }

    /// A block whose keys are known; `f` looks at each value.
    fn known(&mut self, value: &Value, keys: &'static [Key], mut f: impl FnMut(&mut Self, &str, &Value)) {
        match &value.kind {
            ValueKind::Block(block) => {
                for e in &block.entries {
                    if self.key(&e.key, keys, block) {
                        f(self, &e.key.value, &e.value);
                    }
                }
            }
            ValueKind::Name(n) => {
                self.marked(n, || Slot::Nothing);
            }
            _ => {}
        }
    }

    fn robot(&mut self, robot: &Robot) {
        for e in &robot.body.entries {
            if !self.key(&e.key, ROBOT, &robot.body) {
                continue;
            }
            match e.key.value.as_str() {
                "urdf" => {
                    if let Some(path) = word(&e.value)
                        && !self.marked(path, || Slot::Nothing)
                    {
                        self.note(path, e.value.span, What::File);
                    }
                }
                "base" => {
                    if let Some(base) = word(&e.value) {
                        self.marked(base, || Slot::Words(BASES));
                    }
                }
                "rate" | "tracking_gain" => self.expression(&e.value),
                "home" => self.joint_block(&e.value, |w, v| w.expression(v)),
                "lock" => match &e.value.kind {
                    ValueKind::Block(_) => self.joint_block(&e.value, |w, v| w.expression(v)),
                    _ => self.joints(&e.value),
                },
                "limits" => self.joint_block(&e.value, |w, v| w.known(v, LIMIT, |w, _, v| w.expression(v))),
                "joints" => entries(&e.value).iter().for_each(|e| self.joints(&e.value)),
                "arms" => {
                    for arm in entries(&e.value) {
                        self.known(&arm.value, ARM, |w, key, v| match key {
                            "points" => w.geometries(v),
                            _ => w.link(v),
                        });
                    }
                }
                "points" => {
                    for point in entries(&e.value) {
                        self.placed(&point.value, POINT);
                    }
                }
                "segments" => {
                    for segment in entries(&e.value) {
                        self.placed(&segment.value, SEGMENT);
                    }
                }
                "groups" => entries(&e.value).iter().for_each(|e| self.geometries(&e.value)),
                _ => {}
            }
        }
    }

    /// A link, or a block with a link and places in its frame.
    fn placed(&mut self, value: &Value, keys: &'static [Key]) {
        match &value.kind {
            ValueKind::Block(_) => self.known(value, keys, |w, key, v| match key {
                "link" => w.link(v),
                _ => w.expression(v),
            }),
            _ => self.link(value),
        }
    }

    fn stack(&mut self, stack: &Stack) {
        let keys = if self.spelling == Spelling::Hq { STACK } else { STACK_YAML };
        for e in &stack.settings.entries {
            if self.key(&e.key, keys, &stack.settings) && e.key.value == "lock" {
                self.joints(&e.value);
            }
        }
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
        let keys = if self.spelling == Spelling::Hq { LEVEL } else { LEVEL_YAML };
        if let (Some(span), Some(key)) = (level.hard, find(keys, "hard")) {
            self.note("hard", span, What::Key(key));
        }
        for e in &level.settings.entries {
            if self.key(&e.key, keys, &level.settings) {
                self.expression(&e.value);
            }
        }
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
            if before.ends_with("weight") {
                let start = before.len() - "weight".len();
                self.note("weight", Span::new(weight.span.source, start, before.len()), What::Key(&WEIGHT));
            }
            self.expression(weight);
        }
    }

    fn run(&mut self, run: &Run) {
        for e in &run.body.entries {
            if !self.key(&e.key, RUN, &run.body) {
                continue;
            }
            match e.key.value.as_str() {
                "stack" => {
                    if let Some(name) = word(&e.value)
                        && !self.marked(name, || Slot::Stack)
                    {
                        self.note(name, e.value.span, What::Declared(Class::Stack, name.to_string()));
                    }
                }
                "solver" => {
                    if let Some(name) = word(&e.value) {
                        self.marked(name, || Slot::Words(&["active_set", "clarabel"]));
                    }
                }
                "duration" => self.expression(&e.value),
                "simulator" => self.known(&e.value, SIMULATOR, |w, _, v| w.expression(v)),
                _ => {}
            }
        }
    }
}
