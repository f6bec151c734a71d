//! The parts of a plan that all kinds of mission share: activities, cost, status of the search.
//!
//! Each kind has its own type of activity. A plan can be printed, drawn, compared, and checked by a validator that is
//! independent of the planner; the rest of the program reads it as data ([`crate::planned`]) and as a chart
//! ([`crate::chart`]).

use serde::{Deserialize, Serialize};

/// Limit that ended a search before its proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Limit {
    /// The time limit of the budget: another run may get further.
    Time,
    /// The nodes or conflicts of the budget: every run stops here.
    Work,
    /// The rounds of the outer loop, or the numerical accuracy of the engine: every run stops here.
    Accuracy,
}

/// Status of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// No plan costs less than `bound`, and the cost of this one exceeds it by at most the requested gap.
    Proven {
        /// Lower bound on the cost of every plan.
        bound: f64,
    },
    /// The best plan found before a limit ended the search.
    Gap {
        /// Lower bound on the cost of every plan.
        bound: f64,
        /// `(cost - bound) / cost`, from 0 to 1.
        gap: f64,
        /// Limit that ended the search.
        stopped: Limit,
    },
    /// A valid plan without a bound: repaired from another one, or given.
    Unbounded {
        /// Limit that ended a search before its proof, if any.
        stopped: Option<Limit>,
    },
}

impl Status {
    /// Returns the limit that ended the search before its proof, if any.
    pub fn stopped(&self) -> Option<Limit> {
        match self {
            Status::Proven { .. } => None,
            Status::Gap { stopped, .. } => Some(*stopped),
            Status::Unbounded { stopped } => *stopped,
        }
    }

    /// Returns the same status with a bound that does not exceed the cost of the plan, as it may by rounding.
    pub fn at_cost(self, cost: f64) -> Status {
        match self {
            Status::Proven { bound } => Status::Proven { bound: bound.min(cost) },
            Status::Gap { bound, gap, stopped } => Status::Gap { bound: bound.min(cost), gap, stopped },
            Status::Unbounded { stopped } => Status::Unbounded { stopped },
        }
    }

    /// Returns the lower bound on the cost of every plan, if there is one.
    pub fn bound(&self) -> Option<f64> {
        match self {
            Status::Proven { bound } | Status::Gap { bound, .. } => Some(*bound),
            Status::Unbounded { .. } => None,
        }
    }
}

/// Statistics of a search: counts that are the same in every run, unless the time limit ends it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Statistics {
    /// Number of mixed-integer, constraint and cone programs solved.
    pub solves: u64,
    /// Number of nodes or conflicts of their searches, as far as the engine reports them.
    pub nodes: u64,
    /// Number of tangent cuts added.
    pub cuts: u64,
}

impl Statistics {
    /// Returns the sum of both statistics.
    pub fn plus(self, other: Statistics) -> Statistics {
        Statistics { solves: self.solves + other.solves, nodes: self.nodes + other.nodes, cuts: self.cuts + other.cuts }
    }
}

/// An activity of a plan.
pub trait Activity {
    /// Start (s).
    fn start(&self) -> f64;

    /// End (s).
    fn end(&self) -> f64;
}

/// A plan: activities of a kind in a stable order, with their cost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan<A> {
    /// Names of the members, in the mission's order.
    pub members: Vec<String>,
    /// All activities.
    pub activities: Vec<A>,
    /// The cost that the planner minimised, dimensionless.
    pub cost: f64,
    /// Status of the plan.
    pub status: Status,
    /// Name of the planner: formulation and engine.
    pub engine: String,
    /// Statistics of the search.
    pub statistics: Statistics,
}

impl<A: Activity> Plan<A> {
    /// Returns the end of the last activity (s); `None` for an empty plan.
    pub fn end(&self) -> Option<f64> {
        self.activities.iter().map(Activity::end).reduce(f64::max)
    }
}
