//! Declarations of a spec by kind, values from the command line, and unused declarations.

use std::collections::{BTreeMap, BTreeSet};

use dsl::tree::{ItemKind, Machine, MemberTask, Param, Robot, Run, Stack, Task, Value};
use dsl::{Diagnostic, Help, Snippet, Span, Spanned, Syntax};

use super::Lowerer;
use super::inline_tasks::names;
use super::signals::parts_of_signal;
use crate::expand::{Class, Expanded, Named};

/// Declarations of a spec by kind.
pub(super) struct Declared<'t> {
    pub params: Vec<&'t Param>,
    pub robots: Vec<&'t Robot>,
    pub tasks: Vec<&'t Task>,
    pub stacks: Vec<&'t Stack>,
    pub machine: Option<&'t Machine>,
    pub runs: Vec<(&'t Run, Span)>,
    /// False if a part of the spec is missing.
    pub whole: bool,
    /// Stacks with parameters.
    pub patterns: &'t BTreeMap<String, Span>,
    /// Tasks that could not be expanded.
    pub failed: &'t BTreeSet<String>,
}

impl Lowerer<'_> {
    pub(super) fn collect<'t>(&mut self, expanded: &'t Expanded) -> Declared<'t> {
        let params = expanded.values.iter().filter_map(|v| match v {
            Named::Param(p) => Some(p),
            Named::Let(_) | Named::Signal(_) | Named::Block(_) | Named::Variable(_) => None,
        });
        let mut robots: Vec<&Robot> = Vec::new();
        for robot in &expanded.robots {
            match robots.iter().find(|first| first.name.value == robot.name.value) {
                Some(first) => self.push(twice(&robot.name, first.name.span)),
                None => robots.push(robot),
            }
        }
        for (_, other) in expanded.runs.iter().skip(1) {
            let d = Diagnostic::error("HQ0202", *other, "there is already a `run`");
            self.push(d.label(expanded.runs[0].1, "the first one").help("keep one of them"));
        }
        for other in expanded.machines.iter().skip(1) {
            let d = Diagnostic::error("HQ0202", other.name.span, "a spec has one machine for now");
            let d = d.label(expanded.machines[0].name.span, "the first one");
            self.push(d.help("make its states those of a state of the first one"));
        }
        Declared {
            params: params.collect(),
            robots,
            tasks: expanded.tasks.iter().collect(),
            stacks: expanded.stacks.iter().collect(),
            machine: expanded.machines.first(),
            runs: expanded.runs.iter().take(1).map(|(run, at)| (run, *at)).collect(),
            whole: expanded.whole,
            patterns: &expanded.patterns,
            failed: &expanded.failed,
        }
    }

    /// Parses the values given with `--set`.
    pub(super) fn overrides(&mut self, declared: &Declared) -> BTreeMap<String, Value> {
        let mut out = BTreeMap::new();
        for (name, text) in self.input.set {
            let whole = format!("hierarq 1\nparam {name} = {text}\n");
            let source = self.sources.add(format!("--set {name}={text}"), whole.clone());
            let (spec, diagnostics) = dsl::parse(source, &whole, Syntax::Native);
            self.diagnostics.extend(diagnostics);
            let param = spec.items.into_iter().find_map(|i| match i.kind {
                ItemKind::Param(p) => Some(p),
                _ => None,
            });
            let Some(param) = param else { continue };
            if declared.params.iter().any(|p| p.name.value == *name) {
                out.insert(name.clone(), param.value);
            } else {
                // Params of other files that are not imported by name have names that users cannot write.
                let names = declared.params.iter().map(|p| p.name.value.as_str()).filter(|n| !n.contains('.'));
                let d = Diagnostic::unknown_name(param.name.span, format!("the spec has no param `{name}`"));
                let d = d
                    .help(Help::with(
                        "it has no params at all: declare one, {}",
                        [Snippet::defined("param", "NAME", "VALUE")],
                    ))
                    .one_of("it has", name, names);
                self.push(d);
            }
        }
        out
    }

    /// Warns of unused declarations. `complete` is true if all tasks were bound; otherwise, a parameter may be used in
    /// a part that was not examined.
    pub(super) fn unused(&mut self, declared: &Declared, expanded: &Expanded, complete: bool) {
        // Unused declarations of another file are not reported.
        let place = |class: Class, name: &Spanned<String>| match expanded.imported.get(&(class, name.value.clone())) {
            Some(at) => Some((*at, true)),
            None => (!name.value.contains('.')).then_some((name.span, false)),
        };
        // Levels that a derived stack replaces or removes are written for the base, so their contents count as used.
        let discarded: Vec<&MemberTask> = expanded.discarded.iter().flat_map(|l| &l.members).map(|m| &m.task).collect();
        let mentioned: BTreeSet<String> = (discarded.iter())
            .flat_map(|task| match task {
                MemberTask::Inline(d) => names(d),
                MemberTask::Name(_) | MemberTask::For(_) => BTreeSet::new(),
            })
            .collect();
        // After an error, a transition may wait for an event under another name.
        let all_heard = self.errors() == 0;
        let advice = |imported: bool, own: &'static str| if imported { "do not import it" } else { own };
        for value in &expanded.values {
            let (word, name) = match value {
                Named::Param(p) => ("param", &p.name),
                Named::Let(l) => ("let", &l.name),
                Named::Signal(s) => ("signal", &s.name),
                Named::Block(b) => (b.kind.keyword(), &b.name),
                Named::Variable(v) => ("variable", &v.name),
            };
            let known = (self.params.symbols.contains_key(&name.value)
                || self.params.humans.contains_key(&name.value)
                || (self.params.events.contains_key(&name.value) && all_heard)
                || (self.params.wrenches.contains(&name.value) && all_heard)
                || self.params.fields.contains(&name.value)
                || self.params.obstacles.contains(&name.value))
                && !self.params.used.contains(&name.value)
                && !parts_of_signal(&name.value).iter().any(|part| self.params.used.contains(part))
                && !mentioned.contains(&name.value);
            if let Some((at, imported)) = place(Class::Value, name).filter(|_| complete && known) {
                let event = self.params.events.contains_key(&name.value);
                let d = Diagnostic::unused(at, format!("{word} `{}` is never used", name.value));
                let own = match event {
                    true => "let a transition wait for it, or remove it",
                    false => "use it, or remove it",
                };
                self.push(
                    if event { d.note("no transition waits for this event") } else { d }.help(advice(imported, own)),
                );
            }
        }
        let members: Vec<&str> = (declared.stacks.iter().flat_map(|s| &s.levels).flat_map(|l| &l.members))
            .map(|m| &m.task)
            .chain(discarded.iter().copied())
            .filter_map(|task| match task {
                MemberTask::Name(n) => Some(n.value.as_str()),
                MemberTask::Inline(_) | MemberTask::For(_) => None,
            })
            .collect();
        for t in &declared.tasks {
            let name = &t.name;
            let used = members.contains(&name.value.as_str()) || self.used_tasks.contains(&name.value);
            if let Some((at, imported)) =
                place(Class::Task, name).filter(|_| !used && !declared.stacks.is_empty() && declared.whole)
            {
                let d = Diagnostic::unused(at, format!("task `{}` is in no stack", name.value));
                self.push(d.help(advice(imported, "add it to a level, or remove it")));
            }
        }
    }
}

pub(super) fn twice(name: &Spanned<String>, first: Span) -> Diagnostic {
    Diagnostic::error("HQ0202", name.span, format!("`{}` is declared twice", name.value))
        .label(first, "first here")
        .help("choose another name for one of them")
}
