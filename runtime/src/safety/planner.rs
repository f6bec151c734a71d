//! The safety planner: thesis 4.2.3, Algorithm 1, in sampled time.
//!
//! At each tick it decides the clock's speed `u_c`, the deviations `u_a` and the internal motion `u_n` of a protected
//! task so that, with `h = F - F_min`,
//!
//! ```text
//! mu_1 u_c + mu_2 . u_a + mu_3 . u_n + w >= F_min' - k_f h - mu_4                      (4.30) with a moving threshold
//! ```
//!
//! as near as possible to `u_c = 1`, `u_a = 0`, `u_n = k_n dF/dq` (4.31), inside the bounds (4.28), (4.29). The row is
//! soft: `w` is the part of the demand that is not met. If levels above the task would withhold part of the planned
//! motion, they are included in the program ([`limited`]).
//!
//! [`limited`]: LimitedProgram

use nalgebra::{UnitQuaternion, Vector3};
use solver::{Level, LevelShape};

use crate::safety::decomposition::{Damping, Decomposition, Push, TaskRows, axpy, dot};
use crate::safety::deviation::{Course, Deviation, Frame};
use crate::safety::limited::{LimitedInputs, LimitedProgram, LimitedSolution, RowCurvature, breaks};
use crate::safety::one_row::{OneRowProgram, Outcome};
use crate::safety::strategy::{Strategy, task_share};
use stdlib_tasks::field::Field;
use stdlib_tasks::field::{SafetyError, finite, gain, setting};

/// Part of the field's rate that levels above may withhold without a new plan, in the field's unit per second.
const WITHHELD: f64 = 1e-6;

/// Diagonal of Q and weight of the slack, thesis (4.27). Deviations have weights of their own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// Weight of `u_c`: with a large one, the planner deviates rather than slows down.
    pub clock: f64,
    /// Weight of each entry of `u_n`.
    pub internal: f64,
    /// q_w: large compared with the others; otherwise the row is met only in part although the inputs could meet it.
    pub slack: f64,
}

impl Default for Weights {
    fn default() -> Self {
        Weights { clock: 1.0, internal: 1.0, slack: 1e6 }
    }
}

/// Settings of a planner.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannerSettings {
    /// Control period P \[s\].
    pub period: f64,
    /// k_f \[1/s\]: rate at which the margin may be used up; times the period at most 1.
    pub gain: f64,
    /// k_n: internal motion along the field's gradient, in 1/s times the square of a joint's unit over the field's; 0
    /// for no internal motion unless the row needs it.
    pub internal_gain: f64,
    /// Largest internal speed of each degree of freedom, rad/s or m/s; infinite for no bound, zero for no internal
    /// motion. One number for each degree of freedom.
    pub internal_speed: Vec<f64>,
    /// Weights of the inputs and of the slack.
    pub weights: Weights,
    /// Deviations of the task from its path. Each has rows of its own.
    pub deviations: Vec<Deviation>,
    /// Damping near singularities of the task.
    pub damping: Damping,
    /// The planner or a baseline.
    pub strategy: Strategy,
}

/// Inputs of the planner at a tick. Slices belong to the caller.
#[derive(Clone, Copy, Debug)]
pub struct Tick<'a> {
    /// Safety field, updated at this tick.
    pub field: &'a Field,
    /// F_min.
    pub threshold: f64,
    /// Its rate, per s; zero if it does not move.
    pub threshold_rate: f64,
    /// Protected task: its rates along the clock, and its feedback towards the safe target.
    pub task: TaskRows<'a>,
    /// One frame for each deviation.
    pub frames: &'a [Frame],
    /// Levels above the protected task, as they are at this tick. The baselines ignore them.
    pub above: &'a [Level],
}

/// Decision of the planner. All buffers belong to the planner.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// h = F - F_min.
    pub margin: f64,
    /// Smallest rate of the field that is demanded, `F_min' - k_f h`.
    pub need: f64,
    /// Speed of the clock, 0 to 1.
    pub u_c: f64,
    /// Deviation inputs, m/s or rad/s.
    pub u_alpha: Vec<f64>,
    /// Internal velocity, n numbers: the target of a level `v = u_n` below the task. In a plan that was made below
    /// limits it is the whole velocity.
    pub u_n: Vec<f64>,
    /// w and the row's multiplier.
    pub outcome: Outcome,
    /// m of [`Strategy::Evasive`]; 1 for the others.
    pub task_share: f64,
    /// nu_s = eta u_c + dnu, m numbers: rates of the task's rows, in place of those of their target, (4.8).
    pub rate: Vec<f64>,
    /// Expected velocity, n numbers: that of the law, whose rate of F is the sum of the parts; or that of a plan below
    /// limits, whose rate is not such a sum.
    pub velocity: Vec<f64>,
    /// dF/dt at that velocity, including the contribution of the people.
    pub field_rate: f64,
}

