//! Compares the gains of position limits and walls with the limits of accelerations: a joint must brake as fast as the
//! barrier asks.
//!
//! Along a barrier `v = φ h` a joint is `T v` closer after a tick, and brakes with `φ v`. From one end of its range R,
//! with the acceleration a, it reaches the barrier of the other end at the speed v with
//!
//! ```text
//! v²/(2a) + v/φ = R        v = a (sqrt(1/φ² + 2R/a) - 1/φ)
//! ```
//!
//! or at its speed limit, if that is lower. A single joint can satisfy both if `a >= φ v`. For a wall that many joints
//! move, the condition is summed over the joints, each weighted with the steepest gradient of the margin in it: `sum_j
//! |J_j| (a_j - φ v_j) >= 0`. The curvature of the wall is neglected, so walls that are impossible only because of
//! their curvature are not reported. Source: ours.

use std::collections::BTreeSet;

use dsl::Diagnostic;
use runtime::Built;
use runtime::program::{MemberProgram, Program, StackProgram};
use stdlib_tasks::bound::Bound;
use stdlib_tasks::dimension::{ACCELERATION, ANGULAR_ACCELERATION, ANGULAR_VELOCITY, Dimension, VELOCITY};

use super::Checked;
use crate::source_map::SourceMap;
use crate::units::shown;

/// Barrier of a joint: its task, the joint, the gain (1/s) and the width of the joint's range.
struct Barrier {
    task: usize,
    dof: usize,
    gain: f64,
    range: f64,
}

/// Number that a parameter of a task sets for a joint, if it is set and constant.
fn said(program: &Program, task: usize, param: &str, dof: usize) -> Option<f64> {
    let Some(Bound::PerJoint(list)) = program.tasks[task].params.get(param) else { return None };
    let at = list.iter().find(|(d, _)| *d == dof)?.1.at;
    let moves = program.values.tape.outputs.iter().any(|o| o.at == at);
    program.values.initial.get(at).copied().filter(|_| !moves)
}

/// Barriers of a task that limits joint positions.
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

/// Maximum speed of a joint along its barrier, from its speed limit and its acceleration.
fn along(barrier: &Barrier, speed: f64, acceleration: f64) -> f64 {
    let inverse = 1.0 / barrier.gain;
    let reached = acceleration * ((inverse * inverse + 2.0 * barrier.range / acceleration).sqrt() - inverse);
    speed.min(if reached.is_nan() { f64::INFINITY } else { reached })
}

/// Hard levels of a stack, as needed to judge braking.
struct Hard<'p> {
    program: &'p Program,
    locked: &'p [usize],
    members: Vec<(&'p MemberProgram, &'p Built)>,
    /// Speed limit of each degree of freedom.
    speeds: &'p [f64],
    /// Barriers of the joints' position limits.
    barriers: Vec<Barrier>,
}

impl<'p> Hard<'p> {
    /// Collects the hard members of a stack; `None` without a hard level.
    fn new(program: &'p Program, stack: &'p StackProgram, built: &'p [Built]) -> Option<Self> {
        let all = stack.levels.iter().flat_map(|l| l.members.iter().map(move |m| (l.hard, m)));
        let members: Vec<_> = all.zip(built).filter(|((hard, _), _)| *hard).map(|((_, m), b)| (m, b)).collect();
        // Speed limits accumulate from member to member, so the last member has all of them.
        let speeds = &members.last()?.1.speed;
        let positions = members.iter().filter(|(m, _)| is(program, m, "joint_position_limits"));
        let barriers = positions.flat_map(|(m, built)| barriers(program, m.task, built)).collect();
        Some(Hard { program, locked: &stack.locked, members, speeds, barriers })
    }

    /// Maximum speed of a joint.
    fn fastest(&self, dof: usize, acceleration: f64) -> f64 {
        let own = self.barriers.iter().filter(|b| b.dof == dof);
        own.map(|b| along(b, f64::INFINITY, acceleration)).fold(self.speeds[dof], f64::min)
    }

