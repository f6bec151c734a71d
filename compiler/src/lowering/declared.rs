//! The declarations of a spec by kind, values given on the command line, and what nothing uses.

use std::collections::BTreeMap;

use dsl::tree::{Item, ItemKind, MemberTask, Param, Robot, Run, Stack, Task, Value};
use dsl::{Diagnostic, Span, Spanned, Spelling};

use super::Lowerer;
use crate::names::{list, suggest};

/// The declarations of a spec by kind.
#[derive(Default)]
pub(super) struct Declared<'t> {
    pub params: Vec<&'t Param>,
    pub robots: Vec<&'t Robot>,
    pub tasks: Vec<&'t Task>,
    pub stacks: Vec<&'t Stack>,
    pub runs: Vec<(&'t Run, Span)>,
}

impl Lowerer<'_> {
    pub(super) fn collect<'t>(&mut self, items: &'t [Item]) -> Declared<'t> {
        let mut d = Declared::default();
        for item in items {
            match &item.kind {
                ItemKind::Param(p) => d.params.push(p),
                ItemKind::Robot(r) => {
                    if let Some(first) = d.robots.first() {
                        self.push(
                            Diagnostic::error("HQ0202", r.name.span, "a spec has one robot for now")
                                .label(first.name.span, "the first one")
                                .help("write one spec for each robot"),
                        );
                    } else {
                        d.robots.push(r);
                    }
                }
                ItemKind::Task(t) => {
                    if let Some(first) = d.tasks.iter().find(|o| o.name == t.name).map(|o| o.name.span) {
                        self.push(twice(&t.name, first));
                    } else {
                        d.tasks.push(t);
                    }
                }
                ItemKind::Stack(s) => {
                    if let Some(first) = d.stacks.iter().find(|o| o.name == s.name).map(|o| o.name.span) {
                        self.push(twice(&s.name, first));
                    } else {
                        d.stacks.push(s);
                    }
                }
                ItemKind::Run(r) => {
                    if let Some((_, first)) = d.runs.first() {
                        let d2 = Diagnostic::error("HQ0202", item.span, "there is already a `run`")
                            .label(*first, "the first one")
                            .help("keep one of them");
                        self.push(d2);
                    } else {
                        d.runs.push((r, item.span));
                    }
                }
            }
        }
        d
    }

    /// Values given with `--set`.
    pub(super) fn overrides(&mut self, declared: &Declared) -> BTreeMap<String, Value> {
        let mut out = BTreeMap::new();
        for (name, text) in self.input.set {
            let whole = format!("hierarq 1\nparam {name} = {text}\n");
            let source = self.sources.add(format!("--set {name}={text}"), whole.clone());
            let (spec, diagnostics) = dsl::parse(source, &whole, Spelling::Hq);
            self.diagnostics.extend(diagnostics);
            let param = spec.items.into_iter().find_map(|i| match i.kind {
                ItemKind::Param(p) => Some(p),
                _ => None,
            });
            let Some(param) = param else { continue };
            if declared.params.iter().any(|p| p.name.value == *name) {
                out.insert(name.clone(), param.value);
            } else {
                let names = declared.params.iter().map(|p| p.name.value.as_str());
                let d = Diagnostic::error("HQ0201", param.name.span, format!("the spec has no param `{name}`"));
                let d = match suggest(name, names.clone()) {
                    Some(near) => d.help(format!("did you mean `{near}`?")),
                    None if declared.params.is_empty() => {
                        d.help("it has no params at all: declare one, `param NAME = VALUE`")
                    }
                    None => d.help(format!("it has {}", list(names, 12))),
                };
                self.push(d);
            }
        }
        out
    }

    /// Warns of what nothing uses. `complete` says that all tasks could be bound; otherwise a parameter may be used in
    /// what was not looked at.
    pub(super) fn unused(&mut self, declared: &Declared, complete: bool) {
        for p in &declared.params {
            let name = p.name.value.as_str();
            if complete && self.params.symbols.contains_key(name) && !self.params.used.contains(name) {
                let d = Diagnostic::warning("HQ0203", p.name.span, format!("param `{name}` is never used"));
                self.push(d.help("use it, or remove it"));
            }
        }
        let members: Vec<&str> = (declared.stacks.iter().flat_map(|s| &s.levels).flat_map(|l| &l.members))
            .filter_map(|m| match &m.task {
                MemberTask::Name(n) => Some(n.value.as_str()),
                MemberTask::Inline(_) => None,
            })
            .collect();
        for t in &declared.tasks {
            let name = &t.name.value;
            if !members.contains(&name.as_str()) && !self.meant.contains(name) && !declared.stacks.is_empty() {
                self.push(
                    Diagnostic::warning("HQ0203", t.name.span, format!("task `{}` stands in no stack", t.name.value))
                        .help("add it to a level, or remove it"),
                );
            }
        }
    }
}

pub(super) fn twice(name: &Spanned<String>, first: Span) -> Diagnostic {
    Diagnostic::error("HQ0202", name.span, format!("`{}` is declared twice", name.value))
        .label(first, "first here")
        .help("choose another name for one of them")
}
