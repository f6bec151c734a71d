//! What begins a declaration, and the keys of declarations that are neither robot nor stack.

use stdlib_tasks::dimension::{ANGLE, ANGULAR_ACCELERATION, ANGULAR_VELOCITY, NONE, TIME};
use stdlib_tasks::params::Quantity;

use super::field::SAFETY_FIELD;
use super::human::HUMAN;
use super::machine::{MACHINE, SIGNAL, VARIABLE};
use super::mission::MISSION;
use super::robot::ROBOT;
use super::scenario::SCENARIO;
use super::stack::STACK;
use super::{Holds, Key, Named, Place, Section};

/// A spec. What the native spelling declares one by one, YAML collects under a key in the plural.
pub static SPEC: Section = Section {
    name: "a spec",
    keys: &[
        Key::required(
            "hierarq",
            Holds::Choice(&["1"]),
            "The version of the language, first in every spec: `hierarq 1`; in YAML `hierarq: 1`.",
        )
        .at(Place::Word),
        Key::optional(
            "import",
            Holds::Declarations,
            "Names of another spec: `import \"common/safety.hq\" { deck, canopies as robot }`.",
        )
        .at(Place::Hq),
        Key::optional(
            "import",
            Holds::Declarations,
            "Names of other specs, a list for each file, `NAME` or `NAME as OTHER`: `common/safety.hq: [deck, canopies as \
             robot]`. Paths start from this file.",
        )
        .at(Place::Yaml),
        Key::optional("param", Holds::Value, "A named value that `--set` may override: `param approach = 0.15 m`.")
            .at(Place::Hq),
        Key::optional(
            "params",
            Holds::Each(&Holds::Block(&PARAM)),
            "Values with a name, which `--set NAME=VALUE` may override: `approach: 0.15 m`, or `{ value, min, max }`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "let",
            Holds::Value,
            "A named expression, which may move: `let wave = 0.1 m * sin(t/(1 s))`. `--set` does not override it.",
        )
        .at(Place::Hq),
        Key::optional(
            "lets",
            Holds::Each(&Holds::Value),
            "Named expressions, which may move: `wave: 0.1 m * sin(t/(1 s))`. `--set` does not override them.",
        )
        .at(Place::Yaml),
        Key::required("robot", Holds::Block(&ROBOT), "The robot: `robot NAME { urdf \"..\"  rate 100 Hz }`.").at(Place::Hq),
        Key::required("robots", Holds::Each(&Holds::Block(&ROBOT)), "The robot, by name.").at(Place::Yaml),
        Key::optional("task", Holds::Declarations, "A named task: `task NAME = TYPE { .. }`.").at(Place::Hq),
        Key::optional(
            "tasks",
            Holds::Declarations,
            "Tasks by name, each `NAME: { TYPE: { .. } }`; one with parameters as `\"NAME(side: arm)\"`.",
        )
        .at(Place::Yaml),
        Key::required(
            "stack",
            Holds::Block(&STACK),
            "An ordered hierarchy: `stack NAME { level NAME hard { task } }`, the most important level first.",
        )
        .at(Place::Hq),
        Key::required(
            "stacks",
            Holds::Each(&Holds::Block(&STACK)),
            "Ordered hierarchies by name, each with `levels`, the most important first; one with parameters as \
             `\"NAME(side: arm)\"`.",
        )
        .at(Place::Yaml),
        Key::optional("signal", Holds::Block(&SIGNAL), "A typed input: `signal NAME : point?  timeout 0.5 s`.").at(Place::Hq),
        Key::optional(
            "signals",
            Holds::Each(&Holds::Block(&SIGNAL)),
            "Typed inputs by name: `NAME: point?`, or `NAME: { type: point?, timeout: 0.5 s }`.",
        )
        .at(Place::Yaml),
        Key::optional("variable", Holds::Block(&VARIABLE), "What the machine keeps and sets itself: `variable NAME : number = 0`.").at(Place::Hq),
        Key::optional(
            "variables",
            Holds::Each(&Holds::Block(&VARIABLE)),
            "What the machine keeps and sets itself, by name: `NAME: { type: number, value: 0 }`, or `NAME: point?`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "human",
            Holds::Block(&HUMAN),
            "A person whose points are tracked: `human NAME { points [chest, left_wrist] }`.",
        )
        .at(Place::Hq),
        Key::optional("humans", Holds::Each(&Holds::Block(&HUMAN)), "People whose points are tracked, by name.").at(Place::Yaml),
        Key::optional(
            "safety_field",
            Holds::Block(&SAFETY_FIELD),
            "How far the robot is from people, as one number: `safety_field NAME { of HUMAN }`, read as `field(NAME)`.",
        )
        .at(Place::Hq),
        Key::optional(
            "safety_fields",
            Holds::Each(&Holds::Block(&SAFETY_FIELD)),
            "How far the robot is from people, each as one number, by name; read as `field(NAME)`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "machine",
            Holds::Block(&MACHINE),
            "A state machine: `machine NAME { initial STATE  state STATE { .. } }`.",
        )
        .at(Place::Hq),
        Key::optional(
            "machines",
            Holds::Each(&Holds::Block(&MACHINE)),
            "State machines by name, each with `initial` and `states`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "for",
            Holds::Declarations,
            "Repeats declarations: `for side in [left, right] { task touch_${side} = .. }`.",
        )
        .at(Place::Hq),
        Key::optional(
            "for",
            Holds::List(&Holds::Block(&REPEAT)),
            "Declarations that are repeated: `- { name: side, in: [left, right], tasks: { .. } }`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "scenario",
            Holds::Block(&SCENARIO),
            "A run in a world of its own, and what is expected of it: `scenario NAME { stack NAME  expect always margin(TASK) \
             >= 0 m }`.",
        )
        .at(Place::Hq),
        Key::optional(
            "scenarios",
            Holds::Each(&Holds::Block(&SCENARIO)),
            "Runs in worlds of their own, by name, and what is expected of them.",
        )
        .at(Place::Yaml),
        Key::optional(
            "mission",
            Holds::Block(&MISSION),
            "A problem about a team, for `hierarq plan`: `mission NAME : schedule { robot NAME { .. }  human NAME { .. } }`.",
        )
        .at(Place::Hq),
        Key::optional(
            "missions",
            Holds::Each(&Holds::Block(&MISSION)),
            "Problems about teams, for `hierarq plan`, by name, each with its kind: `NAME: { schedule: { .. } }`.",
        )
        .at(Place::Yaml),
        Key::optional("run", Holds::Block(&RUN), "What `hierarq run` does: `run { stack NAME  duration 10 s }`.")
            .at(Place::Word),
    ],
};

