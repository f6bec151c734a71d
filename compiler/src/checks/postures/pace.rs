//! Targets that move faster than the joints can: at postures where the target is met, the joints at their permitted speeds
//! yield only a part of its velocity. And joint velocities that last until the joint is at its stop.

use dsl::Diagnostic;
use robot::DofUnit;
use runtime::program::{LevelProgram, MemberProgram, Program, StackProgram, Times};
use runtime::{Evaluator, RestInputs};
use solver::{Backend, LevelShape, Problem, Solution, Status};
use stdlib_tasks::dimension::{ANGLE, Dimension, LENGTH, TIME};

use super::parts::{JointLimits, VelocityTarget};
use super::report::{place, seconds, velocity};
use crate::analysis::postures::{alone, gains};
use crate::binding::Number;
use crate::checks::Checked;
use crate::units::{shown, shown_range};

/// Share of the velocity of a target that must be missing before it counts as too fast. The joints are examined at one
/// posture of many, so that a small deficit has no meaning.
const SPEED_DEFICIT: f64 = 0.2;

/// The same at home at the entry of the stack, which is the posture of the robot at that moment.
const DEFICIT_AT_HOME: f64 = 0.05;

/// The same of an acceleration. It is larger, since the change of the rows with the posture is left out.
const ACCELERATION_DEFICIT: f64 = 0.5;

/// Share of a rate that the joints must be able to reach without limits.
const SINGULAR: f64 = 0.5;

/// Rate up to which a target stands still.
const NOTHING: f64 = 1e-6;

/// Number of moments at which a velocity of joints is examined.
const MOMENTS: usize = 200;

/// Gain that removes the feedback from the rows.
const NO_GAIN: f64 = 1e-6;

/// A posture at which a target is met, and its moment.
pub(super) struct Moment {
    /// Configuration.
    pub q: Vec<f64>,
    /// Time since the entry of the stack (s).
    pub t: f64,
}

/// One target by itself, without feedback.
struct Pace {
    evaluator: Evaluator,
    problem: Problem,
    rest: RestInputs,
}

impl Pace {
    fn new(program: &Program, stack: usize, member: &MemberProgram) -> Option<Pace> {
        let own = &program.stacks[stack];
        let level = LevelProgram {
            name: "target".to_string(),
            hard: false,
            damping: 0.0,
            exact: true,
            members: vec![member.clone()],
        };
        let (name, locked) = (own.name.clone(), own.locked.clone());
        let stack = StackProgram { name, locked, levels: vec![level], parts: own.parts.clone() };
        let mut program = alone(program, stack);
        let places = gains(&program.tasks[member.task].params);
        program.values.tape.outputs.retain(|o| !places.contains(&o.at));
        for at in places {
            *program.values.initial.get_mut(at)? = NO_GAIN;
        }
        let (mut evaluator, problem) = Evaluator::new(&program, 0).ok()?;
        if !evaluator.needs().is_empty() {
            return None;
        }
        let rest = RestInputs::new(&program);
        evaluator.enter(&program.robot.home, rest.at(Times::default()));
        Some(Pace { evaluator, problem, rest })
    }

    /// Writes the rows of a posture at time `t`, and returns the rates that the target asks for.
    fn rates(&mut self, q: &[f64], t: f64) -> Option<&[f64]> {
        self.evaluator.update(q, self.rest.at(Times { t, time: t }), &mut self.problem).ok()?;
        Some(&self.problem.levels[0].lower)
    }

    /// Changes of the rates over a period around time `t`, per s.
    fn accelerations(&mut self, q: &[f64], t: f64, period: f64) -> Option<Vec<f64>> {
        let (before, after) = ((t - 0.5 * period).max(0.0), (t - 0.5 * period).max(0.0) + period);
        let first = self.rates(q, before)?.to_vec();
        let second = self.rates(q, after)?;
        Some(first.iter().zip(second).map(|(a, b)| (b - a) / period).collect())
    }
}

/// Something of a target that the joints do not reach.
pub(super) struct TooFast {
    /// Velocity or acceleration of the target, and that of the joints along it, in the unit of the row per s or s^2.
    wanted: f64,
    reached: f64,
    dimension: Dimension,
    t: f64,
}

