//! The keys of what happens in a scenario of a mission, and of what people say in it.

use mission::numbers::MAX_NUMBER;
use stdlib_tasks::dimension::{LENGTH, TIME};
use stdlib_tasks::params::Quantity;

use super::{BlockSchema, Key, Named, ValueType};

/// Ratings of a wait, in the five steps of thesis Fig. 5.5, from -2 to 2.
pub const WAITS: &[&str] = &["too_short", "short", "ok", "long", "too_long"];
/// Ratings of the speed at which a robot came, in five steps.
pub const APPROACHES: &[&str] = &["very_fast", "fast", "ok", "slow", "very_slow"];
/// Ratings of the distance at which a robot waited, in five steps.
pub const DISTANCES: &[&str] = &["very_far", "far", "ok", "close", "very_close"];

const SOMEBODY: ValueType = ValueType::Name(Named::Member);

const WAIT: Key = Key::optional("wait", ValueType::Choice(WAITS), "Rating of the wait for the robot; default: `ok`.");
const APPROACH: Key = Key::optional(
    "approach",
    ValueType::Choice(APPROACHES),
    "Rating of the speed at which the robot came; default: `ok`.",
);
const DISTANCE: Key = Key::optional(
    "distance",
    ValueType::Choice(DISTANCES),
    "Rating of the distance at which the robot waited; default: `ok`.",
);

/// Something that happens.
pub static EVENT: BlockSchema = BlockSchema {
    name: "an event of a mission",
    keys: &[
        Key::required(
            "at",
            ValueType::Number(Quantity::at_least(TIME, 0.0)),
            "Time of the event, from the start of the mission.",
        )
        .example("120 s"),
        Key::optional(
            "late",
            SOMEBODY,
            "The current operation, service or task of this agent, or the current service of this robot, takes longer \
             by the time `by`. In an exploration the person stands for so long.",
        ),
        Key::optional(
            "by",
            ValueType::Number(Quantity::between(TIME, -MAX_NUMBER, MAX_NUMBER)),
            "Of `late`: the additional time; negative if the activity is shorter.",
        ),
        Key::optional(
            "moved",
            SOMEBODY,
            "Of a schedule: from then on, this agent works at another place, given by `to`, a point on the ground.",
        ),
        Key::optional(
            "to",
            ValueType::Pair(LENGTH),
            "Of `moved`: the new place; of messages and `strays`: the place that is told, or gone to.",
        ),
        Key::optional(
            "my_pose",
            ValueType::Name(Named::Person),
            "Of a search or an exploration: this person says where they are, `to`.",
        ),
        Key::optional(
            "my_goal",
            ValueType::Name(Named::Person),
            "Of a search: this person says where they go next, `to`. The plan is made around it.",
        ),
        Key::optional("robot_goal", SOMEBODY, "Of a search: a person sends this robot to a place, `to`."),
        Key::optional("robot_pose", SOMEBODY, "Of a search: a person says where this robot is, `to`."),
        Key::optional("free", SOMEBODY, "Of a search: the goal that was told for this agent is withdrawn."),
        Key::optional("replan", ValueType::Name(Named::Person), "Of a search: this person asks for a new plan."),
        Key::optional(
            "strays",
            ValueType::Name(Named::Person),
            "Of a search: this person leaves the plan for a place, `to`, and tells nobody. The others believe the person to follow \
             the plan, until the person is seen or says where they are. In an exploration the person walks there, in sight, and then \
             goes on as the model says.",
        ),
        Key::optional("seen", ValueType::Name(Named::Person), "Of a search: the others see where this person is."),
        Key::optional("found", SOMEBODY, "Of a search: somebody says that one of these hidden objects is found."),
        Key::optional(
            "lost",
            SOMEBODY,
            "This robot breaks down, or this agent leaves; in an exploration the robots lose sight of the person.",
        ),
        Key::optional(
            "back",
            SOMEBODY,
            "The lost participant is back: a robot at its depot, an agent at its place or base.",
        ),
        Key::optional(
            "failed",
            SOMEBODY,
            "The service by this robot, or the service of this agent, fails and is repeated; in a mission of layers, \
             the current task of this agent.",
        ),
        Key::optional(
            "begun",
            SOMEBODY,
            "Of a schedule: this agent begins its next operation, even if the plan would begin it later.",
        ),
        Key::optional("done", SOMEBODY, "The operation or task of this agent ends."),
        Key::optional("served", SOMEBODY, "Of a schedule: the service of this agent ends early."),
        Key::optional(
            "feedback",
            ValueType::Name(Named::Person),
            "Of a schedule: this person gives feedback on the last service.",
        ),
        WAIT,
        APPROACH,
        DISTANCE,
    ],
};

/// Feedback of a person about a service.
pub static REPLY: BlockSchema = BlockSchema { name: "feedback of a service", keys: &[WAIT, APPROACH, DISTANCE] };
