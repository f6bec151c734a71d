//! Stacks with their levels and tasks.

use std::collections::BTreeMap;

use blocks::{Block, NumberOrWord};
use dsl::tree::{Entry, Let, MemberTask, Stack, TaskDefinition, Unit, Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet, Span, Spanned, Topic};
use names::{list, suggest};
use runtime::program::{LevelProgram, MemberProgram, StackProgram};
use stdlib_tasks::params::ParamType;

use super::Lowerer;
use super::declared::{Declared, twice};
use super::inline_tasks::in_place;
use crate::binding::{Binder, BoundTask};
use crate::block_binding::Scope;
use crate::diagnostics::examples;
use crate::diagnostics::other_frameworks::known_elsewhere;
use crate::forms::unknown_key;
use crate::robot_binding::{BoundRobot, joints};
use crate::sections::{LevelBlock, MEMBER, STACK, StackBlock};

impl Lowerer<'_> {
    /// Binds tasks; `None` for a task that failed. `later` are named expressions of the robot's state, each after those
    /// that it uses; `refused` are spans of values whose mistakes are reported already.
    pub(super) fn tasks(
        &mut self,
        definitions: &[(String, TaskDefinition)],
        robot: &BoundRobot,
        (later, refused): (&[&Let], &[Span]),
    ) -> Vec<Option<BoundTask>> {
        let before = self.diagnostics.len();
        let mut binder = Binder { tasks: definitions, ..self.binder(robot) };
        for it in later {
            binder.named(it);
        }
        // A task that names another one is bound after it, because it needs the axes of the other one's target.
        let names_another = |d: &TaskDefinition| {
            let kind = stdlib_tasks::find(&d.kind.value);
            kind.is_some_and(|k| k.params.iter().any(|p| p.ty == ParamType::Task))
        };
        let mut bound: Vec<Option<BoundTask>> = definitions.iter().map(|_| None).collect();
        for naming in [false, true] {
            for (i, (_, d)) in definitions.iter().enumerate().filter(|(_, (_, d))| names_another(d) == naming) {
                bound[i] = binder.task(d, i);
            }
        }
        // The mistake of an argument is reported once, and not at each use of its parameter.
        let again = |d: &Diagnostic| {
            let at = d.primary.span;
            refused.iter().any(|r| r.source == at.source && r.start <= at.start && at.end <= r.end)
        };
        let mut found = self.diagnostics.split_off(before);
        found.retain(|d| !again(d));
        self.diagnostics.extend(found);
        bound
    }
}

/// Lowering of the stacks of a spec.
pub(super) struct Stacks<'s, 'l> {
    /// Constants and diagnostics of the spec.
    pub lowerer: &'s mut Lowerer<'l>,
    /// Declarations.
    pub declared: &'s Declared<'s>,
    /// The robot, if it could be bound.
    pub robot: Option<&'s BoundRobot>,
    /// Names of all tasks: the declared ones, and then those that are written inside levels.
    pub names: Vec<&'s str>,
    /// Index of the next task that is written inside a level.
    pub inline: usize,
}