/// Finds the moment at which the joints fall farthest behind what a target asks for. `wanted` returns the rows' values.
fn worst(
    pace: &mut Pace,
    limits: &[f64],
    share: impl Fn(&Moment) -> f64,
    moments: &[Moment],
    wanted: impl Fn(&mut Pace, &Moment) -> Option<Vec<f64>>,
) -> Option<TooFast> {
    if limits.iter().all(|x| x.is_infinite()) {
        return None;
    }
    let info = pace.evaluator.members()[0].row_info.clone();
    let n = limits.len();
    let shape = |rows| LevelShape { rows, hard: false, damping: 0.0 };
    let mut problem = Problem::new(n, &[shape(n), shape(info.len())]);
    for (dof, limit) in limits.iter().enumerate() {
        let row: Vec<f64> = (0..n).map(|k| f64::from(u8::from(k == dof))).collect();
        problem.levels[0].set(dof, &row, -limit, *limit);
    }
    // The same without limits: what the posture itself excludes, for example a singular one, is no matter of speed.
    let mut free = Problem::new(n, &[shape(info.len())]);
    let mut solver = None;
    let mut free_solver = Backend::ActiveSet.solver(&free);
    let (mut solution, mut free_solution) = (Solution::new(&problem), Solution::new(&free));
    let mut worst: Option<TooFast> = None;
    for moment in moments {
        let Some(values) = wanted(pace, moment) else { continue };
        for (i, x) in values.iter().enumerate() {
            let row = pace.problem.levels[0].row(i)[..n].to_vec();
            problem.levels[1].set(i, &row, *x, *x);
            free.levels[0].set(i, &row, *x, *x);
        }
        free_solver.solve(&free, &mut free_solution);
        // The limits change nothing of a solution within them.
        let within = || free_solution.x.iter().zip(limits).all(|(x, limit)| x.abs() <= *limit);
        if free_solution.status == Status::Optimal && within() {
            continue;
        }
        solver.get_or_insert_with(|| Backend::ActiveSet.solver(&problem)).solve(&problem, &mut solution);
        if solution.status != Status::Optimal || free_solution.status != Status::Optimal {
            continue;
        }
        for dimension in [LENGTH, ANGLE].into_iter().chain(info.first().map(|r| r.dimension)) {
            let own = || info.iter().enumerate().filter(|(_, r)| r.dimension == dimension).map(|(i, _)| i);
            let norm = |of: &[f64]| own().map(|i| of[i].powi(2)).sum::<f64>().sqrt();
            let (all, asked) = (norm(&values), norm(&values) - norm(&free_solution.levels[0].slack));
            let missing = norm(&solution.levels[1].slack) - (all - asked);
            let slower = worst.as_ref().is_none_or(|w| missing / asked > 1.0 - w.reached / w.wanted);
            if all.is_finite() && asked > NOTHING.max(SINGULAR * all) && missing > share(moment) * asked && slower {
                worst = Some(TooFast { wanted: asked, reached: asked - missing, dimension, t: moment.t });
            }
        }
    }
    worst
}

/// Rounds to two digits, away from the other one of two numbers that are compared: the postures are found by searches, whose
/// last digits mean nothing.
fn outward(x: f64, round: impl Fn(f64) -> f64) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return x;
    }
    let digit = 10_f64.powf(x.abs().log10().floor() - 1.0);
    // A number that is round already stays as it is, whatever its rounding error.
    let near = (x / digit).round();
    if (x / digit - near).abs() < 1e-6 { near * digit } else { round(x / digit) * digit }
}

/// Finding about the pace of a target.
pub(super) enum Finding {
    /// It moves faster than the joints.
    Speed(TooFast),
    /// It accelerates faster than the joints.
    Acceleration(TooFast),
    /// It is a velocity of joints that lasts until a joint is at its stop.
    Stop(Stop),
}

/// Finds out whether a target is faster than the joints at postures where it is met.
pub(super) fn of_target(
    program: &Program,
    stack: usize,
    limits: &JointLimits,
    member: &MemberProgram,
    moments: &[Moment],
) -> Option<Finding> {
    too_fast(program, &mut Pace::new(program, stack, member)?, limits, moments)
}

/// Finds out whether a velocity of joints is faster than these at home, or lasts until one is at its stop.
pub(super) fn of_velocity(
    program: &Program,
    stack: usize,
    limits: &JointLimits,
    target: &VelocityTarget,
    duration: f64,
    moments: &[Moment],
) -> Option<Finding> {
    let mut pace = Pace::new(program, stack, &target.member)?;
    let fast = too_fast(program, &mut pace, limits, moments);
    fast.or_else(|| stop(program, &mut pace, limits, target, duration).map(Finding::Stop))
}

