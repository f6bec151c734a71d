//! `summary.json`: what a run came to, task by task and level by level, as data. [`SummaryRecorder`] gathers it.

pub use crate::tick::MARGIN_TOLERANCE;
use std::collections::BTreeMap;

use serde::Serialize;

use crate::record::expectations::ExpectationRecord;
use crate::record::held_back::HeldBack;
use crate::record::joint_motion::JointMotion;
use crate::record::slow_ticks::SlowTick;
use crate::record::verify::Verification;

pub use super::summarise::SummaryRecorder;

/// A run in numbers. SI units throughout.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the program.
    pub program: String,
    /// Ticks that were run.
    pub ticks: usize,
    /// Simulated time, in s.
    pub duration_s: f64,
    /// The run was stopped before its end, by whoever started it.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub interrupted: bool,
    /// True where every fault was answered and no margin fell below zero (by more than [`MARGIN_TOLERANCE`]).
    pub ok: bool,
    /// True where a fault that no transition answers keeps the robot still.
    #[serde(skip)]
    pub halted: bool,
    /// What became of the expectations of a scenario.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub expectations: Vec<ExpectationRecord>,
    /// Faults, in order. One that no transition answers keeps the robot still until the end.
    pub faults: Vec<FaultRecord>,
    /// States that the machine was in, in order; empty where none ran.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub states: Vec<StateRecord>,
    /// How many times each state was entered, those around others among them; without those that never were.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub entries: BTreeMap<String, u64>,
    /// Tasks, by name.
    pub tasks: BTreeMap<String, TaskSummary>,
    /// Levels, the most important first.
    pub levels: Vec<LevelSummary>,
    /// Levels that gave way to limits above them, where the solver tells.
    pub held_back: Vec<HeldBack>,
    /// How smoothly each joint moved, by name.
    pub joints: BTreeMap<String, JointMotion>,
    /// The second solver's opinion, if it was asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verification: Option<Verification>,
    /// Ticks whose budget was spent; none where there is no budget.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub late: Option<LateTicks>,
    /// Time of the controller per tick; without the ticks after a fault, which compute nothing.
    pub tick_us: TickTimes,
    /// What to do about limits that were passed by no more than sampling in time can lose.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub hints: Vec<String>,
    /// Files that were written.
    pub outputs: Vec<String>,
}

/// Ticks whose budget was spent before the hierarchy was solved: the robot made do with what was known of the answer, within its hard levels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LateTicks {
    /// The budget, in microseconds.
    pub budget_us: f64,
    /// Number of late ticks.
    pub ticks: usize,
    /// The most one after the other.
    pub in_a_row: usize,
    /// When the first was, in s; 0 if none was.
    pub first_s: f64,
}

/// A fault and when it came.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultRecord {
    /// Time, in s.
    pub time: f64,
    /// The word of its [`FaultKind`].
    pub kind: String,
    /// In words.
    pub text: String,
    /// A transition answered it; otherwise the robot was kept still from then on.
    pub answered: bool,
}

/// A stay in a state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StateRecord {
    /// The state's path.
    pub state: String,
    /// From when, in s.
    pub from_s: f64,
    /// Until when, in s.
    pub to_s: f64,
    /// How many times it was entered; more than once where it was left and entered anew at the same tick.
    pub entries: u64,
}

/// How a task fared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TaskSummary {
    /// Its type.
    pub kind: String,
    /// Its level.
    pub level: String,
    /// SI unit of the figures; `rad or m` where rows of several units stand in one task.
    pub unit: String,
    /// Limits: the smallest `h`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_margin: Option<f64>,
    /// Limits: the row that had it.
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
    /// When the smallest margin or the largest error was seen, in s.
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

/// The error of a part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartError {
    /// SI unit.
    pub unit: String,
    /// The largest.
    pub max: f64,
    /// At the last tick.
    #[serde(rename = "final")]
    pub last: f64,
    /// When the largest was seen, in s.
    pub at_s: f64,
}

/// How a level fared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LevelSummary {
    /// Its stack, where a machine ran.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stack: Option<String>,
    /// Its name.
    pub name: String,
    /// Takes no slack.
    pub hard: bool,
    /// Number of rows.
    pub rows: usize,
    /// Share of ticks at which the level could not be met in full.
    pub relaxed_share: f64,
    /// Share of ticks at which one of its inequality rows was at its bound.
    pub saturated_share: f64,
    /// The largest weighted norm of its slack.
    pub max_violation: f64,
    /// The fewest degrees of freedom that it left.
    pub min_freedom: usize,
}

/// Times of the ticks, in microseconds.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct TickTimes {
    /// Of all ticks.
    #[serde(flatten)]
    pub all: Percentiles,
    /// The slowest ticks, the slowest first, and what changed at them.
    pub slowest: Vec<SlowTick>,
}

/// Percentiles of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Percentiles {
    /// Half of the ticks took longer.
    pub median: f64,
    /// One in a hundred took longer.
    pub p99: f64,
    /// The longest.
    pub max: f64,
}

impl Percentiles {
    /// Of a sample, which is sorted in place; zeros for an empty one.
    pub fn of(sample: &mut [f32]) -> Percentiles {
        if sample.is_empty() {
            return Percentiles::default();
        }
        sample.sort_unstable_by(f32::total_cmp);
        let at = |share: f64| f64::from(sample[((sample.len() - 1) as f64 * share).round() as usize]);
        Percentiles { median: at(0.5), p99: at(0.99), max: at(1.0) }
    }
}
