//! The blocks of a mission of layers: keys with their types, units, ranges, defaults and texts.

use std::collections::BTreeSet;

use blocks::{ByName, Key, Located, MemberIndex, Members, Named, Place, ValueType, block};
use quantities::dimension::{Dimension, NONE};
use quantities::{Quantity, usual};
use serde::{Deserialize, Serialize};

use crate::declare::common::{A_FACTOR, A_LENGTH, A_SHARE, A_WEIGHT, ENERGY, EnergyBlock, LABEL, PLACE_BLOCK};
use crate::numbers::Range;

const PER_MASS: Dimension = Dimension { kg: -1, ..NONE };
const A_MASS: ValueType = ValueType::Number(usual::HANDLED_MASS);
const A_TIME: ValueType = ValueType::Number(usual::WORK_TIME);
const WORDS: ValueType = ValueType::List(&ValueType::NewName);

/// The objects, in the order of [`Problem::objects`](super::problem::Problem::objects).
pub static OBJECTS: Members = Members { noun: "object", roles: &["object"] };
/// The agents, in the order of [`Problem::agents`](super::problem::Problem::agents).
pub static AGENTS: Members = Members { noun: "agent", roles: &["robot", "human"] };

block! {
    /// A mission of the kind `layers`.
    pub struct LayersBlock = LAYERS, "a mission of layers" {
        /// Weights of the terms in the cost of a plan.
        weights: Weights = optional(ValueType::Block(&LAYERS_WEIGHTS));
        /// Number of tasks that are planned at a time; default: all at once.
        batch: Option<usize> = optional(ValueType::Count(Quantity::at_least(NONE, 1.0)));
        /// During the execution of a plan: tasks that have not begun are planned again when the cost has changed by
        /// more than this fraction.
        reallocate_above: f64 = or(A_WEIGHT, "0.1");
        /// Instruction for a language model that writes the layers, `hierarq context`. With an instruction, the
        /// layers may be omitted.
        instruction: Option<String> = optional(ValueType::Text, "\"Build the letter H.\"");
        /// Rules that the language model must follow, one sentence each: `["Objects must not overlap."]`.
        directives: Vec<String> = optional(ValueType::List(&ValueType::Text), "[\"Objects must not overlap.\"]");
        /// A JSON file of layers, in place of `layer`, written by `hierarq context` or by a person.
        layers_from: Option<Located<String>> = optional(ValueType::File, "\"layers.json\"");
        /// True if the way back to the base is part of each task.
        returns: bool = or(ValueType::Flag, "true");
    }
    also [
        Key::optional("robot", ValueType::Block(&LAYERS_ROBOT), "A robot of the team: `robot NAME { place [x, y, z] m  speed [0.1, 0.4] m/s  skills { pick 2 s } }`.")
        .at(Place::Hq),
        Key::optional("robots", ValueType::Each(&ValueType::Block(&LAYERS_ROBOT)), "The robots of the team, by name.")
            .at(Place::Yaml),
        Key::optional("human", ValueType::Block(&LAYERS_HUMAN), "A person of the team: `human NAME { place [x, y, z] m  speed 0.5 m/s  skills { pick 2 s } }`.")
        .at(Place::Hq),
        Key::optional("humans", ValueType::Each(&ValueType::Block(&LAYERS_HUMAN)), "The people of the team, by name.")
            .at(Place::Yaml),
        Key::optional("object", ValueType::Block(&OBJECT), "An object that a task uses: `object NAME { place [x, y, z] m  features [cube, red] }`. Only one task can \
             use it.")
        .at(Place::Hq),
        Key::optional("objects", ValueType::Each(&ValueType::Block(&OBJECT)), "Objects that tasks use, by name; only one task can use each.")
        .at(Place::Yaml),
        Key::optional("place", ValueType::Block(&PLACE_BLOCK), "A named place: `place NAME { at [x, y, z] m }`. Tasks, agents and objects can refer to it.")
        .at(Place::Hq),
        Key::optional("places", ValueType::Each(&ValueType::Block(&PLACE_BLOCK)), "Named places.").at(Place::Yaml),
        Key::optional("layer", ValueType::Block(&LAYER), "Tasks without an order among them: `layer NAME { task NAME = SKILL { .. } }`. A layer begins when the \
             layers before it are done.")
        .at(Place::Hq),
        Key::optional("layers", ValueType::Each(&ValueType::Block(&LAYER)), "Layers of tasks by name. The tasks of a layer have no order among them; a layer begins when the layers \
             before it are done.")
        .at(Place::Yaml),
    ]
}

block! {
    /// Weights of the cost (6.7) of a plan of layers.
    #[derive(Copy, PartialEq, Serialize, Deserialize)]
    pub struct Weights = LAYERS_WEIGHTS, "`weights` of layers" {
        /// Weight of the workload of people, `beta`.
        workload: f64 = or(A_WEIGHT, "1");
        /// Weight of the energy of robots, `gamma`.
        energy: f64 = or(A_WEIGHT, "1");
        /// Weight of the makespan, `eta`.
        makespan: f64 = or(A_WEIGHT, "1");
    }
}

