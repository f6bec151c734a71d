//! Warns of limits of joints that name a part of the joints, while a target of the stack moves others as well.

use std::collections::{BTreeMap, BTreeSet};

use dsl::Diagnostic;
use names::list;
use stdlib_tasks::task::RowKind;

use super::Checked;
use crate::analysis::stacks::Signals;

/// Limits of one task type in a stack.
#[derive(Default)]
struct Limits {
    /// Joints that they bound.
    bounded: BTreeSet<usize>,
    /// The tasks.
    tasks: Vec<usize>,
}

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let mut told: BTreeSet<usize> = BTreeSet::new();
    for stack in c.program.run_stacks() {
        let Some(compiled) = c.program.stacks.get(stack) else { continue };
        // A limit on a soft level is a preference, and need not concern all joints.
        let members = compiled.levels.iter().flat_map(|l| l.members.iter().map(move |m| (l.hard, m)));
        let mut limits: BTreeMap<&str, Limits> = BTreeMap::new();
        for ((hard, member), built) in members.zip(c.stacks.tasks(stack)) {
            let (task, Ok(made)) = (&c.program.tasks[member.task], &built.task) else { continue };
            let speeds = made.speed_limits(&c.program.values.initial);
            let named = stdlib_tasks::find(&task.kind).is_some_and(|k| k.params.iter().any(|p| p.name == "joints"));
            if hard && named && !speeds.is_empty() {
                let of = limits.entry(task.kind.as_str()).or_default();
                of.bounded.extend(speeds.iter().map(|s| s.0));
                of.tasks.push(member.task);
            }
        }
        for Limits { bounded, tasks } in limits.into_values() {
            let written = |task: &usize| c.places.tasks[*task].spans.get("joints").copied();
            let Some((task, at)) = tasks.iter().find_map(|t| Some((*t, written(t)?))) else { continue };
            let open: Vec<&str> = moved(c, stack)
                .difference(&bounded)
                .filter_map(|&dof| c.program.robot.model.dofs.get(dof))
                .filter(|d| d.q_index.is_some())
                .map(|d| d.name.as_str())
                .collect();
            if open.is_empty() || !told.insert(task) {
                continue;
            }
            out.push(
                Diagnostic::warning(
                    "HQ0557",
                    at,
                    format!("`{}` leaves out joints that the stack moves", c.program.tasks[task].name),
                )
                .here(format!("without a speed limit: {}", list(open.iter().copied(), 4)))
                .label(c.places.stacks[stack].0, "in this stack")
                .note("the reference of these joints may be faster than they are, and they lag behind it")
                .help("name all joints that the stack moves, leave the names out for all joints, or lock the others"),
            );
        }
    }
}

/// Degrees of freedom that the targets of a stack move.
fn moved(c: &Checked, stack: usize) -> BTreeSet<usize> {
    let locked = &c.program.stacks[stack].locked;
    let mut moved = BTreeSet::new();
    for sample in c.stacks.samples(stack, Signals::Present) {
        for m in c.stacks.members(stack).iter().filter(|m| m.row_kind == RowKind::Equality) {
            let unlocked = (0..c.program.robot.model.nv()).filter(|dof| !locked.contains(dof));
            moved.extend(unlocked.filter(|&dof| sample.rows(m).any(|row| row[dof].abs() > 1e-9)));
        }
    }
    moved
}
