//! Checks of a problem before planning: each mistake names the declaration, the reason and, for a contradiction, the
//! other declaration.

use serde::{Deserialize, Serialize};

use crate::check::{self, NumberReason, entry, of};

use super::duration_quantile;
use super::problem::{Distances, Problem};
use crate::numbers::{MAX_NUMBER, MIN_SPEED, Range};

/// Maximum number of robots of a problem.
pub const MAX_ROBOTS: usize = 64;
/// Maximum number of operations of all agents of a problem together.
pub const MAX_OPERATIONS: usize = 512;

/// A declaration of the problem.
pub type Declaration = check::Declaration<Item, Key>;

/// A mistake in a problem.
pub type Mistake = check::Mistake<Item, Key, Reason>;

pub(super) type Checker<'a> = check::Checker<'a, Problem, Item, Key, Reason>;

/// An entry of the problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Item {
    /// The mission itself.
    Mission,
    /// The robot of this index.
    Robot(usize),
    /// The agent of this index.
    Agent(usize),
    /// The entry of this index in [`Problem::begun`].
    Begun(usize),
}

/// A key of an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "each is named after the field of the problem that it is")]
pub enum Key {
    Depot,
    Speed,
    Proximity,
    Serve,
    Deposit,
    Factor,
    Energy,
    Place,
    Operations,
    Duration,
    Severity,
    WaitDistance,
    WaitLimit,
    LimitWeights,
    Approaches,
    WaitWeights,
    ApproachWeights,
    Distances,
    Confidence,
    Weights,
    Start,
    Scales,
}

impl Key {
    /// Returns the name of the key in the language.
    pub fn name(self) -> &'static str {
        match self {
            Key::Depot => "depot",
            Key::Speed => "speed",
            Key::Proximity => "proximity_speed",
            Key::Serve => "serve",
            Key::Deposit => "deposit",
            Key::Factor => "factor",
            Key::Energy => "energy",
            Key::Place => "place",
            Key::Operations => "operations",
            Key::Duration => "duration",
            Key::Severity => "severity",
            Key::WaitDistance => "wait_distance",
            Key::WaitLimit => "wait_limit",
            Key::LimitWeights => "limit_weights",
            Key::Approaches => "approaches",
            Key::WaitWeights => "wait_weights",
            Key::ApproachWeights => "approach_weights",
            Key::Distances => "distances",
            Key::Confidence => "confidence",
            Key::Weights => "weights",
            Key::Start => "start",
            Key::Scales => "scales",
        }
    }
}

/// Reason why a declaration is rejected.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "the message says what each field is")]
pub enum Reason {
    #[error("must be a finite number of at most {MAX_NUMBER:e}, and is {value}")]
    TooLarge { value: f64 },
    #[error("must be at least {least}, and is {value}")]
    TooSmall { value: f64, least: f64 },
    #[error("must be more than 0, and is {value}")]
    NotPositive { value: f64 },
    #[error("must lie between {low} and {high}, and is {value}")]
    Outside { value: f64, low: f64, high: f64 },
    #[error("begins at {low} and ends below, at {high}")]
    Reversed { low: f64, high: f64 },
    #[error("lies from {low} to {high} m/s, wholly outside of the robot's cruising speeds")]
    OutsideCruise { low: f64, high: f64 },
    #[error(
        "an operation would be planned to take {seconds} s at this confidence: its spread is too large for its mean"
    )]
    NoTime { seconds: f64 },
    #[error("there is no robot")]
    NoRobot,
    #[error("there is nothing to do: no agent has an operation")]
    NoOperation,
    #[error("there are {count}, more than {most}")]
    TooMany { count: usize, most: usize },
    #[error("there are {found} numbers, and {expected} are wanted")]
    Count { found: usize, expected: usize },
    #[error("names number {index}, which does not exist")]
    Unknown { index: usize },
    #[error("is given twice")]
    Twice,
    #[error("no robot has a distance to travel to any agent, so that waits have no scale")]
    NoWay,
    #[error("the instants do not ascend")]
    NotAscending,
    #[error("it begins at {begins} s, after the plan is made")]
    Later { begins: f64 },
    #[error("the operation before it has not been served")]
    NotServed,
    #[error("it begins before the service of the operation before it ends")]
    BeforeService,
    #[error("it is served before it ends")]
    BeforeEnd,
    #[error("the robot goes {length} m in no time")]
    NoDuration { length: f64 },
    #[error("the robot does two services at a time")]
    Overlap,
}

impl NumberReason for Reason {
    fn too_large(value: f64) -> Reason {
        Reason::TooLarge { value }
    }

    fn too_small(value: f64, least: f64) -> Reason {
        Reason::TooSmall { value, least }
    }
}

impl Problem {
    /// Returns all mistakes of this problem, in the order of its fields; empty if the problem can be planned.
    pub fn check(&self) -> Vec<Mistake> {
        let mut checker = Checker::new(self);
        checker.mission();
        checker.robots();
        checker.agents();
        if checker.mistakes.is_empty() {
            checker.absent();
            checker.begun();
        }
        checker.mistakes
    }
}

