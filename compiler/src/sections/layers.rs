//! The keys of missions of the kind `layers`: a team, objects, and layers of tasks.

use stdlib_tasks::dimension::{Dimension, LENGTH, MASS, NONE, TIME, VELOCITY};
use stdlib_tasks::params::Quantity;

use super::mission::{ENERGY, LABEL};
use super::{Holds, Key, Named, Place, Section};

const PER_MASS: Dimension = Dimension { kg: -1, ..NONE };

const A_LENGTH: Holds = Holds::Number(Quantity::at_least(LENGTH, 0.0));
const A_WEIGHT: Holds = Holds::Number(Quantity::at_least(NONE, 0.0));
const PLACE: Key = Key::required(
    "place",
    Holds::Spot,
    "Base of the agent, a position or a named place: every task begins and ends there.",
);
const SKILLS: Key = Key::required(
    "skills",
    Holds::Each(&Holds::Number(Quantity::at_least(TIME, 0.0))),
    "Skills of the agent, each with the time that it takes in addition to the motion: `skills { pick_and_place 2 s }`.",
);
const REACH: Key = Key::optional("reach", A_LENGTH, "Largest distance from its base; default: unlimited.");
const PAYLOAD: Key = Key::optional(
    "payload",
    Holds::Number(Quantity::at_least(MASS, 0.0)),
    "Mass of the heaviest object that it handles; default: unlimited.",
);
const CANNOT: Key =
    Key::optional("cannot", Holds::List(&Holds::NewName), "Features of objects that it cannot handle: `[fragile]`.");

const SPREAD: Key = Key::or(
    "spread",
    Holds::Number(Quantity::between(NONE, 0.0, 1.0)),
    "0",
    "Relative standard deviation of the durations of its tasks when they are executed with `operations sampled`. Plans \
     do not use it.",
);

/// A mission of the kind `layers`.
pub static LAYERS: Section = Section {
    name: "a mission of layers",
    keys: &[
        Key::optional("weights", Holds::Block(&LAYERS_WEIGHTS), "Weights of the terms in the cost of a plan."),
        Key::optional(
            "batch",
            Holds::Number(Quantity::at_least(NONE, 1.0)),
            "Number of tasks that are planned at a time, a whole number; default: all at once.",
        ),
        Key::or(
            "reallocate_above",
            A_WEIGHT,
            "0.1",
            "During the execution of a plan: tasks that have not begun are planned again when the cost has changed by \
             more than this fraction.",
        ),
        Key::optional(
            "instruction",
            Holds::Text,
            "Instruction for a language model that writes the layers, `hierarq context`. With an instruction, the \
             layers may be omitted.",
        ),
        Key::optional(
            "directives",
            Holds::List(&Holds::Text),
            "Rules that the language model must follow, one sentence each: `[\"Objects must not overlap.\"]`.",
        ),
        Key::optional(
            "layers_from",
            Holds::Text,
            "A JSON file of layers, in place of `layer`, written by `hierarq context` or by a person.",
        ),
        Key::or("returns", Holds::Flag, "true", "True if the way back to the base is part of each task."),
        Key::optional(
            "robot",
            Holds::Block(&LAYERS_ROBOT),
            "A robot of the team: `robot NAME { place [x, y, z] m  speed [0.1, 0.4] m/s  skills { pick 2 s } }`.",
        )
        .at(Place::Hq),
        Key::optional("robots", Holds::Each(&Holds::Block(&LAYERS_ROBOT)), "The robots of the team, by name.")
            .at(Place::Yaml),
        Key::optional(
            "human",
            Holds::Block(&LAYERS_HUMAN),
            "A person of the team: `human NAME { place [x, y, z] m  speed 0.5 m/s  skills { pick 2 s } }`.",
        )
        .at(Place::Hq),
        Key::optional("humans", Holds::Each(&Holds::Block(&LAYERS_HUMAN)), "The people of the team, by name.")
            .at(Place::Yaml),
        Key::optional(
            "object",
            Holds::Block(&OBJECT),
            "An object that a task uses: `object NAME { place [x, y, z] m  features [cube, red] }`. Only one task can \
             use it.",
        )
        .at(Place::Hq),
        Key::optional(
            "objects",
            Holds::Each(&Holds::Block(&OBJECT)),
            "Objects that tasks use, by name; only one task can use each.",
        )
        .at(Place::Yaml),
        Key::optional(
            "place",
            Holds::Block(&LAYERS_PLACE),
            "A named place: `place NAME { at [x, y, z] m }`. Tasks, agents and objects can refer to it.",
        )
        .at(Place::Hq),
        Key::optional("places", Holds::Each(&Holds::Block(&LAYERS_PLACE)), "Named places.").at(Place::Yaml),
        Key::optional(
            "layer",
            Holds::Block(&LAYER),
            "Tasks without an order among them: `layer NAME { task NAME = SKILL { .. } }`. A layer begins when the \
             layers before it are done.",
        )
        .at(Place::Hq),
        Key::optional(
            "layers",
            Holds::Each(&Holds::Block(&LAYER)),
            "Layers of tasks by name. The tasks of a layer have no order among them; a layer begins when the layers \
             before it are done.",
        )
        .at(Place::Yaml),
    ],
};