impl Stacks<'_, '_> {
    /// Lowers one stack.
    pub(super) fn stack(&mut self, s: &Stack) -> StackProgram {
        let tasks = &self.declared.tasks;
        let declared = tasks.len();
        let keys: Vec<&str> = STACK.entries().collect();
        let known = |e: &Entry| keys.contains(&e.key.value.as_str());
        for (i, e) in s.settings.entries.iter().enumerate().filter(|(_, e)| !known(e)) {
            let d = unknown_key(self.lowerer.diagnostics.len(), &s.settings, i, &keys, STACK.name);
            self.lowerer.push(match &e.value.kind {
                ValueKind::Block(_) if e.key.value != "for" => d.help(Snippet::each(
                    format!("level {} {{ .. }}", e.key.value),
                    format!("levels: [ {{ name: {}, .. }} ]", e.key.value),
                )),
                ValueKind::Block(_) => d,
                _ if e.key.value == "for" => {
                    d.help("`for` repeats tasks inside a level, and declarations; write the levels one by one")
                }
                _ => d,
            });
        }
        let bound = self.lowerer.block_binder(&Scope::default()).entries(&s.settings, &STACK, s.name.span, |_| true);
        let StackBlock { lock, .. } = StackBlock::read(&bound);
        let lock = lock.and_then(|lock| self.lowerer.origins.unbound(&lock));
        let locked = lock.zip(self.robot).and_then(|(lock, robot)| {
            joints(lock.items(), &robot.model, &robot.joint_groups, self.lowerer.diagnostics)
        });
        if s.levels.is_empty() && s.settings.entries.iter().all(known) {
            self.lowerer.push(
                Diagnostic::error("HQ0601", s.name.span, format!("stack `{}` has no level", s.name.value))
                    .about(Topic::MissingDeclaration)
                    .help(Snippet::level("NAME", false, "task").listed("levels")),
            );
        }
        let mut levels = Vec::new();
        let mut seen: BTreeMap<usize, Span> = BTreeMap::new();
        let mut soft: Option<Span> = None;
        for (i, l) in s.levels.iter().enumerate() {
            if let Some(first) = s.levels[..i].iter().find(|o| o.name == l.name) {
                self.lowerer.push(twice(&l.name, first.name.span));
            }
            let LevelBlock { damping, .. } = self.lowerer.read(&l.settings, l.name.span);
            if l.members.is_empty() {
                self.lowerer.push(
                    Diagnostic::error("HQ0601", l.name.span, format!("level `{}` has no task", l.name.value))
                        .about(Topic::MissingDeclaration)
                        .help("add a task, or remove the level"),
                );
            }
            match (l.hard, soft) {
                (Some(hard), Some(soft)) => {
                    let d = Diagnostic::warning("HQ0606", hard, "this hard level is below a soft one")
                        .label(soft, "this level is soft")
                        .note("the soft level can make the hard one infeasible, which is a fault")
                        .help("put hard levels first");
                    self.lowerer.push(d);
                }
                (None, None) => soft = Some(l.name.span),
                _ => {}
            }
            let mut members = Vec::new();
            for m in &l.members {
                let task = match &m.task {
                    task if in_place(task, tasks).is_some() => {
                        self.inline += 1;
                        self.inline - 1
                    }
                    MemberTask::Inline(_) | MemberTask::For(_) => continue,
                    MemberTask::Name(n) if self.declared.failed.contains(&n.value) => continue,
                    MemberTask::Name(n) => match self.names[..declared].iter().position(|x| *x == n.value) {
                        Some(t) => t,
                        None => {
                            self.unknown_task(n);
                            continue;
                        }
                    },
                };
                if let Some(first) = seen.insert(task, m.span) {
                    self.lowerer.push(
                        Diagnostic::error(
                            "HQ0602",
                            m.span,
                            format!("task `{}` is twice in stack `{}`", self.names[task], s.name.value),
                        )
                        .label(first, "first here")
                        .help("keep it on the most important level"),
                    );
                    continue;
                }
                let weight = match &m.weight {
                    Some(Value { kind: ValueKind::Unit(_, unit), span }) => {
                        self.weight_with_unit(*span, unit);
                        1.0
                    }
                    Some(weight) => self.lowerer.read_word(&MEMBER, "weight", weight).unwrap_or(1.0),
                    None => 1.0,
                };
                members.push(MemberProgram { task, weight, parts: Vec::new(), idle: Vec::new() });
            }
            levels.push(LevelProgram {
                name: l.name.value.clone(),
                hard: l.hard.is_some(),
                damping: if let NumberOrWord::Number(damping) = damping { damping } else { 0.0 },
                exact: damping == NumberOrWord::Word("none"),
                members,
            });
        }
        let (name, locked) = (s.name.value.clone(), locked.unwrap_or_default());
        StackProgram { name, locked, levels, parts: Vec::new() }
    }

    /// Reports a weight with a unit. In `reach weight 4  g weight 5` the next task is read as one.
    fn weight_with_unit(&mut self, at: Span, unit: &Unit) {
        let unit = unit.to_string();
        let d = Diagnostic::error("HQ0301", at, "a weight has no unit").here(format!("`{unit}` is read as a unit"));
        let task = self.names.iter().any(|name| **name == unit);
        // It is meant to be in the stack.
        self.lowerer.used_tasks.extend(task.then(|| unit.clone()));
        self.lowerer.push(if task {
            d.help(format!("begin a new line before the task `{unit}`, or put a comma before it"))
        } else {
            d.help("leave the unit out")
        });
    }

    fn unknown_task(&mut self, name: &Spanned<String>) {
        // Tasks of other files have names that users cannot write.
        let names = &self.names[..self.declared.tasks.len()];
        let names: Vec<&str> = names.iter().copied().filter(|n| !n.contains('.')).collect();
        let d = Diagnostic::undeclared("task", &name.value, name.span);
        let d = if let Some(near) = suggest(&name.value, names.iter().copied()) {
            // The suggested task must not be reported as unused.
            self.lowerer.used_tasks.insert(near.to_string());
            d.meant(near)
        } else if let Some(here) = known_elsewhere(&name.value) {
            d.help(here)
        } else if let Some(near) = suggest(&name.value, stdlib_tasks::KINDS.iter().map(|k| k.name)) {
            d.meant_as("the task type", near)
        } else if names.is_empty() {
            d.help(Help::with("declare it: {}", [examples::task()]))
        } else {
            d.help(format!("declared are {}", list(names.iter().copied(), 12)))
        };
        self.lowerer.push(d);
    }
}
