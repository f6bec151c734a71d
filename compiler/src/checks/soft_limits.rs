//! Distances on soft levels below or beside a target that moves the same joints: the target may violate them.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet};
use runtime::Member;
use runtime::program::{Program, Subject};
use stdlib_tasks::dimension::LENGTH;
use stdlib_tasks::task::RowKind;

use super::{Checked, watches};
use crate::analysis::stacks::Signals;

/// Warns of each distance that a target with the same or a higher priority may violate, once for all stacks that run.
pub(super) fn check(c: &Checked, diagnostics: &mut Vec<Diagnostic>) {
    let (program, places) = (c.program, c.places);
    let mut told: BTreeSet<usize> = BTreeSet::new();
    let runs = |stack: &usize| program.run.subject != Subject::Machine || program.run_stacks().contains(stack);
    for stack in (0..program.stacks.len()).filter(runs) {
        let levels = &program.stacks[stack].levels;
        let members = c.stacks.members(stack);
        let limits: Vec<usize> = (0..members.len())
            .filter(|&i| !levels[members[i].level].hard && is_distance(program, &members[i]))
            .collect();
        if limits.is_empty() {
            continue;
        }
        let moved = moved(c, stack);
        for limit in limits {
            let m = &members[limit];
            let rival = members.iter().enumerate().find(|(i, o)| {
                o.row_kind == RowKind::Equality && o.level <= m.level && !moved[*i].is_disjoint(&moved[limit])
            });
            let Some((_, rival)) = rival.filter(|_| told.insert(m.program_index)) else { continue };
            let (own, above) = (&levels[m.level].name, &levels[rival.level].name);
            let beside = rival.level == m.level;
            let text = match beside {
                true => format!("`{}` may violate `{}`: both are on the soft level `{own}`", rival.name, m.name),
                false => format!(
                    "`{}` may violate `{}`: level `{above}` is above `{own}`, which is soft",
                    rival.name, m.name
                ),
            };
            let spans = &places.stacks[stack].1;
            let d = Diagnostic::warning("HQ0526", spans[m.level], text);
            let d = match beside {
                true => d,
                false => d.label(spans[rival.level], format!("`{}` has priority", rival.name)),
            };
            let note = match beside {
                true => {
                    "tasks of one soft level share the error: the robot passes the limit as far as the target asks for it"
                }
                false => {
                    "a lower level uses only the freedom that the levels above leave: the robot passes the limit where the target asks for it"
                }
            };
            diagnostics.push(d.note(note).help(Help::with(
                "put the limit on a hard level above: {}",
                [Snippet::level("safety", true, &m.name).listed("levels")],
            )));
        }
    }
}

/// True for a limit whose margins are lengths, and that bounds something.
fn is_distance(program: &Program, m: &Member) -> bool {
    let lengths = m.row_info.iter().all(|r| r.dimension == LENGTH) && !m.row_info.is_empty();
    m.row_kind == RowKind::Inequality && lengths && !watches::only_watches(program, m.program_index)
}

/// Degrees of freedom in the rows of each task. A task whose rows cannot be computed has none.
fn moved(c: &Checked, stack: usize) -> Vec<BTreeSet<usize>> {
    let members = c.stacks.members(stack);
    let mut moved = vec![BTreeSet::new(); members.len()];
    for sample in c.stacks.samples(stack, Signals::Present) {
        for (m, dofs) in members.iter().zip(&mut moved) {
            for row in sample.rows(m) {
                dofs.extend((0..row.len()).filter(|&dof| row[dof] != 0.0));
            }
        }
    }
    moved
}
