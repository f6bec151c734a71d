//! The parts of an execution that all kinds of mission share: how time passes, when a plan is repaired or made anew, how
//! long activities really take, and the log.
//!
//! An execution is a discrete-event [`Simulation`]. The kind supplies the state of those who take part with the steps that
//! happen by themselves ([`World`]), and how its plan is repaired ([`Replans`]); the loop over steps and the rule for planning
//! anew are here, once.

mod clock;
mod log;
mod replan;
mod simulation;

use serde::{Deserialize, Serialize};

pub use self::clock::DiscreteEvents;
pub use self::log::{NoFeasiblePlan, PlanChange, Record};
pub use self::replan::{Improved, Repaired, ReplanPolicy, Replans};
pub use self::simulation::{Simulation, World};

/// Source of the true durations of activities.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Durations {
    /// As planned.
    #[default]
    Planned,
    /// Drawn from the normal distribution of the activity, cut off at a hundredth of its mean. A draw depends on the seed and
    /// on names alone, so that it does not change with the plan.
    Sampled {
        /// Seed of the mission.
        seed: u64,
    },
}

/// Reaction of the plan to a difference between plan and world. Under each setting a late activity is waited for, and a loss
/// that leaves work without anybody to do it is planned for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Replan {
    /// Assignments and parameters stay: times move, feedback is logged and changes nothing.
    None,
    /// Assignments stay; feedback changes the parameters, times and speeds are repaired.
    Reschedule,
    /// As `reschedule`; and the part that has not begun is planned anew when its cost has changed too much.
    #[default]
    Both,
}
