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
//! Where the wanted velocity meets all rows, which is so at almost every tick, there is nothing to solve. A limit that the robot has passed
//! leads it back no faster than the limits of accelerations allow. Equalities, of feet and of closed chains, hold at the reference alone,
//! whose noise is none. Source: ours.

use robot::Model;
use solver::{HierarchicalSolver, LevelShape, Problem, Solution, Status};
use stdlib_tasks::task::RowKind;

use crate::evaluator::{Evaluator, TickInputs};
use crate::fault::Fault;
use crate::program::{Program, ProgramError, StackProgram};

/// Relative difference from a bound up to which a row counts as met.
const MET: f64 = 1e-9;

/// Time over which the margins of the measured robot are averaged before one counts as passed (s), against noise.
const AVERAGED: f64 = 0.05;

/// Speed in m/s or rad/s by which a row of the measured robot may be missed where limits of accelerations forbid to meet it: noise of encoders
/// asks for more than a drive can do.
const NOISE: f64 = 0.02;

/// Averaged margin, in m or rad or the unit of a row, below which a hard limit counts as passed by the measured robot.
const BEYOND: f64 = 1e-3;

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
}

/// The stack at the measured configuration.
pub(super) struct Guard {
    evaluator: Evaluator,
    /// Rows at this configuration, as the stack has them.
    problem: Problem,
    /// True if the numbers of the evaluator are those of the last decision.
    is_current: bool,
    limits: Vec<Limit>,
    /// Largest change of each velocity in a period, in rad/s or m/s.
    steps: Vec<f64>,
    period: f64,
    /// Averaged margins; NaN until the robot was within the limit.
    averages: Vec<f64>,
    /// Hard limits, and those of accelerations.
    nearest: Problem,
    solution: Solution,
    solver: Box<dyn HierarchicalSolver + Send>,
}

/// What was sent last, and for how long.
#[derive(Clone, Copy)]
pub(super) struct Sent<'a> {
    /// Velocity, `nv` numbers.
    pub velocity: &'a [f64],
    /// Time since then (s).
    pub dt: f64,
}

impl Guard {
    /// Prepares the stack of an evaluator once more.
    ///
    /// # Errors
    /// The stack cannot be executed, which was excluded when its controller was made.
    pub fn new(program: &Program, stack: &StackProgram) -> Result<Guard, ProgramError> {
        let (evaluator, problem) = Evaluator::of_stack(program, stack)?;
        let (mut limits, mut rows, mut yielding, mut first) = (Vec::new(), 0, 0, 0);
        for (member, m) in evaluator.members().iter().enumerate() {
            let hard = stack.levels.get(m.level).is_some_and(|level| level.hard);
            if !hard || m.row_kind != RowKind::Inequality {
                continue;
            }
            let Some(task) = evaluator.task(member) else { continue };
            let accelerates = !task.acceleration_limits().is_empty();
            let own = program.values.tape.only(&m.slots.iter().copied().collect()).signals().is_empty();
            limits.push(Limit { member, accelerates, own, first });
            first += m.margins.len();
            *if accelerates { &mut yielding } else { &mut rows } += m.rows.len();
        }
        let shape = |rows, hard| LevelShape { rows, hard, damping: 0.0 };
        let shapes = [shape(rows, true), shape(yielding, false), shape(rows, false)];
        let nearest = Problem::new(program.robot.model.nv(), &shapes);
        Ok(Guard {
            steps: evaluator.acceleration_limits().iter().map(|a| a * program.robot.period).collect(),
            period: program.robot.period,
            averages: vec![f64::NAN; first],
            limits,
            is_current: false,
            solution: Solution::new(&nearest),
            solver: program.run.solver.solver(&nearest),
            nearest,
            evaluator,
            problem,
        })
    }

    /// Evaluator at the measured configuration; `None` if its numbers are not those of the last decision.
    pub fn evaluator(&self) -> Option<&Evaluator> {
        Some(&self.evaluator).filter(|_| self.is_current)
    }

    /// Notes that the numbers of the reference are those of the robot, which is where its reference is.
    pub fn leave_out(&mut self) {
        self.is_current = false;
    }

    /// The stack is entered at a configuration; `leader` is its evaluator at the reference, whose captured values are those of this one too.
    pub fn enter(&mut self, q: &[f64], inputs: TickInputs, leader: &Evaluator) {
        self.evaluator.enter_beside(q, inputs, leader);
        self.averages.fill(f64::NAN);
        self.is_current = false;
    }

    /// Evaluates the stack at a configuration, after its evaluator at the reference.
    pub fn update(&mut self, q: &[f64], inputs: TickInputs, leader: &Evaluator) {
        self.evaluator.follow(leader);
        self.evaluator.update_for_rest(q, inputs, &mut self.problem);
        self.is_current = true;
    }

