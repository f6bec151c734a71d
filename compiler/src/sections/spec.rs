//! Keywords of declarations, and the keys of declarations other than robots and stacks.

use blocks::{Located, Word, block};
use stdlib_tasks::dimension::{ANGLE, ANGULAR_ACCELERATION, ANGULAR_VELOCITY, NONE, TIME};
use stdlib_tasks::params::Quantity;

use super::MISSION;
use super::coverage::COVERAGE;
use super::field::SAFETY_FIELD;
use super::human::HUMAN;
use super::machine::{MACHINE, SIGNAL, VARIABLE};
use super::obstacle::OBSTACLE;
use super::plant::{PLANT, PlantBlock};
use super::robot::ROBOT;
use super::ros::{ROS, RosBlock};
use super::scenario::SCENARIO;
use super::stack::STACK;
use super::{BlockSchema, Key, Named, Place, ValueType};

/// The key of every block for warnings that are intended there. `expand` takes it out of all of them.
pub const ALLOW: Key = Key::optional(
    "allow",
    ValueType::Each(&ValueType::Text),
    "A warning that is intended here, with the reason: `allow HQ0606 \"the tray is soft on purpose\"`; in YAML a mapping of \
     codes, `allow: { HQ0606: the tray is soft on purpose }`. It is allowed in this declaration alone, and listed by \
     `hierarq check` and in reports. Every block has this key.",
)
.at(Place::Word);

