//! Warns of trajectories whose speed is an order of magnitude above what the joints can do: the trajectory is at its goal
//! before the robot has begun to move.

use dsl::{Diagnostic, Span};
use runtime::program::{Op, Shape};
use stdlib_tasks::bound::{Bound, Slot};
use stdlib_tasks::dimension::{LENGTH, VELOCITY};

use crate::analysis::stacks::Signals;
use crate::checks::{Checked, place};
use crate::units::shown;

/// Factor above the largest speed that is reported.
const BEYOND: f64 = 10.0;

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let graph = c.context.graph;
    let mut told: Vec<Span> = Vec::new();
    for stack in 0..c.program.stacks.len() {
        let mut fastest: Option<Vec<f64>> = None;
        for member in c.program.stacks[stack].levels.iter().flat_map(|l| &l.members) {
            let task = member.task;
            for (param, bound) in &c.program.tasks[task].params {
                let Bound::Value(Slot { at, len: 3 }) = bound else { continue };
                let nodes = c.context.table.placed.get(*at..*at + 3).unwrap_or_default();
                let length = c.places.tasks[task].numbers.iter().any(|n| n.slot.at == *at && n.dimension == LENGTH);
                let Some(Op::Trajectory(first)) = nodes.first().filter(|_| length).map(|&n| graph.ops()[n]) else {
                    continue;
                };
                let path = graph.trajectory_of(first).filter(|t| t.shape == Shape::Vector);
                let Some(speed) = path.and_then(|t| graph.constant(*t.limits.first()?)) else { continue };
                let fastest = fastest.get_or_insert_with(|| fastest_of(c, stack));
                let Some(possible) = fastest.get(task).copied().filter(|v| *v > 0.0 && v.is_finite()) else { continue };
                let at = place(c.places, task, param);
                if speed <= BEYOND * possible || told.contains(&at) {
                    continue;
                }
                told.push(at);
                let name = &c.program.tasks[task].name;
                out.push(
                    Diagnostic::warning("HQ0550", at, format!("the joints cannot move `{name}` at the speed of its path"))
                        .here(shown(speed, VELOCITY))
                        .note(format!(
                            "with all joints at their speed limits it reaches about {}: the path would be at its goal long before the robot",
                            shown(format!("{possible:.1}").parse().unwrap_or(possible), VELOCITY)
                        ))
                        .help("write the speed at which the robot is to move, in m/s; 250 mm/s is 0.25 m/s"),
                );
            }
        }
    }
}

/// Largest speed of a row of each task, with all joints at their speed limits, at some postures.
fn fastest_of(c: &Checked, stack: usize) -> Vec<f64> {
    let mut fastest = vec![0.0_f64; c.program.tasks.len()];
    let locked = &c.program.stacks[stack].locked;
    for sample in c.stacks.samples(stack, Signals::Present) {
        for m in c.stacks.members(stack) {
            for row in sample.rows(m) {
                let dofs = c.program.robot.model.dofs.iter().enumerate().filter(|(i, _)| !locked.contains(i));
                let own = dofs.filter(|(i, _)| row[*i] != 0.0);
                let speed: f64 = own.map(|(i, d)| row[i].abs() * d.velocity).sum();
                fastest[m.program_index] = fastest[m.program_index].max(speed);
            }
        }
    }
    fastest
}
