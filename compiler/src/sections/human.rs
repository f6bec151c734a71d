//! Keys of humans, and of what they do in a scenario.

use blocks::{Located, OneOrEach, Unbound, Word, block};
use quantities::usual;
use stdlib_tasks::dimension::{LENGTH, TIME};
use stdlib_tasks::params::Quantity;

use super::scenario::{DROP, LOST, LostBlock, TIMES, WAYPOINT};
use super::{BlockSchema, Key, Named, ValueType};

const A_TIME: ValueType = ValueType::Number(Quantity::at_least(TIME, 0.0));
const A_DELAY: ValueType = ValueType::Number(Quantity::at_least(TIME, 0.0).usually(1e-4, 120.0));
const A_SPEED: ValueType = ValueType::Number(usual::WALKING_SPEED);

block! {
    /// A human.
    pub struct HumanBlock = HUMAN, "a human" {
        /// Names of the tracked points: `points [chest, left_wrist]`. Each is a position in the world, `NAME.chest`.
        points: Option<Unbound> =
            required_elsewhere(ValueType::List(&ValueType::NewName), "[chest, left_wrist, right_wrist]");
        /// Segments between two points: `links [[chest, left_wrist]]`. The host can read them from the program.
        links: Option<Unbound> = elsewhere(ValueType::List(&ValueType::List(&ValueType::Name(Named::Point))));
        /// Time for which a reading is valid after it was received.
        timeout: f64 = or(ValueType::Number(usual::TIMEOUT), "0.2 s");
        /// Velocity of the points: estimated from successive positions, sent by the host after each
        /// position, or none.
        velocity: Word = or(ValueType::Choice(&["estimated", "measured", "none"]), "estimated");
        /// Cutoff of the first-order low-pass filter of an estimated velocity.
        cutoff: f64 = or(ValueType::Number(usual::CUTOFF), "5 Hz");
        /// Place of a point between two readings: that of the last one, from which a limit knows how far the person can be;
        /// or on from it with the velocity, until the `timeout`, for a point that a target follows.
        between: Word = or(ValueType::Choice(&["hold", "extrapolate"]), "hold");
        /// The largest plausible speed; a larger velocity is shortened to it.
        max_speed: Option<f64> = optional(A_SPEED);
        /// Treatment of a point when its readings stop: it is absent, which is the fault `stale`; or its last
        /// position remains valid, at rest, and `uncertainty(NAME)` grows.
        lost: Word = or(ValueType::Choice(&["fault", "hold"]), "fault");
        /// Growth rate of the uncertainty of a held point: by default the walking speed of ISO 13855.
        growth: f64 = or(A_SPEED, "1.6 m/s");
    }
}

block! {
    /// Motion of a human in a scenario.
    pub struct HumanScriptBlock = HUMAN_SCRIPT, "the script of a human" {
        /// Constant position of the body; `shape` gives the positions of its points.
        value: Option<Unbound> = elsewhere(ValueType::Vector(Quantity::any(LENGTH)));
        /// Path of the body: `[{ at 0 s  value [..] m }, ..]`, along straight lines, without rotation; `shape` gives
        /// the positions of its points.
        path: Option<Unbound> = elsewhere(ValueType::List(&ValueType::Block(&WAYPOINT)));
        /// Position of each point relative to the body, along the axes of the world.
        shape: Option<Unbound> = elsewhere(ValueType::Of(Named::Point, &ValueType::Vector(Quantity::any(LENGTH))));
        /// Instead of a body, a script for each point.
        points: Option<Unbound> = elsewhere(ValueType::Of(Named::Point, &ValueType::Block(&HUMAN_POINT)));
        /// Instead of both, a recording as a file of comma-separated values: a header
        /// `time,chest.x,chest.y,chest.z,..`, then lines in s and m.
        file: Option<Located<String>> = optional(ValueType::Text);
        /// Time of the first reading.
        from: f64 = or(A_TIME, "0 s");
        /// Time after which no reading is sent; default: the end of the run.
        to: Option<Located<f64>> = optional(A_TIME);
        /// Standard deviation of the noise on each number of a position.
        noise: f64 = or(ValueType::Number(Quantity::at_least(LENGTH, 0.0).usually(1e-6, 2.0)), "0 m");
        /// Time from the measurement of a reading to its arrival.
        delay: f64 = or(A_DELAY, "0 s");
        /// Fraction of the readings that are lost in transmission, for all points together, from 0 to 1.
        drop: f64 = or(DROP, "0");
        /// Time between two readings; 0 for one at every tick.
        period: f64 = or(A_DELAY, "0 s");
        /// Times at which a reading is sent that is not a number.
        nan: Option<OneOrEach> = optional(TIMES);
        /// Intervals in which the person is not observed, but continues to move.
        lost: Vec<LostBlock> = optional(ValueType::Blocks(&LOST));
    }
}

/// Path of a point of a human.
pub static HUMAN_POINT: BlockSchema = BlockSchema {
    name: "the way of a point",
    keys: &[
        Key::optional("value", ValueType::Vector(Quantity::any(LENGTH)), "Constant position of the point."),
        Key::optional(
            "path",
            ValueType::List(&ValueType::Block(&WAYPOINT)),
            "Path of the point: `[{ at 0 s  value [..] m }, ..]`.",
        ),
    ],
};