    /// Passes the velocity that the robot was told to the tasks, for margins and errors of velocities.
    pub fn observe(&mut self, q: &[f64], v: &[f64]) {
        self.evaluator.observe(q, v);
    }

    /// Returns the first hard limit that the robot has passed, on the average of the last moments. `dt` is the time since the last look (s).
    pub fn passed(&mut self, dt: f64) -> Option<Fault> {
        let part = 1.0 - (-dt / AVERAGED).exp();
        let mut found = None;
        for Limit { member, own, first, accelerates } in &self.limits {
            let Some(m) = self.evaluator.members().get(*member).filter(|_| *own && !accelerates) else { continue };
            let margins = &self.evaluator.margins()[m.margins.clone()];
            for (row, (h, mean)) in margins.iter().zip(&mut self.averages[*first..]).enumerate() {
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
                *mean = (*mean + part * (h - *mean)).min(10.0 * BEYOND);
                if *mean < -BEYOND && found.is_none() {
                    found = Some(Fault::Beyond { member: *member, row, by: -*mean });
                    *mean = f64::NAN;
                }
            }
        }
        found
    }

    /// Changes a velocity to the nearest one that the hard limits allow at the configuration of the last update. Returns true if it was changed.
    pub fn protect(&mut self, model: &Model, sent: Sent, u: &mut [f64]) -> bool {
        let limits = self.limits.iter();
        let met = limits.clone().all(|limit| {
            let Some(m) = self.evaluator.members().get(limit.member) else { return true };
            let level = &self.problem.levels[m.level];
            m.rows.clone().all(|row| {
                let value: f64 = level.row(row).iter().zip(&*u).map(|(a, u)| a * u).sum();
                let (lower, upper) = self.bounds(limit, row, sent);
                let room = MET * (1.0 + value.abs());
                value >= lower - room && value <= upper + room
            })
        });
        if met {
            return false;
        }
        let (mut row_of, mut yielding) = (0, 0);
        for k in 0..self.limits.len() {
            let Some(m) = self.evaluator.members().get(self.limits[k].member) else { continue };
            for row in m.rows.clone() {
                let (lower, upper) = self.bounds(&self.limits[k], row, sent);
                let coefficients = self.problem.levels[m.level].row(row);
                if self.limits[k].accelerates {
                    self.nearest.levels[1].set(yielding, coefficients, lower, upper);
                    yielding += 1;
                } else {
                    self.nearest.levels[0].set(row_of, coefficients, lower - NOISE, upper + NOISE);
                    self.nearest.levels[2].set(row_of, coefficients, lower, upper);
                    row_of += 1;
                }
            }
        }
        self.nearest.reference.copy_from_slice(u);
        self.solver.solve(&self.nearest, &mut self.solution);
        let x = &self.solution.x;
        let usable = self.solution.status == Status::Optimal && x.iter().all(|v| v.is_finite());
        if usable {
            u.iter_mut().zip(x).zip(&model.dofs).for_each(|((u, x), d)| *u = x.clamp(-d.velocity, d.velocity));
        } else {
            // Rows that contradict each other, or too little room: slower is safe for all constant ones.
            u.iter_mut().zip(sent.velocity).zip(&self.steps).for_each(|((u, last), step)| {
                *u = last.signum() * (last.abs() - step * sent.dt / self.period).max(0.0);
            });
        }
        true
    }

    /// Bounds of a row for a velocity that is sent now.
    fn bounds(&self, limit: &Limit, row: usize, sent: Sent) -> Bounds {
        let Some(m) = self.evaluator.members().get(limit.member) else { return (f64::NEG_INFINITY, f64::INFINITY) };
        let level = &self.problem.levels[m.level];
        let (lower, upper) = (level.lower[row], level.upper[row]);
        let last = || level.row(row).iter().zip(sent.velocity).map(|(a, v)| a * v).sum::<f64>();
        if limit.accelerates {
            // The row is for a period, and around the velocity of the reference; what passed until now is a part of it.
            let (last, most) = (last(), 0.5 * (upper - lower) * sent.dt / self.period);
            return (last - most, last + most);
        }
        let h = self.evaluator.margins().get(m.margins.start + row - m.rows.start).copied().unwrap_or(f64::INFINITY);
        if h >= 0.0 || (lower <= 0.0 && upper >= 0.0) {
            return (lower, upper);
        }
        let room: f64 =
            level.row(row).iter().zip(&self.steps).filter(|(a, _)| **a != 0.0).map(|(a, s)| a.abs() * s).sum();
        let (last, room) = (last(), room * sent.dt / self.period);
        (lower.min((last + room).max(0.0)), upper.max((last - room).min(0.0)))
    }
}

/// Lower and upper bound.
type Bounds = (f64, f64);
