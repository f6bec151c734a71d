//! The keys of what happens in a scenario of a mission, and of what people say in it.

use stdlib_tasks::dimension::{LENGTH, TIME};
use stdlib_tasks::params::Quantity;

use super::{Holds, Key, Named, Section};

/// What a wait was, in the five steps of thesis Fig. 5.5, from -2 to 2.
pub const WAITS: &[&str] = &["too_short", "short", "ok", "long", "too_long"];
/// How a robot came, in five steps.
pub const APPROACHES: &[&str] = &["very_fast", "fast", "ok", "slow", "very_slow"];
/// How far away a robot waited, in five steps.
pub const DISTANCES: &[&str] = &["very_far", "far", "ok", "close", "very_close"];

const SOMEBODY: Holds = Holds::Name(Named::Member);

const WAIT: Key = Key::optional("wait", Holds::Choice(WAITS), "What the wait for the robot was; `ok` where left out.");
const APPROACH: Key = Key::optional("approach", Holds::Choice(APPROACHES), "How the robot came; `ok` where left out.");
const DISTANCE: Key =
    Key::optional("distance", Holds::Choice(DISTANCES), "How far away the robot waited; `ok` where left out.");

/// Entries of what happens that only schedules have.
pub const HAPPENING_OF_SCHEDULES: &[&str] =
    &["moved", "to", "served", "begun", "feedback", "wait", "approach", "distance"];

/// Something that happens.
pub static HAPPENING: Section = Section {
    name: "an event of a mission",
    keys: &[
        Key::required("at", Holds::Number(Quantity::at_least(TIME, 0.0)), "When, from the start of the mission."),
        Key::optional(
            "late",
            SOMEBODY,
            "The operation, service or task under way of this agent, or the service that this robot gives, takes longer than it \
             would have, `by` a time.",
        ),
        Key::optional("by", Holds::Number(Quantity::any(TIME)), "Of `late`: how much longer; below 0 shorter."),
        Key::optional(
            "moved",
            SOMEBODY,
            "Of a schedule: this agent works at another place from then on, `to` a point of the ground.",
        ),
        Key::optional("to", Holds::Pair(LENGTH), "Of `moved`: the new place."),
        Key::optional("lost", SOMEBODY, "This robot breaks down, or this agent leaves."),
        Key::optional("back", SOMEBODY, "Who was lost is back: a robot at its depot, an agent at its place or base."),
        Key::optional(
            "failed",
            SOMEBODY,
            "The service that this robot gives, or this agent is given, fails and is done again; of layers the task under way of \
             this agent.",
        ),
        Key::optional(
            "begun",
            SOMEBODY,
            "Of a schedule: this agent begins its next operation, though the plan lets it begin later.",
        ),
        Key::optional("done", SOMEBODY, "The operation or task of this agent ends."),
        Key::optional("served", SOMEBODY, "Of a schedule: the service of this agent ends, earlier than its time."),
        Key::optional(
            "feedback",
            Holds::Name(Named::Person),
            "Of a schedule: this person says what the last service was like.",
        ),
        WAIT,
        APPROACH,
        DISTANCE,
    ],
};

/// What a person says of a service.
pub static REPLY: Section = Section { name: "what is said of a service", keys: &[WAIT, APPROACH, DISTANCE] };
