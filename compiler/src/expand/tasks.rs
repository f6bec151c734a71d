//! Copies tasks: library types unchanged, and tasks with parameters for each use.

use std::collections::BTreeMap;

use dsl::tree::{ItemKind, MemberTask, Task, TaskDefinition, ValueKind};
use dsl::{Diagnostic, Help, Snippet, SourceId, Span, Spanned};

use super::arguments::{Arguments, Taker};
use super::substitute::{Bindings, Bound, Frame};
use super::{Class, Expander, MAX_DEPTH};
use crate::diagnostics::other_frameworks::known_elsewhere;
use crate::forms::text_of;
use crate::units::as_written;

/// A use of a task with parameters.
pub(super) struct Instance {
    bound: Bindings,
    /// Name of the resulting task; `None` if it failed.
    pub(super) task: Option<String>,
    /// Instance of the task's text for this use.
    source: SourceId,
}

impl Expander<'_> {
    /// Reduces a definition to a library type. Returns `None` if that fails, with diagnostics.
    pub(super) fn definition(&mut self, d: &TaskDefinition, frame: &mut Frame) -> Option<TaskDefinition> {
        let kind = self.name(&d.kind, frame);
        match self.find(frame.module, Class::Task, &kind.value) {
            Ok(found) => {
                let (_, definition) = self.used_task(found, d, &kind, frame)?;
                Some(definition)
            }
            Err(true) => {
                self.out.whole = false;
                None
            }
            Err(false) => self.library(d, frame),
        }
    }

    /// Copies a definition whose type is in the library.
    pub(super) fn library(&mut self, d: &TaskDefinition, frame: &mut Frame) -> Option<TaskDefinition> {
        let mut copy = self.copied(d, frame);
        if copy.kind.value.is_empty() {
            // The parser could not read the type.
            self.out.whole = false;
            return None;
        }
        if stdlib_tasks::find(&copy.kind.value).is_none() {
            let own = self.names(frame.module, Class::Task, true);
            self.fail(unknown_kind(&copy.kind, &own));
            return None;
        }
        // Named arguments are equivalent to entries in braces.
        if !copy.named.is_empty() {
            let inside = std::mem::take(&mut copy.body.entries);
            let mut first: BTreeMap<&str, Span> = BTreeMap::new();
            for e in &inside {
                first.entry(&e.key.value).or_insert(e.key.span);
            }
            let mut all = Vec::with_capacity(copy.named.len() + inside.len());
            for e in std::mem::take(&mut copy.named) {
                if let Some(other) = first.get(e.key.value.as_str()) {
                    let text = format!("`{}` is given in parentheses and in braces", e.key.value);
                    let d = Diagnostic::error("HQ0207", e.key.span, text).label(*other, "here too");
                    self.fail(d.help("keep one of the two"));
                    continue;
                }
                all.push(e);
            }
            all.extend(inside);
            copy.body.entries = all;
        }
        Some(copy)
    }

    /// Expands a use of a task with parameters to its bindings and its definition.
    fn used_task(
        &mut self,
        (m, i): (usize, usize),
        d: &TaskDefinition,
        kind: &Spanned<String>,
        frame: &mut Frame,
    ) -> Option<(Bindings, TaskDefinition)> {
        let bound = self.bindings((m, i), d, kind, frame)?;
        let at = self.at(d.span, frame);
        let definition = self.body((m, i), &mut Frame::used(m, bound.clone(), at))?;
        Some((bound, definition))
    }

    /// Definition of a task with bound parameters.
    fn body(&mut self, (m, i): (usize, usize), inner: &mut Frame) -> Option<TaskDefinition> {
        let ItemKind::Task(task) = self.modules[m].items[i].kind.clone() else { return None };
        let key = (m, Class::Task, task.name.value.clone());
        self.active.push(key);
        let definition = self.definition(&task.definition, inner);
        self.active.pop();
        definition
    }

    /// Binds the parameters of a task for a use.
    fn bindings(
        &mut self,
        (m, i): (usize, usize),
        d: &TaskDefinition,
        kind: &Spanned<String>,
        frame: &mut Frame,
    ) -> Option<Bindings> {
        let ItemKind::Task(task) = self.modules[m].items[i].kind.clone() else { return None };
        let name = &task.name;
        self.used.insert((m, Class::Task, name.value.clone()));
        if task.parameters.is_empty() {
            let e = Diagnostic::error("HQ0204", kind.span, format!("`{}` is a task, and no task type", kind.value));
            self.fail(e.label(name.span, "declared here").help(Help::with(
                "write {} alone in a level, or give it parameters: {}",
                [
                    Snippet::same(kind.value.as_str()),
                    Snippet::each(
                        format!("task {}(..) = ..", name.value),
                        format!("tasks: {{ \"{}(..)\": .. }}", name.value),
                    ),
                ],
            )));
            return None;
        }
        if self.recursive(m, Class::Task, name, kind.span) {
            return None;
        }
        if let Some(first) = d.body.entries.first() {
            let span = self.at(first.key.span, frame);
            let e = Diagnostic::error("HQ0214", span, format!("`{}` takes its arguments in parentheses", kind.value));
            let e = e.label(name.span, "declared here");
            self.fail(e.help(format!("write `{}(..)` without braces", kind.value)));
            return None;
        }
        let taker = Taker { name, parameters: &task.parameters, module: m };
        let given = Arguments { args: &d.args, named: &d.named, at: d.span };
        self.arguments(&taker, &given, frame)
    }

    /// Reports a declaration that uses itself, and uses that are nested too deeply.
    pub(super) fn recursive(&mut self, m: usize, class: Class, name: &Spanned<String>, at: Span) -> bool {
        let key = (m, class, name.value.clone());
        if let Some(first) = self.active.iter().position(|a| *a == key) {
            // A cycle is one mistake, whatever its entry.
            let known = self.circles.contains(&key);
            self.circles.extend(self.active[first..].iter().cloned());
            if known {
                self.out.whole = false;
                return true;
            }
            let word = class.word();
            let d = Diagnostic::error("HQ0216", at, format!("{word} `{}` uses itself", name.value));
            let d = d.label(name.span, "declared here").note("it would expand without end");
            self.fail(d.help("use another one here"));
            return true;
        }
        if self.active.len() >= MAX_DEPTH {
            let text = format!("declarations use each other more than {MAX_DEPTH} deep");
            self.fail(Diagnostic::error("HQ0218", at, text).help("merge some of them"));
            return true;
        }
        false
    }

    /// Instantiates a use of a task with parameters in a level. Uses with equal arguments share one task.
    pub(super) fn instance(
        &mut self,
        (m, i): (usize, usize),
        d: &TaskDefinition,
        kind: &Spanned<String>,
        frame: &mut Frame,
    ) -> Option<String> {
        let bound = self.bindings((m, i), d, kind, frame)?;
        let at = self.at(d.span, frame);
        let alike = (m, i, digest(&bound));
        let known = self.alike.get(&alike).into_iter().flatten().map(|k| &self.instances[*k]);
        if let Some(known) = known.into_iter().find(|k| k.bound == bound) {
            let (source, task) = (known.source, known.task.clone());
            self.sources.used_again(source, at);
            return task;
        }
        let ItemKind::Task(task) = &self.modules[m].items[i].kind else { return None };
        let (written, place) = (task.name.value.clone(), task.name.span);
        let mut inner = Frame::used(m, bound.clone(), at);
        let span = self.at(place, &mut inner);
        let definition = self.body((m, i), &mut inner);
        let name = definition.map(|definition| {
            let name = self.instance_name(&written, &task_words(&bound, &self.order((m, i))));
            let name = Spanned::new(name, span);
            self.add_task(Task { name: name.clone(), parameters: Vec::new(), definition });
            name.value
        });
        self.alike.entry(alike).or_default().push(self.instances.len());
        self.instances.push(Instance { bound, task: name.clone(), source: span.source });
        name
    }

    /// Names of a task's parameters, in order.
    fn order(&self, (m, i): (usize, usize)) -> Vec<String> {
        super::module::parameters(&self.modules[m].items[i].kind).iter().map(|p| p.name.value.clone()).collect()
    }

    /// Name of an instance, `reach.left`: the task and the names among its arguments, numbered if that is not unique.
    fn instance_name(&mut self, task: &str, words: &[String]) -> String {
        let name = std::iter::once(task).chain(words.iter().map(String::as_str)).collect::<Vec<_>>().join(".");
        if name != task && !self.task_names.contains(&name) {
            return name;
        }
        let last = self.numbered.entry(name.clone()).or_insert(1);
        loop {
            *last += 1;
            let numbered = format!("{name}.{last}");
            if !self.task_names.contains(&numbered) {
                return numbered;
            }
        }
    }

    /// Adds a task to the program.
    pub(super) fn add_task(&mut self, task: Task) {
        self.task_names.insert(task.name.value.clone());
        self.out.tasks.push(task);
    }
}

