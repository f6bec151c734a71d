//! Parameters that name another task or a safety field, and the permitted deviations of that task's target.

use std::collections::BTreeMap;

use dsl::tree::{Block, Value, ValueKind};
use dsl::{Diagnostic, Help};
use names::list;
use stdlib_tasks::bound::{Bound, BoundParams, Obstacle};
use stdlib_tasks::kinds::safety_planner::{PATH, TURN};
use stdlib_tasks::params::{ParamInfo, ParamType};
use stdlib_tasks::task::RowKind;

use super::{Binder, Owner};
use crate::diagnostics::examples;
use crate::diagnostics::examples::unknown_obstacle;
use crate::expr::{Axes, Frame};
use crate::forms::{block_of, target, text_of, unknown_key, written};

impl Binder<'_> {
    /// Index of a declared task that has a target.
    pub(super) fn task_named(&mut self, owner: Owner, value: &Value, info: &ParamInfo) -> Option<usize> {
        let Some(name) = text_of(value) else {
            return self.wrong(value, info, "the name of a declared task");
        };
        // A task of another file may have a different name in the program.
        let program = match &value.kind {
            ValueKind::Name(name) => target(name),
            _ => name,
        };
        let found = self.tasks.iter().position(|t| t.0 == program);
        let Some((index, (_, definition))) = found.and_then(|i| Some((i, self.tasks.get(i)?))) else {
            let names: Vec<&str> = self.tasks.iter().map(|t| t.0.as_str()).filter(|n| !n.contains('.')).collect();
            let d = Diagnostic::undeclared("task", name, value.span);
            self.diagnostics
                .push(d.help(Help::with("declare it: {}", [examples::task()])).nearest(name, names.iter().copied()));
            return None;
        };
        let kind = stdlib_tasks::find(&definition.kind.value)?;
        let why = match kind.row_kind {
            RowKind::Inequality => "it is a limit, which has no path to delay or to deviate from",
            RowKind::Equality if kind.name == owner.kind.name => "it is a safety planner itself",
            RowKind::Equality => return Some(index),
        };
        let text = format!("a safety planner cannot protect `{name}`: {why}");
        let d = Diagnostic::error("HQ0608", value.span, text).label(definition.kind.span, "declared here");
        self.diagnostics
            .push(d.help("name a task that pulls towards a target, such as `frame_pose` or `cooperative_motion`"));
        None
    }

    /// Index of a declared safety field.
    pub(super) fn field_named(&mut self, value: &Value, info: &ParamInfo) -> Option<usize> {
        let Some(said) = text_of(value) else {
            return self.wrong(value, info, "the name of a declared safety field");
        };
        let name = match &value.kind {
            ValueKind::Name(name) => target(name),
            _ => said,
        };
        if self.params.failed.contains(name) {
            return None;
        }
        if let Some(found) = self.fields.iter().position(|f| f == name) {
            self.params.used.insert(name.to_string());
            return Some(found);
        }
        if self.params.fields.contains(name) {
            // Its binding failed, and that was reported.
            return None;
        }
        let d = Diagnostic::undeclared("safety field", written(said), value.span);
        let known = || self.fields.iter().map(String::as_str).filter(|n| !n.contains('.'));
        self.diagnostics.push(d.help(Help::with("declare it: {}", [examples::safety_field("NAME", "HUMAN")])).one_of(
            "declared are",
            said,
            known(),
        ));
        None
    }

    /// Declared obstacles.
    pub(super) fn obstacles_named(&mut self, value: &Value, info: &ParamInfo) -> Option<Vec<Obstacle>> {
        let mut all: Vec<Obstacle> = Vec::new();
        let mut good = true;
        for item in value.items() {
            let Some(name) = text_of(item) else {
                self.wrong::<()>(item, info, "the name of a declared obstacle, or a list of names");
                good = false;
                continue;
            };
            let name = target(name);
            match self.obstacles.iter().find(|o| o.name == name) {
                Some(o) => {
                    self.params.used.insert(name.to_string());
                    if !all.iter().any(|known| known.name == o.name) {
                        all.push(o.clone());
                    }
                }
                None => {
                    good = false;
                    if !self.params.failed.contains(name) {
                        // One whose declaration has an error may be meant too.
                        let known = self.params.obstacles.iter().map(String::as_str).filter(|n| !n.contains('.'));
                        self.diagnostics.push(unknown_obstacle(written(name), item.span, known));
                    }
                }
            }
        }
        good.then_some(all)
    }

    /// Permitted deviations of another task's parameters, with the names and groups that they have in that task.
    pub(super) fn deviations(&mut self, owner: Owner, value: &Value, of: Option<usize>) -> Option<BoundParams> {
        let block = block_of(value, "`deviate`", self.diagnostics)?;
        // An unknown task was reported.
        let (name, definition) = self.tasks.get(of?)?.clone();
        let kind = stdlib_tasks::find(&definition.kind.value)?;
        let axes = of.and_then(|of| self.bound_axes.get(&of)).cloned().unwrap_or_default();
        self.deviating(owner, block, kind.params, (&axes, &name), "")
    }

    fn deviating(
        &mut self,
        owner: Owner,
        block: &Block,
        infos: &'static [ParamInfo],
        (axes, name): (&BTreeMap<&'static str, Axes>, &str),
        path: &str,
    ) -> Option<BoundParams> {
        let what = if path.is_empty() { format!("task `{name}`") } else { format!("`{path}` of task `{name}`") };
        let mut bound = BoundParams::new();
        let mut good = true;
        for (i, e) in block.entries.iter().enumerate() {
            let key = e.key.value.as_str();
            let path = if path.is_empty() { key.to_string() } else { format!("{path}.{key}") };
            let Some(info) = infos.iter().find(|p| p.name == key) else {
                let keys: Vec<&str> = infos.iter().filter(|p| may(p)).map(|p| p.name).collect();
                self.diagnostics.push(if keys.is_empty() {
                    let text = format!("{what} has nothing that can deviate");
                    Diagnostic::error("HQ0609", e.key.span, text)
                        .help("remove `deviate`: then only the clock is slowed")
                } else {
                    unknown_key(self.diagnostics.len(), block, i, &keys, &what)
                });
                good = false;
                continue;
            };
            let params = match info.ty {
                ParamType::Group(inner) if may(info) => block_of(&e.value, &format!("`{path}`"), self.diagnostics)
                    .and_then(|b| self.deviating(owner, b, inner, (axes, name), &path)),
                ParamType::Vector(_) | ParamType::Rotation => {
                    let turns = info.ty == ParamType::Rotation;
                    let prefix = format!("{}deviate.{path}.", owner.prefix);
                    let owner = Owner { prefix: &prefix, ..owner };
                    let what = format!("deviation `{path}`");
                    // A deviation is expressed in the axes of its parameter: those of a link, or the world's.
                    self.deviating = axes.get(path.as_str()).map_or(Frame::World, |a| a.to.clone());
                    let bound = block_of(&e.value, &format!("`{path}`"), self.diagnostics)
                        .and_then(|b| self.group(owner, if turns { TURN } else { PATH }, b, &what, e.key.span));
                    self.deviating = Frame::World;
                    bound
                }
                ParamType::Expression(_) => {
                    let text = format!("`{path}` of task `{name}` is an expression of any kind, and cannot deviate");
                    self.diagnostics.push(
                        Diagnostic::error("HQ0609", e.key.span, text)
                            .note("a deviation moves or rotates a target in the world, and an expression need not be one")
                            .help(
                                "track a frame with `frame_position(F) { position .. }` or `frame_pose(F)`, whose targets \
                                 deviate; or leave `deviate` out: the clock and the motion in its null space give way",
                            ),
                    );
                    None
                }
                _ => {
                    let text =
                        format!("`{path}` of task `{name}` is no position and no orientation, and cannot deviate");
                    let keys: Vec<&str> = infos.iter().filter(|p| may(p)).map(|p| p.name).collect();
                    let d = Diagnostic::error("HQ0609", e.key.span, text);
                    self.diagnostics.push(match keys.is_empty() {
                        true => d.help("remove `deviate`: then only the clock is slowed"),
                        false => d.help(format!("it may be {}", list(keys.iter().copied(), 8))),
                    });
                    None
                }
            };
            match params {
                Some(params) => drop(bound.insert(key.to_string(), Bound::Group(params))),
                None => good = false,
            }
        }
        good.then_some(bound)
    }
}

/// True if a parameter, or a member of it, may deviate.
fn may(info: &ParamInfo) -> bool {
    match info.ty {
        ParamType::Vector(_) | ParamType::Rotation => true,
        ParamType::Group(inner) => inner.iter().any(may),
        _ => false,
    }
}
