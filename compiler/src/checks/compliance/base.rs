//! Warns of pushes at a frame that move the base: the base is not locked, and the rows of the frame have its columns.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet};
use robot::{MobileBase, Model};
use runtime::Member;
use stdlib_tasks::bound::Bound;
use stdlib_tasks::task::RowKind;

use crate::analysis::stacks::Signals;
use crate::checks::Checked;

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let model = &c.program.robot.model;
    if model.bases.is_empty() {
        return;
    }
    let mut told: BTreeSet<usize> = BTreeSet::new();
    for stack in c.program.run_stacks() {
        let Some(Pushed { task, base }) = pushed(c, stack).filter(|_| told.insert(stack)) else { continue };
        let group = format!("{}base", base.prefix(model));
        out.push(
            Diagnostic::warning(
                "HQ0548",
                c.places.stacks[stack].0,
                format!("a push at `{}` rolls the {}", c.program.tasks[task].name, words(model, &group)),
            )
            .label(c.places.tasks[task].span, "this yields with every joint that is free, and the base is")
            .note("the base of a robot beside a person moves over the person's feet, and nobody pushes it there on purpose")
            .help(Help::with(
                "keep the base still in this stack, {}; or guide the base by a task of its own",
                [Snippet::entry("lock", format!("[{group}]"))],
            )),
        );
    }
}

/// A push that moves a base.
struct Pushed<'p> {
    /// Index of the task that yields.
    task: usize,
    base: &'p MobileBase,
}

/// Words for a base: its group, if there are several robots.
fn words(model: &Model, group: &str) -> String {
    if model.roots.len() > 1 { format!("base `{group}`") } else { "base".to_string() }
}

/// A task whose frame yields to a wrench and moves against the base, if nothing above or beside it decides on the base.
fn pushed<'p>(c: &Checked<'p>, stack: usize) -> Option<Pushed<'p>> {
    let program = c.program;
    let model = &program.robot.model;
    let locked = &program.stacks[stack].locked;
    let is_free = |base: &&MobileBase| base.dofs().any(|dof| !locked.contains(&dof));
    model.bases.iter().find(is_free)?;
    let (sample, members) = (c.stacks.sample(stack, Signals::Present, 0)?, c.stacks.members(stack));
    let columns = |m: &Member| -> BTreeSet<usize> {
        (0..model.nv()).filter(|&dof| sample.rows(m).any(|row| row[dof].abs() > 1e-9)).collect()
    };
    let (yields, base) = members.iter().find_map(|m| {
        let params = &program.tasks[m.program_index].params;
        let own = columns(m);
        let with_joints = own.iter().any(|dof| model.base_of_dof(*dof).is_none());
        let is_pushed = matches!(params.get("wrench"), Some(Bound::Group(_))) && with_joints;
        let base = own.iter().filter(|dof| !locked.contains(dof)).find_map(|dof| model.base_of_dof(*dof));
        Some((m, base.filter(|_| is_pushed)?))
    })?;
    let in_base = |dof: &usize| base.dofs().contains(dof) && !locked.contains(dof);
    let decided = members.iter().any(|m| {
        let other =
            m.program_index != yields.program_index && m.row_kind == RowKind::Equality && m.level <= yields.level;
        other && columns(m).iter().any(in_base)
    });
    (!decided).then_some(Pushed { task: yields.program_index, base })
}
