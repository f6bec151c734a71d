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

/// The stack at a configuration.
struct Place {
    evaluator: Evaluator,
    /// Rows at this configuration, as the stack has them.
    problem: Problem,
}

impl Place {
    fn new(program: &Program, stack: &StackProgram) -> Result<Place, ProgramError> {
        let (evaluator, problem) = Evaluator::of_stack(program, stack)?;
        Ok(Place { evaluator, problem })
    }

    fn update(&mut self, q: &[f64], inputs: TickInputs, leader: &Evaluator) {
        self.evaluator.follow(leader);
        self.evaluator.update_for_rest(q, inputs, &mut self.problem);
    }
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
        let measured = Place::new(program, stack)?;
        let evaluator = &measured.evaluator;
        let behind = program.robot.behind();
        let mut ahead = if behind > 0.0 { Some(Place::new(program, stack)?) } else { None };
        // Where the robot is now, it meets an obstacle where that is now.
        ahead.iter_mut().for_each(|place| place.evaluator.foresee(program, behind));
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
            ahead,
            measured,
        })
    }

    /// Evaluator at the measured configuration; `None` if its numbers are not those of the last decision.
    pub fn evaluator(&self) -> Option<&Evaluator> {
        Some(&self.measured.evaluator).filter(|_| self.is_current)
    }

    /// Notes that the numbers of the reference are those of the robot, which is where its reference is.
    pub fn leave_out(&mut self) {
        self.is_current = false;
    }

    /// The stack is entered; `leader` is its evaluator at the reference, whose captured values are those of this one too.
    pub fn enter(&mut self, robot: Robot, inputs: TickInputs, leader: &Evaluator) {
        self.measured.evaluator.enter_beside(robot.q, inputs, leader);
        if let Some(ahead) = &mut self.ahead {
            ahead.evaluator.enter_beside(robot.ahead, inputs, leader);
        }
        self.averages.fill(f64::NAN);
        self.is_current = false;
    }

    /// Evaluates the stack for a robot, after its evaluator at the reference.
    pub fn update(&mut self, robot: Robot, inputs: TickInputs, leader: &Evaluator) {
        self.measured.update(robot.q, inputs, leader);
        if let Some(ahead) = &mut self.ahead {
            ahead.update(robot.ahead, inputs, leader);
        }
        self.is_current = true;
    }

    /// Passes the velocity that the robot was told to the tasks, for margins and errors of velocities.
    pub fn observe(&mut self, q: &[f64], v: &[f64]) {
        self.measured.evaluator.observe(q, v);
    }

    /// Returns the first hard limit that the robot has passed, on the average of the last moments. `dt` is the time since the last look (s).
    pub fn passed(&mut self, dt: f64) -> Option<Fault> {
        let part = 1.0 - (-dt / AVERAGED).exp();
        let mut found = None;
        for Limit { member, own, first, accelerates } in &self.limits {
            let Some(m) = self.measured.evaluator.members().get(*member).filter(|_| *own && !accelerates) else {
                continue;
            };
            let margins = &self.measured.evaluator.margins()[m.margins.clone()];
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
        let Guard { measured, ahead, limits, steps, period, nearest, solution, solver, .. } = self;
        let rows = Rows { place: ahead.as_ref().unwrap_or(measured), steps, period: *period, sent };
        let met = limits.iter().all(|limit| {
            rows.of(limit).all(|(coefficients, (lower, upper))| {
                let value: f64 = coefficients.iter().zip(&*u).map(|(a, u)| a * u).sum();
                let room = MET * (1.0 + value.abs());
                value >= lower - room && value <= upper + room
            })
        });
        if met {
            return false;
        }
        let (mut row, mut yielding) = (0, 0);
        for limit in &*limits {
            for (coefficients, (lower, upper)) in rows.of(limit) {
                if limit.accelerates {
                    nearest.levels[1].set(yielding, coefficients, lower, upper);
                    yielding += 1;
                } else {
                    nearest.levels[0].set(row, coefficients, lower - NOISE, upper + NOISE);
                    nearest.levels[2].set(row, coefficients, lower, upper);
                    row += 1;
                }
            }
        }
        nearest.reference.copy_from_slice(u);
        solver.solve(nearest, solution);
        let usable = solution.status == Status::Optimal && solution.x.iter().all(|v| v.is_finite());
        if usable {
            u.iter_mut()
                .zip(&solution.x)
                .zip(&model.dofs)
                .for_each(|((u, x), d)| *u = x.clamp(-d.velocity, d.velocity));
        } else {
            // Rows that contradict each other, or too little room: slower is safe for all constant ones.
            u.iter_mut().zip(sent.velocity).zip(&*steps).for_each(|((u, last), step)| {
                *u = last.signum() * (last.abs() - step * sent.dt / *period).max(0.0);
            });
        }
        true
    }
}

/// Rows of the hard limits for a velocity that is sent now.
#[derive(Clone, Copy)]
struct Rows<'a> {
    place: &'a Place,
    /// Largest change of each velocity in a period.
    steps: &'a [f64],
    period: f64,
    sent: Sent<'a>,
}

/// Lower and upper bound.
type Bounds = (f64, f64);

impl<'a> Rows<'a> {
    /// Coefficients and bounds of the rows of a limit.
    fn of(self, limit: &Limit) -> impl Iterator<Item = (&'a [f64], Bounds)> {
        let accelerates = limit.accelerates;
        let member = self.place.evaluator.members().get(limit.member);
        member.into_iter().flat_map(move |m| {
            let level = &self.place.problem.levels[m.level];
            m.rows.clone().enumerate().map(move |(k, row)| {
                let (coefficients, bounds) = (level.row(row), (level.lower[row], level.upper[row]));
                let margin = self.place.evaluator.margins().get(m.margins.start + k).copied();
                (coefficients, self.bounds(coefficients, bounds, if accelerates { None } else { margin }))
            })
        })
    }

    /// Bounds of a row for a velocity that is sent now; `margin` is `None` for a limit of an acceleration.
    fn bounds(&self, coefficients: &[f64], (lower, upper): Bounds, margin: Option<f64>) -> Bounds {
        let Sent { velocity, dt } = self.sent;
        let last = || coefficients.iter().zip(velocity).map(|(a, v)| a * v).sum::<f64>();
        let Some(h) = margin else {
            // The row is for a period, and around the velocity of the reference; what passed until now is a part of it.
            let (last, most) = (last(), 0.5 * (upper - lower) * dt / self.period);
            return (last - most, last + most);
        };
        if h >= 0.0 || (lower <= 0.0 && upper >= 0.0) {
            return (lower, upper);
        }
        // A limit that was passed is led back no faster than accelerations allow.
        let room: f64 = coefficients.iter().zip(self.steps).filter(|(a, _)| **a != 0.0).map(|(a, s)| a.abs() * s).sum();
        let (last, room) = (last(), room * dt / self.period);
        (lower.min((last + room).max(0.0)), upper.max((last - room).min(0.0)))
    }
}