impl Checker<'_> {
    fn positive(&mut self, at: Declaration, value: f64) {
        if self.usual(at, value) && value <= 0.0 {
            self.refuse(at, Reason::NotPositive { value });
        }
    }

    fn within(&mut self, at: Declaration, value: f64, low: f64, high: f64) {
        if !(low..=high).contains(&value) {
            self.refuse(at, Reason::Outside { value, low, high });
        }
    }

    fn speeds(&mut self, at: Declaration, range: Range) -> bool {
        let before = self.mistakes.len();
        if self.usual(at, range.low) && self.usual(at, range.high) {
            if range.low < MIN_SPEED {
                self.refuse(at, Reason::TooSmall { value: range.low, least: MIN_SPEED });
            } else if range.high < range.low {
                self.refuse(at, Reason::Reversed { low: range.low, high: range.high });
            }
        }
        self.mistakes.len() == before
    }

    fn near_speeds(&mut self, at: Declaration, range: Range, robot: usize) {
        let cruise = self.problem.robots.get(robot).map(|machine| machine.speed);
        let outside = |c: &Range| c.low <= c.high && (range.high < c.low || range.low > c.high);
        if self.speeds(at, range) && cruise.as_ref().is_some_and(outside) {
            let reason = Reason::OutsideCruise { low: range.low, high: range.high };
            self.mistakes.push(Mistake { at, against: Some(of(Item::Robot(robot), Key::Speed)), reason });
        }
    }

    fn mission(&mut self) {
        let problem = self.problem;
        let mission = entry(Item::Mission);
        self.within(of(Item::Mission, Key::Confidence), problem.confidence, 1e-6, 1.0 - 1e-6);
        self.usual(of(Item::Mission, Key::Start), problem.start);
        let weights = problem.weights;
        for weight in [weights.worker_wait, weights.energy, weights.makespan] {
            self.not_negative(of(Item::Mission, Key::Weights), weight);
        }
        if let Some(scales) = problem.scales {
            self.positive(of(Item::Mission, Key::Scales), scales.makespan);
            self.positive(of(Item::Mission, Key::Scales), scales.wait);
            for scale in scales.energy {
                self.not_negative(of(Item::Mission, Key::Scales), scale);
            }
        }
        if problem.robots.is_empty() {
            self.refuse(mission, Reason::NoRobot);
        }
        if problem.robots.len() > MAX_ROBOTS {
            self.refuse(mission, Reason::TooMany { count: problem.robots.len(), most: MAX_ROBOTS });
        }
        let operations = problem.agents.iter().fold(0_usize, |sum, agent| sum.saturating_add(agent.operations));
        if operations == 0 {
            self.refuse(mission, Reason::NoOperation);
        }
        let most = operations.max(problem.agents.len());
        if most > MAX_OPERATIONS {
            self.refuse(mission, Reason::TooMany { count: most, most: MAX_OPERATIONS });
        }
        if let Distances::Table(table) = &problem.distances {
            let at = of(Item::Mission, Key::Distances);
            if table.len() != problem.robots.len() {
                self.refuse(at, Reason::Count { found: table.len(), expected: problem.robots.len() });
            }
            for row in table {
                if row.len() != problem.agents.len() {
                    self.refuse(at, Reason::Count { found: row.len(), expected: problem.agents.len() });
                }
                for length in row {
                    self.not_negative(at, *length);
                }
            }
        }
    }

    fn robots(&mut self) {
        for (index, robot) in self.problem.robots.iter().enumerate() {
            let item = Item::Robot(index);
            for coordinate in robot.depot {
                self.usual(of(item, Key::Depot), coordinate);
            }
            self.speeds(of(item, Key::Speed), robot.speed);
            if let Some(range) = robot.proximity {
                self.near_speeds(of(item, Key::Proximity), range, index);
            }
            self.not_negative(of(item, Key::Serve), robot.serve);
            self.not_negative(of(item, Key::Deposit), robot.deposit);
            self.positive(of(item, Key::Factor), robot.factor);
            for coefficient in [robot.energy.standby, robot.energy.friction, robot.energy.drag] {
                self.not_negative(of(item, Key::Energy), coefficient);
            }
        }
    }

    fn agents(&mut self) {
        let problem = self.problem;
        for (index, agent) in problem.agents.iter().enumerate() {
            let item = Item::Agent(index);
            for coordinate in agent.place {
                self.usual(of(item, Key::Place), coordinate);
            }
            let before = self.mistakes.len();
            self.positive(of(item, Key::Duration), agent.duration.mean);
            self.not_negative(of(item, Key::Duration), agent.duration.sigma);
            let seconds = duration_quantile::nominal(problem, index);
            if self.mistakes.len() == before && seconds <= 0.0 {
                self.refuse(of(item, Key::Duration), Reason::NoTime { seconds });
            }
            self.within(of(item, Key::Severity), agent.severity, 0.0, 1.0);
            self.not_negative(of(item, Key::WaitDistance), agent.wait_distance);
            self.not_negative(of(item, Key::WaitLimit), agent.wait_limit);
            for (key, weights) in [
                (Key::WaitWeights, &agent.wait_weights),
                (Key::LimitWeights, &agent.limit_weights),
                (Key::ApproachWeights, &agent.approach_weights),
            ] {
                if !weights.is_empty() && weights.len() != agent.operations {
                    self.refuse(of(item, key), Reason::Count { found: weights.len(), expected: agent.operations });
                }
                for weight in weights {
                    self.not_negative(of(item, key), *weight);
                }
            }
            for (number, approach) in agent.approaches.iter().enumerate() {
                let at = of(item, Key::Approaches);
                if approach.robot >= problem.robots.len() {
                    self.refuse(at, Reason::Unknown { index: approach.robot });
                } else if agent.approaches[..number].iter().any(|other| other.robot == approach.robot) {
                    self.refuse(at, Reason::Twice);
                }
                if let Some(range) = approach.speed {
                    self.near_speeds(at, range, approach.robot);
                }
                if let Some(distance) = approach.wait_distance {
                    self.not_negative(at, distance);
                }
            }
        }
        let far = |m: usize| (0..problem.agents.len()).any(|a| problem.lengths(a, m).depositing > 0.0);
        if self.mistakes.is_empty() && !(0..problem.robots.len()).any(far) {
            self.refuse(of(Item::Mission, Key::Distances), Reason::NoWay);
        }
    }
}