/// A param with a range.
pub static PARAM: Section = Section {
    name: "the range of a param",
    keys: &[
        Key::required("value", Holds::Value, "The value.").at(Place::Yaml),
        Key::optional(
            "min",
            Holds::Bound,
            "The least value that this param may have, written here or given with `--set`.",
        )
        .at(Place::Word),
        Key::optional(
            "max",
            Holds::Bound,
            "The largest value that this param may have, written here or given with `--set`.",
        )
        .at(Place::Word),
    ],
};

/// A repetition, in YAML.
pub static REPEAT: Section = Section {
    name: "a repetition",
    keys: &[
        Key::required("name", Holds::NewName, "What runs over the values; `${NAME}` in names.").at(Place::Yaml),
        Key::required("in", Holds::Values, "The values: a list, or whole numbers, `1..4`.").at(Place::Yaml),
    ],
};

/// A run.
pub static RUN: Section = Section {
    name: "a run",
    keys: &[
        Key::optional(
            "stack",
            Holds::Name(Named::Stack),
            "The stack that runs from start to end; where left out, the machine, or else the only stack.",
        ),
        Key::optional("machine", Holds::Name(Named::Machine), "The machine that runs; the only one where left out."),
        Key::or("duration", Holds::Number(Quantity::above(TIME, 0.0)), "10 s", "How long it runs."),
        Key::optional(
            "title",
            Holds::Text,
            "Text for table and report; the name of the stack or machine where left out.",
        ),
        Key::or(
            "solver",
            Holds::Choice(&["active_set", "clarabel"]),
            "active_set",
            "What solves the hierarchy; `clarabel` is the slower reference.",
        ),
        Key::optional(
            "tick_budget",
            Holds::Number(Quantity::above(TIME, 0.0)),
            "The time that a tick may take, up to a period, before the robot makes do with what is known of the answer; any time where left out.",
        ),
        Key::optional("simulator", Holds::Block(&SIMULATOR), "How the simulated robot differs from a perfect one."),
    ],
};

pub(super) const ACTUATOR_SPEED: &str =
    "The largest real speed of every joint, beside its own limit; of prismatic joints the same number in m/s.";
pub(super) const ACTUATOR_ACCELERATION: &str =
    "The largest real acceleration of every joint; of prismatic joints the same number in m/s^2.";

/// The simulated robot.
pub static SIMULATOR: Section = Section {
    name: "the simulator",
    keys: &[
        Key::or(
            "lag",
            Holds::Number(Quantity::at_least(TIME, 0.0)),
            "0 s",
            "Time constant of a first-order lag between commanded and real velocity.",
        ),
        Key::or(
            "noise",
            Holds::Number(Quantity::at_least(ANGLE, 0.0)),
            "0 rad",
            "Standard deviation of the noise on measured joint positions; of prismatic joints the same number in m.",
        ),
        Key::or("seed", Holds::Number(Quantity::at_least(NONE, 0.0)), "0", "Of the noise, a whole number."),
        Key::optional("speed", Holds::Number(Quantity::above(ANGULAR_VELOCITY, 0.0)), ACTUATOR_SPEED),
        Key::optional("acceleration", Holds::Number(Quantity::above(ANGULAR_ACCELERATION, 0.0)), ACTUATOR_ACCELERATION),
    ],
};
