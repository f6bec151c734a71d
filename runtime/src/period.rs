//! The control period of a program and its gains: a gain `φ` overshoots where `φ T > 1`.
//!
//! A row is held for one period T. A target `J v = -φ e` then takes `φ T e` off its error, and a limit `J v >= -φ h` lets
//! `φ T h` of its margin be used up: with `φ T > 1` the error changes its sign at every tick, and a single step passes the
//! limit. The compiler refuses such gains (HQ0501) for the rate of the spec. A controller refuses them for the period of the
//! program that it is given, and [`Program::at_period`] says which they are.

use std::fmt;

use crate::evaluator::{Evaluator, build_tasks};
use crate::program::{Program, ProgramError, overshoots};

/// A gain that is too high for a period.
#[derive(Clone, Debug, PartialEq)]
pub struct HighGain {
    /// The task that has it; none for the tracking gain of the robot.
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

/// Why a program cannot run at a period.
#[derive(Clone, Debug, PartialEq)]
pub enum PeriodError {
    /// It is no positive, finite time.
    NotATime,
    /// Gains overshoot within it.
    HighGains {
        /// The period, in s.
        period: f64,
        /// The gains: that of the robot, then those of tasks in the order of the program.
        gains: Vec<HighGain>,
    },
    /// Something else does not go with it: a run that would be shorter than one tick, the gain of a safety field.
    Program(ProgramError),
}

impl fmt::Display for PeriodError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            PeriodError::NotATime => write!(f, "a control period is a positive, finite time"),
            PeriodError::HighGains { period, gains } => {
                let gains: Vec<String> = gains.iter().map(HighGain::to_string).collect();
                write!(
                    f,
                    "gains overshoot at a period of {period} s, where at most {} /s goes: {}",
                    1.0 / period,
                    gains.join(", ")
                )
            }
            PeriodError::Program(e) => write!(f, "{e}"),
        }
    }
}

impl std::error::Error for PeriodError {}

impl Program {
    /// The same program at another control period in s, as if its spec had been compiled for that rate.
    ///
    /// The deadline stays the same number of periods. Gains that move with time are held below one over the new period while
    /// the program runs. Rows that were proven to have no say at the old period are solved again. Scenarios are left out: what
    /// they expect is counted in ticks.
    ///
    /// # Errors
    /// The period is no positive, finite time; gains overshoot within it: all of them are named, of a gain that moves its
    /// value at the start; or something else of the program does not go with it.
    pub fn at_period(&self, period: f64) -> Result<Program, PeriodError> {
        if !(period.is_finite() && period > 0.0) {
            return Err(PeriodError::NotATime);
        }
        let mut program = self.clone();
        let robot = &mut program.robot;
        robot.deadline = period * (robot.deadline / robot.period);
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
            // What else depends on the period is told where tasks and planners are built, such as the gain of a field.
            Evaluator::new(&program, stack).map_err(PeriodError::Program)?;
        }
        Ok(program)
    }

    /// The gains that overshoot within the program's period: the robot's, then those of tasks, each task once.
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