/// A spec. What the native syntax declares one by one, YAML collects under a key in the plural.
pub static SPEC: BlockSchema = BlockSchema {
    name: "a spec",
    keys: &[
        Key::required(
            "hierarq",
            ValueType::Choice(&["1"]),
            "The version of the language, first in every spec: `hierarq 1`; in YAML `hierarq: 1`.",
        )
        .at(Place::Word),
        Key::optional(
            "import",
            ValueType::Declarations,
            "Names of another spec: `import \"common/safety.hq\" { deck, canopies as robot }`.",
        )
        .at(Place::Hq),
        Key::optional(
            "import",
            ValueType::Declarations,
            "Names of other specs, a list for each file, `NAME` or `NAME as OTHER`: `common/safety.hq: [deck, canopies \
             as robot]`. Paths are relative to this file.",
        )
        .at(Place::Yaml),
        ALLOW,
        Key::optional("param", ValueType::Value, "A named value that `--set` may override: `param approach = 0.15 m`.")
            .at(Place::Hq),
        Key::optional(
            "params",
            ValueType::Each(&ValueType::Block(&PARAM)),
            "Named values that `--set NAME=VALUE` may override: `approach: 0.15 m`, or `{ value, min, max }`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "let",
            ValueType::Value,
            "A named expression, which may depend on time: `let wave = 0.1 m * sin(t/(1 s))`. `--set` does not \
             override it.",
        )
        .at(Place::Hq),
        Key::optional(
            "lets",
            ValueType::Each(&ValueType::Value),
            "Named expressions, which may depend on time: `wave: 0.1 m * sin(t/(1 s))`. `--set` does not override \
             them.",
        )
        .at(Place::Yaml),
        Key::required("robot", ValueType::Block(&ROBOT), "The robot: `robot NAME { urdf \"..\"  rate 100 Hz }`.")
            .at(Place::Hq),
        Key::required("robots", ValueType::Each(&ValueType::Block(&ROBOT)), "The robot, by name.").at(Place::Yaml),
        Key::optional("task", ValueType::Declarations, "A named task: `task NAME = TYPE { .. }`.").at(Place::Hq),
        Key::optional(
            "tasks",
            ValueType::Declarations,
            "Tasks by name, each `NAME: { TYPE: { .. } }`; a task with parameters as `\"NAME(side: arm)\"`.",
        )
        .at(Place::Yaml),
        Key::required(
            "stack",
            ValueType::Block(&STACK),
            "An ordered hierarchy: `stack NAME { level NAME hard { task } }`, the most important level first.",
        )
        .at(Place::Hq),
        Key::required(
            "stacks",
            ValueType::Each(&ValueType::Block(&STACK)),
            "Ordered hierarchies by name, each with `levels`, the most important first; a stack with parameters as \
             `\"NAME(side: arm)\"`.",
        )
        .at(Place::Yaml),
        Key::optional("signal", ValueType::Block(&SIGNAL), "A typed input: `signal NAME : point?  timeout 0.5 s`.")
            .at(Place::Hq),
        Key::optional(
            "signals",
            ValueType::Each(&ValueType::Block(&SIGNAL)),
            "Typed inputs by name: `NAME: point?`, or `NAME: { type: point?, timeout: 0.5 s }`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "variable",
            ValueType::Block(&VARIABLE),
            "A value that the machine stores and sets: `variable NAME : number = 0`.",
        )
        .at(Place::Hq),
        Key::optional(
            "variables",
            ValueType::Each(&ValueType::Block(&VARIABLE)),
            "Values that the machine stores and sets, by name: `NAME: { type: number, value: 0 }`, or `NAME: point?`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "human",
            ValueType::Block(&HUMAN),
            "A person whose points are tracked: `human NAME { points [chest, left_wrist] }`.",
        )
        .at(Place::Hq),
        Key::optional(
            "humans",
            ValueType::Each(&ValueType::Block(&HUMAN)),
            "People whose points are tracked, by name.",
        )
        .at(Place::Yaml),
        Key::optional(
            "safety_field",
            ValueType::Block(&SAFETY_FIELD),
            "The distance between the robot and people as one number: `safety_field NAME { of HUMAN }`, read as \
             `field(NAME)`.",
        )
        .at(Place::Hq),
        Key::optional(
            "safety_fields",
            ValueType::Each(&ValueType::Block(&SAFETY_FIELD)),
            "Distances between the robot and people, each as one number, by name; read as `field(NAME)`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "obstacle",
            ValueType::Block(&OBSTACLE),
            "A body in the room: `obstacle NAME { box [1.2, 0.8, 0.04] m  position [0.7, 0, 0.4] m }`, kept clear of by \
             `keep_clear`.",
        )
        .at(Place::Hq),
        Key::optional(
            "obstacles",
            ValueType::Each(&ValueType::Block(&OBSTACLE)),
            "Bodies in the room, by name, kept clear of by `keep_clear`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "machine",
            ValueType::Block(&MACHINE),
            "A state machine: `machine NAME { initial STATE  state STATE { .. } }`.",
        )
        .at(Place::Hq),
        Key::optional(
            "machines",
            ValueType::Each(&ValueType::Block(&MACHINE)),
            "State machines by name, each with `initial` and `states`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "for",
            ValueType::Declarations,
            "Repeats declarations: `for side in [left, right] { task touch_${side} = .. }`.",
        )
        .at(Place::Hq),
        Key::optional(
            "for",
            ValueType::List(&ValueType::Block(&REPEAT)),
            "Repeated declarations: `- { name: side, in: [left, right], tasks: { .. } }`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "scenario",
            ValueType::Block(&SCENARIO),
            "A run in a world of its own, with expectations: `scenario NAME { stack NAME  expect always margin(TASK) \
             >= 0 m }`.",
        )
        .at(Place::Hq),
        Key::optional(
            "scenarios",
            ValueType::Each(&ValueType::Block(&SCENARIO)),
            "Runs in worlds of their own, with expectations, by name.",
        )
        .at(Place::Yaml),
        Key::optional(
            "mission",
            ValueType::Block(&MISSION),
            "A planning problem of a team, for `hierarq plan`: `mission NAME : schedule { robot NAME { .. }  human \
             NAME { .. } }`.",
        )
        .at(Place::Hq),
        Key::optional(
            "missions",
            ValueType::Each(&ValueType::Block(&MISSION)),
            "Planning problems of teams, for `hierarq plan`, by name, each with its kind: `NAME: { schedule: { .. } \
             }`.",
        )
        .at(Place::Yaml),
        Key::optional(
            "coverage",
            ValueType::Block(&COVERAGE),
            "Demands on the limits of stacks: `coverage { velocity hard  people { NAME { links [LINK] } } }`. A demand that \
             is not met is an error. There may be several.",
        )
        .at(Place::Hq),
        Key::optional(
            "coverage",
            ValueType::Blocks(&COVERAGE),
            "Demands on the limits of stacks, a mapping or a list of several: `{ velocity: hard, people: { NAME: { links: \
             [LINK] } } }`. A demand that is not met is an error.",
        )
        .at(Place::Yaml),
        Key::optional("run", ValueType::Block(&RUN), "Settings of `hierarq run`: `run { stack NAME  duration 10 s }`.")
            .at(Place::Word),
    ],
};

