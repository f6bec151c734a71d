//! The blocks of a search: keys with their types, units, ranges, defaults and texts.

use blocks::{
    Argument, ByName, Companion, FileWith, FunctionType, Key, Located, MemberIndex, Members, Named, Place, ValueType,
    Word, block,
};
use expressions::Function;
use quantities::dimension::{ANGLE, LENGTH, NONE, RATE, TIME, VELOCITY};
use quantities::{Quantity, usual};

use super::habits_blocks::{HABITS, HabitsBlock, REMINDER, ReminderBlock};
use super::map_file::UNREADABLE;
use super::problem::{Fall, MAX_COUNT, SourceKind};
use crate::declare::common::{A_LENGTH, A_SHARE, A_WEIGHT, LABEL};
use crate::declare::driven::{DRIVEN, DrivenBlock};
use crate::numbers::Range;
use crate::occupancy::{MAX_IMAGE_BYTES, image_path};

/// The agents, in the order of [`Problem::agents`](super::problem::Problem::agents).
pub static AGENTS: Members = Members { noun: "agent", roles: &["robot", "human"] };
/// The sources, in the order of [`Problem::sources`](super::problem::Problem::sources).
pub static SOURCES: Members = Members { noun: "source", roles: &["source"] };
/// The groups of hidden objects, in the order of [`Problem::objects`](super::problem::Problem::objects).
pub static OBJECTS: Members = Members { noun: "object", roles: &["object"] };
/// The walls, in the order of [`Problem::walls`](super::problem::Problem::walls).
pub static WALLS: Members = Members { noun: "wall", roles: &["wall"] };

/// The image that a map file names.
static MAP: Companion = Companion {
    code: UNREADABLE,
    path: image_path,
    most: MAX_IMAGE_BYTES,
    if_larger: "crop it, or save the map with a larger `resolution`",
    if_no_text: "name the YAML file of the map, which names its image",
};

/// A reward rate as a function of the vector from the nearest point of the boundary, srs (1).
static RATE_OF: FunctionType = FunctionType {
    arguments: &[
        Argument {
            name: "d",
            is_vector: false,
            dimension: LENGTH,
            doc: "Distance from the boundary, inside of it too.",
        },
        Argument {
            name: "away",
            is_vector: true,
            dimension: LENGTH,
            doc: "Vector from the nearest point of the boundary to the agent, in the axes of the map; of an interaction \
                  source in the frame of its agent, whose x axis points forward.",
        },
        Argument {
            name: "speed",
            is_vector: false,
            dimension: VELOCITY,
            doc: "Speed of the agent; for action sources.",
        },
        Argument {
            name: "heading",
            is_vector: false,
            dimension: ANGLE,
            doc: "Direction of travel, from the x axis of the map to the left, between -180 and 180 deg; for action \
                  sources with `headings`.",
        },
    ],
    result: Quantity::any(RATE),
};

/// The ground as a polygon, as an example.
pub(super) const AREA: &str = "[[0, 0], [10, 0], [10, 8], [0, 8]] m";
const POINTS: ValueType = ValueType::List(&ValueType::Pair(LENGTH));
const SQUARE: &str = "[[0, 0], [4, 0], [4, 3], [0, 3]] m";
const SOME_SOURCES: ValueType = ValueType::List(&ValueType::Name(Named::Own(&SOURCES)));
const SOME_AGENTS: ValueType = ValueType::List(&ValueType::Name(Named::Own(&AGENTS)));
const SOME_WALLS: ValueType = ValueType::List(&ValueType::Name(Named::Own(&WALLS)));

const fn count(least: f64, most: f64) -> ValueType {
    ValueType::Count(Quantity::between(NONE, least, most))
}

