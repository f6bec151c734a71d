//! Keys of signals, machines and states. What begins a part of a state is a word that the readers take.

use blocks::{Located, Unbound, Word, block};
use quantities::usual;
use stdlib_tasks::dimension::{ANGULAR_VELOCITY, TIME};
use stdlib_tasks::params::Quantity;

use super::{BlockSchema, Key, Named, ValueType};

const TURNING: ValueType = ValueType::Number(Quantity::above(ANGULAR_VELOCITY, 0.0).usually(0.01, 80.0));

block! {
    /// A signal.
    pub struct SignalBlock = SIGNAL, "a signal" {
        /// Time for which a value is valid after it was received. After this time the signal is absent; if the state
        /// needs a signal without `?`, this is the fault `stale`.
        timeout: Option<f64> = optional(ValueType::Number(usual::TIMEOUT));
        /// Of a wrench: the link in whose axes the sensor gives force and moment, with the moment about the link's
        /// origin; the name of an arm is that of its tip. The wrench is rotated into the axes of the world at the
        /// observed configuration. Default: the sensor gives the wrench in the axes of the world.
        frame: Option<Unbound> = elsewhere(ValueType::Link);
        /// Of a wrench: the sensor's reading without contact, in the sensor's axes; it is subtracted first.
        /// `tare(NAME)` replaces it while the machine runs.
        bias: Option<WrenchBlock> = optional(ValueType::Block(&WRENCH));
        /// Cutoff frequency of a first-order low-pass filter for a number, a vector or a wrench, and for a pose with
        /// `velocity`. It is applied last, and starts again after the signal was absent. With `velocity`, the filtered
        /// value goes on with the velocity, so that a steady motion does not lag, and `NAME.velocity` is the derivative
        /// of the filtered value.
        low_pass: Option<Located<f64>> = optional(ValueType::Number(usual::CUTOFF));
        /// Of a point or a pose: its velocity, estimated from successive readings, or sent by the host
        /// after each value. It is `NAME.velocity`, of a pose also `NAME.angular_velocity`, and the time derivative of
        /// the value in expressions. Default: the value counts as at rest between readings.
        velocity: Option<Word> = optional(ValueType::Choice(&["estimated", "measured"]));
        /// With `velocity`: cutoff of the first-order low-pass filter of an estimated velocity. Default: 5 Hz.
        cutoff: Option<f64> = optional(ValueType::Number(usual::CUTOFF));
        /// With `velocity`: the value between two readings goes on from the last one with the velocity, until the `timeout`;
        /// or it stays at the last one. Default: `extrapolate`, and `hold` without a `timeout`.
        between: Option<Word> = optional(ValueType::Choice(&["extrapolate", "hold"]));
        /// With `velocity`: the largest plausible speed; a larger velocity is shortened to it. Default: any.
        max_speed: Option<f64> = optional(ValueType::Number(usual::WALKING_SPEED));
        /// With `velocity`, of a pose: the largest plausible angular speed; a larger one is shortened to it. Default: any.
        max_angular_speed: Option<f64> = optional(TURNING);
    }
    also [
        Key::required(
            "type",
            ValueType::Choice(&["event", "flag", "wrench", "point", "length"]),
            "Type of the value: `event`, `flag`, `wrench`, or the type of a quantity such as `point`. With a `?` after \
             the type, the signal may be absent.",
        )
        .at(super::Place::Yaml),
    ]
}

block! {
    /// The parts of a wrench.
    pub struct WrenchBlock = WRENCH, "a wrench" {
        /// The force.
        force: [f64; 3] = or(ValueType::Vector(usual::CONTACT_FORCE), "[0, 0, 0] N");
        /// The moment.
        moment: [f64; 3] = or(ValueType::Vector(usual::CONTACT_MOMENT), "[0, 0, 0] Nm");
    }
}

impl WrenchBlock {
    /// Returns the force (N), then the moment (N m).
    pub fn numbers(&self) -> [f64; 6] {
        let ([fx, fy, fz], [mx, my, mz]) = (self.force, self.moment);
        [fx, fy, fz, mx, my, mz]
    }
}

/// A variable of the machine.
pub static VARIABLE: BlockSchema = BlockSchema {
    name: "a variable",
    keys: &[
        Key::required(
            "type",
            ValueType::Choice(&["number", "flag", "point", "length"]),
            "Type of the value: `flag`, or the type of a quantity such as `number`. With a `?` after the type, the \
             variable may be absent.",
        )
        .at(super::Place::Yaml),
        Key::optional(
            "value",
            ValueType::Sent,
            "Initial value; a variable with `?` and without a value is absent at the start.",
        )
        .at(super::Place::Yaml),
    ],
};