/// The planner: the clock, the deviations, and storage for everything.
pub struct SafetyPlanner {
    settings: PlannerSettings,
    clock: f64,
    courses: Vec<Course>,
    pushes: Vec<Push>,
    springs: Vec<f64>,
    work: Vec<f64>,
    x: Vec<f64>,
    limited: LimitedProgram,
    parts: Decomposition,
    program: OneRowProgram,
    plan: Plan,
}

impl SafetyPlanner {
    /// Creates a planner for a task of `rows` rows, below levels of the shapes `above`, on a robot with `dofs` degrees
    /// of freedom.
    ///
    /// # Errors
    /// [`SafetyError::Setting`], [`SafetyError::Overshoot`] for a gain or stiffness that overshoots within the period,
    /// [`SafetyError::Shape`] for deviations that exceed the rows or share some, and for a wrong number of internal
    /// speeds.
    pub fn new(
        settings: PlannerSettings,
        rows: usize,
        dofs: usize,
        above: &[LevelShape],
    ) -> Result<SafetyPlanner, SafetyError> {
        let s = &settings;
        setting("period", s.period, s.period > 0.0 && s.period.is_finite(), "positive and finite")?;
        gain("field gain", s.gain, s.period)?;
        let positive = |x: f64| x > 0.0 && x.is_finite();
        setting("internal gain", s.internal_gain, s.internal_gain == 0.0 || positive(s.internal_gain), "not negative")?;
        for (name, w) in [("clock", s.weights.clock), ("internal", s.weights.internal), ("slack", s.weights.slack)] {
            setting(name, w, positive(w), "a positive and finite weight")?;
        }
        if let Strategy::Evasive { band } = s.strategy {
            setting("band", band, band > 0.0 && band < 1.0, "between 0 and 1")?;
        }
        if s.internal_speed.len() != dofs {
            return Err(SafetyError::Shape { name: "internal speeds" });
        }
        for v in &s.internal_speed {
            setting("internal speed", *v, *v >= 0.0, "not negative")?;
        }
        let courses = s.deviations.iter().map(|d| Course::new(*d, rows, s.period)).collect::<Result<Vec<_>, _>>()?;
        let k = courses.len();
        let apart = |a: &Deviation, b: &Deviation| a.row.abs_diff(b.row) >= 3;
        if !(0..k).all(|i| (0..i).all(|j| apart(&s.deviations[i], &s.deviations[j]))) {
            return Err(SafetyError::Shape { name: "deviations" });
        }
        let parts = Decomposition::new(rows, dofs, k, s.damping)?;
        let mut program = OneRowProgram::new(1 + k + dofs);
        program.slack_weight = s.weights.slack;
        program.weight[0] = s.weights.clock;
        (program.nominal[0], program.lower[0], program.upper[0]) = (1.0, 0.0, 1.0);
        for (w, d) in program.weight[1..].iter_mut().zip(&s.deviations) {
            *w = d.weight;
        }
        for (i, v) in s.internal_speed.iter().enumerate() {
            program.weight[1 + k + i] = s.weights.internal;
            (program.lower[1 + k + i], program.upper[1 + k + i]) = (-v, *v);
        }
        let plan = Plan {
            margin: f64::INFINITY,
            need: f64::NEG_INFINITY,
            u_c: 0.0,
            u_alpha: vec![0.0; k],
            u_n: vec![0.0; dofs],
            outcome: Outcome::default(),
            task_share: 1.0,
            rate: vec![0.0; rows],
            velocity: vec![0.0; dofs],
            field_rate: 0.0,
        };
        Ok(SafetyPlanner {
            clock: 0.0,
            pushes: vec![Push { row: 0, along: Vector3::zeros() }; k],
            springs: vec![0.0; rows],
            work: vec![0.0; rows],
            x: vec![0.0; 1 + k + dofs],
            courses,
            limited: LimitedProgram::new(rows, k, dofs, above),
            parts,
            program,
            plan,
            settings,
        })
    }

    /// Sets the curvature of the rows. Below limits, a demand that cannot be met is then met as far as the prediction
    /// holds over a step of one period, with plans of the same kind at every tick. Without the curvature, it is met as
    /// far as the linear rows allow, and plans may jump.
    pub fn set_curvature(&mut self, given: &RowCurvature) {
        self.limited.set_curvature(given);
    }

    /// Returns to the nominal path, with the clock at `c` \[s\], at the entry of the stack that contains the task.
    pub fn restart(&mut self, c: f64) {
        self.clock = c;
        self.limited.forget();
        self.courses.iter_mut().for_each(Course::reset);
    }