/// A param with a range.
pub static PARAM: BlockSchema = BlockSchema {
    name: "the range of a param",
    keys: &[
        Key::required("value", ValueType::Value, "The value.").at(Place::Yaml),
        Key::optional(
            "min",
            ValueType::Bound,
            "The least value that this param may have, written here or given with `--set`.",
        )
        .at(Place::Word),
        Key::optional(
            "max",
            ValueType::Bound,
            "The largest value that this param may have, written here or given with `--set`.",
        )
        .at(Place::Word),
    ],
};

/// A repetition, in YAML.
pub static REPEAT: BlockSchema = BlockSchema {
    name: "a repetition",
    keys: &[
        Key::required("name", ValueType::NewName, "Name of the loop variable; `${NAME}` in names.").at(Place::Yaml),
        Key::required("in", ValueType::Values, "The values: a list, or whole numbers, `1..4`.").at(Place::Yaml),
    ],
};

block! {
    /// A run.
    pub struct RunBlock = RUN, "a run" {
        /// The stack that runs from start to end; default: the machine, or else the only stack.
        stack: Option<Located<String>> = optional(ValueType::Name(Named::Stack));
        /// The machine that runs; default: the only one.
        machine: Option<Located<String>> = optional(ValueType::Name(Named::Machine));
        /// Duration of the run.
        duration: Located<f64> = or(ValueType::Number(Quantity::above(TIME, 0.0)), "10 s");
        /// Title of table and report; default: the name of the stack or machine.
        title: Option<String> = optional(ValueType::Text);
        /// The solver of the hierarchy; `clarabel` is the slower reference.
        solver: Word = or(ValueType::Choice(&["active_set", "clarabel"]), "active_set");
        /// Time limit of a tick, at most a period. When it is spent, the tick uses the part of the solution that is
        /// known. Default: no limit.
        tick_budget: Option<Located<f64>> =
            optional(ValueType::Number(Quantity::above(TIME, 0.0).usually(1e-6, 1.0)));
        /// Deviations of the simulated robot from a perfect one.
        simulator: SimulatorBlock = optional(ValueType::Block(&SIMULATOR));
        /// The robot as a body with masses and drives, moved by a library for physics: `plant mujoco { response 10 ms }`.
        plant: PlantBlock = optional(ValueType::Block(&PLANT));
        /// Topics of ROS 2 for `hierarq ros`: `ros { commands { arm { topic "/arm_controller/commands" } } }`.
        ros: Option<Located<RosBlock>> = optional(ValueType::Block(&ROS));
    }
}

/// A seed. Larger whole numbers are not all representable as `f64`.
pub(super) const SEED: ValueType = ValueType::Count(Quantity { min: 0.0, max: 9e15, ..Quantity::any(NONE) });

pub(super) const ACTUATOR_SPEED: Key = Key::optional(
    "speed",
    ValueType::Number(Quantity::above(ANGULAR_VELOCITY, 0.0).usually(1e-4, 200.0)),
    "The largest real speed of every joint, in addition to its own limit; for prismatic joints the same number in m/s.",
);
pub(super) const ACTUATOR_ACCELERATION: Key = Key::optional(
    "acceleration",
    ValueType::Number(Quantity::above(ANGULAR_ACCELERATION, 0.0).usually(1e-3, 1e4)),
    "The largest real acceleration of every joint; for prismatic joints the same number in m/s^2.",
);

block! {
    /// The simulated robot.
    pub struct SimulatorBlock = SIMULATOR, "the simulator" {
        /// Time constant of a first-order lag between commanded and real velocity.
        lag: Located<f64> = or(ValueType::Number(Quantity::at_least(TIME, 0.0)), "0 s");
        /// Standard deviation of the noise on measured joint positions; for prismatic joints the same number in m.
        noise: Located<f64> = or(ValueType::Number(Quantity::at_least(ANGLE, 0.0)), "0 rad");
        /// Seed of the noise.
        seed: usize = or(SEED, "0");
        /// Largest real speed.
        speed: Option<f64> = same(ACTUATOR_SPEED);
        /// Largest real acceleration.
        acceleration: Option<f64> = same(ACTUATOR_ACCELERATION);
    }
}