/// Digest of bindings, equal for equal arguments: names, texts and numbers in sequence.
fn digest(bound: &Bindings) -> String {
    let mut text = String::new();
    for bound in bound.values() {
        let mut open = match bound {
            Bound::Value(value) | Bound::Joints(value) => vec![value],
            Bound::Task(MemberTask::Name(name)) => {
                text.push_str(&name.value);
                Vec::new()
            }
            Bound::Task(_) => Vec::new(),
        };
        while let Some(value) = open.pop() {
            match &value.kind {
                ValueKind::Number(n) => text.push_str(&n.value.to_string()),
                ValueKind::Name(word) | ValueKind::Text(word) => text.push_str(word),
                _ => {}
            }
            open.extend(value.parts());
            text.push(' ');
        }
    }
    text
}

/// Names and whole numbers among the arguments.
fn task_words(bound: &Bindings, order: &[String]) -> Vec<String> {
    let word = |name: &String| match bound.get(name)? {
        Bound::Value(value) | Bound::Joints(value) => match &as_written(value).kind {
            ValueKind::Name(_) => text_of(as_written(value)).map(str::to_string),
            ValueKind::Number(n) if n.text.bytes().all(|b| b.is_ascii_digit()) => Some(n.text.clone()),
            _ => None,
        },
        Bound::Task(_) => None,
    };
    order.iter().filter_map(word).collect()
}

/// Diagnostic for a task type that neither the library nor the spec declares.
fn unknown_kind(kind: &Spanned<String>, own: &[String]) -> Diagnostic {
    let d = Diagnostic::error("HQ0204", kind.span, format!("there is no task type `{}`", kind.value));
    if let Some(here) = known_elsewhere(&kind.value) {
        return d.help(here);
    }
    let library = stdlib_tasks::KINDS.iter().map(|k| k.name);
    d.help("`hierarq tasks` lists all types").nearest(&kind.value, library.chain(own.iter().map(String::as_str)))
}
