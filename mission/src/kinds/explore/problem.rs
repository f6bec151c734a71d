//! The problem of an exploration: robots that take over the targets which a person leaves (armchair, section 2).

use serde::{Deserialize, Serialize};

use super::motion::{Discrete, Dynamics, State};
use super::polygon::{Convex, Point};
use crate::labels::Labels;

/// The most robots.
pub const MAX_ROBOTS: usize = 6;
/// The most targets.
pub const MAX_TARGETS: usize = 32;
/// The most obstacles.
pub const MAX_OBSTACLES: usize = 32;
/// The most corners of one polygon.
pub const MAX_CORNERS: usize = 16;
/// The most periods of a plan.
pub const MAX_PERIODS: usize = 100;
/// The most cells of the grid along one side.
pub const MAX_SIDE: usize = 32;

/// An exploration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Problem {
    /// The region of operation, `A`.
    pub area: Convex,
    /// Obstacles, `O`.
    pub obstacles: Vec<Obstacle>,
    /// Names of the types of targets, in the order of the feature maps (6).
    pub types: Vec<String>,
    /// Targets, `T`.
    pub targets: Vec<Target>,
    /// The exit, `F`: the mission ends when the person is there.
    pub exit: Convex,
    /// Relative positions at which two members are connected, `C`; symmetric about the origin.
    pub connection: Convex,
    /// The robots.
    pub robots: Vec<Robot>,
    /// The person.
    pub person: Person,
    /// Period of the plan (s), `T`, more than 0.
    pub period: f64,
    /// The most periods that a plan looks ahead, `N`.
    pub periods: usize,
    /// Weight of the 1-norm of the inputs, `gamma_u`.
    pub effort: f64,
    /// Planning.
    pub planner: Planner,
    /// Texts that people read in place of names.
    pub labels: Labels,
}

/// A convex obstacle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Obstacle {
    /// Name.
    pub name: String,
    /// Its polygon.
    pub shape: Convex,
}

/// A target: whoever takes it is in its polygon.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// Name.
    pub name: String,
    /// Its polygon.
    pub shape: Convex,
    /// Index of its type.
    pub of: usize,
    /// Its reward for the robots, `gamma_e`, more than 0.
    pub worth: f64,
}

/// A robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Robot {
    /// Name.
    pub name: String,
    /// Position at the start (m), where it stands.
    pub start: Point,
    /// Its body around its position, `R`.
    pub body: Convex,
    /// Its dynamics.
    pub dynamics: Dynamics,
    /// The greatest speed along each axis (m/s), more than 0.
    pub speed: f64,
    /// The greatest acceleration along each axis (m/s^2), more than 0; infinite: no limit.
    pub acceleration: f64,
}

/// The person: walks over a grid at constant speed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Person {
    /// Name.
    pub name: String,
    /// Position at the start (m): the middle of the cell in which it lies.
    pub start: Point,
    /// The body around the position, `R^h`.
    pub body: Convex,
    /// Speed (m/s), more than 0.
    pub speed: f64,
    /// Width of the square cells of the grid (m), more than 0.
    pub cell: f64,
    /// Model by which the person walks in simulated executions.
    pub walks: Model,
    /// Model by which the robots predict the person.
    pub predicted: Model,
}

/// A model of the person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Model {
    /// A trained policy, as the bytes of its file.
    Policy(PolicyFile),
    /// The person takes the shortest ways to targets, those of the types with the highest values first, and then to the exit.
    GoalDirected {
        /// Value of each type; types without one have the value 1, and those without a positive one are left.
        values: Vec<f64>,
    },
    /// The person walks on in the same direction.
    ConstantVelocity,
}

/// The file of a trained policy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PolicyFile {
    /// Path as the spec writes it.
    pub path: String,
    /// Its content.
    #[serde(with = "hexadecimal")]
    pub bytes: Vec<u8>,
}

