//! Limits of positions and walls against limits of accelerations: whether joints can brake as fast as barriers ask for.
//!
//! Along a barrier `v = φ h` a joint is `T v` closer after a tick, and brakes with `φ v`. From one end of its range R it
//! gets, with the acceleration a, to the barrier of the other end at the speed v with
//!
//! ```text
//! v²/(2a) + v/φ = R        v = a (sqrt(1/φ² + 2R/a) - 1/φ)
//! ```
//!
//! or at its speed limit, if that is lower. Both hold together for the joint alone where `a >= φ v`. A wall that many joints
//! move takes the sum over them, each by how steep the margin can be in it: `sum_j |J_j| (a_j - φ v_j) >= 0`. Its curvature is
//! left out, so that nothing is said of walls that only their curvature makes impossible. Source: ours.

use std::collections::BTreeSet;

use dsl::Diagnostic;
use runtime::program::{MemberProgram, Program, StackProgram};
use runtime::{Built, build_tasks};
use stdlib_tasks::bound::Bound;
use stdlib_tasks::dimension::{ACCELERATION, ANGULAR_ACCELERATION, ANGULAR_VELOCITY, Dimension, VELOCITY};

use crate::source_map::SourceMap;
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

/// The hard levels of a stack, as far as brakes are concerned.
struct Hard<'p> {
    program: &'p Program,
    locked: &'p [usize],
    members: Vec<(&'p MemberProgram, &'p Built)>,
    /// Speed limits of all degrees of freedom.
    speeds: &'p [f64],
    /// Barriers of the joints' own positions.
    barriers: Vec<Barrier>,
}

impl<'p> Hard<'p> {
    /// None where no level is hard.
    fn new(program: &'p Program, stack: &'p StackProgram, built: &'p [Built]) -> Option<Self> {
        let all = stack.levels.iter().flat_map(|l| l.members.iter().map(move |m| (l.hard, m)));
        let members: Vec<_> = all.zip(built).filter(|((hard, _), _)| *hard).map(|((_, m), b)| (m, b)).collect();
        // The last one is told of all hard limits of speeds.
        let speeds = &members.last()?.1.speed;
        let positions = members.iter().filter(|(m, _)| is(program, m, "joint_position_limits"));
        let barriers = positions.flat_map(|(m, built)| barriers(program, m.task, built)).collect();
        Some(Hard { program, locked: &stack.locked, members, speeds, barriers })
    }

    /// The speed that a joint can have at most.
    fn fastest(&self, dof: usize, acceleration: f64) -> f64 {
        let own = self.barriers.iter().filter(|b| b.dof == dof);
        own.map(|b| along(b, f64::INFINITY, acceleration)).fold(self.speeds[dof], f64::min)
    }

    /// The members that limit accelerations, with their limits.
    fn brakes(&self) -> impl Iterator<Item = (&'p MemberProgram, Vec<(usize, f64)>)> + use<'p, '_> {
        let limiting = self.members.iter().filter(|(m, _)| is(self.program, m, "joint_acceleration_limits"));
        limiting.filter_map(|(m, built)| Some((*m, built.task.as_ref().ok()?.acceleration_limits())))
    }
}

fn is(program: &Program, member: &MemberProgram, kind: &str) -> bool {
    program.tasks[member.task].kind == kind
}

/// A joint that cannot brake.
struct Weak {
    dof: usize,
    /// Its acceleration limit, the speed that it can have, and the gain that it brakes with.
    acceleration: f64,
    speed: f64,
    gain: f64,
}

impl Weak {
    fn needed(&self) -> f64 {
        self.gain * self.speed
    }

    /// The quantities of its speed and its acceleration.
    fn quantities(&self, program: &Program) -> (Dimension, Dimension) {
        match program.robot.model.dofs[self.dof].unit {
            robot::DofUnit::Metre => (VELOCITY, ACCELERATION),
            robot::DofUnit::Radian => (ANGULAR_VELOCITY, ANGULAR_ACCELERATION),
        }
    }
}

/// Warns of joints that hard levels let run faster towards their limits, or towards a wall, than they let them brake.
pub(crate) fn check(program: &Program, places: &SourceMap, diagnostics: &mut Vec<Diagnostic>) {
    let mut told = BTreeSet::new();
    for stack in &program.stacks {
        let built = build_tasks(program, stack);
        let Some(hard) = Hard::new(program, stack, &built) else { continue };
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

/// The first joint that cannot brake before its position limit, with the task of that limit and how many more there are.
fn before_position_limits(hard: &Hard, limits: &[(usize, f64)]) -> Option<(usize, Weak, usize)> {
    let mut weak = hard.barriers.iter().filter(|b| !hard.locked.contains(&b.dof)).filter_map(|b| {
        let acceleration = limits.iter().find(|(dof, _)| *dof == b.dof)?.1;
        let speed = along(b, hard.speeds[b.dof], acceleration);
        (acceleration < b.gain * speed * (1.0 - 1e-9))
            .then_some((b.task, Weak { dof: b.dof, acceleration, speed, gain: b.gain }))
    });
    let (task, first) = weak.next()?;
    Some((task, first, weak.count()))
}

/// The walls that joints cannot brake before, each with the largest gain for which they could and the joint that lacks most.
fn before_walls(hard: &Hard, limits: &[(usize, f64)]) -> Vec<(usize, f64, Weak)> {
    let mut found: Vec<(usize, f64, Weak)> = Vec::new();
    for (m, built) in &hard.members {
        let Ok(task) = &built.task else { continue };
        let gains = task.gains(&hard.program.values.initial);
        let slopes = task.slopes(&hard.program.robot.model);
        for (row, steep) in slopes.iter().enumerate() {
            let Some(&gain) = gains.get(row).or(gains.first()) else { continue };
            // What brakes can take from the fall of the margin, and what they have to, both by the steepest way down.
            let (mut can, mut speed_down) = (0.0, 0.0);
            let mut worst: Option<Weak> = None;
            for (dof, &slope) in steep.iter().enumerate().filter(|(dof, s)| **s > 0.0 && !hard.locked.contains(dof)) {
                let acceleration = limits.iter().find(|(d, _)| *d == dof).map_or(f64::INFINITY, |l| l.1);
                let speed = hard.fastest(dof, acceleration);
                can += slope * acceleration;
                speed_down += slope * speed;
                let lacks = |w: &Weak| w.needed() / w.acceleration;
                let weak = Weak { dof, acceleration, speed, gain };
                if worst.as_ref().is_none_or(|w| lacks(w) < lacks(&weak)) {
                    worst = Some(weak);
                }
            }
            // Speeds without a limit are told of by another check; joints without brakes of their own stop at once.
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

/// The place of a limit of accelerations.
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
            "a joint that runs along `v = φ h` brakes with `φ v`{others}; with less a hard level ends in a fault"
        ))
        .help(format!(
            "write `max` from {needed}, a gain up to {} /s, or put this task on a soft level",
            runtime::text::number(weak.acceleration / weak.speed)
        ))
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
