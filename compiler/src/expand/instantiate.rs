//! Collects the declarations of the program: those that the spec declares or imports by name, and those that they use.

use std::collections::BTreeMap;
use std::path::Path;

use dsl::tree::{
    BlockKind, Entry, ItemKind, Let, NamedBlock, Param, Robot, Signal, Spec, Stack, Task, Value, ValueKind, Variable,
};
use dsl::{Diagnostic, SourceId, Span, Spanned};

use super::module::{Target, declared, parameters};
use super::substitute::Frame;
use super::{Class, Expander, MAX_DEPTH, Named};
use crate::forms::text_of;
use crate::paths::tidy;

/// Keys of a named block whose values are names other than those of values.
fn names_in(kind: BlockKind) -> &'static [&'static str] {
    match kind {
        BlockKind::Human => &["points", "links", "velocity", "lost"],
        BlockKind::SafetyField => &["links"],
        BlockKind::Obstacle => &["on"],
    }
}

impl Expander<'_> {
    /// Expands the spec itself, which is module 0.
    pub(super) fn spec(&mut self, source: SourceId, spec: Spec) {
        self.read(source, spec);
        let imported: Vec<((Class, String), Target)> =
            self.modules[0].scope.iter().map(|(key, target)| (key.clone(), target.clone())).collect();
        // Imports in source order, so that programs do not depend on the sort order of names.
        let mut imported: Vec<(Class, String, Span)> = imported
            .into_iter()
            .filter_map(|((class, name), target)| match target {
                Target::Imported { at, .. } => Some((class, name, at)),
                _ => None,
            })
            .collect();
        imported.sort_by_key(|(class, _, at)| (at.start, *class));
        for (class, name, at) in &imported {
            if let Ok((m, i)) = self.find(0, *class, name) {
                let there = declared(&self.modules[m].items[i].kind).map(|d| d.1.value.clone()).unwrap_or_default();
                if let Some(other) = self.visible.get(&(m, *class, there.clone())) {
                    let d = Diagnostic::error("HQ0202", *at, format!("`{there}` is imported already, as `{other}`"));
                    self.fail(d.help("import it once"));
                    continue;
                }
                self.visible.insert((m, *class, there), name.clone());
                self.out.imported.insert((*class, name.clone()), *at);
            }
        }
        let own = (0..self.modules[0].items.len()).filter_map(|i| {
            let (class, _) = declared(&self.modules[0].items[i].kind)?;
            Some((class, (0, i)))
        });
        let own: Vec<(Class, (usize, usize))> = own.collect();
        let all = imported.iter().filter_map(|(class, name, _)| Some((*class, self.find(0, *class, name).ok()?)));
        let all: Vec<(Class, (usize, usize))> = all.chain(own).collect();
        // Signals come first, so that their order is the source order, whatever uses them.
        let is_signal = |e: &Self, (m, i): (usize, usize)| {
            matches!(
                e.modules[m].items[i].kind,
                ItemKind::Signal(_)
                    | ItemKind::Block(NamedBlock { kind: BlockKind::Human, .. })
                    | ItemKind::Variable(_)
            )
        };
        for (_, found) in all.iter().filter(|a| a.0 == Class::Value) {
            if is_signal(self, *found) {
                self.emit(*found);
            }
        }
        for class in [Class::Robot, Class::Value, Class::Task, Class::Stack, Class::Machine, Class::Mission] {
            for (_, found) in all.iter().filter(|a| a.0 == class) {
                self.emit(*found);
            }
        }
        let runs = self.modules[0].items.iter().filter_map(|item| match &item.kind {
            ItemKind::Run(run) => Some((run.clone(), item.span)),
            _ => None,
        });
        for (run, span) in runs.collect::<Vec<_>>() {
            let body = self.block(&run.body, &mut Frame::of(0));
            self.out.runs.push((dsl::tree::Run { body }, span));
        }
        let coverage = self.modules[0].items.iter().filter_map(|item| match &item.kind {
            ItemKind::Coverage(it) => Some((it.clone(), item.span)),
            _ => None,
        });
        for (it, span) in coverage.collect::<Vec<_>>() {
            let body = self.block(&it.body, &mut Frame::of(0));
            self.out.coverage.push((dsl::tree::Coverage { body }, span));
        }
        self.scenarios();
        self.unused(&all);
    }

    /// Adds a declaration of the spec to the program; declarations with parameters are added at their uses.
    fn emit(&mut self, (m, i): (usize, usize)) {
        let kind = &self.modules[m].items[i].kind;
        if !parameters(kind).is_empty() {
            if let ItemKind::Stack(s) = kind {
                self.out.patterns.insert(s.name.value.clone(), s.name.span);
            }
            return;
        }
        // A second declaration of the same name was reported.
        let Some((class, name)) = declared(kind) else { return };
        let (name, span) = (name.value.clone(), name.span);
        if class != Class::Robot && self.find(m, class, &name) != Ok((m, i)) {
            return;
        }
        match kind.clone() {
            ItemKind::Robot(robot) => self.emit_robot(m, &robot),
            ItemKind::Param(_)
            | ItemKind::Let(_)
            | ItemKind::Signal(_)
            | ItemKind::Block(_)
            | ItemKind::Variable(_) => {
                self.emit_value((m, i), span);
            }
            ItemKind::Task(_) => {
                self.emit_task((m, i));
            }
            ItemKind::Stack(stack) => self.emit_stack((m, i), &stack),
            ItemKind::Import(_)
            | ItemKind::Allow(_)
            | ItemKind::For(_)
            | ItemKind::Coverage(_)
            | ItemKind::Run(_)
            | ItemKind::Scenario(_) => {}
            ItemKind::Machine(_) => self.emit_machine((m, i)),
            ItemKind::Mission(_) => self.emit_mission((m, i)),
        }
    }

    /// Name of a declaration in the program.
    pub(super) fn program_name(&self, m: usize, class: Class, name: &str) -> String {
        match self.visible.get(&(m, class, name.to_string())) {
            Some(visible) => visible.clone(),
            None if m == 0 => name.to_string(),
            None => format!("{}.{name}", self.modules[m].stem),
        }
    }

    /// Adds a value to the program, after the values that it uses. `at` is the place that requires it.
    pub(super) fn emit_value(&mut self, found: (usize, usize), at: Span) -> Option<String> {
        // Values that wait for those above them; an explicit stack, because chains of values may be long.
        let mut open = vec![(found, at)];
        while let Some((found, _)) = open.last().copied() {
            let key = self.value_key(found)?;
            match self.emitted.get(&key) {
                Some(Some(_)) => {
                    open.pop();
                }
                Some(None) => {
                    self.copy_value(found, key, false);
                    open.pop();
                }
                None => {
                    self.emitted.insert(key.clone(), None);
                    let uses = self.uses_of(found);
                    let mut circle = false;
                    for (other, at) in uses {
                        let Some(used) = self.value_key(other) else { continue };
                        match self.emitted.get(&used) {
                            Some(Some(_)) => {}
                            Some(None) => {
                                circle = true;
                                let d = Diagnostic::error("HQ0216", at, format!("`{}` is defined by itself", used.2));
                                self.fail(d.help("write the value without this name"));
                            }
                            None => open.push((other, at)),
                        }
                    }
                    if circle {
                        self.copy_value(found, key, true);
                    }
                }
            }
        }
        let key = self.value_key(found)?;
        self.emitted.get(&key).cloned().flatten()
    }

    fn value_key(&self, (m, i): (usize, usize)) -> Option<(usize, Class, String)> {
        let (class, name) = declared(&self.modules[m].items[i].kind)?;
        Some((m, class, name.value.clone()))
    }

    /// Values that a declaration uses.
    fn uses_of(&self, (m, i): (usize, usize)) -> Vec<((usize, usize), Span)> {
        let mut open: Vec<&Value> = match &self.modules[m].items[i].kind {
            ItemKind::Param(p) => std::iter::once(&p.value).chain(p.range.entries.iter().map(|e| &e.value)).collect(),
            ItemKind::Let(l) => vec![&l.value],
            ItemKind::Block(b) => {
                let names = names_in(b.kind);
                let settings = b.body.entries.iter().filter(|e| !names.contains(&e.key.value.as_str()));
                settings.map(|e| &e.value).collect()
            }
            ItemKind::Variable(v) => v.value.iter().collect(),
            _ => Vec::new(),
        };
        let mut out = Vec::new();
        while let Some(value) = open.pop() {
            if let ValueKind::Name(name) = &value.kind {
                out.extend(self.find(m, Class::Value, name).ok().map(|found| (found, value.span)));
            }
            open.extend(value.parts());
        }
        out
    }

    /// Adds a value to the program, after those that it uses; with missing contents if it is `broken`.
    fn copy_value(&mut self, (m, i): (usize, usize), key: (usize, Class, String), broken: bool) {
        let kind = self.modules[m].items[i].kind.clone();
        let Some((_, written)) = declared(&kind) else { return };
        let mut frame = Frame::of(m);
        let own = self.name(written, &mut frame);
        let name = Spanned::new(self.program_name(m, Class::Value, &own.value), own.span);
        self.emitted.insert(key, Some(name.value.clone()));
        let mut value = |e: &mut Self, value: &Value| match broken {
            true => Value { kind: ValueKind::Missing, span: value.span },
            false => e.value(value, &mut frame),
        };
        let named = match &kind {
            ItemKind::Param(p) => {
                let own = value(self, &p.value);
                let range = if broken { Default::default() } else { self.block(&p.range, &mut frame) };
                Named::Param(Param { name, value: own, range })
            }
            ItemKind::Let(l) => Named::Let(Let { name, value: value(self, &l.value) }),
            ItemKind::Signal(s) => Named::Signal(Signal { name, ..self.copied_signal(s, &mut frame) }),
            ItemKind::Block(b) => {
                let mut copied = self.copied_block(b, &mut frame);
                if b.kind == BlockKind::Obstacle {
                    self.paths(m, &mut copied.body.entries);
                }
                Named::Block(NamedBlock { name, ..copied })
            }
            ItemKind::Variable(v) => {
                let ty = self.name(&v.ty, &mut frame);
                let optional = v.optional.map(|at| self.at(at, &mut frame));
                let held = v.value.as_ref().map(|held| match broken {
                    true => Value { kind: ValueKind::Missing, span: held.span },
                    false => self.value(held, &mut frame),
                });
                Named::Variable(Variable { name, ty, optional, value: held })
            }
            _ => return,
        };
        self.out.values.push(named);
    }

    /// Adds a task without parameters. Returns `None` if that fails, with diagnostics.
    pub(super) fn emit_task(&mut self, (m, i): (usize, usize)) -> Option<String> {
        let ItemKind::Task(task) = self.modules[m].items[i].kind.clone() else { return None };
        let key = (m, Class::Task, task.name.value.clone());
        if let Some(known) = self.emitted.get(&key) {
            return known.clone();
        }
        let mut frame = Frame::of(m);
        let own = self.name(&task.name, &mut frame);
        let name = Spanned::new(self.program_name(m, Class::Task, &own.value), own.span);
        self.emitted.insert(key, Some(name.value.clone()));
        match self.definition(&task.definition, &mut frame) {
            Some(definition) => self.add_task(Task { name: name.clone(), parameters: Vec::new(), definition }),
            None => {
                self.out.failed.insert(name.value.clone());
            }
        }
        Some(name.value)
    }

    pub(super) fn emit_stack(&mut self, (m, i): (usize, usize), stack: &Stack) {
        let key = (m, Class::Stack, stack.name.value.clone());
        if self.emitted.contains_key(&key) {
            return;
        }
        let mut frame = Frame::of(m);
        let own = self.name(&stack.name, &mut frame);
        let name = Spanned::new(self.program_name(m, Class::Stack, &own.value), own.span);
        self.emitted.insert(key, Some(name.value.clone()));
        if let Some(expanded) = self.stack((m, i), &mut frame) {
            self.out.stacks.push(Stack { name, ..expanded });
        }
    }

    /// Adds a robot of the spec, unless another robot is derived from it.
    fn emit_robot(&mut self, m: usize, robot: &Robot) {
        let Some(body) = self.robot_body(m, robot, &mut Vec::new()) else { return };
        let visible = self.program_name(m, Class::Robot, &robot.name.value);
        let is_base = |item: &dsl::tree::Item| match &item.kind {
            ItemKind::Robot(r) => r.base.as_ref().is_some_and(|b| b.value == visible),
            _ => false,
        };
        if !self.modules[0].items.iter().any(is_base) {
            let name = Spanned::new(visible, robot.name.span);
            self.out.robots.push(Robot { name, base: None, body });
        }
    }

    /// Body of a robot: the entries of its base, overridden by its own.
    fn robot_body(&mut self, m: usize, robot: &Robot, seen: &mut Vec<(usize, String)>) -> Option<dsl::tree::Block> {
        seen.push((m, robot.name.value.clone()));
        let mut own = self.block(&robot.body, &mut Frame::of(m));
        self.paths(m, &mut own.entries);
        let Some(base) = &robot.base else { return Some(own) };
        let (bm, bi) = match self.find(m, Class::Robot, &base.value) {
            Ok(found) => found,
            Err(failed) => {
                self.unknown(m, Class::Robot, base, failed);
                return None;
            }
        };
        // The entries of a base are counted before they are copied, because it may be large.
        let ItemKind::Robot(other) = &self.modules[bm].items[bi].kind else { return None };
        let (size, at) = (other.body.entries.len(), base.span);
        if !(0..size).all(|_| self.count(at)) {
            return None;
        }
        let ItemKind::Robot(other) = self.modules[bm].items[bi].kind.clone() else { return None };
        if seen.contains(&(bm, other.name.value.clone())) || seen.len() >= MAX_DEPTH {
            let d = Diagnostic::error("HQ0216", base.span, format!("`{}` is made from itself", base.value));
            self.fail(d.label(other.name.span, "declared here").help("make it from another robot"));
            return None;
        }
        let mut body = self.robot_body(bm, &other, seen)?;
        let mut places: BTreeMap<String, usize> =
            body.entries.iter().enumerate().map(|(i, e)| (e.key.value.clone(), i)).collect();
        for entry in own.entries {
            match places.get(&entry.key.value) {
                Some(&known) => body.entries[known] = entry,
                None => {
                    places.insert(entry.key.value.clone(), body.entries.len());
                    body.entries.push(entry);
                }
            }
        }
        Some(dsl::tree::Block { span: own.span, ..body })
    }

    /// Converts paths from relative to the module's file to relative to the spec.
    pub(super) fn paths(&self, m: usize, entries: &mut [Entry]) {
        let folder = &self.modules[m].folder;
        if folder.as_os_str().is_empty() {
            return;
        }
        let is_path = |e: &&mut Entry| {
            let paths = ["urdf", "srdf", "package_path", "layers_from", "map", "spec", "mesh", "cloud", "heightfield"];
            paths.contains(&e.key.value.as_str())
        };
        for e in entries.iter_mut().filter(is_path) {
            if let Some(path) = text_of(&e.value) {
                let path = tidy(&folder.join(Path::new(path)), self.input.folder);
                let kind = ValueKind::Text(path.to_string_lossy().into_owned());
                e.value = Value { kind, span: e.value.span };
            }
        }
    }

    /// Reports a missing base of a robot or stack.
    pub(super) fn unknown(&mut self, m: usize, class: Class, name: &Spanned<String>, failed: bool) {
        self.out.whole = false;
        if failed {
            return;
        }
        let word = class.word();
        let mut names = self.names(m, class, false);
        names.extend(self.names(m, class, true));
        let d = Diagnostic::undeclared(word, &name.value, name.span);
        self.push(d.help(format!("declare the {word}, or import it")).one_of(
            "declared are",
            &name.value,
            names.iter().map(String::as_str),
        ));
    }

    /// Warns of unused tasks and stacks with parameters; later stages report the other unused declarations.
    fn unused(&mut self, all: &[(Class, (usize, usize))]) {
        if !self.out.whole {
            return;
        }
        for (class, (m, i)) in all {
            let kind = &self.modules[*m].items[*i].kind;
            let Some((_, name)) = declared(kind).filter(|_| !parameters(kind).is_empty()) else { continue };
            if self.used.contains(&(*m, *class, name.value.clone())) {
                continue;
            }
            let visible = self.program_name(*m, *class, &name.value);
            // The run uses it, and a later stage reports the missing arguments.
            let run = |(run, _): &(dsl::tree::Run, Span)| {
                run.body.get("stack").and_then(|e| text_of(&e.value)) == Some(visible.as_str())
            };
            if *class == Class::Stack && self.out.runs.iter().any(run) {
                continue;
            }
            let imported = self.out.imported.get(&(*class, visible.clone())).copied();
            let at = imported.unwrap_or(name.span);
            let d = Diagnostic::unused(at, format!("{} `{visible}` is never used", class.word()));
            self.push(d.help(if imported.is_some() { "do not import it" } else { "use it, or remove it" }));
        }
    }
}
