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

/// Entries of scenarios of missions that only schedules have.
pub const OF_SCHEDULES: &[&str] = &["travel", "feedback"];

/// A scenario.
pub static SCENARIO: Section = Section {
    name: "a scenario",
    keys: &[
        Key::optional("stack", Holds::Name(Named::Stack), "The stack that runs; where left out, what `run` runs."),
        Key::optional("machine", Holds::Name(Named::Machine), "The machine that runs, instead of a stack."),
        Key::optional(
            "mission",
            Holds::Name(Named::Mission),
            "The mission that is executed, instead of a robot's controller.",
        ),
        Key::optional(
            "duration",
            Holds::Number(Quantity::above(TIME, 0.0)),
            "How long it runs; as `run` where left out, and required for a mission.",
        ),
        Key::or(
            "seed",
            Holds::Number(Quantity::at_least(NONE, 0.0)),
            "0",
            "Of everything random in it, a whole number.",
        ),
        Key::optional("start", Holds::Positions, "Where joints stand at the beginning; others stand as `home` says."),
        Key::optional(
            "simulator",
            Holds::Block(&SCENARIO_SIMULATOR),
            "How the simulated robot differs from a perfect one; what is left out is as in `run`.",
        ),
        Key::optional("signals", Holds::Each(&Holds::Blocks(&SIGNAL_SCRIPT)), "What signals are sent, by name."),
        Key::optional(
            "humans",
            Holds::Each(&Holds::Block(&HUMAN_SCRIPT)),
            "What people do in the whole run, and how the tracker tells of it, by name.",
        ),
        Key::optional(
            "events",
            Holds::Each(&Holds::Numbers(Quantity::at_least(TIME, 0.0))),
            "When the host raises events, by name: `start 1 s`, `start [1, 20] s`.",
        ),
        Key::optional(
            "outcomes",
            Holds::Each(&Holds::Blocks(&OUTCOME)),
            "What becomes of actions, by their first argument or their verb. The k-th request comes out as the k-th entry \
             says, and the last entry repeats. An action of which nothing is said succeeds at once.",
        ),
        Key::optional(
            "push",
            Holds::Each(&Holds::Blocks(&PUSH)),
            "Forces on sensors, by the name of the wrench signal.",
        ),
        Key::optional(
            "late",
            Holds::Blocks(&LATE),
            "Ticks that come late: the controller is not called, and the robot goes on with its last command.",
        ),
        Key::optional(
            "lost",
            Holds::PerJoint(&Holds::Blocks(&LOST)),
            "Readings of joints that are lost: their position is not a number.",
        ),
        Key::or(
            "operations",
            Holds::Choice(&["sampled", "planned"]),
            "sampled",
            "Of a mission: operations, or tasks of layers, take as long as drawn from their distributions, and operations of workers with `runs` as long as their controllers take; or all as long as planned.",
        ),
        Key::or(
            "travel",
            Holds::Choice(&["planned", "bases"]),
            "planned",
            "Of a schedule: robots travel as planned, through each other; or as wheeled bases that follow the plan and keep \
             out of each other's way and that of people.",
        ),
        Key::or(
            "replan",
            Holds::Choice(&["none", "reschedule", "both"]),
            "both",
            "Of a mission: what the plan does when something differs from it. Its times move no more than they must; what \
             people say moves them too; or it is also made anew when its cost has changed by more than `reallocate_above`.",
        ),
        Key::or(
            "step",
            Holds::Number(Quantity::above(TIME, 0.0)),
            "1 s",
            "Of a mission: the time from one instant at which expectations are judged to the next. The run is a whole number of \
             steps long.",
        ),
        Key::optional(
            "happens",
            Holds::Blocks(&HAPPENING),
            "Of a mission: what happens beside it, each at its time: `[{ at 120 s  moved h1  to [2, 0] m }, ..]`.",
        ),
        Key::optional(
            "feedback",
            Holds::Each(&Holds::Blocks(&REPLY)),
            "Of a schedule: what people say after they were served, by name. Of the k-th service they say the k-th entry, and \
             the last entry repeats; an empty one is silence.",
        ),
        Key::optional("expect", Holds::Declarations, "What must hold: `expect \"label\" always margin(TASK) >= 0 m`.")
            .at(Place::Hq),
        Key::optional("expect", Holds::Declarations, "What must hold: `- FORMULA`, or `- LABEL: FORMULA`.")
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
            "Standard deviation of the noise on measured joint positions; of prismatic joints the same number in m.",
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
            "Instead of one value, values at instants, with straight lines between them: `[{ at 0 s  value [..] m }, ..]`.",
        ),
        Key::or("from", A_TIME, "0 s", "When the first value is sent."),
        Key::optional("to", A_TIME, "From when on none is sent; the end of the run where left out."),
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
            "The share of values that are lost on the way, from 0 to 1.",
        ),
        Key::or("period", A_TIME, "0 s", "Time from a value to the next; 0 for one at every tick."),
        Key::optional(
            "nan",
            Holds::Numbers(Quantity::at_least(TIME, 0.0)),
            "Instants at which a value that is not a number is sent.",
        ),
    ],
};

/// A value of a path.
pub static WAYPOINT: Section = Section {
    name: "a waypoint",
    keys: &[
        Key::required("at", A_TIME, "When, from the beginning of the run."),
        Key::required("value", Holds::Sent, "The value at that instant."),
    ],
};

/// How an action comes out.
pub static OUTCOME: Section = Section {
    name: "an outcome",
    keys: &[
        Key::required(
            "outcome",
            Holds::NewName,
            "The word for it: `found`, `done`; `never` for an action without an end.",
        ),
        Key::or("after", A_TIME, "0 s", "How long the action takes."),
        Key::optional("sets", Holds::Each(&Holds::Sent), "Values that signals have from then on, by name."),
    ],
};

/// A force on a sensor.
pub static PUSH: Section = Section {
    name: "a push",
    keys: &[
        Key::or("from", A_TIME, "0 s", "From when."),
        Key::optional("to", A_TIME, "Until when; the end of the run where left out."),
        Key::optional("force", Holds::Vector(FORCE), "The force on the robot, in the axes of the world."),
        Key::optional("moment", Holds::Vector(MOMENT), "The moment on the robot, in the axes of the world."),
        Key::optional("link", Holds::Link, "Instead of a force: the link whose origin a hand pulls."),
        Key::optional("towards", Holds::Vector(LENGTH), "The point of the world that it is pulled towards."),
        Key::or(
            "stiffness",
            Holds::Number(Quantity::at_least(STIFFNESS, 0.0)),
            "200 N/m",
            "Of the hand: force for each metre from the point.",
        ),
        Key::or(
            "damping",
            Holds::Number(Quantity::at_least(DAMPING, 0.0)),
            "20 N s/m",
            "Of the hand: force against each metre per second.",
        ),
        Key::or("most", Holds::Number(Quantity::at_least(FORCE, 0.0)), "30 N", "The largest force of the hand."),
    ],
};

/// A late tick.
pub static LATE: Section = Section {
    name: "a late tick",
    keys: &[
        Key::required("at", A_TIME, "The first tick that does not come in time."),
        Key::required("by", Holds::Number(Quantity::above(TIME, 0.0)), "How late the next one is."),
    ],
};

/// A reading that is lost.
pub static LOST: Section = Section {
    name: "a lost reading",
    keys: &[Key::required("from", A_TIME, "From when."), Key::required("to", A_TIME, "Until when.")],
};