    /// Members that limit accelerations, with their limits.
    fn brakes(&self) -> impl Iterator<Item = (&'p MemberProgram, Vec<(usize, f64)>)> + use<'p, '_> {
        let limiting = self.members.iter().filter(|(m, _)| is(self.program, m, "joint_acceleration_limits"));
        limiting.filter_map(|(m, built)| Some((*m, built.task.as_ref().ok()?.acceleration_limits())))
    }
}

fn is(program: &Program, member: &MemberProgram, kind: &str) -> bool {
    program.tasks[member.task].kind == kind
}

/// A joint that brakes too slowly.
struct Weak {
    dof: usize,
    /// Acceleration limit, maximum speed, and gain of the barrier.
    acceleration: f64,
    speed: f64,
    gain: f64,
    /// True if no hard level bounds the speed, which then grows over the whole range of the joint.
    no_speed_limit: bool,
}

impl Weak {
    fn needed(&self) -> f64 {
        self.gain * self.speed
    }

    /// Dimensions of the joint's speed and acceleration.
    fn quantities(&self, program: &Program) -> (Dimension, Dimension) {
        let unit = program.robot.model.dofs[self.dof].unit;
        unit.select((VELOCITY, ACCELERATION), (ANGULAR_VELOCITY, ANGULAR_ACCELERATION))
    }
}

/// Warns of joints that may move faster towards their limits or a wall, by the hard levels, than they can brake.
pub(super) fn check(c: &Checked, diagnostics: &mut Vec<Diagnostic>) {
    let (program, places) = (c.program, c.places);
    let mut told = BTreeSet::new();
    for (index, stack) in program.stacks.iter().enumerate() {
        let Some(hard) = Hard::new(program, stack, c.stacks.tasks(index)) else { continue };
        for (m, limits) in hard.brakes() {
            if let Some((barrier, weak, others)) = before_position_limits(&hard, &limits)
                && told.insert((m.task, barrier))
            {
                diagnostics.push(of_positions(program, places, (m.task, barrier), &weak, others));
            }
            for (task, gain, weak) in before_walls(&hard, &limits) {
                if told.insert((m.task, task)) {
                    diagnostics.push(of_wall(program, places, (m.task, task), &weak, gain));
                }
            }
        }
    }
}

/// First joint that cannot brake before its position limit, with the limit's task and the number of further joints.
fn before_position_limits(hard: &Hard, limits: &[(usize, f64)]) -> Option<(usize, Weak, usize)> {
    let mut weak = hard.barriers.iter().filter(|b| !hard.locked.contains(&b.dof)).filter_map(|b| {
        let acceleration = limits.iter().find(|(dof, _)| *dof == b.dof)?.1;
        let speed = along(b, hard.speeds[b.dof], acceleration);
        (acceleration < b.gain * speed * (1.0 - 1e-9)).then_some((
            b.task,
            Weak { dof: b.dof, acceleration, speed, gain: b.gain, no_speed_limit: hard.speeds[b.dof].is_infinite() },
        ))
    });
    let (task, first) = weak.next()?;
    Some((task, first, weak.count()))
}

