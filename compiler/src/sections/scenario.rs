//! The keys of a scenario, and of what the world does in it.

use blocks::{Located, Unbound, Word, block};
use stdlib_tasks::dimension::{ANGLE, Dimension, FORCE, LENGTH, MOMENT, NONE, TIME};
use stdlib_tasks::params::Quantity;

use super::human::HUMAN_SCRIPT;
use super::mission_events::{EVENT, REPLY};
use super::spec::{ACTUATOR_ACCELERATION, ACTUATOR_SPEED};
use super::{BlockSchema, Key, Named, Place, ValueType};

const STIFFNESS: Dimension = Dimension { m: 0, kg: 1, s: -2, rad: 0 };
const DAMPING: Dimension = Dimension { m: 0, kg: 1, s: -1, rad: 0 };

const A_TIME: ValueType = ValueType::Number(Quantity::at_least(TIME, 0.0));

/// Entries of scenarios of missions and of robots' controllers.
pub const OF_ALL_SCENARIOS: &[&str] = &["duration", "seed"];

/// Entries of scenarios of missions alone. All others are of those of robots' controllers alone.
pub const OF_MISSIONS: &[&str] = &["mission", "operations", "travel", "replan", "step", "happens", "feedback"];

block! {
    /// A scenario.
    pub struct ScenarioBlock = SCENARIO, "a scenario" {
        /// The stack that runs; default: the stack or machine of `run`.
        stack: Option<Located<String>> = optional(ValueType::Name(Named::Stack));
        /// The machine that runs, instead of a stack.
        machine: Option<Located<String>> = optional(ValueType::Name(Named::Machine));
        /// The mission that is executed, instead of a robot's controller.
        mission: Option<Located<String>> = optional(ValueType::Name(Named::Mission));
        /// Duration of the run; default: that of `run`. Required for a mission.
        duration: Option<Located<f64>> = optional(ValueType::Number(Quantity::above(TIME, 0.0)));
        /// Seed of all random numbers of the scenario, a whole number.
        seed: Located<f64> = or(ValueType::Number(Quantity::at_least(NONE, 0.0)), "0");
        /// Initial joint positions; the other joints start at `home`.
        start: Option<Unbound> = elsewhere(ValueType::Positions);
        /// Deviations of the simulated robot from a perfect one; default: those of `run`.
        simulator: ScenarioSimulator = optional(ValueType::Block(&SCENARIO_SIMULATOR));
        /// Values that are sent to signals, by name.
        signals: Option<Unbound> = elsewhere(ValueType::Of(Named::Signal, &ValueType::Blocks(&SIGNAL_SCRIPT)));
        /// Motion of people during the whole run, and the readings of the tracker, by name.
        humans: Option<Unbound> = elsewhere(ValueType::Of(Named::Human, &ValueType::Block(&HUMAN_SCRIPT)));
        /// Times at which the host raises events, by name: `start 1 s`, `start [1, 20] s`.
        events: Option<Unbound> = elsewhere(ValueType::Of(Named::Event, &ValueType::Numbers(Quantity::at_least(TIME, 0.0))));
        /// Outcomes of actions, by their first argument or their verb. The k-th request has the outcome of the k-th
        /// entry, and the last entry repeats. An action without an entry succeeds immediately.
        outcomes: Option<Unbound> = elsewhere(ValueType::Each(&ValueType::Blocks(&OUTCOME)));
        /// Forces on sensors, by the name of the wrench signal.
        push: Option<Unbound> = elsewhere(ValueType::Of(Named::Signal, &ValueType::Blocks(&PUSH)));
        /// Ticks that are late: the controller is not called, and the robot continues with its last command.
        late: Option<Unbound> = elsewhere(ValueType::Blocks(&LATE));
        /// Lost readings of joints: the position is not a number.
        lost: Option<Unbound> = elsewhere(ValueType::PerJoint(&ValueType::Blocks(&LOST)));
        /// Of a mission, `sampled`: the durations of operations, or of tasks of layers, are drawn from their
        /// distributions, and those of workers with `runs` result from their controllers. `planned`: all durations
        /// are as planned.
        operations: Word = or(ValueType::Choice(&["sampled", "planned"]), "sampled");
        /// Of a schedule, `planned`: robots travel as planned, and pass through each other. `bases`: they are
        /// wheeled bases that follow the plan, and avoid each other and people.
        travel: Word = or(ValueType::Choice(&["planned", "bases"]), "planned");
        /// Of a mission: reaction of the plan to deviations. `none`: its times change only as necessary.
        /// `reschedule`: feedback of people changes its times and speeds too. `both`: it is also planned again when
        /// its cost has changed by more than `reallocate_above`.
        replan: Word = or(ValueType::Choice(&["none", "reschedule", "both"]), "both");
        /// Of a mission: time between two evaluations of the expectations. The duration is a whole number of steps.
        step: f64 = or(ValueType::Number(Quantity::above(TIME, 0.0)), "1 s");
        /// Of a mission: events that the plan does not contain, each at its time: `[{ at 120 s  moved h1  to [2, 0]
        /// m }, ..]`.
        happens: Option<Unbound> = elsewhere(ValueType::Blocks(&EVENT));
        /// Of a schedule: feedback of people after they were served, by name. The k-th entry is the feedback on the
        /// k-th service, and the last entry repeats; an empty entry is no feedback.
        feedback: Option<Unbound> = elsewhere(ValueType::Of(Named::Person, &ValueType::Blocks(&REPLY)));
    }
    also [
        Key::optional("expect", ValueType::Declarations, "Expectations: `expect \"label\" always margin(TASK) >= 0 m`.")
            .at(Place::Hq),
        Key::optional("expect", ValueType::Declarations, "Expectations: `- FORMULA`, or `- LABEL: FORMULA`.")
            .at(Place::Yaml),
    ]
}