    /// Goes on where the same planner of another stack is, whose levels above the task may differ.
    pub fn take_over(&mut self, from: &mut SafetyPlanner) {
        self.clock = from.clock;
        self.limited.forget();
        std::mem::swap(&mut self.courses, &mut from.courses);
    }

    /// Control period P \[s\].
    pub fn period(&self) -> f64 {
        self.settings.period
    }

    /// Clock c \[s\]: the time at which the nominal target is evaluated.
    pub fn clock(&self) -> f64 {
        self.clock
    }

    /// Offset of deviation `i` from its nominal position \[m\]; zero for an orientation or an index out of range.
    pub fn offset(&self, i: usize) -> Vector3<f64> {
        self.courses.get(i).map_or_else(Vector3::zeros, |c| c.offset)
    }

    /// Rotation of deviation `i` from its nominal orientation: `R_s = R_d * turn`; the identity for a position or an
    /// index out of range.
    pub fn turn(&self, i: usize) -> UnitQuaternion<f64> {
        self.courses.get(i).map_or_else(UnitQuaternion::identity, |c| c.turn)
    }

    /// Last decision.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Parts of dF/dt at the last tick.
    pub fn parts(&self) -> &Decomposition {
        &self.parts
    }

    /// Decides about this tick; [`SafetyPlanner::advance`] applies the decision. Never allocates.
    ///
    /// # Errors
    /// [`SafetyError::Shape`] and [`SafetyError::NotFinite`] about the arguments. The plan must then not be used; clock
    /// and deviations are unchanged.
    pub fn decide(&mut self, tick: &Tick) -> Result<(), SafetyError> {
        let field = tick.field;
        if field.value().is_nan() {
            return Err(SafetyError::NotFinite { name: "safety field" });
        }
        finite("threshold", &[tick.threshold, tick.threshold_rate])?;
        if tick.frames.len() != self.courses.len() {
            return Err(SafetyError::Shape { name: "frames" });
        }
        self.plan.margin = field.value() - tick.threshold;
        self.plan.need = tick.threshold_rate - self.settings.gain * self.plan.margin;
        self.divide(tick)?;
        self.choose(tick)?;
        self.follow(tick)
    }

    /// Computes the contribution of each input to the rate of the field.
    fn divide(&mut self, tick: &Tick) -> Result<(), SafetyError> {
        self.parts.factorise(&tick.task, tick.field.gradient())?;
        self.springs.fill(0.0);
        for ((course, frame), push) in self.courses.iter_mut().zip(tick.frames).zip(&mut self.pushes) {
            course.see(frame, self.parts.task_gradient())?;
            let row = course.of.row;
            *push = Push { row, along: course.along };
            for (s, e) in self.springs[row..row + 3].iter_mut().zip(course.error.iter()) {
                *s = course.of.stiffness * e;
            }
        }
        self.parts.split(&tick.task, &self.pushes, &self.springs, tick.field.human_rate())
    }

    /// Chooses the inputs.
    fn choose(&mut self, tick: &Tick) -> Result<(), SafetyError> {
        let (k, s) = (self.courses.len(), &self.settings);
        let plan = &mut self.plan;
        plan.task_share = 1.0;
        plan.outcome = Outcome::default();
        plan.u_alpha.fill(0.0);
        for (u, g) in plan.u_n.iter_mut().zip(tick.field.gradient()) {
            *u = s.internal_gain * g;
        }
        match s.strategy {
            Strategy::Program => {
                let program = &mut self.program;
                program.row[0] = self.parts.mu_1;
                program.row[1..=k].copy_from_slice(&self.parts.mu_2);
                program.row[1 + k..].copy_from_slice(&self.parts.mu_3);
                program.need = plan.need - self.parts.mu_4;
                program.nominal[1 + k..].copy_from_slice(&plan.u_n);
                for (i, course) in self.courses.iter().enumerate() {
                    [program.lower[1 + i], program.upper[1 + i]] = course.bounds(s.gain, s.period);
                }
                plan.outcome = program.solve(&mut self.x)?;
                plan.u_c = self.x[0];
                plan.u_alpha.copy_from_slice(&self.x[1..=k]);
                plan.u_n.copy_from_slice(&self.x[1 + k..]);
            }
            Strategy::Evasive { band } => {
                plan.u_c = 1.0;
                plan.task_share = task_share(tick.field.value(), tick.threshold, band);
            }
            Strategy::Stop => {
                plan.u_c = f64::from(u8::from(plan.margin > 0.0));
                plan.u_n.fill(0.0);
            }
        }
        Ok(())
    }

