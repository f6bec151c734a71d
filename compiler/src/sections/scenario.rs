//! The keys of a scenario, and of what the world does in it.

use blocks::{ByName, Located, OneOrEach, Unbound, Word, block};
use quantities::usual;
use stdlib_tasks::dimension::{ANGLE, Dimension, LENGTH, NONE, TIME};
use stdlib_tasks::params::Quantity;

use super::human::HUMAN_SCRIPT;
use super::mission_events::{EVENT, REPLY};
use super::obstacle::TRUE_OBSTACLE;
use super::plant::{PLANT, PlantBlock};
use super::spec::{ACTUATOR_ACCELERATION, ACTUATOR_SPEED, SEED};
use super::{Key, Named, Place, ValueType};

const STIFFNESS: Dimension = Dimension { m: 0, kg: 1, s: -2, rad: 0 };
const DAMPING: Dimension = Dimension { m: 0, kg: 1, s: -1, rad: 0 };

const A_DELAY: ValueType = ValueType::Number(Quantity::at_least(TIME, 0.0).usually(1e-4, 120.0));
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
        /// Seed of all random numbers of the scenario.
        seed: usize = or(SEED, "0");
        /// Initial joint positions, or the name of a posture of the robot's `srdf`; the other joints start at `home`.
        start: Option<Unbound> = elsewhere(ValueType::Positions);
        /// Deviations of the simulated robot from a perfect one; default: those of `run`.
        simulator: ScenarioSimulator = optional(ValueType::Block(&SCENARIO_SIMULATOR));
        /// The robot as a body with masses and drives, moved by a library for physics; default: that of `run`.
        plant: PlantBlock = optional(ValueType::Block(&PLANT));
        /// Values that are sent to signals, by name.
        signals: Option<Unbound> = elsewhere(ValueType::Of(Named::Signal, &ValueType::Blocks(&SIGNAL_SCRIPT)));
        /// Motion of people during the whole run, and the readings of the tracker, by name.
        humans: Option<Unbound> = elsewhere(ValueType::Of(Named::Human, &ValueType::Block(&HUMAN_SCRIPT)));
        /// True places of obstacles, by name, where the controller does not believe them to be. Expectations and margins use
        /// the true ones.
        obstacles: Option<Unbound> = elsewhere(ValueType::Of(Named::Obstacle, &ValueType::Block(&TRUE_OBSTACLE)));
        /// Times at which the host raises events, by name: `start 1 s`, `start [1, 20] s`.
        events: Vec<ByName<OneOrEach>> = optional(ValueType::Of(Named::Event, &TIMES));
        /// Times at which the host stops the robot: it comes to rest, and stands until a `resume`.
        stop: Option<OneOrEach> = optional(TIMES);
        /// Times at which the host lets a robot go on that was stopped, or that takes commands again.
        resume: Option<OneOrEach> = optional(TIMES);
        /// Outcomes of actions, by their first argument or their verb. The k-th request has the outcome of the k-th
        /// entry, and the last entry repeats. An action without an entry succeeds immediately.
        outcomes: Option<Unbound> = elsewhere(ValueType::Each(&ValueType::Blocks(&OUTCOME)));
        /// Forces on sensors, by the name of the wrench signal.
        push: Option<Unbound> = elsewhere(ValueType::Of(Named::Signal, &ValueType::Blocks(&PUSH)));
        /// Ticks that are late: the controller is not called, and the robot continues with its last command.
        late: Vec<LateBlock> = optional(ValueType::Blocks(&LATE));
        /// Lost readings of joints: the position is not a number.
        lost: Vec<ByName<Vec<LostBlock>>> = optional(ValueType::PerJoint(&ValueType::Blocks(&LOST)));
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

/// Fraction of readings that are lost in transmission.
pub(super) const DROP: ValueType = ValueType::Number(Quantity::between(NONE, 0.0, 1.0));
/// Times at which a reading is not a number.
pub(super) const TIMES: ValueType = ValueType::Numbers(Quantity::at_least(TIME, 0.0));

