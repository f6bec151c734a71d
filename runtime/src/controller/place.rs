//! A stack at another configuration than its reference: tasks are evaluated there when they are needed, and not at all where bounds of their
//! gradients are proof enough.
//!
//! A margin h whose gradient is bounded by s, and whose row is `h' >= -φ h`, is at a distance Δ from the reference, along each degree of freedom,
//!
//! ```text
//! h(q)  >=  h(q_d) - sum_j s_j |Δ_j|
//! ```
//!
//! and a velocity u certainly meets its row there if the bound b of the row at the reference has room for both:
//!
//! ```text
//! b(q_d) + sum_j s_j (|u_j| + φ |Δ_j|)  <=  0
//! ```
//!
//! as for [idle rows](crate::program::IdleRow). This needs parameters that never move, and joints inside their limits. Source: ours.

use solver::Problem;
use stdlib_tasks::task::RowKind;

use crate::evaluator::{Evaluator, Member, TickInputs};
use crate::program::{Program, ProgramError, StackProgram, Times};

/// Bounds of the gradients of a limit.
pub(super) struct Slopes {
    /// `nv` numbers for each row.
    slopes: Vec<f64>,
    gain: f64,
    /// Margins and lower bounds of its rows at the reference; a row that is idle has no bound.
    margins: Vec<f64>,
    lower: Vec<f64>,
}

impl Slopes {
    /// Slopes of a task of an evaluator, if they and its gain are known, and its parameters do not move.
    pub fn of(program: &Program, evaluator: &Evaluator, member: usize) -> Option<Slopes> {
        let (m, task) = (evaluator.members().get(member)?, evaluator.task(member)?);
        let moves = |at: &usize| program.values.tape.outputs.iter().any(|o| o.at == *at);
        if m.slots.iter().any(moves) {
            return None;
        }
        let slopes = task.gradient_bounds(evaluator.model());
        let [gain] = task.gains(&program.values.initial)[..] else { return None };
        let rows = m.rows.len();
        (slopes.len() == rows && rows > 0).then(|| Slopes {
            slopes: slopes.concat(),
            gain,
            margins: vec![0.0; rows],
            lower: vec![0.0; rows],
        })
    }

    /// Notes the margins and bounds at the reference.
    pub fn note(&mut self, m: &Member, reference: &Evaluator, problem: &Problem) {
        self.margins.copy_from_slice(&reference.margins()[m.margins.clone()]);
        self.lower.copy_from_slice(&problem.levels[m.level].lower[m.rows.clone()]);
        // A row that was left out for another reason than that it is idle is not known.
        for (row, lower) in self.lower.iter_mut().enumerate().filter(|(_, lower)| !lower.is_finite()) {
            *lower = if m.idle.get(row) == Some(&true) { f64::NEG_INFINITY } else { f64::INFINITY };
        }
    }

    /// Returns true if every margin is at least `least` at these distances from the reference.
    pub fn are_beyond(&self, least: f64, off: &[f64]) -> bool {
        let mut slopes = self.slopes.chunks_exact(off.len().max(1));
        self.margins.iter().all(|h| slopes.next().is_some_and(|s| h - sum(s, off) >= least))
    }

    /// Returns true if every row is met at these distances from the reference, by a velocity of these sizes. `both` is storage.
    pub fn are_met(&self, off: &[f64], speeds: &[f64], both: &mut [f64]) -> bool {
        both.iter_mut().zip(speeds).zip(off).for_each(|((both, speed), off)| *both = speed.abs() + self.gain * off);
        let mut slopes = self.slopes.chunks_exact(off.len().max(1));
        self.lower.iter().all(|lower| slopes.next().is_some_and(|s| lower + sum(s, both) <= 0.0))
    }
}

