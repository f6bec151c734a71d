//! The keys of a scenario, and of what the world does in it.

use stdlib_tasks::dimension::{
    ANGLE, ANGULAR_ACCELERATION, ANGULAR_VELOCITY, Dimension, FORCE, LENGTH, MOMENT, NONE, TIME,
};
use stdlib_tasks::params::Quantity;

use super::happening::{HAPPENING, REPLY};
use super::human::HUMAN_SCRIPT;
use super::spec::{ACTUATOR_ACCELERATION, ACTUATOR_SPEED};
use super::{Holds, Key, Named, Place, Section};

const STIFFNESS: Dimension = Dimension { m: 0, kg: 1, s: -2, rad: 0 };
const DAMPING: Dimension = Dimension { m: 0, kg: 1, s: -1, rad: 0 };

const A_TIME: Holds = Holds::Number(Quantity::at_least(TIME, 0.0));

/// Entries of scenarios of missions and of robots' controllers.
pub const OF_ALL_SCENARIOS: &[&str] = &["duration", "seed"];

/// Entries of scenarios of missions alone. All others are of those of robots' controllers alone.
pub const OF_MISSIONS: &[&str] = &["mission", "operations", "travel", "replan", "step", "happens", "feedback"];

/// A scenario.
pub static SCENARIO: Section = Section {
    name: "a scenario",
    keys: &[
        Key::optional(
            "stack",
            Holds::Name(Named::Stack),
            "The stack that runs; default: the stack or machine of `run`.",
        ),
        Key::optional("machine", Holds::Name(Named::Machine), "The machine that runs, instead of a stack."),
        Key::optional(
            "mission",
            Holds::Name(Named::Mission),
            "The mission that is executed, instead of a robot's controller.",
        ),
        Key::optional(
            "duration",
            Holds::Number(Quantity::above(TIME, 0.0)),
            "Duration of the run; default: that of `run`. Required for a mission.",
        ),
        Key::or(
            "seed",
            Holds::Number(Quantity::at_least(NONE, 0.0)),
            "0",
            "Seed of all random numbers of the scenario, a whole number.",
        ),
        Key::optional("start", Holds::Positions, "Initial joint positions; the other joints start at `home`."),
        Key::optional(
            "simulator",
            Holds::Block(&SCENARIO_SIMULATOR),
            "Deviations of the simulated robot from a perfect one; default: those of `run`.",
        ),
        Key::optional(
            "signals",
            Holds::Of(Named::Signal, &Holds::Blocks(&SIGNAL_SCRIPT)),
            "Values that are sent to signals, by name.",
        ),
        Key::optional(
            "humans",
            Holds::Of(Named::Human, &Holds::Block(&HUMAN_SCRIPT)),
            "Motion of people during the whole run, and the readings of the tracker, by name.",
        ),
        Key::optional(
            "events",
            Holds::Of(Named::Event, &Holds::Numbers(Quantity::at_least(TIME, 0.0))),
            "Times at which the host raises events, by name: `start 1 s`, `start [1, 20] s`.",
        ),
        Key::optional(
            "outcomes",
            Holds::Each(&Holds::Blocks(&OUTCOME)),
            "Outcomes of actions, by their first argument or their verb. The k-th request has the outcome of the k-th \
             entry, and the last entry repeats. An action without an entry succeeds immediately.",
        ),
        Key::optional(
            "push",
            Holds::Of(Named::Signal, &Holds::Blocks(&PUSH)),
            "Forces on sensors, by the name of the wrench signal.",
        ),
        Key::optional(
            "late",
            Holds::Blocks(&LATE),
            "Ticks that are late: the controller is not called, and the robot continues with its last command.",
        ),
        Key::optional(
            "lost",
            Holds::PerJoint(&Holds::Blocks(&LOST)),
            "Lost readings of joints: the position is not a number.",
        ),
        Key::or(
            "operations",
            Holds::Choice(&["sampled", "planned"]),
            "sampled",
            "Of a mission, `sampled`: the durations of operations, or of tasks of layers, are drawn from their \
             distributions, and those of workers with `runs` result from their controllers. `planned`: all durations \
             are as planned.",
        ),
        Key::or(
            "travel",
            Holds::Choice(&["planned", "bases"]),
            "planned",
            "Of a schedule, `planned`: robots travel as planned, and pass through each other. `bases`: they are \
             wheeled bases that follow the plan, and avoid each other and people.",
        ),
        Key::or(
            "replan",
            Holds::Choice(&["none", "reschedule", "both"]),
            "both",
            "Of a mission: reaction of the plan to deviations. `none`: its times change only as necessary. \
             `reschedule`: feedback of people changes its times and speeds too. `both`: it is also planned again when \
             its cost has changed by more than `reallocate_above`.",
        ),
        Key::or(
            "step",
            Holds::Number(Quantity::above(TIME, 0.0)),
            "1 s",
            "Of a mission: time between two evaluations of the expectations. The duration is a whole number of steps.",
        ),
        Key::optional(
            "happens",
            Holds::Blocks(&HAPPENING),
            "Of a mission: events that the plan does not contain, each at its time: `[{ at 120 s  moved h1  to [2, 0] \
             m }, ..]`.",
        ),
        Key::optional(
            "feedback",
            Holds::Of(Named::Person, &Holds::Blocks(&REPLY)),
            "Of a schedule: feedback of people after they were served, by name. The k-th entry is the feedback on the \
             k-th service, and the last entry repeats; an empty entry is no feedback.",
        ),
        Key::optional("expect", Holds::Declarations, "Expectations: `expect \"label\" always margin(TASK) >= 0 m`.")
            .at(Place::Hq),
        Key::optional("expect", Holds::Declarations, "Expectations: `- FORMULA`, or `- LABEL: FORMULA`.")
            .at(Place::Yaml),
    ],
};