block! {
    /// Values that a signal is sent in a scenario.
    pub struct SignalScriptBlock = SIGNAL_SCRIPT, "the script of a signal" {
        /// The value that is sent; of a wrench `{ force [..] N  moment [..] Nm }`.
        value: Option<Unbound> = elsewhere(ValueType::Sent);
        /// Instead of one value, values at given times, with linear interpolation: `[{ at 0 s  value [..] m }, ..]`.
        path: Option<Unbound> = elsewhere(ValueType::List(&ValueType::Block(&WAYPOINT)));
        /// Time of the first value.
        from: f64 = or(A_TIME, "0 s");
        /// Time after which no value is sent; default: the end of the run.
        to: Option<Located<f64>> = optional(A_TIME);
        /// Standard deviation of the noise on each number, in the unit of the value.
        noise: Unbound = or(ValueType::Bound, "0");
        /// Time from the measurement of a value to its arrival.
        delay: f64 = or(A_DELAY, "0 s");
        /// Fraction of the values that are lost in transmission, from 0 to 1.
        drop: f64 = or(DROP, "0");
        /// Time between two values; 0 for one at every tick.
        period: f64 = or(A_DELAY, "0 s");
        /// Times at which a value is sent that is not a number.
        nan: Option<OneOrEach> = optional(TIMES);
    }
}

block! {
    /// A value of a path.
    pub struct WaypointBlock = WAYPOINT, "a waypoint" {
        /// Time of the value, from the beginning of the run.
        at: Located<f64> = required(A_TIME, "3 s");
        /// The value at that time.
        value: Option<Unbound> = required_elsewhere(ValueType::Sent, "[0, 0, 1] m");
    }
}

block! {
    /// Outcome of an action in a scenario.
    pub struct OutcomeBlock = OUTCOME, "an outcome" {
        /// Name of the outcome: `found`, `done`; `never` for an action without an end.
        outcome: Located<String> = required(ValueType::NewName, "done");
        /// Duration of the action.
        after: f64 = or(A_TIME, "0 s");
        /// Values of signals from then on, by name.
        sets: Option<Unbound> = elsewhere(ValueType::Of(Named::Signal, &ValueType::Sent));
    }
}

block! {
    /// A force on a sensor.
    pub struct PushBlock = PUSH, "a push" {
        /// Start of the push.
        from: f64 = or(A_TIME, "0 s");
        /// End of the push; default: the end of the run.
        to: Option<Located<f64>> = optional(A_TIME);
        /// The force on the robot, in the axes of the world.
        force: Option<[f64; 3]> = optional(ValueType::Vector(usual::CONTACT_FORCE), "[0, 0, -20] N");
        /// The moment on the robot, in the axes of the world.
        moment: Option<[f64; 3]> = optional(ValueType::Vector(usual::CONTACT_MOMENT));
        /// Instead of a force: the link whose origin a hand pulls.
        link: Option<Unbound> = elsewhere(ValueType::Link);
        /// The point in the world towards which the hand pulls.
        towards: Option<[f64; 3]> = optional(ValueType::Vector(Quantity::any(LENGTH)), "[0.6, 0, 1.2] m");
        /// Stiffness of the hand: force for each metre from the point.
        stiffness: f64 = or(ValueType::Number(Quantity::at_least(STIFFNESS, 0.0).usually(0.1, 2e5)), "200 N/m");
        /// Damping of the hand: force against each metre per second.
        damping: f64 = or(ValueType::Number(Quantity::at_least(DAMPING, 0.0).usually(1e-2, 2e4)), "20 N s/m");
        /// The largest force of the hand.
        most: f64 =
            or(ValueType::Number(Quantity { min: 0.0, ..usual::CONTACT_FORCE }), "30 N");
    }
}

block! {
    /// A late tick.
    pub struct LateBlock = LATE, "a late tick" {
        /// Time of the first tick that is late.
        at: f64 = required(A_TIME, "3 s");
        /// Delay of the next tick.
        by: f64 = required(ValueType::Number(Quantity::above(TIME, 0.0).usually(1e-5, 60.0)), "30 ms");
    }
}

block! {
    /// A reading that is lost.
    pub struct LostBlock = LOST, "a lost reading" {
        /// From when the readings are lost.
        from: f64 = required(A_TIME, "3 s");
        /// Time until which the readings are lost.
        to: Located<f64> = required(A_TIME, "3.02 s");
    }
}
