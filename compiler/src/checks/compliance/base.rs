//! Warns of pushes at a frame that move the base: the base is not locked, and the rows of the frame have its columns.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet};
use runtime::Member;
use stdlib_tasks::bound::Bound;
use stdlib_tasks::task::RowKind;

use crate::analysis::stacks::Signals;
use crate::checks::Checked;

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let base = c.program.robot.model.base.nv();
    if base == 0 {
        return;
    }
    let mut told: BTreeSet<usize> = BTreeSet::new();
    for stack in c.program.run_stacks() {
        let Some(task) = pushed(c, stack, base).filter(|_| told.insert(stack)) else { continue };
        out.push(
            Diagnostic::warning(
                "HQ0548",
                c.places.stacks[stack].0,
                format!("a push at `{}` rolls the base", c.program.tasks[task].name),
            )
            .label(c.places.tasks[task].span, "this yields with every joint that is free, and the base is")
            .note("the base of a robot beside a person moves over the person's feet, and nobody pushes it there on purpose")
            .help(Help::with(
                "keep the base still in this stack, {}; or guide the base by a task of its own",
                [Snippet::entry("lock", "[base]")],
            )),
        );
    }
}

/// A task whose frame yields to a wrench and moves against the base, if nothing above or beside it decides on the base.
fn pushed(c: &Checked, stack: usize, base: usize) -> Option<usize> {
    let program = c.program;
    let model = &program.robot.model;
    let locked = &program.stacks[stack].locked;
    if (0..base).all(|dof| locked.contains(&dof)) {
        return None;
    }
    let (sample, members) = (c.stacks.sample(stack, Signals::Present, 0)?, c.stacks.members(stack));
    let in_base = |dof: &usize| *dof < base && !locked.contains(dof);
    let columns = |m: &Member| -> BTreeSet<usize> {
        (0..model.nv()).filter(|&dof| sample.rows(m).any(|row| row[dof].abs() > 1e-9)).collect()
    };
    let yields = members.iter().find(|m| {
        let params = &program.tasks[m.program_index].params;
        let own = columns(m);
        matches!(params.get("wrench"), Some(Bound::Group(_)))
            && own.iter().any(in_base)
            && own.iter().any(|d| *d >= base)
    })?;
    let decided = members.iter().any(|m| {
        let other =
            m.program_index != yields.program_index && m.row_kind == RowKind::Equality && m.level <= yields.level;
        other && columns(m).iter().any(in_base)
    });
    (!decided).then_some(yields.program_index)
}