/// The simulated robot of a scenario.
pub static SCENARIO_SIMULATOR: Section = Section {
    name: "the simulator of a scenario",
    keys: &[
        Key::optional("lag", A_TIME, "Time constant of a first-order lag between commanded and real velocity."),
        Key::optional(
            "noise",
            Holds::Number(Quantity::at_least(ANGLE, 0.0)),
            "Standard deviation of the noise on measured joint positions; for prismatic joints the same number in m.",
        ),
        Key::optional("speed", Holds::Number(Quantity::above(ANGULAR_VELOCITY, 0.0)), ACTUATOR_SPEED),
        Key::optional("acceleration", Holds::Number(Quantity::above(ANGULAR_ACCELERATION, 0.0)), ACTUATOR_ACCELERATION),
    ],
};

/// What a signal is sent.
pub static SIGNAL_SCRIPT: Section = Section {
    name: "the script of a signal",
    keys: &[
        Key::optional("value", Holds::Sent, "The value that is sent; of a wrench `{ force [..] N  moment [..] Nm }`."),
        Key::optional(
            "path",
            Holds::List(&Holds::Block(&WAYPOINT)),
            "Instead of one value, values at given times, with linear interpolation: `[{ at 0 s  value [..] m }, ..]`.",
        ),
        Key::or("from", A_TIME, "0 s", "Time of the first value."),
        Key::optional("to", A_TIME, "Time after which no value is sent; default: the end of the run."),
        Key::or(
            "noise",
            Holds::Bound,
            "0",
            "Standard deviation of the noise on each number, in the unit of the value.",
        ),
        Key::or("delay", A_TIME, "0 s", "Time from the measurement of a value to its arrival."),
        Key::or(
            "drop",
            Holds::Number(Quantity { min: 0.0, max: 1.0, ..Quantity::any(NONE) }),
            "0",
            "Fraction of the values that are lost in transmission, from 0 to 1.",
        ),
        Key::or("period", A_TIME, "0 s", "Time between two values; 0 for one at every tick."),
        Key::optional(
            "nan",
            Holds::Numbers(Quantity::at_least(TIME, 0.0)),
            "Times at which a value is sent that is not a number.",
        ),
    ],
};

/// A value of a path.
pub static WAYPOINT: Section = Section {
    name: "a waypoint",
    keys: &[
        Key::required("at", A_TIME, "Time of the value, from the beginning of the run."),
        Key::required("value", Holds::Sent, "The value at that time."),
    ],
};

/// How an action comes out.
pub static OUTCOME: Section = Section {
    name: "an outcome",
    keys: &[
        Key::required(
            "outcome",
            Holds::NewName,
            "Name of the outcome: `found`, `done`; `never` for an action without an end.",
        ),
        Key::or("after", A_TIME, "0 s", "Duration of the action."),
        Key::optional("sets", Holds::Of(Named::Signal, &Holds::Sent), "Values of signals from then on, by name."),
    ],
};

/// A force on a sensor.
pub static PUSH: Section = Section {
    name: "a push",
    keys: &[
        Key::or("from", A_TIME, "0 s", "Start of the push."),
        Key::optional("to", A_TIME, "End of the push; default: the end of the run."),
        Key::optional("force", Holds::Vector(FORCE), "The force on the robot, in the axes of the world."),
        Key::optional("moment", Holds::Vector(MOMENT), "The moment on the robot, in the axes of the world."),
        Key::optional("link", Holds::Link, "Instead of a force: the link whose origin a hand pulls."),
        Key::optional("towards", Holds::Vector(LENGTH), "The point in the world towards which the hand pulls."),
        Key::or(
            "stiffness",
            Holds::Number(Quantity::at_least(STIFFNESS, 0.0)),
            "200 N/m",
            "Stiffness of the hand: force for each metre from the point.",
        ),
        Key::or(
            "damping",
            Holds::Number(Quantity::at_least(DAMPING, 0.0)),
            "20 N s/m",
            "Damping of the hand: force against each metre per second.",
        ),
        Key::or("most", Holds::Number(Quantity::at_least(FORCE, 0.0)), "30 N", "The largest force of the hand."),
    ],
};

/// A late tick.
pub static LATE: Section = Section {
    name: "a late tick",
    keys: &[
        Key::required("at", A_TIME, "Time of the first tick that is late."),
        Key::required("by", Holds::Number(Quantity::above(TIME, 0.0)), "Delay of the next tick."),
    ],
};

/// A reading that is lost.
pub static LOST: Section = Section {
    name: "a lost reading",
    keys: &[
        Key::required("from", A_TIME, "From when the readings are lost."),
        Key::required("to", A_TIME, "Time until which the readings are lost."),
    ],
};