block! {
    /// A mission of the kind `search`.
    pub struct SearchBlock = SEARCH, "a search" {
        /// Corners of the ground on which the agents move. Default: the whole `map`, without which it is required.
        area: Vec<[f64; 2]> = optional(POINTS, AREA);
        /// Path of a map of ROS: the YAML file of `map_server`, which names an image (PGM or PNG). Agents move in its free cells;
        /// occupied ones, unknown ones and everything outside it are blocked.
        map: Option<Located<FileWith>> = optional(ValueType::FileWith(&MAP), "\"lab.yaml\"");
        /// Time, from the start on, in which rewards count.
        horizon: f64 = or(ValueType::Number(Quantity::above(TIME, 0.0)), "60 s");
        /// Number of goals that an agent considers after each action, `N_a`.
        goals: usize = or(count(1.0, 64.0), "8");
        /// Factor of the probability of the last action of a rollout, `w` of (14).
        reduction: f64 = or(ValueType::Number(Quantity::between(NONE, 0.01, 0.99)), "0.8");
        /// Discount of that reduction for each earlier action, `gamma` of (14).
        discount: f64 = or(ValueType::Number(Quantity::between(NONE, 0.5, 0.99)), "0.8");
        /// Number of nodes of each tree of ways around walls.
        tree_nodes: usize = or(count(16.0, 20_000.0), "400");
        /// Time that an agent stays at a source with an infinite pool before it decides again.
        stay: f64 = or(ValueType::Number(Quantity::between(TIME, 0.1, 1e6)), "5 s");
        /// Time that a plan looks ahead. Agents that have nothing more to do then are planned for anew. Default: up to the
        /// horizon.
        window: Option<f64> = optional(ValueType::Number(Quantity::above(TIME, 0.0)), "60 s");
        /// Width of the square cells of the belief about hidden objects.
        cell: f64 = or(ValueType::Number(Quantity::above(LENGTH, 0.0)), "1 m");
        /// Number of places from which an agent considers to look for hidden objects.
        lookouts: usize = or(count(1.0, 64.0), "16");
        /// Number of states of the search tree, with which planning ends.
        states: usize = or(count(100.0, 1e6), "20000");
        /// Reminders of people to send their pose; default: none.
        reminder: Option<ReminderBlock> = optional(ValueType::Block(&REMINDER), "{ kind multimodal  after 10 s }");
        /// Seed of the planner.
        seed: usize = or(count(0.0, 1e6), "1");
    }
    also [
        Key::optional("robot", ValueType::Block(&SEARCH_AGENT), "A robot of the team: `robot NAME { start [0, 0] m  speed 0.8 m/s }`.")
            .at(Place::Hq),
        Key::optional("robots", ValueType::Each(&ValueType::Block(&SEARCH_AGENT)), "The robots of the team, by name.")
            .at(Place::Yaml),
        Key::optional("human", ValueType::Block(&SEARCH_AGENT), "A person of the team: `human NAME { start [0, 0] m  speed 1.2 m/s }`.")
            .at(Place::Hq),
        Key::optional("humans", ValueType::Each(&ValueType::Block(&SEARCH_AGENT)), "The people of the team, by name.")
            .at(Place::Yaml),
        Key::optional("source", ValueType::Block(&SOURCE), "A source of reward: `source NAME { at [4, 2] m  radius 0.5 m  inside { rate 5 /s }  pool 10 }`.")
            .at(Place::Hq),
        Key::optional("sources", ValueType::Each(&ValueType::Block(&SOURCE)), "Sources of reward, by name.")
            .at(Place::Yaml),
        Key::optional("object", ValueType::Block(&HIDDEN), "Hidden objects that the team looks for: `object NAME { count 3  worth 10 }`.")
            .at(Place::Hq),
        Key::optional("objects", ValueType::Each(&ValueType::Block(&HIDDEN)), "Hidden objects that the team looks for, by name.")
            .at(Place::Yaml),
        Key::optional("wall", ValueType::Block(&WALL), "A wall: `wall NAME { line [[0, 2], [3, 2]] m }`.").at(Place::Hq),
        Key::optional("walls", ValueType::Each(&ValueType::Block(&WALL)), "Walls, by name.").at(Place::Yaml),
    ]
}

