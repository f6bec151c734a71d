//! A safety field between people and the robot, and the planner that keeps it above a threshold: thesis 4.2, corrected.
//!
//! [`Field`] measures how far all of the robot is from all observed points of a person, with exact derivatives.
//! [`Decomposition`] splits its rate into what the clock of a protected task, deviations from its path, internal motion
//! and the person contribute. [`SafetyPlanner`] decides on these inputs. [`SpeedAndSeparation`] is the rule of ISO/TS
//! 15066. Nothing here knows the hierarchy: the controller passes rows in and puts what comes out back into its levels.
//!
//! Everything is allocated by constructors; what runs in a tick neither allocates nor panics.

mod body;
mod chi;
mod decomposition;
mod deviation;
mod error;
mod field;
mod line;
mod one_row;
mod planner;
mod quadrature;
mod segment;
mod separation;
mod strategy;

pub use body::{Attached, Body, LinkSegment};
pub use chi::{Chi, DistanceFunction};
pub use decomposition::{Damping, Decomposition, Push, TaskRows};
pub use deviation::{Deviation, DeviationKind, Direction, Frame, towards};
pub use error::SafetyError;
pub use field::{Field, HumanPoint, Over};
pub use line::line_mean;
pub use one_row::{OneRowProgram, Outcome};
pub use planner::{Plan, PlannerSettings, SafetyPlanner, Tick, Weights};
pub use quadrature::GaussLegendre;
pub use segment::{Mean, mean_distance};
pub use separation::{SpeedAndSeparation, Stopping, Verdict};
pub use strategy::{Strategy, task_share};

#[cfg(test)]
mod testing;
