//! Copies levels and their members: unrolls repetitions, and renames tasks to their names in the program.

use dsl::tree::{Level, Member, MemberTask, TaskDefinition};
use dsl::{Diagnostic, Span, Spanned};

use super::module::parameters;
use super::substitute::{Bound, Frame};
use super::{Class, Expander};
use crate::forms::text_of;

/// Name of a task in a level that failed to expand.
const FAILED: &str = "?";

impl Expander<'_> {
    /// Copies a level.
    pub(super) fn level(&mut self, level: &Level, frame: &mut Frame) -> Level {
        let mut settings = self.block(&level.settings, frame);
        settings.span = self.at(level.settings.span, frame);
        Level {
            name: self.name(&level.name, frame),
            hard: level.hard.map(|h| self.at(h, frame)),
            settings,
            members: self.members(&level.members, frame),
            span: self.at(level.span, frame),
            comments: Default::default(),
        }
    }

    /// Copies members and unrolls their repetitions.
    pub(super) fn members(&mut self, members: &[Member], frame: &mut Frame) -> Vec<Member> {
        let mut out = Vec::new();
        for m in members {
            if frame.copies() && !self.count(m.span) {
                break;
            }
            let task = match &m.task {
                MemberTask::For(repeat) => {
                    let Some(values) = self.values(&repeat.values, frame) else {
                        let (task, span) = (self.failed(m.span), m.span);
                        out.push(Member { task, weight: None, span, comments: Default::default() });
                        continue;
                    };
                    for value in values {
                        if !self.count(value.span) {
                            break;
                        }
                        let at = value.span;
                        let mut inner = frame.with(&repeat.variable.value, value, at);
                        out.extend(self.members(&repeat.body, &mut inner));
                    }
                    continue;
                }
                MemberTask::Name(name) => self.member_name(name, frame),
                MemberTask::Inline(definition) => self.member_inline(definition, frame),
            };
            let weight = m.weight.as_ref().map(|w| self.value(w, frame));
            out.push(Member { task, weight, span: self.at(m.span, frame), comments: Default::default() });
        }
        out
    }

    fn failed(&mut self, span: Span) -> MemberTask {
        self.out.failed.insert(FAILED.to_string());
        MemberTask::Name(Spanned::new(FAILED.to_string(), span))
    }

    fn member_name(&mut self, written: &Spanned<String>, frame: &mut Frame) -> MemberTask {
        let word = match frame.bound.get(&written.value) {
            Some(Bound::Task(task)) => return task.clone(),
            // `for task in [deck, arms_apart] { task }`
            Some(Bound::Value(value) | Bound::Joints(value)) => text_of(value).map(str::to_string),
            None => None,
        };
        let task = word.filter(|word| {
            self.find(frame.module, Class::Task, word) != Err(false) || stdlib_tasks::find(word).is_some()
        });
        let chosen = task.map(|word| Spanned::new(word, written.span));
        let written = match (&chosen, frame.bound.contains_key(&written.value)) {
            (Some(chosen), _) => chosen,
            (None, false) => written,
            (None, true) => {
                let span = self.at(written.span, frame);
                let d = Diagnostic::error(
                    "HQ0215",
                    span,
                    format!("`{}` is no task, and a task is needed here", written.value),
                );
                self.fail(d.help("give the name of a task there; a parameter for tasks is declared `NAME: task`"));
                return self.failed(span);
            }
        };
        let name = self.name(written, frame);
        match self.find(frame.module, Class::Task, &name.value) {
            Ok((m, i)) if parameters(&self.modules[m].items[i].kind).is_empty() => match self.emit_task((m, i)) {
                Some(task) => MemberTask::Name(Spanned::new(task, name.span)),
                None => self.failed(name.span),
            },
            Ok(_) => {
                let body = dsl::tree::Block { span: written.span, ..Default::default() };
                let (args, named) = (Vec::new(), Vec::new());
                let all = TaskDefinition { kind: written.clone(), args, named, body, span: written.span };
                self.member_inline(&all, frame)
            }
            Err(true) => {
                self.out.whole = false;
                self.failed(name.span)
            }
            // A type of the library, or an unknown name.
            Err(false) => MemberTask::Name(name),
        }
    }

    fn member_inline(&mut self, d: &TaskDefinition, frame: &mut Frame) -> MemberTask {
        let kind = self.name(&d.kind, frame);
        let task = match self.find(frame.module, Class::Task, &kind.value) {
            Ok(found) => {
                self.instance(found, d, &kind, frame).map(|name| MemberTask::Name(Spanned::new(name, kind.span)))
            }
            Err(true) => {
                self.out.whole = false;
                None
            }
            Err(false) => self.library(d, frame).map(MemberTask::Inline),
        };
        task.unwrap_or_else(|| self.failed(kind.span))
    }
}
