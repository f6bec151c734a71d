//! The keys of a stack, of its levels and of what stands in them.

use stdlib_tasks::dimension::NONE;
use stdlib_tasks::params::Quantity;

use super::{Holds, Key, Named, Place, Section};

/// A stack.
pub static STACK: Section = Section {
    name: "a stack",
    keys: &[
        Key::optional("lock", Holds::Joints, "Joints, groups and patterns that stand still while this stack runs."),
        Key::optional(
            "from",
            Holds::Name(Named::Stack),
            "The stack that this one is made from: a name, or `NAME(..)`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "changes",
            Holds::List(&Holds::Block(&CHANGE)),
            "What it changes in the stack that it is made from: `- { replace: NAME, tasks: [..] }`, `- { add: NAME, before: \
             NAME, tasks: [..] }`, `- { remove: NAME }`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "levels",
            Holds::List(&Holds::Block(&LEVEL)),
            "The levels, the most important first: `- { name: limits, hard: true, tasks: [..] }`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "level",
            Holds::Block(&LEVEL),
            "A level: `level NAME hard { task  task weight 2 }`. The first is the most important.",
        )
        .at(Place::Hq),
        Key::optional(
            "replace",
            Holds::Block(&LEVEL),
            "In a stack `from` another one: another level in the place of one, `replace NAME { .. }`.",
        )
        .at(Place::Hq),
        Key::optional(
            "add",
            Holds::Block(&LEVEL),
            "In a stack `from` another one: one more level, `add NAME { .. } before OTHER`.",
        )
        .at(Place::Hq),
        Key::optional(
            "remove",
            Holds::Name(Named::Level),
            "In a stack `from` another one: a level less, `remove NAME`.",
        )
        .at(Place::Hq),
    ],
};

/// A change of a stack, in YAML.
pub static CHANGE: Section = Section {
    name: "a change of a stack",
    keys: &[
        Key::optional("replace", Holds::Name(Named::Level), "The level that this one stands for.").at(Place::Yaml),
        Key::optional("add", Holds::NewName, "The name of one more level.").at(Place::Yaml),
        Key::optional("remove", Holds::Name(Named::Level), "The level that is left out.").at(Place::Yaml),
        Key::optional("before", Holds::Name(Named::Level), "The level that the new one stands before.").at(Place::Yaml),
        Key::optional("after", Holds::Name(Named::Level), "The level that the new one stands behind.").at(Place::Yaml),
    ],
};

/// A level.
pub static LEVEL: Section = Section {
    name: "a level",
    keys: &[
        Key::required("name", Holds::NewName, "The name of the level, for tables and logs.").at(Place::Yaml),
        Key::or("hard", Holds::Flag, "false", "This level takes no slack: it is met, or the run has a fault.")
            .at(Place::Word),
        Key::or(
            "damping",
            Holds::NumberOr(Quantity::at_least(NONE, 0.0), &["auto", "none"]),
            "auto",
            "What keeps the level from chasing what it cannot reach. `auto`: exact where the level can be met, damped where \
             it cannot. `none`: exact always. A number of zero or more: `damping · |v|²` in the cost of the level, met or not.",
        ),
        Key::required(
            "tasks",
            Holds::List(&Holds::Block(&MEMBER)),
            "The tasks of the level: names, tasks in place, or `{ task: .., weight: .. }`.",
        )
        .at(Place::Yaml),
    ],
};

/// A task in a level.
pub static MEMBER: Section = Section {
    name: "a member",
    keys: &[
        Key::required("task", Holds::Tasks, "The name of a task, or a task in place.").at(Place::Yaml),
        Key::or(
            "weight",
            Holds::Number(Quantity::above(NONE, 0.0)),
            "1",
            "What the squared slack of this task counts against that of the others of its level.",
        )
        .at(Place::Word),
    ],
};