block! {
    /// The simulated robot of a scenario.
    pub struct ScenarioSimulator = SCENARIO_SIMULATOR, "the simulator of a scenario" {
        /// Time constant of a first-order lag between commanded and real velocity.
        lag: Option<f64> = optional(A_TIME);
        /// Standard deviation of the noise on measured joint positions; for prismatic joints the same number in m.
        noise: Option<f64> = optional(ValueType::Number(Quantity::at_least(ANGLE, 0.0)));
        /// Largest real speed.
        speed: Option<f64> = same(ACTUATOR_SPEED);
        /// Largest real acceleration.
        acceleration: Option<f64> = same(ACTUATOR_ACCELERATION);
    }
}

/// Values that a signal is sent in a scenario.
pub static SIGNAL_SCRIPT: BlockSchema = BlockSchema {
    name: "the script of a signal",
    keys: &[
        Key::optional(
            "value",
            ValueType::Sent,
            "The value that is sent; of a wrench `{ force [..] N  moment [..] Nm }`.",
        ),
        Key::optional(
            "path",
            ValueType::List(&ValueType::Block(&WAYPOINT)),
            "Instead of one value, values at given times, with linear interpolation: `[{ at 0 s  value [..] m }, ..]`.",
        ),
        Key::or("from", A_TIME, "0 s", "Time of the first value."),
        Key::optional("to", A_TIME, "Time after which no value is sent; default: the end of the run."),
        Key::or(
            "noise",
            ValueType::Bound,
            "0",
            "Standard deviation of the noise on each number, in the unit of the value.",
        ),
        Key::or("delay", A_TIME, "0 s", "Time from the measurement of a value to its arrival."),
        Key::or(
            "drop",
            ValueType::Number(Quantity { min: 0.0, max: 1.0, ..Quantity::any(NONE) }),
            "0",
            "Fraction of the values that are lost in transmission, from 0 to 1.",
        ),
        Key::or("period", A_TIME, "0 s", "Time between two values; 0 for one at every tick."),
        Key::optional(
            "nan",
            ValueType::Numbers(Quantity::at_least(TIME, 0.0)),
            "Times at which a value is sent that is not a number.",
        ),
    ],
};

/// A value of a path.
pub static WAYPOINT: BlockSchema = BlockSchema {
    name: "a waypoint",
    keys: &[
        Key::required("at", A_TIME, "Time of the value, from the beginning of the run."),
        Key::required("value", ValueType::Sent, "The value at that time."),
    ],
};

/// Outcome of an action in a scenario.
pub static OUTCOME: BlockSchema = BlockSchema {
    name: "an outcome",
    keys: &[
        Key::required(
            "outcome",
            ValueType::NewName,
            "Name of the outcome: `found`, `done`; `never` for an action without an end.",
        ),
        Key::or("after", A_TIME, "0 s", "Duration of the action."),
        Key::optional(
            "sets",
            ValueType::Of(Named::Signal, &ValueType::Sent),
            "Values of signals from then on, by name.",
        ),
    ],
};

/// A force on a sensor.
pub static PUSH: BlockSchema = BlockSchema {
    name: "a push",
    keys: &[
        Key::or("from", A_TIME, "0 s", "Start of the push."),
        Key::optional("to", A_TIME, "End of the push; default: the end of the run."),
        Key::optional("force", ValueType::Vector(FORCE), "The force on the robot, in the axes of the world."),
        Key::optional("moment", ValueType::Vector(MOMENT), "The moment on the robot, in the axes of the world."),
        Key::optional("link", ValueType::Link, "Instead of a force: the link whose origin a hand pulls."),
        Key::optional("towards", ValueType::Vector(LENGTH), "The point in the world towards which the hand pulls."),
        Key::or(
            "stiffness",
            ValueType::Number(Quantity::at_least(STIFFNESS, 0.0)),
            "200 N/m",
            "Stiffness of the hand: force for each metre from the point.",
        ),
        Key::or(
            "damping",
            ValueType::Number(Quantity::at_least(DAMPING, 0.0)),
            "20 N s/m",
            "Damping of the hand: force against each metre per second.",
        ),
        Key::or("most", ValueType::Number(Quantity::at_least(FORCE, 0.0)), "30 N", "The largest force of the hand."),
    ],
};

/// A late tick.
pub static LATE: BlockSchema = BlockSchema {
    name: "a late tick",
    keys: &[
        Key::required("at", A_TIME, "Time of the first tick that is late."),
        Key::required("by", ValueType::Number(Quantity::above(TIME, 0.0)), "Delay of the next tick."),
    ],
};

/// A reading that is lost.
pub static LOST: BlockSchema = BlockSchema {
    name: "a lost reading",
    keys: &[
        Key::required("from", A_TIME, "From when the readings are lost."),
        Key::required("to", A_TIME, "Time until which the readings are lost."),
    ],
};
