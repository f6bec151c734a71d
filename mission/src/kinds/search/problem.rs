//! The problem of a search: a team on a map with sources of reward, in the social reward sources model (srs section 3).

use serde::{Deserialize, Serialize};

use super::geometry::{self, Point};
use super::habits::{Habits, Reminder};
use super::sight::{Sight, SightCache};
pub use super::source::{Boundary, Extent, Fall, NoValue, Rate, RateFunction, Source, SourceKind, TOUCHES, Travel};
use crate::labels::Labels;
use crate::occupancy::OccupancyGrid;

/// The most agents.
pub const MAX_AGENTS: usize = 16;
/// The most sources.
pub const MAX_SOURCES: usize = 64;
/// The most groups of hidden objects.
pub const MAX_OBJECTS: usize = 16;
/// The most hidden objects of a group.
pub const MAX_COUNT: usize = 100;
/// The most walls.
pub const MAX_WALLS: usize = 512;
/// The most corners of all polygons and walls together.
pub const MAX_CORNERS: usize = 4096;
/// Content of a pool below which the pool is empty.
pub const EMPTY: f64 = 1e-9;

/// A search: agents, walls, sources and their interdependence `G_I` (srs (8), (12)).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Problem {
    /// Corners of the ground on which agents move (m).
    pub area: Vec<Point>,
    /// A map of the ground, on which agents move in free cells alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub occupancy: Option<OccupancyGrid>,
    /// Walls and solid obstacles.
    pub walls: Vec<Wall>,
    /// The team.
    pub agents: Vec<Agent>,
    /// Sources of reward.
    pub sources: Vec<Source>,
    /// Pairs of sources that share their pools.
    pub codependent: Vec<Codependence>,
    /// Hidden objects that the team looks for (srs section 5).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub objects: Vec<Hidden>,
    /// Width of the cells of the belief (m), more than 0.
    #[serde(default = "usual_cell")]
    pub cell: f64,
    /// Exposure of each cell that the beliefs account for: the integral of the detection rates of those who have looked at it.
    /// Empty: nobody has looked.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub exposure: Vec<f64>,
    /// Time at which rewards cease to count (s).
    pub horizon: f64,
    /// Present time (s); 0 before the execution.
    pub start: f64,
    /// Reminders of people to send their pose.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reminder: Option<Reminder>,
    /// Settings of the planner.
    pub planner: Planner,
    /// Texts that people read in place of names.
    pub labels: Labels,
    /// Cells that see one another.
    #[serde(skip)]
    pub sight: SightCache,
}

fn usual_cell() -> f64 {
    1.0
}

/// Hidden objects that are alike, `O` of srs 5.1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hidden {
    /// Name.
    pub name: String,
    /// Their number, 1 or more.
    pub count: usize,
    /// Number of those that are found.
    #[serde(default)]
    pub found: usize,
    /// Reward of finding one at the start; it falls to zero at the horizon.
    pub worth: f64,
    /// Corners of the region in which each is, with the same probability everywhere (m); none: the whole ground.
    pub region: Vec<Point>,
    /// True places in simulated executions (m), of which plans know nothing; none: they are drawn from the region.
    pub places: Vec<Point>,
}

impl Hidden {
    /// Number of those that are still to be found.
    pub fn left(&self) -> usize {
        self.count.saturating_sub(self.found)
    }
}

/// Detection model of an agent, srs (22): an object that is in sight for a time `t` stays undetected with the probability
/// `exp(-rate t)`, which has the property (23).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Detection {
    /// Farthest distance of what it sees (m), more than 0.
    pub within: f64,
    /// Detection rate (1/s), more than 0.
    pub rate: f64,
}

/// A wall.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Wall {
    /// Name.
    pub name: String,
    /// Its line, or the corners of a solid obstacle (m).
    pub points: Vec<Point>,
    /// The points are the corners of a solid obstacle.
    pub solid: bool,
    /// Objects behind it are in sight.
    #[serde(default)]
    pub transparent: bool,
}

/// A member of the team.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Agent {
    /// Name.
    pub name: String,
    /// A person; else a robot.
    pub human: bool,
    /// Position at the start (m).
    pub start: Point,
    /// Direction at the start (rad).
    pub heading: f64,
    /// Speed (m/s), more than 0.
    pub speed: f64,
    /// Distance that its middle keeps from walls (m). Zero or more.
    pub radius: f64,
    /// Indices of the walls that it passes.
    pub passes: Vec<usize>,
    /// Indices of the sources that it is believed not to know of: it is not expected to consume them (srs (11)).
    pub unaware: Vec<usize>,
    /// Its detection model for hidden objects; none: it does not look for them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sees: Option<Detection>,
    /// Relative standard deviation of the times of its ways.
    pub spread: f64,
    /// It takes no part any more.
    pub lost: bool,
    /// Goal that somebody has told (m), srs section 6: it goes there before anything else, if it can.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub told: Option<Point>,
    /// Habits of a person whom nobody plays.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub habits: Option<Habits>,
}

