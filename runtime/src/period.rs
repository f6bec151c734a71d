//! Control period of a program and its gains: a gain `φ` overshoots if `φ T > 1`.
//!
//! A row is held for one period T. A target `J v = -φ e` then reduces its error by `φ T e`, and a limit `J v >= -φ h`
//! allows `φ T h` of its margin to be used up. With `φ T > 1` the error changes its sign at every tick, and a single
//! step passes the limit. The compiler rejects such gains (HQ0501) for the rate of the spec. A controller rejects them
//! for the period of its program, and [`Program::at_period`] lists them.

use std::fmt;

use crate::evaluator::{Evaluator, build_tasks};
use crate::program::{Program, ProgramError, overshoots};

/// A gain that is too high for a period.
#[derive(Clone, Debug, PartialEq)]
pub struct HighGain {
    /// Task that has it; `None` for the tracking gain of the robot.
    pub task: Option<String>,
    /// The gain, in 1/s.
    pub gain: f64,
}

impl fmt::Display for HighGain {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.task {
            Some(task) => write!(f, "{} /s of task `{task}`", self.gain),
            None => write!(f, "{} /s of the robot's `tracking_gain`", self.gain),
        }
    }
}

/// Reason why a program cannot run at a period.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PeriodError {
    /// It is not a positive, finite time.
    #[error("a control period is a positive, finite time")]
    NotATime,
    /// Gains overshoot within it.
    #[error("gains overshoot at a period of {period} s, where at most {} /s goes: {}", 1.0 / period, joined(gains))]
    HighGains {
        /// The period, in s.
        period: f64,
        /// The gain of the robot, then those of tasks in the order of the program.
        gains: Vec<HighGain>,
    },
    /// Another part is incompatible with it: a run that would be shorter than one tick, or the gain of a safety field.
    #[error(transparent)]
    Program(ProgramError),
}

fn joined(gains: &[HighGain]) -> String {
    gains.iter().map(HighGain::to_string).collect::<Vec<_>>().join(", ")
}

/// Longest time between two calls that is no fault, where a spec declares none, in s: two periods, and at least a period and what an ordinary
/// kernel may take.
pub fn default_deadline(period: f64) -> f64 {
    (2.0 * period).max(period + 0.02)
}

impl Program {
    /// Returns the program at another control period in s, as if its spec had been compiled for that rate.
    ///
    /// A declared deadline remains the same number of periods. Gains that move with time are limited to one over the new
    /// period while the program runs. Rows that were proven idle at the old period are solved again. Scenarios are
    /// removed, because their expectations are counted in ticks.
    ///
    /// # Errors
    /// The period is not a positive, finite time; or gains overshoot within it, all of which are listed (a moving gain
    /// with its initial value); or another part of the program is incompatible with it.
    pub fn at_period(&self, period: f64) -> Result<Program, PeriodError> {
        if !(period.is_finite() && period > 0.0) {
            return Err(PeriodError::NotATime);
        }
        let mut program = self.clone();
        let robot = &mut program.robot;
        // A deadline that nobody declared is that of the new period.
        let by_default = robot.deadline == default_deadline(robot.period);
        robot.deadline = if by_default { default_deadline(period) } else { period * (robot.deadline / robot.period) };
        robot.period = period;
        program.values.ranges.iter_mut().filter(|r| r.gain).for_each(|r| r.max = Some(1.0 / period));
        program.stacks.iter_mut().flat_map(|s| &mut s.levels).flat_map(|l| &mut l.members).for_each(|m| m.idle.clear());
        program.scenarios.clear();
        let gains = program.high_gains();
        if !gains.is_empty() {
            return Err(PeriodError::HighGains { period, gains });
        }
        program.check().map_err(PeriodError::Program)?;
        for stack in 0..program.stacks.len() {
            // Other dependencies on the period, such as the gain of a field, are checked when tasks and planners are
            // built.
            Evaluator::new(&program, stack).map_err(PeriodError::Program)?;
        }
        Ok(program)
    }

    /// Gains that overshoot within the program's period: the robot's, then those of tasks, each task once.
    fn high_gains(&self) -> Vec<HighGain> {
        let (robot, values) = (&self.robot, &self.values.initial);
        let tracking = overshoots(robot.tracking_gain, robot.period);
        let mut found: Vec<HighGain> =
            tracking.then_some(HighGain { task: None, gain: robot.tracking_gain }).into_iter().collect();
        let mut highest = vec![0.0_f64; self.tasks.len()];
        for stack in &self.stacks {
            let built = build_tasks(self, stack);
            for (member, built) in stack.levels.iter().flat_map(|l| &l.members).zip(built) {
                let gains = built.task.map(|task| task.gains(values)).unwrap_or_default();
                highest[member.task] = gains.into_iter().fold(highest[member.task], f64::max);
            }
        }
        let high = self.tasks.iter().zip(highest).filter(|(_, gain)| overshoots(*gain, robot.period));
        found.extend(high.map(|(task, gain)| HighGain { task: Some(task.name.clone()), gain }));
        found
    }
}
