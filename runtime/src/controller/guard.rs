//! Protection of the measured robot: the command keeps the hard limits where the robot is, and not only where its reference is.
//!
//! The hierarchy decides at the reference. What is sent is its velocity and the correction of the tracking law; with A and b the rows of
//! hard limits at the measured configuration, and a the limits of accelerations since the last command,
//!
//! ```text
//! minimise  || u - (v_d + K_q (q_d - q)) ||     subject to   A u >= b - ν,    then |u - u_last| <= a dt,    then A u >= b
//! ```
//!
//! in this order of priority: a distance is never given up for a limit of an acceleration, but noise, ν, is.
//! With a declared lag or dead time, the rows are those of the place where the robot comes to rest by what it was sent already; see
//! [`drive`](super::drive). Margins and errors are those of the measured robot.
//!
//! Where the wanted velocity meets all rows, which is so at almost every tick, there is nothing to solve, and where bounds of gradients prove
//! that it does, they are not even computed; see [`place`](super::place). Where it does not, it is the nearest point that meets all of them; the
//! order of priority counts if there is none. A limit that the robot has passed
//! leads it back no faster than the limits of accelerations allow. Equalities, of feet and of closed chains, hold at the reference alone,
//! whose noise is none. Source: ours.

use std::ops::Range;

use robot::Model;
use solver::{Bounded, HierarchicalSolver, LevelShape, Problem, Projected, Projection, Solution, Status};
use stdlib_tasks::task::RowKind;

use super::place::{Decided, Place, Slopes, sum};
use crate::evaluator::{Evaluator, TickInputs};
use crate::fault::Fault;
use crate::program::{Program, ProgramError, StackProgram};

/// Time over which the margins of the measured robot are averaged before one counts as passed (s), against noise.
const AVERAGED: f64 = 0.05;

/// Speed in m/s or rad/s by which a row of the measured robot may be missed where limits of accelerations forbid to meet it: noise of encoders
/// asks for more than a drive can do.
const NOISE: f64 = 0.02;

/// Averaged margin, in m or rad or the unit of a row, below which a hard limit counts as passed by the measured robot.
const BEYOND: f64 = 1e-3;

/// Largest averaged margin that counts.
const FAR: f64 = 10.0 * BEYOND;

/// A limit on a hard level.
struct Limit {
    /// Its index among the members of the evaluator.
    member: usize,
    /// True if its rows limit accelerations.
    accelerates: bool,
    /// True if only the robot moves its margins.
    own: bool,
    /// Index of its first margin among all averages.
    first: usize,
    /// Bounds of the gradients of its margins, if they are known.
    slopes: Option<Slopes>,
    /// Its rows among all.
    rows: Range<usize>,
    /// True if its rows count at this call, because they are not certainly met.
    counts: bool,
}

impl Limit {
    /// Returns true if its rows are certainly met at a place by a velocity. `both` is storage.
    fn is_met(&self, place: &Place, u: &[f64], both: &mut [f64]) -> bool {
        place.has_bounds() && self.slopes.as_ref().is_some_and(|slopes| slopes.are_met(&place.off, u, both))
    }
}

/// What a velocity is for.
#[derive(Clone, Copy)]
pub(super) enum For {
    /// The command.
    Command,
    /// The offset of the position command.
    Offset,
}

/// A row of a limit, for a velocity that is sent now.
#[derive(Clone, Copy)]
struct Row {
    /// Its level in the problem of the stack, and its index there.
    level: usize,
    row: usize,
    lower: f64,
    upper: f64,
}

/// Configurations of the robot, now and at rest.
#[derive(Clone, Copy)]
pub(super) struct Robot<'a> {
    /// Measured configuration.
    pub q: &'a [f64],
    /// Configuration in which it comes to rest by what was sent already; the same with ideal drives.
    pub ahead: &'a [f64],
}

/// The stack at the measured configuration.
pub(super) struct Guard {
    /// The stack at the measured configuration.
    measured: Place,
    /// The stack where the robot comes to rest; `None` with ideal drives.
    ahead: Option<Place>,
    /// True if the robot is elsewhere than its reference, so that the numbers of this place count.
    is_apart: bool,
    decided: Decided,
    /// Reference of the last decision.
    reference: Vec<f64>,
    limits: Vec<Limit>,
    /// Largest change of each velocity in a period, in rad/s or m/s.
    steps: Vec<f64>,
    period: f64,
    /// Averaged margins; NaN until the robot was within the limit.
    averages: Vec<f64>,
    /// Rows of all limits.
    rows: Vec<Row>,
    /// For the command and for the offset.
    nearest: [Projection; 2],
    /// The order of priority, where no velocity meets all rows.
    ordered: Problem,
    solution: Solution,
    solver: Box<dyn HierarchicalSolver + Send>,
    /// Storage for a velocity.
    both: Vec<f64>,
}

