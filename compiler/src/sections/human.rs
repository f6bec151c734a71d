//! Keys of humans, and of what they do in a scenario.

use blocks::{Unbound, Word, block};
use stdlib_tasks::dimension::{LENGTH, NONE, RATE, TIME, VELOCITY};
use stdlib_tasks::params::Quantity;

use super::{BlockSchema, Key, LOST, Named, ValueType, WAYPOINT};

const A_TIME: ValueType = ValueType::Number(Quantity::at_least(TIME, 0.0));
const A_SPEED: ValueType = ValueType::Number(Quantity::above(VELOCITY, 0.0));

block! {
    /// A human.
    pub struct HumanBlock = HUMAN, "a human" {
        /// Names of the tracked points: `points [chest, left_wrist]`. Each is a position in the world, `NAME.chest`.
        points: Option<Unbound> =
            required_elsewhere(ValueType::List(&ValueType::NewName), "[chest, left_wrist, right_wrist]");
        /// Segments between two points: `links [[chest, left_wrist]]`. The host can read them from the program.
        links: Option<Unbound> = elsewhere(ValueType::List(&ValueType::List(&ValueType::Name(Named::Point))));
        /// Time for which a reading is valid after it was received.
        timeout: f64 = or(ValueType::Number(Quantity::above(TIME, 0.0)), "0.2 s");
        /// Velocity of the points between readings: estimated from successive positions, sent by the host after each
        /// position, or none.
        velocity: Word = or(ValueType::Choice(&["estimated", "measured", "none"]), "estimated");
        /// Cutoff of the first-order low-pass filter of an estimated velocity.
        cutoff: f64 = or(ValueType::Number(Quantity::above(RATE, 0.0)), "5 Hz");
        /// The largest plausible speed; a larger velocity is shortened to it.
        max_speed: Option<f64> = optional(A_SPEED);
        /// Treatment of a point when its readings stop: it is absent, which is the fault `stale`; or its last
        /// position remains valid, at rest, and `uncertainty(NAME)` grows.
        lost: Word = or(ValueType::Choice(&["fault", "hold"]), "fault");
        /// Growth rate of the uncertainty of a held point: by default the walking speed of ISO 13855.
        growth: f64 = or(A_SPEED, "1.6 m/s");
    }
}

/// Motion of a human in a scenario.
pub static HUMAN_SCRIPT: BlockSchema = BlockSchema {
    name: "the script of a human",
    keys: &[
        Key::optional(
            "value",
            ValueType::Vector(LENGTH),
            "Constant position of the body; `shape` gives the positions of its points.",
        ),
        Key::optional(
            "path",
            ValueType::List(&ValueType::Block(&WAYPOINT)),
            "Path of the body: `[{ at 0 s  value [..] m }, ..]`, along straight lines, without rotation; `shape` gives \
             the positions of its points.",
        ),
        Key::optional(
            "shape",
            ValueType::Of(Named::Point, &ValueType::Vector(LENGTH)),
            "Where each point is relative to the body, along the axes of the world.",
        ),
        Key::optional(
            "points",
            ValueType::Of(Named::Point, &ValueType::Block(&HUMAN_POINT)),
            "Instead of a body, a script for each point.",
        ),
        Key::optional(
            "file",
            ValueType::Text,
            "Instead of both, a recording as a file of comma-separated values: a header \
             `time,chest.x,chest.y,chest.z,..`, then lines in s and m.",
        ),
        Key::or("from", A_TIME, "0 s", "Time of the first reading."),
        Key::optional("to", A_TIME, "Time after which no reading is sent; default: the end of the run."),
        Key::or(
            "noise",
            ValueType::Number(Quantity::at_least(LENGTH, 0.0)),
            "0 m",
            "Standard deviation of the noise on each number of a position.",
        ),
        Key::or("delay", A_TIME, "0 s", "Time from the measurement of a reading to its arrival."),
        Key::or(
            "drop",
            ValueType::Number(Quantity { min: 0.0, max: 1.0, ..Quantity::any(NONE) }),
            "0",
            "Fraction of the readings that are lost in transmission, for all points together, from 0 to 1.",
        ),
        Key::or("period", A_TIME, "0 s", "Time between two readings; 0 for one at every tick."),
        Key::optional(
            "nan",
            ValueType::Numbers(Quantity::at_least(TIME, 0.0)),
            "Times at which a reading is sent that is not a number.",
        ),
        Key::optional(
            "lost",
            ValueType::Blocks(&LOST),
            "Intervals in which the person is not observed, but continues to move.",
        ),
    ],
};

/// Path of a point of a human.
pub static HUMAN_POINT: BlockSchema = BlockSchema {
    name: "the way of a point",
    keys: &[
        Key::optional("value", ValueType::Vector(LENGTH), "Constant position of the point."),
        Key::optional(
            "path",
            ValueType::List(&ValueType::Block(&WAYPOINT)),
            "Path of the point: `[{ at 0 s  value [..] m }, ..]`.",
        ),
    ],
};