/// Walls before which the joints cannot brake, each with the largest feasible gain and the joint that lacks most.
fn before_walls(hard: &Hard, limits: &[(usize, f64)]) -> Vec<(usize, f64, Weak)> {
    let mut found: Vec<(usize, f64, Weak)> = Vec::new();
    for (m, built) in &hard.members {
        let Ok(task) = &built.task else { continue };
        let gains = task.gains(&hard.program.values.initial);
        let slopes = task.gradient_bounds(&hard.program.robot.model);
        for (row, steep) in slopes.iter().enumerate() {
            let Some(&gain) = gains.get(row).or(gains.first()) else { continue };
            // Deceleration of the margin that the joints can provide, and that the barrier needs, both along the
            // steepest descent.
            let (mut can, mut speed_down) = (0.0, 0.0);
            let mut worst: Option<Weak> = None;
            for (dof, &slope) in steep.iter().enumerate().filter(|(dof, s)| **s > 0.0 && !hard.locked.contains(dof)) {
                let acceleration = limits.iter().find(|(d, _)| *d == dof).map_or(f64::INFINITY, |l| l.1);
                let speed = hard.fastest(dof, acceleration);
                can += slope * acceleration;
                speed_down += slope * speed;
                let lacks = |w: &Weak| w.needed() / w.acceleration;
                let no_speed_limit = hard.speeds[dof].is_infinite();
                let weak = Weak { dof, acceleration, speed, gain, no_speed_limit };
                if worst.as_ref().is_none_or(|w| lacks(w) < lacks(&weak)) {
                    worst = Some(weak);
                }
            }
            // Another check reports missing speed limits; a joint without a limit of acceleration stops at once.
            let Some(worst) = worst.filter(|_| can.is_finite() && speed_down.is_finite()) else { continue };
            if can < gain * speed_down * (1.0 - 1e-9) {
                match found.iter_mut().find(|f| f.0 == m.task) {
                    Some(of_task) => of_task.1 = of_task.1.min(can / speed_down),
                    None => found.push((m.task, can / speed_down, worst)),
                }
            }
        }
    }
    found
}

/// Span of a limit of accelerations.
fn place(places: &SourceMap, task: usize) -> dsl::Span {
    places.tasks[task].spans.get("max").copied().unwrap_or(places.tasks[task].span)
}

fn of_positions(
    program: &Program,
    places: &SourceMap,
    (brakes, barrier): (usize, usize),
    weak: &Weak,
    others: usize,
) -> Diagnostic {
    let (speed, acceleration) = weak.quantities(program);
    let name = &program.robot.model.dofs[weak.dof].name;
    let needed = shown(weak.needed(), acceleration);
    let others = if others > 0 { format!(", and so do {others} more joints") } else { String::new() };
    Diagnostic::warning("HQ0507", place(places, brakes), format!("`{name}` cannot brake before its position limit"))
        .here(format!("{} at most", shown(weak.acceleration, acceleration)))
        .label(places.tasks[barrier].span, format!("this lets it brake with {needed} at {}", shown(weak.speed, speed)))
        .note(format!(
            "on `v = φ h` a joint brakes with `φ v`{others}; with a smaller limit a hard level can become infeasible, which is a fault"
        ))
        .help(if weak.no_speed_limit {
            format!(
                "add `joint_velocity_limits` to a hard level: without them `{name}` gets as fast as {}",
                shown(weak.speed, speed)
            )
        } else {
            format!(
                "write `max` from {needed}, a gain up to {} /s, or put this task on a soft level",
                runtime::text::number(weak.acceleration / weak.speed)
            )
        })
}

fn of_wall(
    program: &Program,
    places: &SourceMap,
    (brakes, wall): (usize, usize),
    weak: &Weak,
    gain: f64,
) -> Diagnostic {
    let (speed, acceleration) = weak.quantities(program);
    let name = &program.robot.model.dofs[weak.dof].name;
    let title = format!("the joints cannot brake before `{}`", program.tasks[wall].name);
    let needed = shown(weak.needed(), acceleration);
    Diagnostic::warning("HQ0507", place(places, brakes), title)
        .here(format!("`{name}`: {} at most", shown(weak.acceleration, acceleration)))
        .label(
            places.tasks[wall].span,
            format!("its gain lets `{name}` brake with {needed} at {}", shown(weak.speed, speed)),
        )
        .note(
            "joints that run towards a wall along `h' = -φ h` brake with `φ v`; where together they cannot, a hard level can end \
             in the fault `infeasible`",
        )
        .help(format!(
            "write a gain up to {} /s, lower speed limits, a larger `max`, or put this task on a soft level",
            runtime::text::number(gain)
        ))
}