/// What was sent last, and for how long.
#[derive(Clone, Copy)]
pub(super) struct Sent<'a> {
    /// Velocity, `nv` numbers.
    pub velocity: &'a [f64],
    /// Time since then (s).
    pub dt: f64,
    /// True if the robot comes to rest: limits that it has passed do not lead it back.
    pub stops: bool,
}

/// The stack at the reference.
#[derive(Clone, Copy)]
pub(super) struct Leader<'a> {
    pub evaluator: &'a Evaluator,
    pub problem: &'a Problem,
    /// The reference.
    pub q: &'a [f64],
}

impl Guard {
    /// Prepares the stack of an evaluator once more.
    ///
    /// # Errors
    /// The stack cannot be executed, which was excluded when its controller was made.
    pub fn new(program: &Program, stack: &StackProgram) -> Result<Guard, ProgramError> {
        let measured = Place::new(program, stack)?;
        let evaluator = &measured.evaluator;
        let behind = program.robot.behind();
        let mut ahead = if behind > 0.0 { Some(Place::new(program, stack)?) } else { None };
        // Where the robot is now, it meets an obstacle where that is now.
        ahead.iter_mut().for_each(|place| place.evaluator.foresee(program, behind));
        let (mut limits, mut rows, mut yielding, mut first) = (Vec::new(), Vec::new(), 0, 0);
        for (member, m) in evaluator.members().iter().enumerate() {
            let hard = stack.levels.get(m.level).is_some_and(|level| level.hard);
            if !hard || m.row_kind != RowKind::Inequality {
                continue;
            }
            let Some(task) = evaluator.task(member) else { continue };
            let accelerates = !task.acceleration_limits().is_empty();
            let own = program.values.tape.only(&m.slots.iter().copied().collect()).signals().is_empty();
            let row = |row| Row { level: m.level, row, lower: f64::NEG_INFINITY, upper: f64::INFINITY };
            let (slopes, begin) = (Slopes::of(program, evaluator, member), rows.len());
            rows.extend(m.rows.clone().map(row));
            limits.push(Limit { member, accelerates, own, first, slopes, rows: begin..rows.len(), counts: false });
            first += m.margins.len();
            yielding += if accelerates { m.rows.len() } else { 0 };
        }
        let nv = program.robot.model.nv();
        let shape = |rows, hard| LevelShape { rows, hard, damping: 0.0 };
        let keeping = rows.len() - yielding;
        let shapes = [shape(keeping, true), shape(yielding, false), shape(keeping, false)];
        let ordered = Problem::new(nv, &shapes);
        Ok(Guard {
            steps: evaluator.acceleration_limits().iter().map(|a| a * program.robot.period).collect(),
            period: program.robot.period,
            averages: vec![f64::NAN; first],
            limits,
            is_apart: false,
            decided: Decided::new(nv),
            reference: program.robot.home.clone(),
            rows,
            nearest: [Projection::new(nv), Projection::new(nv)],
            solution: Solution::new(&ordered),
            solver: program.run.solver.solver(&ordered),
            ordered,
            both: vec![0.0; nv],
            ahead,
            measured,
        })
    }

    /// Evaluator at the measured configuration, as far as it was evaluated; `None` if the robot is where its reference is.
    pub fn evaluator(&self) -> Option<&Evaluator> {
        Some(&self.measured.evaluator).filter(|_| self.is_apart)
    }

    /// Returns true if the robot is elsewhere than its reference.
    pub fn is_apart(&self) -> bool {
        self.is_apart
    }

    /// Evaluates all tasks at the measured configuration that have not been; `v` is the velocity that the robot was told, for margins and errors of
    /// velocities.
    pub fn complete(&mut self, signals: &[f64], v: &[f64]) {
        if self.is_apart {
            self.measured.look_at_all(self.decided.inputs(signals), v);
        }
    }

