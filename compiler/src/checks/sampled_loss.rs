//! Distances on hard levels whose loss between two ticks may exceed the distance itself, without a reserve against it.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::{Program, TaskProgram};
use stdlib_tasks::bound::Bound;

use super::first_tick::millimetres;
use super::{Checked, place};

/// Warns of each limit on a hard level that has no written `sampled_margin` and whose loss exceeds its `d_min`.
pub(super) fn check(c: &Checked, diagnostics: &mut Vec<Diagnostic>) {
    let (program, places) = (c.program, c.places);
    let mut told: BTreeSet<usize> = BTreeSet::new();
    for index in program.run_stacks() {
        let Some(stack) = program.stacks.get(index) else { continue };
        let members = stack.levels.iter().flat_map(|l| l.members.iter().map(move |m| (l.hard, m.task)));
        for ((hard, task), built) in members.zip(c.stacks.tasks(index)) {
            let Ok(built) = &built.task else { continue };
            let written = places.tasks[task].spans.contains_key("sampled_margin");
            let Some(d_min) = smallest_distance(program, &program.tasks[task]).filter(|_| hard && !written) else {
                continue;
            };
            let rows = built.rows();
            let losses = built.sampled_loss().into_iter().zip(built.sampled_margin());
            // Without a bound on the speeds there is no figure to compare.
            let open =
                losses.map(|(loss, kept)| loss - kept).zip(&rows).filter(|(open, _)| open.is_finite() && *open > d_min);
            let Some((loss, row)) = open.reduce(|a, b| if b.0 > a.0 { b } else { a }) else { continue };
            if !told.insert(task) {
                continue;
            }
            let name = &program.tasks[task].name;
            let text = format!(
                "between two ticks, `{name}` may be passed by {}, more than its `d_min` of {}",
                millimetres(loss),
                millimetres(d_min)
            );
            diagnostics.push(
                Diagnostic::warning("HQ0527", place(places, task, "d_min"), text)
                    .here(format!("{}, without a reserve", row.name))
                    .note(
                        "the bound is that of all joints at their speed limits; a limit of a hard level that is passed is a fault at \
                         run time",
                    )
                    .help(Help::with(
                        "write {}, and lower the speed limits or raise the rate if that reserve is too large; {} accepts the loss",
                        [Snippet::entry("sampled_margin", "auto"), Snippet::entry("sampled_margin", "0 m")],
                    )),
            );
        }
    }
}

/// The minimum distance of a task (m), if it has one. Without a distance, every loss would exceed it.
fn smallest_distance(program: &Program, task: &TaskProgram) -> Option<f64> {
    match task.params.get("d_min")? {
        Bound::Value(slot) => program.values.initial.get(slot.at).copied().filter(|d| d.is_finite() && *d > 0.0),
        _ => None,
    }
}
