//! Limits of positions against limits of accelerations: whether a joint can brake as fast as its barrier asks for.
//!
//! Along a barrier `v = φ h` a joint is `T v` closer after a tick, and brakes with `φ v`. From one end of its range R it
//! gets, with the acceleration a, to the barrier of the other end at the speed v with
//!
//! ```text
//! v²/(2a) + v/φ = R        v = a (sqrt(1/φ² + 2R/a) - 1/φ)
//! ```
//!
//! or at its speed limit, if that is lower. Both hold together for the joint alone where `a >= φ v`. Source: ours.

use std::collections::BTreeSet;

use dsl::Diagnostic;
use runtime::program::Program;
use runtime::{Built, build_tasks};
use stdlib_tasks::bound::Bound;
use stdlib_tasks::dimension::{ACCELERATION, ANGULAR_ACCELERATION, ANGULAR_VELOCITY, VELOCITY};

use crate::lowering::Places;
use crate::units::shown;

/// A barrier of a joint: its task, the joint, its gain in 1/s and the width of its range.
struct Barrier {
    task: usize,
    dof: usize,
    gain: f64,
    range: f64,
}

/// What a task says of a joint, where it says it and it never changes.
fn said(program: &Program, task: usize, param: &str, dof: usize) -> Option<f64> {
    let Some(Bound::PerJoint(list)) = program.tasks[task].params.get(param) else { return None };
    let at = list.iter().find(|(d, _)| *d == dof)?.1.at;
    let moves = program.values.tape.outputs.iter().any(|o| o.at == at);
    program.values.initial.get(at).copied().filter(|_| !moves)
}

/// The barriers of a task that keeps joints inside their positions.
fn barriers(program: &Program, task: usize, built: &Built) -> Vec<Barrier> {
    let Ok(made) = &built.task else { return Vec::new() };
    let gains = made.gains(&program.values.initial);
    let (Some(dofs), Some(&gain)) = (made.degrees_of_freedom(), gains.first()) else { return Vec::new() };
    let one = |dof: usize| {
        let d = &program.robot.model.dofs[dof];
        let lower = said(program, task, "lower", dof).unwrap_or(d.lower);
        let upper = said(program, task, "upper", dof).unwrap_or(d.upper);
        Barrier { task, dof, gain, range: upper - lower }
    };
    dofs.into_iter().map(one).collect()
}

/// The speed that a joint can have along its barrier, with its speed limit and its acceleration.
fn along(barrier: &Barrier, speed: f64, acceleration: f64) -> f64 {
    let inverse = 1.0 / barrier.gain;
    let reached = acceleration * ((inverse * inverse + 2.0 * barrier.range / acceleration).sqrt() - inverse);
    speed.min(if reached.is_nan() { f64::INFINITY } else { reached })
}

/// Warns of joints that hard levels let run faster towards their limits than they let them brake.
pub(crate) fn check(program: &Program, places: &Places, diagnostics: &mut Vec<Diagnostic>) {
    let mut told = BTreeSet::new();
    for stack in &program.stacks {
        let hard = || stack.levels.iter().filter(|l| l.hard).flat_map(|l| &l.members);
        let of = |m: &runtime::program::MemberProgram, kind: &str| program.tasks[m.task].kind == kind;
        if !hard().any(|m| of(m, "joint_acceleration_limits")) || !hard().any(|m| of(m, "joint_position_limits")) {
            continue;
        }
        let all =
            build_tasks(&program.robot.model, program.robot.period, &program.values.initial, &program.tasks, stack);
        let members: Vec<_> = stack.levels.iter().flat_map(|l| l.members.iter().map(move |m| (l.hard, m))).collect();
        let hard: Vec<_> = members.iter().zip(&all).filter(|(m, _)| m.0).map(|(m, built)| (m.1, built)).collect();
        // The last one is told of all hard limits of speeds.
        let Some(speeds) = hard.last().map(|h| &h.1.speed) else { continue };
        let positions = hard.iter().filter(|(m, _)| of(m, "joint_position_limits"));
        let all: Vec<Barrier> = positions.flat_map(|(m, built)| barriers(program, m.task, built)).collect();
        for (m, built) in hard.iter().filter(|(m, _)| of(m, "joint_acceleration_limits")) {
            let limits = built.task.as_ref().map(|task| task.acceleration_limits()).unwrap_or_default();
            let mut weak = all.iter().filter(|b| !stack.locked.contains(&b.dof)).filter_map(|b| {
                let a = limits.iter().find(|(dof, _)| *dof == b.dof)?.1;
                let v = along(b, speeds[b.dof], a);
                (a < b.gain * v * (1.0 - 1e-9)).then_some((b, a, v))
            });
            let Some((b, a, v)) = weak.next() else { continue };
            if !told.insert((m.task, b.task)) {
                continue;
            }
            let more = weak.count();
            let d = &program.robot.model.dofs[b.dof];
            let (speed, acceleration) = match d.unit {
                robot::DofUnit::Metre => (VELOCITY, ACCELERATION),
                robot::DofUnit::Radian => (ANGULAR_VELOCITY, ANGULAR_ACCELERATION),
            };
            let at = places.tasks[m.task].spans.get("max").copied().unwrap_or(places.tasks[m.task].span);
            let others = if more > 0 { format!(", and so do {more} more joints") } else { String::new() };
            let needed = shown(b.gain * v, acceleration);
            diagnostics.push(
                Diagnostic::warning("HQ0507", at, format!("`{}` cannot brake before its position limit", d.name))
                    .here(format!("{} at most", shown(a, acceleration)))
                    .label(places.tasks[b.task].span, format!("this lets it brake with {needed} at {}", shown(v, speed)))
                    .note(format!(
                        "a joint that runs along `v = φ h` brakes with `φ v`{others}; with less a hard level ends in a fault"
                    ))
                    .help(format!(
                        "write `max` from {needed}, a gain up to {} /s, or put this task on a soft level",
                        runtime::text::number(a / v)
                    )),
            );
        }
    }
}
