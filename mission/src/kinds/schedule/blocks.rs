//! The blocks of a schedule: keys with their types, units, ranges, defaults and texts.

use blocks::{Block, Bound, ByName, FromBound, Key, Located, Members, Named, OneOrEach, Place, ValueType, block};
use quantities::dimension::{LENGTH, NONE};
use quantities::{Quantity, usual};
use serde::{Deserialize, Serialize};

use super::problem::Duration;
use crate::declare::common::{
    A_FACTOR, A_LENGTH, A_SHARE, A_TIME, A_WEIGHT, ENERGY, EnergyBlock, LABEL, RUNS, RunsBlock,
};
use crate::numbers::Range;

const WEIGHTS: ValueType = ValueType::Numbers(Quantity::at_least(NONE, 0.0));
const SPEEDS: ValueType = ValueType::Range(usual::WALKING_SPEED);

/// Service robots, in the order of [`Problem::robots`](super::problem::Problem::robots).
pub static SERVERS: Members = Members { noun: "robot", roles: &["robot"] };
/// Working agents, which are served, in the order of [`Problem::agents`](super::problem::Problem::agents).
pub static SERVED: Members = Members { noun: "agent", roles: &["human", "worker"] };

block! {
    /// A mission of the kind `schedule`.
    pub struct ScheduleBlock = SCHEDULE, "a schedule" {
        /// The probability that an operation ends within its planned duration.
        confidence: f64 = or(ValueType::Number(Quantity::between(NONE, 1e-6, 1.0 - 1e-6)), "0.9");
        /// Weights of the terms in the cost of a plan, in addition to the waits of people, which have weights of
        /// their own.
        weights: Weights = optional(ValueType::Block(&SCHEDULE_WEIGHTS));
        /// During the execution of a plan: it is planned again when the cost of its remaining part has changed by
        /// more than this fraction.
        reallocate_above: f64 = or(A_WEIGHT, "0.1");
        /// Number of operations that are planned at a time if there are too many for all at once.
        batch: usize = or(ValueType::Count(Quantity::at_least(NONE, 1.0)), "4");
        /// Constants of the adaptation of a plan to the feedback of people.
        adaptation: Adaptation = optional(ValueType::Block(&ADAPTATION));
        /// Lengths of the paths from the depot of each robot to each agent, `distances { m1 { h1 12 m  h2 15 m } }`;
        /// default: straight lines.
        distances: Option<Vec<ByName<Vec<ByName<f64>>>>> = optional(ValueType::Of(Named::Own(&SERVERS), WAYS));
    }
    also [
        Key::required("robot", ValueType::Block(&SCHEDULE_ROBOT), "A robot that serves: `robot NAME { depot [x, y] m  speed [0.05, 0.2] m/s  serve 20 s }`.")
        .at(Place::Hq),
        Key::required("robots", ValueType::Each(&ValueType::Block(&SCHEDULE_ROBOT)), "The robots that serve, by name.")
            .at(Place::Yaml),
        Key::optional("human", ValueType::Block(&SCHEDULE_HUMAN), "A person who is served: `human NAME { place [x, y] m  operations 3  duration normal(204 s, 20 s) }`.")
        .at(Place::Hq),
        Key::optional("humans", ValueType::Each(&ValueType::Block(&SCHEDULE_HUMAN)), "People who are served, by name.")
            .at(Place::Yaml),
        Key::optional("worker", ValueType::Block(&SCHEDULE_WORKER), "A working robot that is served: `worker NAME { place [x, y] m  operations 3  duration 250 s }`.")
        .at(Place::Hq),
        Key::optional("workers", ValueType::Each(&ValueType::Block(&SCHEDULE_WORKER)), "Working robots that are served, by name.")
        .at(Place::Yaml),
    ]
}

const WAYS: &ValueType = &ValueType::Of(Named::Own(&SERVED), &A_LENGTH);

block! {
    /// Weights of the cost (5.5) of a schedule.
    #[derive(Copy, PartialEq, Serialize, Deserialize)]
    pub struct Weights = SCHEDULE_WEIGHTS, "`weights` of a schedule" {
        /// Of the waits of working robots, `beta`.
        worker_wait: f64 = or(A_WEIGHT, "1");
        /// Of the energy of the robots that serve, `gamma`.
        energy: f64 = or(A_WEIGHT, "1");
        /// Of the time until all is done, `kappa`.
        makespan: f64 = or(A_WEIGHT, "1");
    }
}

block! {
    /// Constants of the adaptation to people. The defaults are ours: the thesis prints none.
    #[derive(Copy, PartialEq, Serialize, Deserialize)]
    pub struct Adaptation = ADAPTATION, "an adaptation" {
        /// Weight of the latest feedback relative to earlier ones, `theta`.
        memory: f64 = or(A_SHARE, "0.5");
        /// Rate at which feedback on waits changes their weights, `k_alpha`.
        wait_gain: f64 = or(A_WEIGHT, "1");
        /// Rate at which feedback on approaches changes their weights, `k_zeta`.
        approach_gain: f64 = or(A_WEIGHT, "1");
        /// Smallest relative distance between the ends of a range of speeds, `c_epsilon`.
        margin: f64 = or(A_SHARE, "0.01");
        /// Change of a person's `wait_limit` by the feedback `too_short` (longer) or `too_long` (shorter); half of
        /// it by `short` and `long`.
        wait_step: f64 = or(A_TIME, "30 s");
    }
}

