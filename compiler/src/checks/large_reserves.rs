//! Reserves against sampling in time that are computed for full speed, and are larger than the distance that they guard.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet};
use runtime::program::{Program, TaskProgram};
use stdlib_tasks::bound::Bound;
use stdlib_tasks::dimension::LENGTH;

use super::first_tick::millimetres;
use super::{Checked, place};

/// Reserve (m) up to which nothing is said: an arm of 0.8 m at 2 rad/s and 100 Hz has 9 cm, which is usual for `auto`.
const SMALL: f64 = 0.1;

/// Warns of each limit whose `sampled_margin auto` is larger than its `d_min` and than [`SMALL`]. A limit that starts
/// inside of its reserve is reported already.
pub(super) fn check(c: &Checked, diagnostics: &mut Vec<Diagnostic>) {
    let (program, places) = (c.program, c.places);
    let mut told: BTreeSet<usize> = BTreeSet::new();
    for index in program.run_stacks() {
        let Some(stack) = program.stacks.get(index) else { continue };
        let members = stack.levels.iter().flat_map(|l| &l.members).map(|m| m.task);
        for (task, built) in members.zip(c.stacks.tasks(index)) {
            let (Ok(built), Some(Bound::Choice(_))) = (&built.task, program.tasks[task].params.get("sampled_margin"))
            else {
                continue;
            };
            let d_min = distance(program, &program.tasks[task]);
            let kept = built.sampled_margin().into_iter().zip(built.rows());
            let kept = kept.filter(|(_, row)| row.dimension == LENGTH);
            let large = kept.filter(|(kept, _)| *kept > d_min.unwrap_or(0.0).max(SMALL));
            let Some((reserve, row)) = large.reduce(|a, b| if b.0 > a.0 { b } else { a }) else { continue };
            let at = place(places, task, "sampled_margin");
            let known = diagnostics.iter().any(|d| d.code == "HQ0505" && d.primary.span == at);
            if known || !told.insert(task) {
                continue;
            }
            let name = &program.tasks[task].name;
            let reserve = millimetres(reserve);
            let text = match d_min {
                Some(d_min) => {
                    format!("`auto` keeps `{name}` {reserve} farther away than its `d_min` of {}", millimetres(d_min))
                }
                None => format!("`auto` keeps the value of `{name}` {reserve} inside of its limit"),
            };
            let help = match d_min {
                Some(_) => Help::with(
                    "leave {} out: the limit then looks ahead at each tick and keeps nothing in reserve; or lower the speed limits, or \
                     raise the rate",
                    [Snippet::same("sampled_margin")],
                ),
                None => "write a smaller reserve, lower the speed limits, or raise the rate".into(),
            };
            diagnostics.push(
                Diagnostic::warning("HQ0527", at, text)
                    .here(format!("the reserve of {}", row.name))
                    .note("the reserve is constant, and that of all joints at their speed limits with the arm stretched out")
                    .help(help),
            );
        }
    }
}

/// The minimum distance of a task (m) before the first tick, zero if it is unknown; `None` if its type has none.
fn distance(program: &Program, task: &TaskProgram) -> Option<f64> {
    let Some(Bound::Value(slot)) = task.params.get("d_min") else { return None };
    Some(program.values.initial.get(slot.at).copied().filter(|d| d.is_finite()).unwrap_or(0.0))
}
