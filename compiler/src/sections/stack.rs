//! The keys of a stack, of its levels and of what stands in them.

use stdlib_tasks::dimension::NONE;
use stdlib_tasks::params::Quantity;

use super::{Holds, Key, Named, Place, Section};

/// A stack.
pub static STACK: Section = Section {
    name: "a stack",
    keys: &[
        Key::optional("lock", Holds::Joints, "Joints, groups and patterns that are held still while this stack runs."),
        Key::optional(
            "from",
            Holds::Name(Named::Stack),
            "The stack from which this one is made: a name, or `NAME(..)`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "changes",
            Holds::List(&Holds::Block(&CHANGE)),
            "Changes of the stack from which this one is made: `- { replace: NAME, tasks: [..] }`, `- { add: NAME, \
             before: NAME, tasks: [..] }`, `- { remove: NAME }`.",
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
            "In a stack `from` another one: replaces a level, `replace NAME { .. }`.",
        )
        .at(Place::Hq),
        Key::optional(
            "add",
            Holds::Block(&LEVEL),
            "In a stack `from` another one: adds a level, `add NAME { .. } before OTHER`.",
        )
        .at(Place::Hq),
        Key::optional(
            "remove",
            Holds::Name(Named::Level),
            "In a stack `from` another one: removes a level, `remove NAME`.",
        )
        .at(Place::Hq),
    ],
};

/// A change of a stack, in YAML.
pub static CHANGE: Section = Section {
    name: "a change of a stack",
    keys: &[
        Key::optional("replace", Holds::Name(Named::Level), "The level that is replaced by this one.").at(Place::Yaml),
        Key::optional("add", Holds::NewName, "The name of the added level.").at(Place::Yaml),
        Key::optional("remove", Holds::Name(Named::Level), "The level that is removed.").at(Place::Yaml),
        Key::optional("before", Holds::Name(Named::Level), "The level below the added one.").at(Place::Yaml),
        Key::optional("after", Holds::Name(Named::Level), "The level above the added one.").at(Place::Yaml),
    ],
};

/// A level.
pub static LEVEL: Section = Section {
    name: "a level",
    keys: &[
        Key::required("name", Holds::NewName, "The name of the level, for tables and logs.").at(Place::Yaml),
        Key::or("hard", Holds::Flag, "false", "A hard level takes no slack: it is met, or the run has a fault.")
            .at(Place::Word),
        Key::or(
            "damping",
            Holds::NumberOr(Quantity::at_least(NONE, 0.0), &["auto", "none"]),
            "auto",
            "Treatment of a level that cannot be met. `auto`: exact if the level can be met, damped if it cannot. \
             `none`: always exact. A number of zero or more: `damping · |v|²` in the cost of the level, met or not.",
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
            "Weight of the squared slack of this task relative to the other tasks of its level.",
        )
        .at(Place::Word),
    ],
};