block! {
    /// A robot or a person of a search.
    pub struct AgentBlock = SEARCH_AGENT, "an agent of a search" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
        /// Position at the start.
        start: [f64; 2] = required(ValueType::Pair(LENGTH), "[0, 0] m");
        /// Direction at the start, from the x axis; for sources that are relative to the agent.
        heading: f64 = or(ValueType::Number(usual::JOINT_ANGLE), "0 rad");
        /// Speed of its motion.
        speed: f64 = required(ValueType::Number(usual::WALKING_SPEED), "1 m/s");
        /// Distance that its middle keeps from walls and from the edge of the area.
        radius: f64 = or(A_LENGTH, "0.3 m");
        /// Walls that it passes, as a drone passes low ones.
        passes: Vec<MemberIndex> = optional(SOME_WALLS, "[fence]");
        /// Sources that it is believed not to know of. The plan does not expect it to consume them.
        unaware: Vec<MemberIndex> = optional(SOME_SOURCES, "[light]");
        /// Its detection model for hidden objects; default: it does not look for them.
        sees: Option<SeesBlock> = optional(ValueType::Block(&SEES), "{ within 6 m  rate 0.2 /s }");
        /// Relative standard deviation of the times of its ways when they are executed with `operations sampled`. Plans do
        /// not use it.
        spread: f64 = or(A_SHARE, "0");
        /// Of a person: habits in scenarios, in which nobody plays the person. Plans do not use them, and on a page the person acts.
        habits: Option<HabitsBlock> = optional(ValueType::Block(&HABITS), "{ my_pose { mean 9.4 s  share 0.73 }  follows 0.8 }");
        /// The controller that drives its base in scenarios, of a robot. Without one it moves along its way as planned.
        runs: Option<DrivenBlock> = optional(ValueType::Block(&DRIVEN));
    }
}

block! {
    /// The detection model of an agent.
    pub struct SeesBlock = SEES, "what an agent sees" {
        /// Farthest distance at which it detects an object, in every direction.
        within: f64 = required(ValueType::Number(Quantity::above(LENGTH, 0.0)), "6 m");
        /// Detection rate: an object that is in sight for a time `t` is detected with the probability `1 - exp(-rate t)`.
        rate: f64 = required(ValueType::Number(Quantity::above(RATE, 0.0)), "0.2 /s");
    }
}

block! {
    /// Hidden objects that are alike.
    pub struct HiddenBlock = HIDDEN, "a group of hidden objects" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
        /// Number of the objects.
        count: usize = or(count(1.0, MAX_COUNT as f64), "1");
        /// Reward of finding one at the start; it falls evenly to zero at the horizon.
        worth: f64 = or(ValueType::Number(Quantity::above(NONE, 0.0)), "10");
        /// Corners of the region in which each object is believed to be, with the same probability everywhere. Default: the
        /// whole ground.
        region: Vec<[f64; 2]> = optional(POINTS, SQUARE);
        /// True positions in scenarios, one for each object, of which plans know nothing. Default: they are drawn from the region
        /// by the seed.
        positions: Vec<[f64; 2]> = optional(POINTS, "[[3, 2]] m");
    }
}

block! {
    /// A wall.
    pub struct WallBlock = WALL, "a wall" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
        /// Points of a thin wall.
        line: Vec<[f64; 2]> = optional(POINTS, "[[0, 2], [3, 2]] m");
        /// Corners of a solid obstacle, in place of `line`.
        polygon: Vec<[f64; 2]> = optional(POINTS, SQUARE);
        /// True if hidden objects behind it are in sight, as behind glass.
        transparent: bool = or(ValueType::Flag, "false");
    }
}

