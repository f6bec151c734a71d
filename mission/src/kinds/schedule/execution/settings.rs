//! Settings of an execution: source of durations, motion of robots, rule of replanning.

use serde::{Deserialize, Serialize};

use crate::execution::{Durations, Replan};
use crate::kinds::schedule::adapt::Adaptation;
use crate::kinds::schedule::choose::{self, Options};
use crate::kinds::schedule::problem::{Distances, Problem};
use crate::kinds::schedule::validate::Violation;
use crate::numbers::MAX_NUMBER;

/// The most obstacles.
const MAX_OBSTACLES: usize = 64;
/// Between two obstacles there is room for a robot and this much more (m): in a narrower gap the potentials of both hold a
/// robot fast.
const PASSAGE: f64 = 1.0;

/// Motion of robots.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Travel {
    /// Along the straight line, as fast as planned, through each other.
    #[default]
    Planned,
    /// As kinematic bases that follow the plan and avoid each other.
    Bases(Potentials),
}

/// A round thing that stands in the way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Obstacle {
    /// Its centre (m).
    pub place: [f64; 2],
    /// Its radius (m). Zero or more.
    pub radius: f64,
}

/// Collision avoidance of bases: artificial potentials, thesis 5.7.1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Potentials {
    /// Time between two commands (s), 0.01 to 0.5.
    pub step: f64,
    /// `d_th` (m): robots that are nearer repel each other. More than `clearance`.
    pub threshold: f64,
    /// No robot comes nearer to another, or to an obstacle, than this (m), unless it begins there. More than 0.
    pub clearance: f64,
    /// Strength of repulsion: share of a robot's maximum speed at 1 m, far below the threshold. Zero or more.
    pub strength: f64,
    /// Gain of the tracking (1/s), at most `1 / step`. More than 0.
    pub gain: f64,
    /// Distance (m) from the axle of a base to the point ahead of it that follows the path. More than 0.
    pub ahead: f64,
    /// Obstacles.
    pub obstacles: Vec<Obstacle>,
}

impl Default for Potentials {
    /// The threshold is the thesis'; the rest is ours.
    fn default() -> Potentials {
        Potentials {
            step: 0.05,
            threshold: 3.0,
            clearance: 0.8,
            strength: 1.0,
            gain: 1.0,
            ahead: 0.3,
            obstacles: Vec::new(),
        }
    }
}

/// Settings of an execution.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Source of the true durations of operations.
    pub durations: Durations,
    /// Motion of robots.
    pub travel: Travel,
    /// Constants of the adaptation to feedback.
    pub adaptation: Adaptation,
    /// The threshold of (5.19) above which is planned anew. Zero or more.
    pub reallocate_above: f64,
    /// Reaction of the plan to differences.
    pub replan: Replan,
    /// Options of the planner.
    pub planning: Options,
    /// Agents (by index) whose operations end only by an event.
    pub reporting: Vec<usize>,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            durations: Durations::default(),
            travel: Travel::default(),
            adaptation: Adaptation::default(),
            reallocate_above: 0.1,
            replan: Replan::default(),
            planning: Options::default(),
            reporting: Vec::new(),
        }
    }
}

/// Reason for which an execution cannot begin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum Refusal {
    /// There is no plan.
    #[error(transparent)]
    Plan(#[from] choose::Refusal),
    /// The plan breaks constraints of the problem.
    #[error("the plan does not belong to this problem: {} constraints are violated, first {}", .0.len(), first(.0))]
    Violations(Vec<Violation>),
    /// The plan lacks activities.
    #[error("the plan is no schedule: {0}")]
    NoSchedule(String),
    /// Something has begun.
    #[error("an execution must begin at the start of its mission, and an activity has begun already")]
    Begun,
    /// A number of the settings is out of its range.
    #[error("`{name}` must lie between {low} and {high}, and is {value}")]
    Setting {
        /// Which.
        name: String,
        /// Its value.
        value: f64,
        /// Its least value.
        low: f64,
        /// Its greatest value.
        high: f64,
    },
    /// Bases need to know where things are.
    #[error("bases need positions, and the lengths of the paths come from a table")]
    NoPlaces,
    /// A robot could never get there.
    #[error("the obstacle at ({:.2}, {:.2}) m covers {what}", .obstacle.place[0], .obstacle.place[1])]
    Covered {
        /// The obstacle.
        obstacle: Obstacle,
        /// The place that it covers.
        what: String,
    },
    /// A robot could neither pass between two obstacles nor be led around both.
    #[error(
        "the obstacles at ({:.2}, {:.2}) m and ({:.2}, {:.2}) m leave less than {PASSAGE} m more than a robot needs between \
         them: give one round obstacle that covers both",
        .first.place[0], .first.place[1], .second.place[0], .second.place[1]
    )]
    Narrow {
        /// One of them.
        first: Obstacle,
        /// The other.
        second: Obstacle,
    },
    /// An agent that is waited for does not exist.
    #[error("there is no agent with number {0}, whose operations are to end by events")]
    Reporting(usize),
}