    /// Notes that the numbers of the reference are those of the robot, which is where its reference is.
    pub fn leave_out(&mut self) {
        self.is_apart = false;
    }

    /// The stack is entered; `leader` is its evaluator at the reference, whose captured values are those of this one too.
    pub fn enter(&mut self, robot: Robot, inputs: TickInputs, leader: &Evaluator) {
        self.measured.evaluator.enter_beside(robot.q, inputs, leader);
        if let Some(ahead) = &mut self.ahead {
            ahead.evaluator.enter_beside(robot.ahead, inputs, leader);
        }
        self.averages.fill(f64::NAN);
        self.is_apart = false;
    }

    /// Takes the place of the robot at a decision, after the stack was evaluated at the reference.
    pub fn update(&mut self, robot: Robot, inputs: TickInputs, leader: Leader) {
        self.is_apart = true;
        self.decided.note(inputs);
        self.reference.copy_from_slice(leader.q);
        self.go(robot, leader.evaluator);
        self.measured.recall(inputs);
        for Limit { member, slopes, .. } in &mut self.limits {
            if let (Some(slopes), Some(m)) = (slopes, leader.evaluator.members().get(*member)) {
                slopes.note(m, leader.evaluator, leader.problem);
            }
        }
    }

    /// Takes the place of the robot, at a decision or between two. `leader` is the evaluator at the reference of the last decision.
    pub fn go(&mut self, robot: Robot, leader: &Evaluator) {
        self.measured.go(robot.q, &self.reference, leader);
        if let Some(ahead) = &mut self.ahead {
            ahead.go(robot.ahead, &self.reference, leader);
        }
    }

    /// Returns the first hard limit that the robot has passed, on the average of the last moments. `dt` is the time since the last look (s).
    pub fn passed(&mut self, dt: f64, signals: &[f64]) -> Option<Fault> {
        let part = 1.0 - (-dt / AVERAGED).exp();
        let Guard { measured, limits, averages, decided, .. } = self;
        let mut found = None;
        for Limit { member, first, slopes, .. } in limits.iter().filter(|limit| limit.own && !limit.accelerates) {
            let range = measured.evaluator.members()[*member].margins.clone();
            let means = &mut averages[*first..][..range.len()];
            if measured.has_bounds() && slopes.as_ref().is_some_and(|s| s.are_beyond(FAR, &measured.off)) {
                means.fill(FAR);
                continue;
            }
            measured.look(*member, decided.inputs(signals));
            for (row, (h, mean)) in measured.evaluator.margins()[range].iter().zip(means).enumerate() {
                if !h.is_finite() {
                    continue;
                }
                if mean.is_nan() {
                    // A limit that is passed when the stack is entered counts once the robot was within it.
                    if *h >= 0.0 {
                        *mean = *h;
                    }
                    continue;
                }
                // The average of a robot that was far within must not hide for long that it has passed the limit.
                *mean = (*mean + part * (h - *mean)).min(FAR);
                if *mean < -BEYOND && found.is_none() {
                    found = Some(Fault::Beyond { member: *member, row, by: -*mean });
                    *mean = f64::NAN;
                }
            }
        }
        found
    }

    /// Changes a velocity to the nearest one that the hard limits allow where the robot is. Returns true if it was changed.
    pub fn protect(&mut self, model: &Model, sent: Sent, signals: &[f64], of: For, u: &mut [f64]) -> bool {
        self.limits.iter_mut().for_each(|limit| limit.counts = false);
        self.rows.iter_mut().for_each(Row::leave_out);
        let mut changed = false;
        // Each round takes up another limit.
        while self.take_up(sent, signals, u, false) {
            let Guard { measured, ahead, rows, nearest, .. } = &mut *self;
            let levels = &ahead.as_ref().unwrap_or(measured).problem.levels;
            let row = |i: usize| {
                let Row { level, row, lower, upper } = rows[i];
                Bounded { coefficients: levels[level].row(row), lower, upper }
            };
            match nearest[of as usize].project(rows.len(), row, u) {
                Projected::Stays => break,
                Projected::Moved => changed = true,
                Projected::Nowhere => {
                    self.take_up(sent, signals, u, true);
                    self.follow_order(sent, u);
                    changed = true;
                    break;
                }
            }
        }
        if changed {
            u.iter_mut().zip(&model.dofs).for_each(|(u, d)| *u = u.clamp(-d.velocity, d.velocity));
        }
        changed
    }

