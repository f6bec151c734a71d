//! The blocks of an exploration: keys with their types, units, ranges, defaults and texts.

use blocks::{BinaryFile, BinaryFormat, Key, Located, Place, ValueType, Word, block};
use quantities::dimension::{ACCELERATION, LENGTH, NONE, TIME, VELOCITY};
use quantities::{Quantity, usual};

use super::motion::Dynamics;
use super::problem::{Escape, Fallback, MAX_PERIODS};
use crate::declare::common::LABEL;
use crate::declare::driven::{DRIVEN, DrivenBlock};

const POINTS: ValueType = ValueType::List(&ValueType::Pair(LENGTH));
const SQUARE: &str = "[[0, 0], [1, 0], [1, 1], [0, 1]] m";
const A_SIZE: ValueType = ValueType::Pair(LENGTH);

/// Words for engines.
pub(super) const ENGINES: [&str; 3] = ["built_in", "highs", "auto"];
/// Words for the types of targets, in the order of the feature maps.
pub(super) const TYPES: [&str; 4] = ["a", "b", "c", "d"];
/// Code of a policy that cannot be used.
pub(super) const POLICY_CODE: &str = "HQ0975";

/// The file of a policy.
static POLICY: BinaryFormat = BinaryFormat {
    code: POLICY_CODE,
    most: 16 << 20,
    if_larger: "name the file of a trained policy, as `hierarq learn` writes it",
    command: "hierarq learn {spec} {mission} --out {file}",
};

/// Words for models of the person.
pub(super) const MODELS: [&str; 3] = ["policy", "goal_directed", "constant_velocity"];

const fn count(least: f64, most: f64) -> ValueType {
    ValueType::Count(Quantity::between(NONE, least, most))
}

const fn above(dimension: quantities::dimension::Dimension) -> ValueType {
    ValueType::Number(Quantity::above(dimension, 0.0))
}

block! {
    /// A mission of the kind `explore`.
    pub struct ExploreBlock = EXPLORE, "an exploration" {
        /// Corners of the region of operation, a convex polygon: `A`.
        area: Vec<[f64; 2]> = required(POINTS, "[[0, 0], [7, 0], [7, 7], [0, 7]] m");
        /// Corners of the exit, a convex polygon: `F`. The mission ends when the person is there.
        exit: Vec<[f64; 2]> = required(POINTS, "[[6, 6], [7, 6], [7, 7], [6, 7]] m");
        /// Range of the radio. Two members are connected if their relative position is in the regular octagon with its corners at
        /// this distance: `C`.
        range: f64 = required(above(LENGTH), "4 m");
        /// Period of the plan, `T`: robots keep their inputs for so long.
        period: f64 = or(ValueType::Number(Quantity::between(TIME, 0.05, 60.0)), "1 s");
        /// The most periods that a plan looks ahead, `N`. It ends earlier where the person is expected at the exit.
        horizon: usize = or(count(2.0, MAX_PERIODS as f64), "30");
        /// Weight of the sum of the absolute inputs of the robots in the cost, `gamma_u`.
        effort: f64 = or(ValueType::Number(Quantity::at_least(NONE, 0.0)), "0.01");
        /// Relative gap between a plan and the best one at which the planner stops.
        gap: f64 = or(ValueType::Number(Quantity::between(NONE, 1e-6, 0.5)), "0.05");
        /// Wall time for a plan. The first plan, which is made before the mission begins, has twenty times as long. Default:
        /// 0.9 of the period.
        plan_time: Option<f64> = optional(above(TIME), "0.9 s");
        /// The most nodes of the search for a plan: a limit that is the same on every machine.
        nodes: usize = or(count(1.0, 1e6), "2000");
        /// Engine for mixed-integer programs: `built_in`, with which plans are the same on every machine and large programs are left to the
        /// lattice; `highs`; or `auto`, which is HiGHS if it is installed.
        engine: Word = or(ValueType::Choice(&ENGINES), "built_in");
        /// Motion of the robots while there is no plan: `stop`, they brake and stand, or `barrier`, they also stay connected and
        /// keep clear of the person.
        fallback: Word = or(ValueType::Choice(&Fallback::NAMES), "barrier");
        /// Care for states in which the person could corner a robot, whatever the prediction says: `ignored`; `preferred`, robots leave targets for it,
        /// and stay connected; or `required`, they also give up the connection.
        escape: Word = or(ValueType::Choice(&Escape::NAMES), "preferred");
    }
    also [
        Key::optional("robot", ValueType::Block(&EXPLORE_ROBOT), "A robot: `robot NAME { start [0.5, 0.5] m }`.").at(Place::Hq),
        Key::optional("robots", ValueType::Each(&ValueType::Block(&EXPLORE_ROBOT)), "The robots, by name.").at(Place::Yaml),
        Key::optional("human", ValueType::Block(&EXPLORE_HUMAN), "The person: `human NAME { start [3.5, 0.5] m }`.").at(Place::Hq),
        Key::optional("humans", ValueType::Each(&ValueType::Block(&EXPLORE_HUMAN)), "The person, by name.").at(Place::Yaml),
        Key::optional("target", ValueType::Block(&TARGET), "A target: `target NAME { at [2.5, 4.5] m  kind b }`.").at(Place::Hq),
        Key::optional("targets", ValueType::Each(&ValueType::Block(&TARGET)), "Targets, by name.").at(Place::Yaml),
        Key::optional("obstacle", ValueType::Block(&OBSTACLE), "An obstacle: `obstacle NAME { polygon [[2, 2], [3, 2], [3, 3]] m }`.")
            .at(Place::Hq),
        Key::optional("obstacles", ValueType::Each(&ValueType::Block(&OBSTACLE)), "Obstacles, by name.").at(Place::Yaml),
    ]
}

