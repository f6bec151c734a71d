//! The keys of a stack, of its levels and of what stands in them.

use blocks::{Located, NumberOrWord, Unbound, block};
use stdlib_tasks::dimension::NONE;
use stdlib_tasks::params::Quantity;

use super::{BlockSchema, Key, Named, Place, ValueType};

block! {
    /// A stack.
    pub struct StackBlock = STACK, "a stack" {
        /// Joints, groups and patterns that are held still while this stack runs.
        lock: Option<Located<Unbound>> = elsewhere(ValueType::Joints);
    }
    also [
        Key::optional(
            "from",
            ValueType::Name(Named::Stack),
            "The stack from which this one is made: a name, or `NAME(..)`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "changes",
            ValueType::List(&ValueType::Block(&CHANGE)),
            "Changes of the stack from which this one is made: `- { replace: NAME, tasks: [..] }`, `- { add: NAME, \
             before: NAME, tasks: [..] }`, `- { remove: NAME }`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "levels",
            ValueType::List(&ValueType::Block(&LEVEL)),
            "The levels, the most important first: `- { name: limits, hard: true, tasks: [..] }`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "level",
            ValueType::Block(&LEVEL),
            "A level: `level NAME hard { task  task weight 2 }`. The first is the most important.",
        )
        .at(Place::Hq),
        Key::optional(
            "replace",
            ValueType::Block(&LEVEL),
            "In a stack `from` another one: replaces a level, `replace NAME { .. }`.",
        )
        .at(Place::Hq),
        Key::optional(
            "add",
            ValueType::Block(&LEVEL),
            "In a stack `from` another one: adds a level, `add NAME { .. } before OTHER`.",
        )
        .at(Place::Hq),
        Key::optional(
            "remove",
            ValueType::Name(Named::Level),
            "In a stack `from` another one: removes a level, `remove NAME`.",
        )
        .at(Place::Hq),
    ]
}

/// A change of a stack, in YAML.
pub static CHANGE: BlockSchema = BlockSchema {
    name: "a change of a stack",
    keys: &[
        Key::optional("replace", ValueType::Name(Named::Level), "The level that is replaced by this one.")
            .at(Place::Yaml),
        Key::optional("add", ValueType::NewName, "The name of the added level.").at(Place::Yaml),
        Key::optional("remove", ValueType::Name(Named::Level), "The level that is removed.").at(Place::Yaml),
        Key::optional("before", ValueType::Name(Named::Level), "The level below the added one.").at(Place::Yaml),
        Key::optional("after", ValueType::Name(Named::Level), "The level above the added one.").at(Place::Yaml),
    ],
};

block! {
    /// A level.
    pub struct LevelBlock = LEVEL, "a level" {
        /// Treatment of a level that cannot be met. `auto`: exact if the level can be met, damped if it cannot. `none`:
        /// always exact. A number of zero or more: `damping · |v|²` in the cost of the level, met or not.
        damping: NumberOrWord =
            or(ValueType::NumberOr(Quantity::at_least(NONE, 0.0), &["auto", "none"]), "auto");
    }
    also [
        Key::required("name", ValueType::NewName, "The name of the level, for tables and logs.").at(Place::Yaml),
        Key::or("hard", ValueType::Flag, "false", "A hard level has no slack: it is met, or the run has a fault.")
            .at(Place::Word),
        Key::required(
            "tasks",
            ValueType::List(&ValueType::Block(&MEMBER)),
            "The tasks of the level: names, tasks in place, or `{ task: .., weight: .. }`.",
        )
        .at(Place::Yaml),
    ]
}

/// A task in a level.
pub static MEMBER: BlockSchema = BlockSchema {
    name: "a member",
    keys: &[
        Key::required("task", ValueType::Tasks, "The name of a task, or a task in place.").at(Place::Yaml),
        Key::or(
            "weight",
            ValueType::Number(Quantity::above(NONE, 0.0)),
            "1",
            "Weight of the squared slack of this task relative to the other tasks of its level.",
        )
        .at(Place::Word),
    ],
};
