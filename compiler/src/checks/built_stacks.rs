//! Builds the tasks of each stack, as the controller does: too many rows, parameters that contradict each other, gains that
//! overshoot within a period. The first tick is only simulated for a stack whose tasks could all be built.

use dsl::Diagnostic;
use runtime::program::{Program, overshoots};
use stdlib_tasks::dimension::RATE;
use stdlib_tasks::task::BuildError;

use super::{Checked, first_tick, has_errors, number, place, size_limits};
use crate::binding::gain;
use crate::source_map::SourceMap;

/// Checks all stacks; a mistake of a task that is in several stacks is reported once.
pub(super) fn check(c: &Checked, diagnostics: &mut Vec<Diagnostic>) {
    let (program, places) = (c.program, c.places);
    let values = &program.values.initial;
    let mut reported: Vec<(usize, String)> = Vec::new();
    for (i, stack) in program.stacks.iter().enumerate() {
        if let Some(refusal) = size_limits::pairs(program, stack, places) {
            diagnostics.push(refusal);
            continue;
        }
        let built = c.stacks.tasks(i);
        let members = stack.levels.iter().enumerate().flat_map(|(k, l)| l.members.iter().map(move |m| (k, m)));
        let rows = built.iter().flat_map(|b| &b.task).map(|t| t.rows().len()).sum();
        if let Some(refusal) = size_limits::rows(rows, i, places) {
            diagnostics.push(refusal);
            continue;
        }
        let mut complete = true;
        for (task, (level, m)) in built.iter().zip(members) {
            match &task.task {
                Ok(task) => {
                    for gain in task.gains(&program.values.initial) {
                        let once = (m.task, "gain".to_string());
                        if overshoots(gain, program.robot.period) && !reported.contains(&once) {
                            reported.push(once);
                            diagnostics.push(overshoot(gain, values, program.robot.period, places, m.task));
                        }
                    }
                }
                Err(e) => {
                    complete = false;
                    let once = (m.task, e.param.clone());
                    if !reported.contains(&once) {
                        reported.push(once);
                        let d = cannot_build(e, places, m.task);
                        diagnostics.push(if e.param == "sampled_margin" {
                            loose_speeds(d, program, (i, level), places)
                        } else {
                            d
                        });
                    }
                }
            }
        }
        if complete && !has_errors(diagnostics) {
            first_tick::start(c, i, diagnostics);
        }
    }
}

fn overshoot(gain: f64, values: &[f64], period: f64, places: &SourceMap, task: usize) -> Diagnostic {
    let at = number(places, task, "gain", |n| n.dimension == RATE && values.get(n.slot.at) == Some(&gain));
    gain::overshoot(at, gain, (period, places.rate), places.tasks[task].kind.row_kind)
}

fn cannot_build(e: &BuildError, places: &SourceMap, task: usize) -> Diagnostic {
    let d = Diagnostic::error("HQ0503", place(places, task, &e.param), e.message.clone());
    match &e.help {
        Some(h) => d.help(h.clone()),
        None => d,
    }
}

/// Labels the speed limits of the stack that do not count for a wall on this level, because they are soft or lower.
fn loose_speeds(
    mut d: Diagnostic,
    program: &Program,
    (stack, level): (usize, usize),
    places: &SourceMap,
) -> Diagnostic {
    let levels = program.stacks[stack].levels.iter().zip(&places.stacks[stack].1);
    for (k, (l, span)) in levels.enumerate() {
        let limits = l.members.iter().any(|m| program.tasks[m.task].kind == "joint_velocity_limits");
        let why = if !limits || (l.hard && k <= level) {
            continue;
        } else if l.hard {
            "the speed limits of this level do not count: it is below"
        } else {
            "the speed limits of this level do not count: it is soft and may be violated"
        };
        d = d.label(*span, why);
    }
    d
}