const PLACE: Key = Key::required(
    "place",
    ValueType::Spot,
    "Base of the agent, a position or a named place: every task begins and ends there.",
);
const SKILLS: Key = Key::required(
    "skills",
    ValueType::Each(&A_TIME),
    "Skills of the agent, each with the time that it takes in addition to the motion: `skills { pick_and_place 2 s }`.",
)
.example("pick_and_place 2 s");
const REACH: Key = Key::optional("reach", A_LENGTH, "Largest distance from its base; default: unlimited.");
const PAYLOAD: Key =
    Key::optional("payload", A_MASS, "Mass of the heaviest object that it handles; default: unlimited.");
const CANNOT: Key =
    Key::optional("cannot", WORDS, "Features of objects that it cannot handle: `[fragile]`.").example("[fragile]");
const SPREAD: Key = Key::or(
    "spread",
    A_SHARE,
    "0",
    "Relative standard deviation of the durations of its tasks when they are executed with `operations sampled`. Plans \
     do not use it.",
);

block! {
    /// A robot of a team.
    pub struct RobotBlock = LAYERS_ROBOT, "a robot of layers" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
        /// Base.
        place: [f64; 3] = same(PLACE);
        /// Range of its speed, `[lowest, highest]`; one number for a fixed speed.
        speed: Range = required(ValueType::Range(usual::WALKING_SPEED));
        /// Actions, each with its duration without motion (s).
        skills: Vec<ByName<f64>> = same(SKILLS);
        /// Largest distance from its base (m).
        reach: Option<f64> = same(REACH);
        /// Mass of the heaviest object (kg).
        payload: Option<f64> = same(PAYLOAD);
        /// Features of objects that it cannot handle.
        cannot: BTreeSet<String> = same(CANNOT);
        /// Relative standard deviation of durations.
        spread: f64 = same(SPREAD);
        /// Physical factor: larger for a heavier robot, which needs more energy.
        factor: f64 = or(A_FACTOR, "1");
        /// Power during motion, `standby + friction v + drag v^2`. Only ratios matter.
        energy: EnergyBlock = optional(ValueType::Block(&ENERGY));
    }
}

block! {
    /// A person of a team.
    pub struct HumanBlock = LAYERS_HUMAN, "a human of layers" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
        /// Base.
        place: [f64; 3] = same(PLACE);
        /// Highest speed of the person, with the lightest object.
        speed: f64 = required(ValueType::Number(usual::WALKING_SPEED), "0.5 m/s");
        /// Actions, each with its duration without motion (s).
        skills: Vec<ByName<f64>> = same(SKILLS);
        /// Fraction of that speed during a skill, `kappa`: `paces { inspect 0.5 }`; default: 1.
        paces: Vec<ByName<f64>> = optional(ValueType::Each(&A_SHARE));
        /// Reduction of the speed by heavier objects, `alpha`: for each kg above the lightest object.
        slowing: f64 = or(ValueType::Number(Quantity::at_least(PER_MASS, 0.0)), "0 /kg");
        /// Largest distance from the base (m).
        reach: Option<f64> = same(REACH);
        /// Mass of the heaviest object (kg).
        payload: Option<f64> = same(PAYLOAD);
        /// Features of objects that the person cannot handle.
        cannot: BTreeSet<String> = same(CANNOT);
        /// Relative standard deviation of durations.
        spread: f64 = same(SPREAD);
    }
}

block! {
    /// An object.
    pub struct ObjectBlock = OBJECT, "an object" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
        /// Position of the object, or a named place.
        place: [f64; 3] = required(ValueType::Spot);
        /// Mass of the object.
        mass: f64 = or(A_MASS, "0 kg");
        /// Words that describe the object: `[cube, red]`.
        features: BTreeSet<String> = optional(WORDS, "[cube, red]");
    }
}

block! {
    /// A layer.
    pub struct LayerBlock = LAYER, "a layer" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
    }
    also [
        Key::required("task", ValueType::Block(&LAYERS_TASK), "A task: `task NAME = SKILL { features [cube] }`.")
            .at(Place::Hq),
        Key::required("tasks", ValueType::Each(&ValueType::Block(&LAYERS_TASK)), "Tasks by name: `NAME: { SKILL: { .. } }`.")
        .at(Place::Yaml),
    ]
}

block! {
    /// A task of a layer.
    pub struct TaskBlock = LAYERS_TASK, "a task of a layer" {
        /// See [`LABEL`].
        label: Option<String> = same(LABEL);
        /// Features that the object of the task must have, `[cube, red]`. Without `features` and `object`, the task
        /// uses no object.
        features: BTreeSet<String> = optional(WORDS, "[cube, red]");
        /// End of the task, a position or a named place; default: the place of the object.
        to: Option<[f64; 3]> = optional(ValueType::Spot);
        /// Intermediate points on the way from the object to the end, in order: `[[0, 0, 1], [1, 0, 1]] m`, `[shelf,
        /// table]`.
        via: Vec<[f64; 3]> = optional(ValueType::List(&ValueType::Spot));
        /// The object that must be used; default: any object with the features.
        object: Option<MemberIndex> = optional(ValueType::Name(Named::Own(&OBJECTS)));
        /// The agent that must do the task; default: any agent that is able to.
        agent: Option<MemberIndex> = optional(ValueType::Name(Named::Own(&AGENTS)));
    }
}