/// Bytes as a text of two hexadecimal digits each.
mod hexadecimal {
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    pub fn serialize<S: Serializer>(bytes: &[u8], to: S) -> Result<S::Ok, S::Error> {
        let digits = bytes.iter().flat_map(|byte| [byte >> 4, byte & 15]);
        let text: String = digits.filter_map(|digit| char::from_digit(u32::from(digit), 16)).collect();
        to.serialize_str(&text)
    }

    pub fn deserialize<'d, D: Deserializer<'d>>(from: D) -> Result<Vec<u8>, D::Error> {
        let text = String::deserialize(from)?;
        let digits: Option<Vec<u32>> = text.chars().map(|c| c.to_digit(16)).collect();
        let digits = digits.filter(|digits| digits.len() % 2 == 0);
        let digits = digits.ok_or_else(|| D::Error::custom("a policy is a text of pairs of hexadecimal digits"))?;
        Ok(digits.chunks(2).map(|two| (16 * two[0] + two[1]) as u8).collect())
    }
}

/// Settings of the planner.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Planner {
    /// Relative gap at which a plan counts as the best one.
    pub gap: f64,
    /// Wall time of a plan (s).
    pub time: f64,
    /// Relaxations that a plan may solve: the limit that is the same in every run.
    pub nodes: u64,
    /// Engine for mixed-integer programs.
    pub engine: EngineChoice,
    /// Motion of the robots while there is no plan.
    pub fallback: Fallback,
    /// Price that plans pay to keep out of states in which the person can corner a robot.
    pub escape: Escape,
}

/// Engine for mixed-integer programs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EngineChoice {
    /// The built-in one.
    #[default]
    BuiltIn,
    /// HiGHS.
    Highs,
    /// HiGHS if it is installed, else the built-in one.
    Auto,
}

/// The price that plans pay so that no robot gets into a state in which the person can corner it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Escape {
    /// Nothing: plans do not look at it.
    Ignored,
    /// Targets, but no connection.
    #[default]
    Preferred,
    /// Targets, and connections.
    Required,
}

impl Escape {
    /// Words of the language.
    pub const NAMES: [&'static str; 3] = ["ignored", "preferred", "required"];
    /// The choices, in the order of the words.
    pub const ALL: [Escape; 3] = [Escape::Ignored, Escape::Preferred, Escape::Required];
}

/// The motion of the robots in a period for which there is no plan.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fallback {
    /// They brake and stand (armchair, section 4.1).
    Stop,
    /// They stay connected and keep clear of the person.
    #[default]
    Barrier,
}

impl Fallback {
    /// Words of the language, in the order of the variants.
    pub const NAMES: [&'static str; 2] = ["stop", "barrier"];
}

impl Robot {
    /// Its dynamics over a time (s).
    pub fn over(&self, time: f64) -> Discrete {
        self.dynamics.over(time)
    }

    /// The greatest input along each axis.
    pub fn most_input(&self) -> f64 {
        match self.dynamics {
            // No acceleration beyond this one keeps the speed within its limit over a period of any use.
            Dynamics::Acceleration => self.acceleration,
            Dynamics::Velocity | Dynamics::Lag(_) => self.speed,
        }
    }

    /// The state at the start.
    pub fn at_start(&self) -> State {
        State { at: self.start, velocity: [0.0; 2] }
    }
}

impl Problem {
    /// Text that people read in place of the name of a robot.
    pub fn robot_label(&self, robot: usize) -> &str {
        self.robots.get(robot).map_or("?", |robot| self.labels.member(&robot.name))
    }

    /// Text that people read in place of the name of the person.
    pub fn person_label(&self) -> &str {
        self.labels.member(&self.person.name)
    }

    /// Text that people read in place of the name of a target.
    pub fn target_label(&self, target: usize) -> &str {
        self.targets.get(target).map_or("?", |target| self.labels.member(&target.name))
    }

    /// Vectors by which the person can move within a time (s): the corners of the set, whose hull it is. A person who walks along
    /// the axes of the grid is within a diamond.
    pub fn strides(&self, time: f64) -> [Point; 4] {
        let far = self.person.speed * time;
        [[far, 0.0], [0.0, far], [-far, 0.0], [0.0, -far]]
    }
}