    /// Computes the rows of limits that a velocity does not certainly meet, or of all. Returns false if there is no further one.
    fn take_up(&mut self, sent: Sent, signals: &[f64], u: &[f64], all: bool) -> bool {
        let Guard { measured, ahead, decided, limits, rows, steps, period, both, .. } = self;
        let place = ahead.as_mut().unwrap_or(measured);
        let mut more = false;
        for limit in limits.iter_mut().filter(|limit| !limit.counts) {
            if !all && limit.is_met(place, u, both) {
                continue;
            }
            place.look(limit.member, decided.inputs(signals));
            let m = &place.evaluator.members()[limit.member];
            let margins = place.evaluator.margins()[m.margins.clone()].iter();
            for (row, h) in rows[limit.rows.clone()].iter_mut().zip(margins) {
                let margin = Some(*h).filter(|_| !limit.accelerates);
                row.bound(&place.problem, margin, sent, Steps { steps, period: *period });
            }
            (limit.counts, more) = (true, true);
        }
        more
    }

    /// Changes a velocity to the one that meets the limits in their order of priority: those of positions and distances up to noise, then those of
    /// accelerations, then the first ones without noise.
    fn follow_order(&mut self, sent: Sent, u: &mut [f64]) {
        let Guard { measured, ahead, limits, rows, ordered, solution, solver, steps, period, .. } = self;
        let from = &ahead.as_ref().unwrap_or(measured).problem;
        let (mut row, mut yielding) = (0, 0);
        for limit in &*limits {
            for of in &rows[limit.rows.clone()] {
                let coefficients = from.levels[of.level].row(of.row);
                if limit.accelerates {
                    ordered.levels[1].set(yielding, coefficients, of.lower, of.upper);
                    yielding += 1;
                } else {
                    ordered.levels[0].set(row, coefficients, of.lower - NOISE, of.upper + NOISE);
                    ordered.levels[2].set(row, coefficients, of.lower, of.upper);
                    row += 1;
                }
            }
        }
        ordered.reference.copy_from_slice(u);
        solver.solve(ordered, solution);
        if solution.status == Status::Optimal && solution.x.iter().all(|v| v.is_finite()) {
            u.copy_from_slice(&solution.x);
        } else {
            // Rows that contradict each other, or too little room: slower is safe for all constant ones.
            u.iter_mut().zip(sent.velocity).zip(&*steps).for_each(|((u, last), step)| {
                *u = last.signum() * (last.abs() - step * sent.dt / *period).max(0.0);
            });
        }
    }
}

/// Largest change of each velocity in a period.
#[derive(Clone, Copy)]
struct Steps<'a> {
    steps: &'a [f64],
    period: f64,
}

impl Row {
    /// Leaves the row out.
    fn leave_out(&mut self) {
        (self.lower, self.upper) = (f64::NEG_INFINITY, f64::INFINITY);
    }

    /// Computes its bounds for a velocity that is sent now; `margin` is `None` for a limit of an acceleration.
    fn bound(&mut self, problem: &Problem, margin: Option<f64>, sent: Sent, most: Steps) {
        let level = &problem.levels[self.level];
        let (a, lower, upper) = (level.row(self.row), level.lower[self.row], level.upper[self.row]);
        let part = sent.dt / most.period;
        let Some(h) = margin else {
            // The row is for a period, and around the velocity of the reference; what passed until now is a part of it.
            let (last, most) = (sum(a, sent.velocity), 0.5 * (upper - lower) * part);
            (self.lower, self.upper) = (last - most, last + most);
            return;
        };
        if sent.stops {
            // Rest meets every limit.
            (self.lower, self.upper) = (lower.min(0.0), upper.max(0.0));
            return;
        }
        (self.lower, self.upper) = (lower, upper);
        if h >= 0.0 || (lower <= 0.0 && upper >= 0.0) {
            return;
        }
        // A limit that was passed is led back no faster than accelerations allow.
        let room: f64 = a.iter().zip(most.steps).filter(|(a, _)| **a != 0.0).map(|(a, s)| a.abs() * s).sum();
        let (last, room) = (sum(a, sent.velocity), room * part);
        (self.lower, self.upper) = (lower.min((last + room).max(0.0)), upper.max((last - room).min(0.0)));
    }
}
