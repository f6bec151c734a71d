//! Counts of an execution: the measures of Tables 1 and 2 of the paper, and how the planner fared.

use serde::Serialize;

/// Counts of an execution.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Counts {
    /// Contacts between members, each counted once while it lasts.
    pub collisions: usize,
    /// Times at which the team lost its connection.
    pub disconnections: usize,
    /// Targets that a second member came to take.
    pub redundant: usize,
    /// Periods for which a plan was made.
    pub plans: usize,
    /// Periods in which the last plan went on, as there was no new one in time.
    pub kept: usize,
    /// Periods without a plan.
    pub without_plan: usize,
    /// Periods with a plan after whose first period it was not known that all robots can give way to the person.
    pub exposed: usize,
    /// The largest gap of a plan to the best one.
    pub worst_gap: f64,
    /// The smallest distance between a robot and the person (m), of their bodies; negative: the depth of a contact.
    pub closest: Option<f64>,
}

impl Counts {
    /// Notes a distance between a robot and the person (m).
    pub fn near(&mut self, distance: f64) {
        self.closest = Some(self.closest.map_or(distance, |closest| closest.min(distance)));
    }
}