fn too_fast(program: &Program, pace: &mut Pace, limits: &JointLimits, moments: &[Moment]) -> Option<Finding> {
    let period = program.robot.period;
    let share = |m: &Moment| match m.t == 0.0 && m.q == program.robot.home {
        true => DEFICIT_AT_HOME,
        false => SPEED_DEFICIT,
    };
    let velocities = worst(pace, &limits.speed, share, moments, |p, m| Some(p.rates(&m.q, m.t)?.to_vec()));
    let accelerations = |p: &mut Pace, m: &Moment| p.accelerations(&m.q, m.t, period);
    velocities.map(Finding::Speed).or_else(|| {
        worst(pace, &limits.acceleration, |_| ACCELERATION_DEFICIT, moments, accelerations).map(Finding::Acceleration)
    })
}

/// Warns of a finding.
pub(super) fn warning(c: &Checked, member: &MemberProgram, finding: &Finding, duration: f64) -> Diagnostic {
    let name = &c.program.tasks[member.task].name;
    let (found, text, unit, what) = match finding {
        Finding::Stop(stop) => return at_stop(c, member, stop, duration),
        Finding::Speed(found) => {
            (found, format!("the target of `{name}` moves faster than the joints can"), "", "speed")
        }
        Finding::Acceleration(found) => {
            let text = format!("the target of `{name}` accelerates faster than the joints can");
            (found, text, "^2", "acceleration")
        }
    };
    let shown = |x: f64| format!("{}{unit}", velocity(x, found.dimension));
    let (wanted, reached) = (outward(found.wanted, f64::ceil), outward(found.reached, f64::floor));
    Diagnostic::warning("HQ0534", place(c, member.task, ""), text)
        .here(format!("up to {} at t = {}", shown(wanted), seconds(found.t)))
        .note(format!(
            "at a posture where the target is met, the joints reach about {} of it within their {what} limits",
            shown(reached)
        ))
        .help("slow the target down; the robot falls behind it otherwise")
}

/// A joint that a velocity leads to its stop.
pub(super) struct Stop {
    dof: usize,
    /// Time at which it is there (s).
    t: f64,
}

fn stop(
    program: &Program,
    pace: &mut Pace,
    limits: &JointLimits,
    target: &VelocityTarget,
    duration: f64,
) -> Option<Stop> {
    let (model, home) = (&program.robot.model, &program.robot.home);
    let step = duration / MOMENTS as f64;
    // How far beyond a stop a joint counts as there: a fiftieth of the range, so that the sum over the moments decides nothing.
    let beyond = |dof: usize| 0.02 * (model.dofs[dof].upper - model.dofs[dof].lower);
    // A joint that is too far from its stops even at full speed need not be looked at. Velocities are within the limits up to
    // their tolerance.
    let fastest = |dof: usize| (1.0 + SPEED_DEFICIT) * limits.speed[dof] * duration;
    let may_arrive = |&&dof: &&usize| {
        let d = &model.dofs[dof];
        let q = d.q_index.and_then(|i| home.get(i));
        q.is_some_and(|q| fastest(dof) > (d.upper - q).min(q - d.lower) + beyond(dof) || fastest(dof).is_nan())
    };
    target.dofs.iter().find(may_arrive)?;
    let mut q = home.clone();
    for k in 0..MOMENTS {
        let t = (k as f64 + 0.5) * step;
        let rates = pace.rates(home, t)?;
        for (rate, &dof) in rates.iter().zip(&target.dofs) {
            let d = &model.dofs[dof];
            let Some(i) = d.q_index else { continue };
            q[i] += rate * step;
            let past = (q[i] - d.upper).max(d.lower - q[i]);
            if past.is_finite() && past > 0.0 && past > beyond(dof) {
                return Some(Stop { dof, t });
            }
        }
    }
    None
}

fn at_stop(c: &Checked, member: &MemberProgram, stop: &Stop, duration: f64) -> Diagnostic {
    let d = &c.program.robot.model.dofs[stop.dof];
    let dimension = if d.unit == DofUnit::Metre { LENGTH } else { ANGLE };
    let text = format!("`{}` is at its limit after {}", d.name, seconds(stop.t));
    let task = &c.places.tasks[member.task];
    let number = |n: &&Number| n.written && n.slot.len == 1;
    let numbers: Vec<_> = task.numbers.iter().filter(number).collect();
    let at = match numbers.as_slice() {
        [one] => one.span,
        _ => task.spans.get("velocity").copied().unwrap_or(task.span),
    };
    Diagnostic::warning("HQ0535", at, text)
        .note(format!(
            "its range is {}, and the stack runs for {}",
            shown_range(d.lower, d.upper, dimension),
            shown(duration, TIME)
        ))
        .help("end the motion before, or let the velocity return, as with a sine of time")
}