fn first(violations: &[Violation]) -> String {
    violations.first().map_or_else(String::new, Violation::to_string)
}

impl Settings {
    /// Checks the settings for this problem.
    ///
    /// # Errors
    ///
    /// The first number that is out of its range, or obstacle that covers a place.
    pub fn check(&self, problem: &Problem) -> Result<(), Refusal> {
        if let Some(nobody) = self.reporting.iter().find(|agent| **agent >= problem.agents.len()) {
            return Err(Refusal::Reporting(*nobody));
        }
        within("reallocate_above", self.reallocate_above, 0.0, f64::MAX)?;
        within("memory", self.adaptation.memory, 0.0, 1.0)?;
        within("wait_gain", self.adaptation.wait_gain, 0.0, MAX_NUMBER)?;
        within("approach_gain", self.adaptation.approach_gain, 0.0, MAX_NUMBER)?;
        within("margin", self.adaptation.margin, 0.0, 1.0)?;
        within("wait_step", self.adaptation.wait_step, 0.0, MAX_NUMBER)?;
        match &self.travel {
            Travel::Planned => Ok(()),
            Travel::Bases(potentials) => potentials.check(problem),
        }
    }
}

impl Potentials {
    fn check(&self, problem: &Problem) -> Result<(), Refusal> {
        within("step", self.step, 0.01, 0.5)?;
        within("clearance", self.clearance, 1e-3, MAX_NUMBER)?;
        within("threshold", self.threshold, self.clearance, MAX_NUMBER)?;
        within("strength", self.strength, 0.0, MAX_NUMBER)?;
        within("gain", self.gain, 1e-3, 1.0 / self.step)?;
        within("ahead", self.ahead, 1e-3, MAX_NUMBER)?;
        if problem.distances != Distances::Straight {
            return Err(Refusal::NoPlaces);
        }
        within("obstacles", self.obstacles.len() as f64, 0.0, MAX_OBSTACLES as f64)?;
        for (number, obstacle) in self.obstacles.iter().enumerate() {
            within("radius", obstacle.radius, 0.0, MAX_NUMBER)?;
            within("place", obstacle.place[0], -MAX_NUMBER, MAX_NUMBER)?;
            within("place", obstacle.place[1], -MAX_NUMBER, MAX_NUMBER)?;
            let narrow = |other: &&Obstacle| {
                let apart = f64::hypot(obstacle.place[0] - other.place[0], obstacle.place[1] - other.place[1]);
                apart < obstacle.radius + other.radius + 2.0 * self.clearance + PASSAGE
            };
            if let Some(first) = self.obstacles[..number].iter().find(narrow) {
                return Err(Refusal::Narrow { first: *first, second: *obstacle });
            }
            let covers = |place: [f64; 2]| self.covers(obstacle, place);
            let depots = problem
                .robots
                .iter()
                .map(|robot| (robot.depot, format!("the depot of {}", problem.labels.member(&robot.name))));
            let places = problem
                .agents
                .iter()
                .map(|who| (who.place, format!("the place of {}", problem.labels.member(&who.name))));
            if let Some((_, what)) = depots.chain(places).find(|(place, _)| covers(*place)) {
                return Err(Refusal::Covered { obstacle: *obstacle, what });
            }
        }
        Ok(())
    }

    /// A robot at this place would be too near to the obstacle.
    pub(super) fn covers(&self, obstacle: &Obstacle, place: [f64; 2]) -> bool {
        f64::hypot(place[0] - obstacle.place[0], place[1] - obstacle.place[1]) < obstacle.radius + self.clearance
    }
}

fn within(name: &str, value: f64, low: f64, high: f64) -> Result<(), Refusal> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(Refusal::Setting { name: name.into(), value, low, high })
}