    /// Computes the rates that follow from the inputs.
    fn rates(&mut self, tick: &Tick) {
        let plan = &mut self.plan;
        for (i, rate) in plan.rate.iter_mut().enumerate() {
            *rate = tick.task.eta[i] * plan.u_c - self.springs[i];
        }
        for (push, u) in self.pushes.iter().zip(&plan.u_alpha) {
            axpy(*u, push.along.as_slice(), &mut plan.rate[push.row..push.row + 3]);
        }
    }

    /// Computes the rates and the velocity that follow from the inputs.
    fn follow(&mut self, tick: &Tick) -> Result<(), SafetyError> {
        self.rates(tick);
        let plan = &mut self.plan;
        for ((w, rate), feedback) in self.work.iter_mut().zip(&plan.rate).zip(tick.task.feedback) {
            *w = rate + feedback;
        }
        plan.velocity.copy_from_slice(&plan.u_n);
        self.parts.law(&tick.task, &mut self.work, &mut plan.velocity);
        if plan.task_share < 1.0 {
            // (4.50): u_n + m (J^+ (r - J u_n))
            for (v, u) in plan.velocity.iter_mut().zip(&plan.u_n) {
                *v = u + plan.task_share * (*v - u);
            }
        }
        plan.field_rate = tick.field.rate(&plan.velocity);
        finite("plan", &plan.velocity)?;
        finite("plan", &plan.rate)
    }

    /// Checks the velocity `x` that the hierarchy computed from the plan of this tick. If levels above the task
    /// withhold some of the rate that the field needs, decides again, below these levels, and returns true if the new
    /// plan is better. If it is not, the slack of the plan becomes the shortfall of the hierarchy. Never allocates.
    ///
    /// # Errors
    /// Those of [`SafetyPlanner::decide`]; the plan must then not be used.
    pub fn reconsider(&mut self, tick: &Tick, x: &[f64]) -> Result<bool, SafetyError> {
        let plan = &self.plan;
        let short = plan.need - tick.field.rate(x);
        let is_program = matches!(self.settings.strategy, Strategy::Program);
        // One part of the slack is left by choice of the weights; the other part, `forced`, no inputs can remove.
        let forced = self.program.shortage();
        let unmet =
            forced > WITHHELD && self.limited.has_curvature() && tick.above.iter().any(|level| level.rows() > 0);
        let withheld = short > plan.outcome.slack + WITHHELD && breaks(tick.above, &plan.velocity);
        if !is_program || !(unmet || withheld) {
            return Ok(false);
        }
        let now = LimitedInputs {
            above: tick.above,
            task: tick.task,
            pushes: &self.pushes,
            springs: &self.springs,
            gradient: tick.field.gradient(),
            need: plan.need - (plan.outcome.slack - forced).max(0.0) - tick.field.human_rate(),
            program: &self.program,
            parts: &self.parts,
        };
        let found = self.limited.solve(&now).map(|found| {
            let rate = tick.field.rate(found.velocity);
            (found, rate, (plan.need - rate).max(0.0))
        });
        let better =
            |(found, _, slack): &(LimitedSolution, f64, f64)| unmet || found.damped || slack + WITHHELD <= short;
        let Some((LimitedSolution { velocity, inputs, .. }, rate, slack)) = found.filter(better) else {
            // The first plan is kept, with the shortfall of the hierarchy as its slack.
            self.plan.outcome.slack = short;
            return Ok(false);
        };
        let plan = &mut self.plan;
        let within = |i: usize| inputs[i].clamp(self.program.lower[i], self.program.upper[i]);
        plan.u_c = within(0);
        plan.u_alpha.iter_mut().enumerate().for_each(|(i, u)| *u = within(1 + i));
        plan.u_n.copy_from_slice(velocity);
        plan.velocity.copy_from_slice(velocity);
        plan.field_rate = rate;
        plan.outcome = Outcome { multiplier: self.settings.weights.slack * slack, slack };
        self.rates(tick);
        if self.limited.is_task_damped() {
            // The hierarchy must meet the task as far as this plan does, and no further.
            let n = self.plan.velocity.len();
            for (i, rate) in self.plan.rate.iter_mut().enumerate() {
                *rate = dot(tick.task.row(i, n), &self.plan.velocity) - tick.task.feedback[i];
            }
        }
        finite("plan", &self.plan.velocity)?;
        finite("plan", &self.plan.rate)?;
        Ok(true)
    }

    /// Advances the clock and the deviations by a part of a period, as decided: by all of it, unless the task waits for the robot.
    pub fn advance(&mut self, part: f64) {
        let period = part * self.settings.period;
        self.clock += self.plan.u_c * period;
        for (course, u) in self.courses.iter_mut().zip(&self.plan.u_alpha) {
            course.advance(*u, period);
        }
    }
}

#[cfg(test)]
#[path = "planner_tests.rs"]
mod tests;