/// Sum of products, in lanes so that it compiles to vector instructions.
pub(super) fn sum(a: &[f64], b: &[f64]) -> f64 {
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [0.0_f64; 4];
    for (a, b) in a.iter().zip(b) {
        for i in 0..4 {
            sums[i] += a[i] * b[i];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest
}

/// Inputs of the last decision other than signals.
pub(super) struct Decided {
    times: Times,
    velocity: Vec<f64>,
    stack_velocity: Vec<f64>,
}

impl Decided {
    pub fn new(nv: usize) -> Decided {
        Decided { times: Times::default(), velocity: vec![0.0; nv], stack_velocity: vec![0.0; nv] }
    }

    /// Notes the inputs of a decision.
    pub fn note(&mut self, inputs: TickInputs) {
        self.times = inputs.times;
        self.velocity.copy_from_slice(inputs.velocity);
        self.stack_velocity.copy_from_slice(inputs.stack_velocity);
    }

    /// The inputs, with the signals of now.
    pub fn inputs<'a>(&'a self, signals: &'a [f64]) -> TickInputs<'a> {
        TickInputs { times: self.times, signals, velocity: &self.velocity, stack_velocity: &self.stack_velocity }
    }
}

/// The stack at a configuration.
pub(super) struct Place {
    pub evaluator: Evaluator,
    /// Rows at this configuration, as the stack has them, of the tasks that were evaluated there.
    pub problem: Problem,
    q: Vec<f64>,
    /// Distance of each degree of freedom from the reference.
    pub off: Vec<f64>,
    /// True if this configuration and the reference are inside the limits of joints.
    is_inside: bool,
    /// True for each task that was evaluated there.
    is_known: Vec<bool>,
    has_values: bool,
    has_kinematics: bool,
    /// Targets that follow what they saw before, and are evaluated at each decision.
    remember: Vec<usize>,
}

impl Place {
    /// Prepares the stack of an evaluator once more.
    ///
    /// # Errors
    /// The stack cannot be executed, which was excluded when its controller was made.
    pub fn new(program: &Program, stack: &StackProgram) -> Result<Place, ProgramError> {
        let (mut evaluator, problem) = Evaluator::of_stack(program, stack)?;
        let members = evaluator.members().len();
        let is_target: Vec<bool> = evaluator.members().iter().map(|m| m.row_kind == RowKind::Equality).collect();
        let remembers = |i: &usize| is_target[*i] && evaluator.task_mut(*i).is_some_and(|task| task.as_any().is_some());
        Ok(Place {
            remember: (0..members).filter(remembers).collect(),
            q: program.robot.home.clone(),
            off: vec![0.0; program.robot.model.nv()],
            is_inside: false,
            is_known: vec![false; members],
            has_values: false,
            has_kinematics: false,
            evaluator,
            problem,
        })
    }

    /// Goes to a configuration, after the evaluator at the reference `q_d` was updated: nothing is known there yet.
    pub fn go(&mut self, q: &[f64], q_d: &[f64], leader: &Evaluator) {
        self.q.copy_from_slice(q);
        self.evaluator.model().difference(q, q_d, &mut self.off);
        self.off.iter_mut().for_each(|off| *off = off.abs());
        self.evaluator.follow(leader);
        self.is_known.fill(false);
        (self.has_values, self.has_kinematics) = (false, false);
        self.is_inside = leader.is_inside() && self.evaluator.is_within_limits(q);
    }

    /// Evaluates the targets that follow what they saw before.
    pub fn recall(&mut self, inputs: TickInputs) {
        for i in 0..self.remember.len() {
            self.look(self.remember[i], inputs);
        }
    }

    /// Returns true if bounds of gradients hold between the reference and here.
    pub fn has_bounds(&self) -> bool {
        self.is_inside
    }

    /// Evaluates a task here, unless that was done.
    pub fn look(&mut self, member: usize, inputs: TickInputs) {
        let Place { evaluator, problem, q, is_known, has_values, has_kinematics, .. } = self;
        if std::mem::replace(&mut is_known[member], true) {
            return;
        }
        if !std::mem::replace(has_values, true) {
            evaluator.begin_update(q, inputs);
        }
        if !evaluator.members()[member].constant && !std::mem::replace(has_kinematics, true) {
            evaluator.update_kinematics(q);
        }
        evaluator.update_one(member, q, inputs, problem);
    }

    /// Evaluates all tasks here, and passes the velocity `v` to them.
    pub fn look_at_all(&mut self, inputs: TickInputs, v: &[f64]) {
        (0..self.is_known.len()).for_each(|i| self.look(i, inputs));
        self.evaluator.observe(&self.q, v);
    }
}