/// Codependent consumption of two sources: a unit that is taken from one takes `share` units from the other.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Codependence {
    /// Indices of the two sources.
    pub of: [usize; 2],
    /// Share, 0 to 1.
    pub share: f64,
}

/// Settings of the planner.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Planner {
    /// Number of goals that an agent considers after each action, `N_a`.
    pub goals: usize,
    /// Factor of the probability of the last action of a rollout, `w` of srs (14), 0 to 1.
    pub reduction: f64,
    /// Discount of the reduction for earlier actions, `gamma` of srs (14), 0.5 to 1.
    pub discount: f64,
    /// Number of nodes of a tree of ways.
    pub tree_nodes: usize,
    /// Time that an agent stays at a source with an infinite pool before it decides again (s), more than 0.
    pub stay: f64,
    /// Number of states of the search tree.
    pub states: u64,
    /// Time that a plan looks ahead (s), more than 0; none: up to the horizon.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window: Option<f64>,
    /// Number of places from which an agent considers to look for hidden objects.
    #[serde(default = "usual_lookouts")]
    pub lookouts: usize,
    /// Seed of trees and samples.
    pub seed: u64,
}

impl Default for Planner {
    fn default() -> Planner {
        Planner {
            goals: 8,
            reduction: 0.8,
            discount: 0.8,
            tree_nodes: 400,
            stay: 5.0,
            states: 20_000,
            window: None,
            lookouts: usual_lookouts(),
            seed: 1,
        }
    }
}

fn usual_lookouts() -> usize {
    16
}

impl Problem {
    /// Text that people read in place of the name of an agent.
    pub fn agent_label(&self, agent: usize) -> &str {
        self.agents.get(agent).map_or("?", |agent| self.labels.member(&agent.name))
    }

    /// End of the time that a plan accounts for (s).
    pub fn end(&self) -> f64 {
        self.planner.window.map_or(self.horizon, |window| self.horizon.min(self.start + window))
    }

    /// Text that people read in place of the name of a group of objects.
    pub fn object_label(&self, object: usize) -> &str {
        self.objects.get(object).map_or("?", |object| self.labels.member(&object.name))
    }

    /// Returns true if something hidden is still to be found.
    pub fn is_searching(&self) -> bool {
        self.objects.iter().any(|object| object.left() > 0)
    }

    /// Returns how an agent looks for what is hidden; none: it does not, or nothing is.
    pub fn looks(&self, agent: usize) -> Option<Detection> {
        let who = self.agents.get(agent).filter(|who| !who.lost)?;
        who.sees.filter(|_| self.is_searching())
    }

    /// The share of the worth of an object that is left at a time (s): 1 at the begin of the mission, 0 at the horizon. The
    /// plan with the most expected worth is then the one with the least expected time to find, cut off at the horizon.
    pub fn urgency(&self, time: f64) -> f64 {
        (1.0 - time / self.horizon).clamp(0.0, 1.0)
    }

    /// Cells that see one another, of the map and the walls as they are.
    pub fn sight(&self) -> std::sync::Arc<Sight> {
        self.sight.of(self)
    }

    /// Text that people read in place of the name of a source.
    pub fn source_label(&self, source: usize) -> &str {
        self.sources.get(source).map_or("?", |source| self.labels.member(&source.name))
    }

    /// Returns true if an agent is one that the plan expects to consume a source.
    pub fn consumes(&self, agent: usize, source: usize) -> bool {
        let knows = self.agents.get(agent).is_some_and(|who| !who.lost && !who.unaware.contains(&source));
        knows && self.sources.get(source).is_some_and(|source| source.targets.contains(&agent))
    }

    /// Pools of the sources at the present; infinite ones are infinite.
    pub fn pools(&self) -> Vec<f64> {
        self.sources.iter().map(|source| source.pool.unwrap_or(f64::INFINITY)).collect()
    }

    /// Returns true if a source is rewarding with these pools: its strict predecessors are consumed, and none of its soft
    /// successors is.
    pub fn is_open(&self, source: usize, pools: &[f64]) -> bool {
        let consumed = |of: &usize| pools.get(*of).is_some_and(|pool| *pool <= EMPTY);
        let source = &self.sources[source];
        source.after.iter().all(consumed) && !source.until.iter().any(consumed)
    }

    /// Corners of the box around the ground (m).
    pub fn bounds(&self) -> [Point; 2] {
        geometry::bounds(self.area.iter().copied())
    }
}
