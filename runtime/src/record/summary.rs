//! `summary.json`: the results of a run as data, task by task and level by level. [`SummaryRecorder`] gathers them.

pub use crate::tick::MARGIN_TOLERANCE;
use std::collections::BTreeMap;

use serde::Serialize;

use crate::physics::PlantRecord;
use crate::program::AllowedWarning;
use crate::record::expectations::ExpectationRecord;
use crate::record::held_back::HeldBack;
use crate::record::joint_motion::JointMotion;
use crate::record::slow_ticks::SlowTick;
use crate::record::verify::Verification;
use crate::stopping::Stopping;

pub use super::remarks::MANY_FAULTS;
pub use super::summarise::SummaryRecorder;

/// Results of a run. SI units throughout.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the program.
    pub program: String,
    /// Ticks that were run.
    pub ticks: usize,
    /// Simulated time, in s.
    pub duration_s: f64,
    /// True if the run was stopped before its end, by its caller.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub interrupted: bool,
    /// Reason why the run ended early: the simulation of its robot has diverged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diverged: Option<String>,
    /// The physics that moved the robot, if it had masses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plant: Option<PlantRecord>,
    /// True if every fault was answered, no margin fell below zero (by more than [`MARGIN_TOLERANCE`]), and the run did not
    /// diverge.
    pub ok: bool,
    /// True if at the end a fault keeps the robot still: no transition answers it, or its transition leads to the state in
    /// which it occurred.
    #[serde(skip)]
    pub halted: bool,
    /// Results of the expectations of a scenario.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub expectations: Vec<ExpectationRecord>,
    /// Faults, in order. A fault that no transition answers keeps the robot halted until the end, one whose transition leads
    /// to the state in which it occurred until the machine leaves that state.
    pub faults: Vec<FaultRecord>,
    /// States that the machine was in, in order; empty if no machine ran.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub states: Vec<StateRecord>,
    /// Number of entries into each state, including states around others, without states that were never entered.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub entries: BTreeMap<String, u64>,
    /// Bounds of the time and of the way to rest, for each stack that the run can enter.
    pub stopping: Vec<Stopping>,
    /// Tasks, by name.
    pub tasks: BTreeMap<String, TaskSummary>,
    /// Levels, the most important first.
    pub levels: Vec<LevelSummary>,
    /// Levels that limits above them held back, as far as the solver reports this.
    pub held_back: Vec<HeldBack>,
    /// Smoothness of the motion of each joint, by name.
    pub joints: BTreeMap<String, JointMotion>,
    /// Comparison with the second solver, if it was requested.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verification: Option<Verification>,
    /// Ticks whose budget was spent; `None` if there is no budget.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub late: Option<LateTicks>,
    /// Wait for the first value of a signal, during which the robot stood still; `None` if there was none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub waited: Option<Waited>,
    /// Computing time of the controller per tick, without the ticks after a fault, which compute nothing.
    pub tick_us: TickTimes,
    /// Remarks of the verdict, although no limit was passed: targets that were never reached, a machine that changes its state
    /// at every tick, many handled faults.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<String>,
    /// Hints for limits that were violated by no more than sampling in time can lose.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub hints: Vec<String>,
    /// Warnings of the compiler that the spec allows.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub allowed: Vec<AllowedWarning>,
    /// Files that were written.
    pub outputs: Vec<String>,
}

/// Ticks whose budget was spent before the hierarchy was solved. Their velocities used the part of the answer that was
/// known, within the hard levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LateTicks {
    /// Budget, in microseconds.
    pub budget_us: f64,
    /// Number of late ticks.
    pub ticks: usize,
    /// Largest number of consecutive late ticks.
    pub in_a_row: usize,
    /// Time of the first late tick, in s; 0 if there was none.
    pub first_s: f64,
}

/// Wait for the first value of a signal that a stack needs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Waited {
    /// The signal; of several, the last one that was missing.
    pub signal: String,
    /// Time of the first tick at which the robot waited, in s.
    pub from_s: f64,
    /// Number of ticks.
    pub ticks: usize,
}

/// A fault and its time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultRecord {
    /// Time, in s.
    pub time: f64,
    /// The word of its [`FaultKind`].
    pub kind: String,
    /// Description of the fault.
    pub text: String,
    /// True if a transition answered it; otherwise the robot stood still from then on.
    pub answered: bool,
}

/// A stay in a state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StateRecord {
    /// Path of the state.
    pub state: String,
    /// Start, in s.
    pub from_s: f64,
    /// End, in s.
    pub to_s: f64,
    /// Number of entries; more than one if the state was left and entered again at the same tick.
    pub entries: u64,
}

/// Results of a task.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TaskSummary {
    /// Its type.
    pub kind: String,
    /// Its level.
    pub level: String,
    /// SI unit of the figures; `rad or m` if one task has rows of several units.
    pub unit: String,
    /// Limits: the smallest `h`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_margin: Option<f64>,
    /// Limits: the row with the smallest `h`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_margin_row: Option<String>,
    /// Limits: the SI unit of that row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_margin_unit: Option<String>,
    /// Limits: the smallest `h` at the last tick.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub final_margin: Option<f64>,
    /// Targets: the largest norm of the error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_error: Option<f64>,
    /// Targets: the norm of the error at the last tick.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub final_error: Option<f64>,
    /// Targets with several parts: each part's largest and last error.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub errors: BTreeMap<String, PartError>,
    /// Time of the smallest margin or the largest error, in s.
    pub at_s: f64,
    /// Limits: share of ticks at which some row was at its bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub active_share: Option<f64>,
    /// Limits: rows that were ever at their bound.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub active_rows: Vec<String>,
    /// Ticks at which a row was undefined and left free.
    pub undefined_ticks: usize,
}

/// Error of a part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartError {
    /// SI unit.
    pub unit: String,
    /// Largest error.
    pub max: f64,
    /// Error at the last tick.
    #[serde(rename = "final")]
    pub last: f64,
    /// Time of the largest error, in s.
    pub at_s: f64,
}

/// Results of a level.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LevelSummary {
    /// Its stack, if a machine ran.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stack: Option<String>,
    /// Its name.
    pub name: String,
    /// True if it takes no slack.
    pub hard: bool,
    /// Number of rows.
    pub rows: usize,
    /// Share of ticks at which the level could not be met in full.
    pub relaxed_share: f64,
    /// Share of ticks at which one of its inequality rows was at its bound.
    pub saturated_share: f64,
    /// Largest weighted norm of its slack.
    pub max_violation: f64,
    /// Smallest number of degrees of freedom that it left.
    pub min_freedom: usize,
}

/// Times of the ticks, in microseconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TickTimes {
    /// Percentiles of all ticks.
    #[serde(flatten)]
    pub all: Percentiles,
    /// Slowest ticks, the slowest first, with the rows that changed at them.
    pub slowest: Vec<SlowTick>,
}

/// Percentiles of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Percentiles {
    /// Median: half of the ticks took longer.
    pub median: f64,
    /// Time that one tick in a hundred exceeded.
    pub p99: f64,
    /// Longest time.
    pub max: f64,
}

impl Percentiles {
    /// Percentiles of a sample, which is sorted in place; zeros for an empty one.
    pub fn of(sample: &mut [f32]) -> Percentiles {
        if sample.is_empty() {
            return Percentiles::default();
        }
        sample.sort_unstable_by(f32::total_cmp);
        let at = |share: f64| f64::from(sample[((sample.len() - 1) as f64 * share).round() as usize]);
        Percentiles { median: at(0.5), p99: at(0.99), max: at(1.0) }
    }
}
