//! The log of an execution, and its changes of the plan.

use serde::{Deserialize, Serialize};

/// The largest index that is logged: it is infinite where a cost of zero became another.
pub(super) const LARGE: f64 = 1e6;

/// An entry of the log. `H` is the kind's own list of what can happen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record<H> {
    /// Time (s).
    pub time: f64,
    /// Content.
    pub what: H,
}

/// A change of the plan, or that there was none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PlanChange {
    /// Times or speeds of the plan moved; assignments stayed.
    Rescheduled {
        /// Relative change of the cost since the last planning, thesis (5.19).
        index: f64,
    },
    /// The part that had not begun was planned anew.
    Reallocated {
        /// The index before; none: there was no feasible plan to keep.
        index: Option<f64>,
        /// Cost of the plan.
        cost: f64,
        /// Formulation and engine that solved it.
        engine: String,
    },
    /// Planning anew gave no plan that could be used: the repaired one stays.
    Refused {
        /// Reason.
        why: String,
    },
    /// There is no plan for everything any more.
    Stranded {
        /// Reason.
        why: NoFeasiblePlan,
    },
}

impl PlanChange {
    /// True if assignments changed, or could not.
    pub fn is_notable(&self) -> bool {
        !matches!(self, PlanChange::Rescheduled { .. })
    }

    /// The change in words; `stranded` are the words for a plan that is gone.
    pub fn describe(&self, stranded: &str) -> String {
        match self {
            PlanChange::Rescheduled { index } => format!("times of the plan move; its cost {}", changed(*index)),
            PlanChange::Reallocated { index: Some(index), .. } => {
                format!("planned anew, as the cost {}", changed(*index))
            }
            PlanChange::Reallocated { index: None, .. } => "planned anew".to_string(),
            PlanChange::Refused { why } => format!("no better plan: {why}"),
            PlanChange::Stranded { why } => format!("{stranded}: {why}"),
        }
    }
}

/// The words for a relative change of the cost.
fn changed(index: f64) -> String {
    if index < LARGE { format!("has changed by {:.1} %", 100.0 * index) } else { "was nothing before".to_string() }
}

/// Reason why there is no plan for everything any more.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum NoFeasiblePlan {
    /// Nobody is left who could do the work.
    #[error("{who} is lost")]
    NobodyLeft {
        /// `every robot`, `everybody`.
        who: String,
    },
    /// The planner has none.
    #[error("no plan was found: {why}")]
    NotFound {
        /// The planner's reason.
        why: String,
    },
    /// The plan violates a constraint.
    #[error("the plan breaks a constraint: {why}")]
    Broken {
        /// The constraint.
        why: String,
    },
}

/// The log of an execution with its counts.
#[derive(Clone, Debug)]
pub(crate) struct Log<H> {
    /// Everything that has happened, in order.
    pub records: Vec<Record<H>>,
    /// Reason why there is no plan for everything, if so.
    pub stranded: Option<NoFeasiblePlan>,
    /// Time at which everything was done (s); none: something is to be done.
    pub done: Option<f64>,
    /// Number of repairs that moved times.
    pub reschedules: usize,
    /// Number of times that the rest was planned anew.
    pub reallocations: usize,
}

impl<H> Log<H> {
    /// The log of an execution that stands at its start.
    pub fn new() -> Log<H> {
        Log { records: Vec::new(), stranded: None, done: None, reschedules: 0, reallocations: 0 }
    }
}
