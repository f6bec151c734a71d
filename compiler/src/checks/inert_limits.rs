//! Limits that limit nothing: their value cannot pass them, no joint changes them, or no row of them ever acts.

use std::collections::{BTreeMap, BTreeSet};

use dsl::Diagnostic;
use runtime::build_tasks;
use runtime::program::StackProgram;
use stdlib_tasks::dimension::LENGTH;
use stdlib_tasks::task::RowKind;

use super::{Checked, ineffective, limit, questioned, reachability, wall_reach};
use crate::analysis::idle_rows;
use crate::analysis::value_ranges::Ranges;
use crate::expr::Typed;
use crate::units::shown;

/// Warns of limits without effect in every stack that contains them, once per limit.
pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let mut told = always_kept(c, out);
    told.extend(unmoved(c, &told, out));
    never_active(c, &told, out);
}

/// Warns of limits of values that hold at all joint positions.
fn always_kept(c: &Checked, out: &mut Vec<Diagnostic>) -> BTreeSet<usize> {
    let mut told = BTreeSet::new();
    for index in reachability::in_stacks(c.program) {
        let Some(task) = c.places.tasks.get(index).filter(|t| t.kind.row_kind == RowKind::Inequality) else { continue };
        let Some(value) = task.operands.get("value") else { continue };
        let sides: Vec<(&&str, &Typed)> = task.operands.iter().filter(|(p, _)| ["min", "max"].contains(p)).collect();
        let roots: Vec<usize> = sides.iter().flat_map(|(_, s)| &s.nodes).chain(&value.nodes).copied().collect();
        let ranges = Ranges::new(c.context, &roots, &BTreeMap::new());
        let kept = |least: bool, side: &Typed| {
            value.nodes.iter().zip(&side.nodes).all(|(&v, &s)| {
                let (v, s) = (ranges.at(v), ranges.at(s));
                if least { v.low >= s.high } else { v.high <= s.low }
            })
        };
        // One side beyond the range is common where the other one matters.
        if sides.is_empty() || !sides.iter().all(|(p, s)| kept(**p == "min", s)) {
            continue;
        }
        let at = limit(c.places, index);
        if questioned(out, at) {
            continue;
        }
        let range = ranges.at(value.nodes[0]);
        let is = match (value.nodes.len(), range.low.is_finite(), range.high.is_finite()) {
            (1, true, true) => format!("it is {}", reachability::between(range, value.dimension)),
            (1, true, false) => format!("it is never below {}", shown(range.low, value.dimension)),
            (1, false, true) => format!("it is never above {}", shown(range.high, value.dimension)),
            _ => "it is always inside".to_string(),
        };
        told.insert(index);
        out.push(
            Diagnostic::warning(
                "HQ0610",
                at,
                format!("`{}` always holds, so it limits nothing", c.program.tasks[index].name),
            )
            .label(value.span, is)
            .note("this holds at all joint positions within the limits of the robot")
            .help("check the sign, the unit and the decimals of the limit, or remove the task"),
        );
    }
    told
}

/// Stacks that contain a limit, by the limit's task.
fn stacks_of_limits<'p>(c: &'p Checked) -> BTreeMap<usize, Vec<(usize, &'p StackProgram)>> {
    let mut found: BTreeMap<usize, Vec<(usize, &StackProgram)>> = BTreeMap::new();
    for (k, stack) in c.program.stacks.iter().enumerate() {
        for m in stack.levels.iter().flat_map(|l| &l.members) {
            let limits = c.places.tasks.get(m.task).is_some_and(|t| {
                // A task with outputs may be there to be read.
                t.kind.row_kind == RowKind::Inequality && t.kind.outputs.is_empty()
            });
            if limits {
                found.entry(m.task).or_default().push((k, stack));
            }
        }
    }
    found
}

/// Warns of limits that no joint changes.
fn unmoved(c: &Checked, told: &BTreeSet<usize>, out: &mut Vec<Diagnostic>) -> BTreeSet<usize> {
    let still: Vec<BTreeSet<usize>> = (0..c.program.stacks.len())
        .map(|stack| ineffective::unmoved(c, stack).iter().map(|m| m.program_index).collect())
        .collect();
    let mut found = BTreeSet::new();
    for (task, stacks) in stacks_of_limits(c) {
        if told.contains(&task) || !stacks.iter().all(|(k, _)| still[*k].contains(&task)) {
            continue;
        }
        found.insert(task);
        let place = &c.places.tasks[task];
        let named = ["on", "between", "and", "points", "joints"].iter().find_map(|p| place.spans.get(*p));
        let at = named.copied().unwrap_or(place.span);
        let text = format!("no joint changes the margin of `{}`", c.program.tasks[task].name);
        let d = Diagnostic::warning("HQ0611", at, text);
        let locking = stacks.iter().find(|(_, s)| !s.locked.is_empty());
        out.push(match locking {
            Some((k, _)) => d
                .label(c.places.stacks[*k].0, "this stack locks joints")
                .help("name a part that moves in this stack, or remove the limit"),
            None => d
                .note("its parts move together, so their distance stays the same")
                .help("name parts that move against each other, or remove the limit"),
        });
    }
    found
}

/// Warns of limits of which no row can act in any stack.
fn never_active(c: &Checked, told: &BTreeSet<usize>, out: &mut Vec<Diagnostic>) {
    let mut open: BTreeSet<usize> = stacks_of_limits(c).into_keys().filter(|t| !told.contains(t)).collect();
    for stack in &c.program.stacks {
        let tasks = stack.levels.iter().flat_map(|l| &l.members).map(|m| m.task);
        for (built, task) in build_tasks(c.program, stack).into_iter().zip(tasks) {
            let idle = || idle_rows::all(c.program, &c.program.tasks[task], built);
            if open.contains(&task) && wall_reach::distant(c, task).is_none() && !idle() {
                open.remove(&task);
            }
        }
    }
    for task in open {
        let text = format!("the robot never comes near the limit `{}`", c.program.tasks[task].name);
        let at = c.places.tasks[task].spans.get("through").copied().unwrap_or_else(|| limit(c.places, task));
        out.push(
            Diagnostic::warning("HQ0612", at, text)
                .note(match wall_reach::distant(c, task) {
                    Some(margin) => {
                        let margin = shown((margin * 1e3).floor() * 1e-3, LENGTH);
                        format!("at all joint positions its parts are {margin} or more away from it")
                    }
                    None => "at all joint positions the margin is so large that no row of it slows the robot down"
                        .to_string(),
                })
                .help("check the place and the unit of the limit, or remove the task"),
        );
    }
}