/// Weights of the cost of a plan of layers.
pub static LAYERS_WEIGHTS: Section = Section {
    name: "`weights` of layers",
    keys: &[
        Key::or("workload", A_WEIGHT, "1", "Weight of the workload of people, `beta`."),
        Key::or("energy", A_WEIGHT, "1", "Weight of the energy of robots, `gamma`."),
        Key::or("makespan", A_WEIGHT, "1", "Weight of the makespan, `eta`."),
    ],
};

/// A robot of a team.
pub static LAYERS_ROBOT: Section = Section {
    name: "a robot of layers",
    keys: &[
        LABEL,
        PLACE,
        Key::required(
            "speed",
            Holds::Range(Quantity::above(VELOCITY, 0.0)),
            "Range of its speed, `[lowest, highest]`; one number for a fixed speed.",
        ),
        SKILLS,
        REACH,
        PAYLOAD,
        CANNOT,
        SPREAD,
        Key::or(
            "factor",
            Holds::Number(Quantity::above(NONE, 0.0)),
            "1",
            "Physical factor: larger for a heavier robot, which needs more energy.",
        ),
        Key::optional(
            "energy",
            Holds::Block(&ENERGY),
            "Power during motion, `standby + friction v + drag v^2`. Only ratios matter.",
        ),
    ],
};

/// A person of a team.
pub static LAYERS_HUMAN: Section = Section {
    name: "a human of layers",
    keys: &[
        LABEL,
        PLACE,
        Key::required(
            "speed",
            Holds::Number(Quantity::above(VELOCITY, 0.0)),
            "Highest speed of the person, with the lightest object.",
        ),
        SKILLS,
        Key::optional(
            "paces",
            Holds::Each(&Holds::Number(Quantity::between(NONE, 0.0, 1.0))),
            "Fraction of that speed during a skill, `kappa`: `paces { inspect 0.5 }`; default: 1.",
        ),
        Key::or(
            "slowing",
            Holds::Number(Quantity::at_least(PER_MASS, 0.0)),
            "0 /kg",
            "Reduction of the speed by heavier objects, `alpha`: for each kg above the lightest object.",
        ),
        REACH,
        PAYLOAD,
        CANNOT,
        SPREAD,
    ],
};

/// An object.
pub static OBJECT: Section = Section {
    name: "an object",
    keys: &[
        LABEL,
        Key::required("place", Holds::Spot, "Position of the object, or a named place."),
        Key::or("mass", Holds::Number(Quantity::at_least(MASS, 0.0)), "0 kg", "Mass of the object."),
        Key::optional("features", Holds::List(&Holds::NewName), "Words that describe the object: `[cube, red]`."),
    ],
};

/// A place with a name.
pub static LAYERS_PLACE: Section =
    Section { name: "a place", keys: &[LABEL, Key::required("at", Holds::Vector(LENGTH), "Position of the place.")] };

/// A layer.
pub static LAYER: Section = Section {
    name: "a layer",
    keys: &[
        LABEL,
        Key::required("task", Holds::Block(&LAYERS_TASK), "A task: `task NAME = SKILL { features [cube] }`.")
            .at(Place::Hq),
        Key::required("tasks", Holds::Each(&Holds::Block(&LAYERS_TASK)), "Tasks by name: `NAME: { SKILL: { .. } }`.")
            .at(Place::Yaml),
    ],
};

/// A task of a layer.
pub static LAYERS_TASK: Section = Section {
    name: "a task of a layer",
    keys: &[
        LABEL,
        Key::optional(
            "features",
            Holds::List(&Holds::NewName),
            "Features that the object of the task must have, `[cube, red]`. Without `features` and `object`, the task \
             uses no object.",
        ),
        Key::optional(
            "to",
            Holds::Spot,
            "End of the task, a position or a named place; default: the place of the object.",
        ),
        Key::optional(
            "via",
            Holds::List(&Holds::Spot),
            "Intermediate points on the way from the object to the end, in order: `[[0, 0, 1], [1, 0, 1]] m`, `[shelf, \
             table]`.",
        ),
        Key::optional(
            "object",
            Holds::Name(Named::Member),
            "The object that must be used; default: any object with the features.",
        ),
        Key::optional(
            "agent",
            Holds::Name(Named::Member),
            "The agent that must do the task; default: any agent that is able to.",
        ),
    ],
};
