//! The plan of a search: what each agent does, one activity after the other.

use serde::{Deserialize, Serialize};

use super::geometry::Point;
use crate::plan;

/// A plan. Its cost is the negative reward of the team, `-g` of srs (15).
pub type Plan = plan::Plan<Activity>;

/// An activity of an agent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Activity {
    /// Index of the agent.
    pub agent: usize,
    /// The kind of activity.
    pub phase: Phase,
    /// Start (s).
    pub start: f64,
    /// End (s).
    pub end: f64,
    /// Its way (m); a single point if it stands still.
    pub way: Vec<Point>,
    /// Index of the source that it is for.
    pub source: Option<usize>,
    /// The activity whose end it waits for.
    pub awaits: Option<Awaited>,
    /// It had begun when the plan was made.
    pub begun: bool,
}

/// The activity that somebody waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Awaited {
    /// Index of its agent.
    pub agent: usize,
    /// Its number among those of the agent, from 0.
    pub number: usize,
}

/// The kind of an activity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// The agent moves.
    Going,
    /// It stays and consumes a source.
    Staying,
    /// It waits for somebody.
    Waiting,
}

impl Phase {
    /// Name, as in data.
    pub fn name(self) -> &'static str {
        match self {
            Phase::Going => "going",
            Phase::Staying => "staying",
            Phase::Waiting => "waiting",
        }
    }
}

impl plan::Activity for Activity {
    fn start(&self) -> f64 {
        self.start
    }

    fn end(&self) -> f64 {
        self.end
    }
}
