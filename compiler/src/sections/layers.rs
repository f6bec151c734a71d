//! The keys of missions of the kind `layers`: a team, objects, and layers of tasks.

use stdlib_tasks::dimension::{Dimension, LENGTH, MASS, NONE, TIME, VELOCITY};
use stdlib_tasks::params::Quantity;

use super::mission::{ENERGY, LABEL};
use super::{Holds, Key, Named, Place, Section};

const PER_MASS: Dimension = Dimension { kg: -1, ..NONE };

const A_LENGTH: Holds = Holds::Number(Quantity::at_least(LENGTH, 0.0));
const A_WEIGHT: Holds = Holds::Number(Quantity::at_least(NONE, 0.0));
const PLACE: Key =
    Key::required("place", Holds::Spot, "Its base, a position or a place: where every task begins and ends.");
const SKILLS: Key = Key::required(
    "skills",
    Holds::Each(&Holds::Number(Quantity::at_least(TIME, 0.0))),
    "What it is able to do, each with the time that this takes beside moving: `skills { pick_and_place 2 s }`.",
);
const REACH: Key = Key::optional("reach", A_LENGTH, "How far from its base it gets; everywhere where left out.");
const PAYLOAD: Key = Key::optional(
    "payload",
    Holds::Number(Quantity::at_least(MASS, 0.0)),
    "The heaviest object that it handles; any where left out.",
);
const CANNOT: Key =
    Key::optional("cannot", Holds::List(&Holds::NewName), "Features of objects that it cannot handle: `[fragile]`.");

const SPREAD: Key = Key::or(
    "spread",
    Holds::Number(Quantity::between(NONE, 0.0, 1.0)),
    "0",
    "How much its tasks take longer or shorter than planned when they are executed with `operations sampled`: the standard \
     deviation of their time, relative to it. Plans do not count with it.",
);

/// A mission of the kind `layers`.
pub static LAYERS: Section = Section {
    name: "a mission of layers",
    keys: &[
        Key::optional("weights", Holds::Block(&LAYERS_WEIGHTS), "What counts how much in the cost of a plan."),
        Key::optional(
            "batch",
            Holds::Number(Quantity::at_least(NONE, 1.0)),
            "How many tasks are planned at a time, a whole number; all at once where left out.",
        ),
        Key::or(
            "reallocate_above",
            A_WEIGHT,
            "0.1",
            "While a plan is executed: what has not begun is planned anew when the cost has changed by more than this share.",
        ),
        Key::optional(
            "instruction",
            Holds::Text,
            "What is to be done, for a language model that is asked for the layers: `hierarq context`. Then layers may be left out.",
        ),
        Key::optional(
            "directives",
            Holds::List(&Holds::Text),
            "What the model must obey, a sentence each: `[\"Objects must not overlap.\"]`.",
        ),
        Key::optional(
            "layers_from",
            Holds::Text,
            "A file of layers, in JSON, in place of `layer`: what `hierarq context` writes, or a person.",
        ),
        Key::or("returns", Holds::Flag, "true", "Whether the way back to the base is a part of each task."),
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
            "Something that a task uses: `object NAME { place [x, y, z] m  features [cube, red] }`. One task uses it.",
        )
        .at(Place::Hq),
        Key::optional("objects", Holds::Each(&Holds::Block(&OBJECT)), "What tasks use, by name; one task uses each.")
            .at(Place::Yaml),
        Key::optional(
            "place",
            Holds::Block(&LAYERS_PLACE),
            "A place with a name: `place NAME { at [x, y, z] m }`. Tasks go there, agents and objects stand there.",
        )
        .at(Place::Hq),
        Key::optional("places", Holds::Each(&Holds::Block(&LAYERS_PLACE)), "Places with names.").at(Place::Yaml),
        Key::optional(
            "layer",
            Holds::Block(&LAYER),
            "Tasks that may be done in any order: `layer NAME { task NAME = SKILL { .. } }`. It begins when those before it \
             are done.",
        )
        .at(Place::Hq),
        Key::optional(
            "layers",
            Holds::Each(&Holds::Block(&LAYER)),
            "Tasks that may be done in any order, by the name of their layer; a layer begins when those before it are done.",
        )
        .at(Place::Yaml),
    ],
};

/// Weights of the cost of a plan of layers.
pub static LAYERS_WEIGHTS: Section = Section {
    name: "`weights` of layers",
    keys: &[
        Key::or("workload", A_WEIGHT, "1", "Of the workload of people, `beta`."),
        Key::or("energy", A_WEIGHT, "1", "Of the energy of robots, `gamma`."),
        Key::or("makespan", A_WEIGHT, "1", "Of the time until all is done, `eta`."),
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
            "How fast it may move, `[least, greatest]`; one number for a fixed speed.",
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
            "What it draws while it moves, `standby + friction v + drag v^2`. Only ratios matter.",
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
            "How fast the person moves at most, with the lightest object.",
        ),
        SKILLS,
        Key::optional(
            "paces",
            Holds::Each(&Holds::Number(Quantity::between(NONE, 0.0, 1.0))),
            "The share of that speed that a skill allows: `paces { inspect 0.5 }`; 1 where left out, `kappa`.",
        ),
        Key::or(
            "slowing",
            Holds::Number(Quantity::at_least(PER_MASS, 0.0)),
            "0 /kg",
            "How much heavier objects slow, `alpha`: each kg above the lightest.",
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
        Key::required("place", Holds::Spot, "Where it is, a position or a place."),
        Key::or("mass", Holds::Number(Quantity::at_least(MASS, 0.0)), "0 kg", "How heavy it is."),
        Key::optional("features", Holds::List(&Holds::NewName), "Words for what it is: `[cube, red]`."),
    ],
};

/// A place with a name.
pub static LAYERS_PLACE: Section =
    Section { name: "a place", keys: &[LABEL, Key::required("at", Holds::Vector(LENGTH), "Where it is.")] };

/// A layer.
pub static LAYER: Section = Section {
    name: "a layer",
    keys: &[
        LABEL,
        Key::required("task", Holds::Block(&LAYERS_TASK), "Something to do: `task NAME = SKILL { features [cube] }`.")
            .at(Place::Hq),
        Key::required("tasks", Holds::Each(&Holds::Block(&LAYERS_TASK)), "What is to do: `NAME: { SKILL: { .. } }`.")
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
            "What the object that is used must be, `[cube, red]`; without it and without `object` none is used.",
        ),
        Key::optional(
            "to",
            Holds::Spot,
            "Where the task ends, a position or a place; where the object is, where left out.",
        ),
        Key::optional(
            "via",
            Holds::List(&Holds::Spot),
            "Where it passes on the way from the object to the end, in order: `[[0, 0, 1], [1, 0, 1]] m`, `[shelf, table]`.",
        ),
        Key::optional(
            "object",
            Holds::Name(Named::Member),
            "The object that must be used; any with the features else.",
        ),
        Key::optional("agent", Holds::Name(Named::Member), "Who must do it; anybody who is able to where left out."),
    ],
};
