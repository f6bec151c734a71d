//! Warns of limits of joints that name a part of the joints, while a target of the stack moves others as well.

use std::collections::{BTreeMap, BTreeSet};

use dsl::Diagnostic;
use names::list;
use runtime::program::{Program, Times};
use runtime::{Evaluator, RestInputs, build_tasks};
use stdlib_tasks::task::RowKind;

use super::{Checked, configurations};

/// Number of random configurations, beside home, at which the joints of a target are determined.
const CONFIGURATIONS: usize = 3;

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
        for ((hard, member), built) in members.zip(build_tasks(c.program, compiled)) {
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
            let open: Vec<&str> = moved(c.program, stack)
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
fn moved(program: &Program, stack: usize) -> BTreeSet<usize> {
    let mut moved = BTreeSet::new();
    let Ok((mut evaluator, mut problem)) = Evaluator::new(program, stack) else { return moved };
    let rest = RestInputs::present(program);
    for q in &configurations(program, CONFIGURATIONS) {
        evaluator.enter(q, rest.at(Times::default()));
        if evaluator.update(q, rest.at(Times::default()), &mut problem).is_err() {
            continue;
        }
        for m in evaluator.members().iter().filter(|m| m.row_kind == RowKind::Equality) {
            let level = &problem.levels[m.level];
            let unlocked = (0..program.robot.model.nv()).filter(|dof| !evaluator.locked().contains(dof));
            moved.extend(unlocked.filter(|&dof| m.rows.clone().any(|r| level.row(r)[dof].abs() > 1e-9)));
        }
    }
    moved
}