impl Default for Adaptation {
    fn default() -> Adaptation {
        Adaptation::empty()
    }
}

block! {
    /// A robot of a schedule.
    pub struct RobotBlock = SCHEDULE_ROBOT, "a robot of a schedule" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
        /// Position where it starts, and where every service ends.
        depot: [f64; 2] = required(ValueType::Pair(LENGTH));
        /// Range of its speed, `[lowest, highest]`; one number for a fixed speed.
        speed: Range = required(SPEEDS);
        /// Range of its speed near an agent. Default: from 0.8 times the lowest to 0.75 times the highest speed of
        /// all robots of the mission.
        proximity_speed: Option<Range> = optional(SPEEDS);
        /// Time to serve an agent.
        serve: f64 = required(A_TIME, "20 s");
        /// Time that it is busy at its depot after each service.
        deposit: f64 = or(A_TIME, "0 s");
        /// Physical factor: larger for a heavier robot, which needs more energy and has to be slower near people.
        factor: f64 = or(A_FACTOR, "1");
        /// Power during motion, `standby + friction v + drag v^2`. Only ratios matter: between these three, and
        /// between the robots.
        energy: EnergyBlock = optional(ValueType::Block(&ENERGY));
    }
}

const PLACE: Key = Key::required("place", ValueType::Pair(LENGTH), "Position where the agent works and is served.");
const OPERATIONS: Key = Key::or(
    "operations",
    ValueType::Count(Quantity::at_least(NONE, 0.0)),
    "1",
    "Number of its operations; a robot comes at the end of each.",
);
const DURATION: Key = Key::required(
    "duration",
    ValueType::Spread(Quantity { min_included: false, ..usual::WORK_TIME }),
    "Duration of an operation: `250 s`, or `normal(204 s, 20 s)` with its mean and standard deviation.",
);
const WAIT_DISTANCE: Key = Key::or(
    "wait_distance",
    A_LENGTH,
    "1 m",
    "Distance from the agent at which a robot waits for the end of the operation.",
);
const APPROACH_WEIGHTS: Key = Key::or(
    "approach_weights",
    WEIGHTS,
    "1",
    "Weights of the energy near the agent: one for all operations, or a list with one for each.",
);
const APPROACHES: Key = Key::optional(
    "approaches",
    ValueType::Of(Named::Own(&SERVERS), EACH_APPROACH),
    "Exceptions for single robots, by the name of the robot.",
);
const EACH_APPROACH: &ValueType = &ValueType::Block(&APPROACH);

block! {
    /// A person of a schedule.
    pub struct HumanBlock = SCHEDULE_HUMAN, "a human of a schedule" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
        /// Position of the service.
        place: [f64; 2] = same(PLACE);
        /// Number of operations.
        operations: usize = same(OPERATIONS);
        /// Duration of an operation.
        duration: Duration = same(DURATION);
        /// Severity of the working conditions, from 0 to 1; a higher severity increases the effect of the person's
        /// feedback.
        severity: f64 = or(A_SHARE, "0");
        /// Waiting distance of a robot.
        wait_distance: f64 = same(WAIT_DISTANCE);
        /// Weights of the waits: one for all operations, or a list with one for each, `alpha`.
        wait_weights: OneOrEach = or(WEIGHTS, "1");
        /// Limit of waits for a person whose feedback reduces the weight of waits: the time beyond the limit has at
        /// least the initial weight. Feedback on waits changes the limit by `wait_step`.
        wait_limit: f64 = or(A_TIME, "60 s");
        /// Weights of the energy near the agent.
        approach_weights: OneOrEach = same(APPROACH_WEIGHTS);
        /// Exceptions for single robots.
        approaches: Vec<ByName<ApproachBlock>> = same(APPROACHES);
    }
}

block! {
    /// A working robot of a schedule.
    pub struct WorkerBlock = SCHEDULE_WORKER, "a worker of a schedule" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
        /// Position of the service.
        place: [f64; 2] = same(PLACE);
        /// Number of operations.
        operations: usize = same(OPERATIONS);
        /// Duration of an operation.
        duration: Duration = same(DURATION);
        /// Waiting distance of a robot.
        wait_distance: f64 = same(WAIT_DISTANCE);
        /// Weights of the energy near the agent.
        approach_weights: OneOrEach = same(APPROACH_WEIGHTS);
        /// Exceptions for single robots.
        approaches: Vec<ByName<ApproachBlock>> = same(APPROACHES);
        /// The controller that it runs in scenarios. The duration of an operation is then what its machine makes of
        /// it, and plans use `duration`.
        runs: Option<RunsBlock> = optional(ValueType::Block(&RUNS));
    }
}

block! {
    /// Approach of one robot to an agent.
    pub struct ApproachBlock = APPROACH, "the approach of a robot" {
        /// Range of its speed near this agent; default: the robot's.
        speed: Option<Located<Range>> = optional(SPEEDS);
        /// Distance at which it waits; default: the agent's.
        wait_distance: Option<f64> = optional(A_LENGTH);
    }
}

impl FromBound for Duration {
    fn from_bound(bound: &Bound) -> Option<Duration> {
        match bound {
            Bound::Spread([mean, sigma]) => Some(Duration { mean: *mean, sigma: *sigma }),
            _ => None,
        }
    }

    fn stand_in(_: &Key) -> Duration {
        Duration { mean: 1.0, sigma: 0.0 }
    }
}