block! {
    /// A source of reward.
    pub struct SourceBlock = SOURCE, "a source" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
        /// Its set: of an element of the `environment`, of an `action` (its boundary is an interval of motions), of a `task`
        /// with a fixed place, or of an `interaction` (its boundary is in the frame of an agent).
        kind: Word = or(ValueType::Choice(&SourceKind::NAMES), "task");
        /// Centre of its boundary, a circle; without `radius` the boundary is this point.
        at: Option<[f64; 2]> = optional(ValueType::Pair(LENGTH));
        /// Radius of the circle.
        radius: Option<f64> = optional(ValueType::Number(Quantity::above(LENGTH, 0.0)), "0.5 m");
        /// Corners of its boundary, a polygon.
        polygon: Vec<[f64; 2]> = optional(POINTS, SQUARE);
        /// Points of its boundary, a line without an inside.
        line: Vec<[f64; 2]> = optional(POINTS, "[[0, 2], [3, 2]] m");
        /// Points that are its boundary.
        points: Vec<[f64; 2]> = optional(POINTS, "[[0, 2], [3, 2]] m");
        /// Boundary of an action source: an interval of speeds.
        speeds: Option<Range> = optional(ValueType::Range(Quantity { min_included: true, ..usual::WALKING_SPEED }), "[0.1, 2] m/s");
        /// Boundary of an action source: an interval of directions of travel, from the x axis of the map to the left.
        headings: Option<Range> = optional(ValueType::Range(Quantity::any(ANGLE)), "[80, 100] deg");
        /// Reward rate inside the boundary and on it, `r_i`; default: none.
        inside: Option<RateBlock> = optional(ValueType::Block(&REWARD_RATE), "{ rate 5 /s }");
        /// Reward rate outside the boundary, `r_e`; default: none.
        outside: Option<RateBlock> = optional(ValueType::Block(&REWARD_RATE), "{ rate 5 /s  fall gaussian  scale 0.5 m }");
        /// Reward that it holds, `R`; default: infinite.
        pool: Option<f64> = optional(A_WEIGHT, "10");
        /// Agents that may consume it, `tau`; default: all.
        targets: Option<Vec<MemberIndex>> = optional(SOME_AGENTS, "[anna]");
        /// Strict precedence: it is rewarding only after all of these sources are consumed.
        after: Vec<MemberIndex> = optional(SOME_SOURCES, "[light]");
        /// Soft precedence: it is rewarding only until one of these sources is consumed.
        until: Vec<MemberIndex> = optional(SOME_SOURCES, "[exit]");
        /// Codependent consumption: of a unit that is taken from it, this share is also taken from each of these sources,
        /// and the other way round.
        codependent: Vec<ByName<f64>> = optional(ValueType::Of(Named::Own(&SOURCES), &A_SHARE), "{ till_2 1 }");
        /// Agent in whose frame the boundary of an interaction source is, with its heading as the x axis.
        of: Option<MemberIndex> = optional(ValueType::Name(Named::Own(&AGENTS)), "anna");
    }
}

block! {
    /// A reward rate as a function of the vector from the boundary.
    pub struct RateBlock = REWARD_RATE, "a reward rate" {
        /// Reward a second at the boundary; with `fall rising` the value that it approaches. Negative for what is to be
        /// avoided. As an expression it depends on the distance `d` from the boundary and on the vector `away` from the nearest
        /// point of the boundary, `2 /s * exp(-(away.x/(1 m))^2)`; of an action source on the `speed` and the `heading` of the
        /// agent, `-0.1 /m * speed`.
        rate: Function = required(ValueType::Function(&RATE_OF), "5 /s");
        /// Form over `d` by which the rate is multiplied, with the length `scale`: `constant`; `linear`, down to zero at `scale`; `exponential`,
        /// `exp(-d/scale)`; `gaussian`, `exp(-d^2/(2 scale^2))`; `rising`, `1 - exp(-d/scale)`.
        fall: Word = or(ValueType::Choice(&Fall::NAMES), "constant");
        /// Length of the form.
        scale: f64 = or(ValueType::Number(Quantity::above(LENGTH, 0.0)), "1 m");
    }
}