block! {
    /// A robot of an exploration.
    pub struct RobotBlock = EXPLORE_ROBOT, "a robot of an exploration" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
        /// Position at the start, where it stands.
        start: [f64; 2] = required(ValueType::Pair(LENGTH), "[0.5, 0.5] m");
        /// Width and height of its body, a rectangle along the axes around its position: `R`.
        size: [f64; 2] = or(A_SIZE, "[0.5, 0.5] m");
        /// Dynamics: its input is the `velocity`; the `acceleration`, as in (15); or a velocity that it follows with a `lag`.
        dynamics: Word = or(ValueType::Choice(&Dynamics::NAMES), "acceleration");
        /// Time constant of the lag.
        lag: Option<f64> = optional(ValueType::Number(Quantity::between(TIME, 1e-3, 60.0)), "0.3 s");
        /// Greatest speed along each axis.
        speed: f64 = or(ValueType::Number(usual::WALKING_SPEED), "2.5 m/s");
        /// Greatest acceleration along each axis.
        acceleration: f64 = or(above(ACCELERATION), "5 m/s^2");
        /// The controller that drives its base in scenarios. Without one it moves as planned.
        runs: Option<DrivenBlock> = optional(ValueType::Block(&DRIVEN));
    }
}

block! {
    /// The person of an exploration.
    pub struct HumanBlock = EXPLORE_HUMAN, "a human of an exploration" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
        /// Position at the start. The person begins in the middle of the cell in which it lies.
        start: [f64; 2] = required(ValueType::Pair(LENGTH), "[3.5, 0.5] m");
        /// Width and height of the body, a rectangle along the axes around the position: `R^h`.
        size: [f64; 2] = or(A_SIZE, "[0.41, 0.29] m");
        /// Speed of walking, which is constant.
        speed: f64 = or(ValueType::Number(Quantity::above(VELOCITY, 0.0).usually(0.1, 5.0)), "1 m/s");
        /// Width of the square cells of the grid over which the person walks.
        cell: f64 = or(above(LENGTH), "1 m");
        /// Model by which the person walks in scenarios, in which nobody plays the person. Default: `goal_directed`.
        walks: Option<ModelBlock> = optional(ValueType::Block(&MODEL), "{ model goal_directed }");
        /// Model by which the robots predict the person. Default: `goal_directed`.
        predicted: Option<ModelBlock> = optional(ValueType::Block(&MODEL), "{ model policy  file \"person.safetensors\" }");
    }
}

block! {
    /// A model of the person.
    pub struct ModelBlock = MODEL, "a model of a person" {
        /// A trained `policy`; `goal_directed`, the shortest ways to the targets, those of the types with the highest `values` first,
        /// and then to the exit; or `constant_velocity`, on in the same direction.
        model: Word = or(ValueType::Choice(&MODELS), "policy");
        /// The file of a trained policy, which `hierarq learn` writes.
        file: Option<Located<BinaryFile>> = optional(ValueType::Binary(&POLICY), "\"person.safetensors\"");
        /// Of `goal_directed`: the value of each type of target, from `a` on. The person leaves types without a positive value.
        /// Default: 1 for each.
        values: Vec<f64> = optional(ValueType::List(&ValueType::Number(Quantity::any(NONE))), "[0.5, 1]");
    }
}

block! {
    /// A target.
    pub struct TargetBlock = TARGET, "a target" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
        /// Its middle.
        at: [f64; 2] = required(ValueType::Pair(LENGTH), "[2.5, 4.5] m");
        /// Width and height of its rectangle along the axes: `T`. Whoever takes it has their middle there.
        size: [f64; 2] = or(A_SIZE, "[0.6, 0.6] m");
        /// Its type, by which the person may prefer it.
        kind: Word = or(ValueType::Choice(&TYPES), "a");
        /// Its reward for the robots, `gamma_e`.
        worth: f64 = or(ValueType::Number(Quantity::above(NONE, 0.0)), "5");
    }
}

block! {
    /// An obstacle.
    pub struct ObstacleBlock = OBSTACLE, "an obstacle" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
        /// Corners of the obstacle, a convex polygon.
        polygon: Vec<[f64; 2]> = required(POINTS, SQUARE);
    }
}