block! {
    /// A machine.
    pub struct MachineBlock = MACHINE, "a machine" {
        /// The initial state.
        initial: Option<Located<String>> = required(ValueType::Name(Named::State));
        /// Time for the command to go over to that of another stack, for the transitions in this block. Default: no
        /// transition time.
        blend: Option<f64> = optional(BLEND);
    }
    also [
        Key::optional("transitions", ValueType::List(&ValueType::Block(&TRANSITION)), TRANSITIONS)
            .at(super::Place::Yaml),
        Key::optional("check", ValueType::Declarations, PROPERTY).at(super::Place::Word),
        Key::required("states", ValueType::Each(&ValueType::Block(&STATE)), "States by name.").at(super::Place::Yaml),
        Key::required("state", ValueType::Block(&STATE), "A state: `state NAME { stack NAME  on EVENT -> NEXT }`.")
            .at(super::Place::Hq),
        Key::optional("final", ValueType::Block(&STATE), FINAL).at(super::Place::Hq),
        Key::optional("on", ValueType::Declarations, "A transition of all states: `on fault(any) -> stopped`.")
            .at(super::Place::Hq),
    ]
}

const FINAL: &str = "A state in which the machine has come to its end: `final state NAME { stack NAME }`.";
const PROPERTY: &str = "A property that must hold at every tick, for all values of the signals: `check always not (in(STATE) and FLAG)`; of a \
     state, at every tick at which it is active.";
const BLEND: ValueType = ValueType::Number(Quantity::at_least(TIME, 0.0).usually(1e-3, 60.0));
const TRANSITIONS: &str = "Transitions, in the order of their evaluation: `- { on: found, to: grasp }`, \
     `- { when: CONDITION, for: 3 s, to: grasp, blend: 1 s }`, `- { after: 10 s, to: ask }`.";

block! {
    /// A state.
    pub struct StateBlock = STATE, "a state" {
        /// The state inside it that is entered with it.
        initial: Option<Located<String>> = optional(ValueType::Name(Named::State));
        /// Time for the command to go over to that of another stack, for the transitions in this block. Default: the
        /// `blend` of the enclosing state, or else no transition time.
        blend: Option<f64> = optional(BLEND);
    }
    also [
        Key::optional(
            "stack",
            ValueType::Name(Named::Stack),
            "The stack that runs in it: `stack NAME`, or `stack NAME(..)` for one with parameters. Default: the stack \
             of the enclosing state continues; if there is none, the robot stands still.",
        )
        .at(super::Place::Word),
        Key::optional("final", ValueType::Flag, "True if the machine has come to its end in this state.")
            .at(super::Place::Yaml),
        Key::optional("enter", ValueType::Declarations, "Actions on entering: `enter say \"text\"`.")
            .at(super::Place::Word),
        Key::optional(
            "do",
            ValueType::Declarations,
            "An action that is started on entering and called off on leaving: `do capture(head_camera)`.",
        )
        .at(super::Place::Word),
        Key::optional("exit", ValueType::Declarations, "Actions on leaving.").at(super::Place::Word),
        Key::optional(
            "on",
            ValueType::Declarations,
            "A transition at an event: `on EVENT -> STATE`, `on reached(TASK, 5 mm, 2 deg, 1 mm/s) -> STATE`, `on fault(KIND) \
             -> STATE`.",
        )
        .at(super::Place::Hq),
        Key::optional(
            "when",
            ValueType::Declarations,
            "A transition while something holds: `when CONDITION for 3 s -> STATE`.",
        )
        .at(super::Place::Hq),
        Key::optional(
            "after",
            ValueType::Declarations,
            "A transition after a time in the state: `after 10 s -> STATE`.",
        )
        .at(super::Place::Hq),
        Key::optional("transitions", ValueType::List(&ValueType::Block(&TRANSITION)), TRANSITIONS)
            .at(super::Place::Yaml),
        Key::optional("check", ValueType::Declarations, PROPERTY).at(super::Place::Word),
        Key::optional("state", ValueType::Block(&STATE), "A state inside it.").at(super::Place::Hq),
        Key::optional("final", ValueType::Block(&STATE), FINAL).at(super::Place::Hq),
        Key::optional("states", ValueType::Each(&ValueType::Block(&STATE)), "States inside it, by name.")
            .at(super::Place::Yaml),
        Key::optional("region", ValueType::Block(&STATE), REGION).at(super::Place::Hq),
        Key::optional(
            "regions",
            ValueType::Each(&ValueType::Block(&STATE)),
            "Regions by name: parts of the state that are active beside each other, each with an initial state, states \
             and transitions of its own.",
        )
        .at(super::Place::Yaml),
    ]
}

const REGION: &str =
    "A part of the state that is active beside its other regions: `region NAME { initial STATE  state STATE { .. } }`.";

block! {
    /// A transition.
    pub struct TransitionBlock = TRANSITION, "a transition" {
        /// Time for the command to go over to that of another stack.
        blend: Option<f64> = optional(BLEND);
    }
    also [
        Key::optional("on", ValueType::Text, "The trigger: an event, `reached(TASK, ..)`, `fault(KIND)`.")
            .at(super::Place::Yaml),
        Key::optional("when", ValueType::Value, "The condition that must hold.").at(super::Place::Yaml),
        Key::optional(
            "for",
            ValueType::Number(Quantity::at_least(TIME, 0.0)),
            "Time for which the condition must have held without a break.",
        )
        .at(super::Place::Yaml),
        Key::optional("after", ValueType::Number(Quantity::at_least(TIME, 0.0)), "Time in the state.")
            .at(super::Place::Yaml),
        Key::required("to", ValueType::Name(Named::State), "The state that the transition leads to.")
            .at(super::Place::Yaml),
    ]
}
