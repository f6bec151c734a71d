//! Keys of humans, and of what they do in a scenario.

use stdlib_tasks::dimension::{LENGTH, NONE, RATE, TIME, VELOCITY};
use stdlib_tasks::params::Quantity;

use super::{Holds, Key, LOST, Named, Section, WAYPOINT};

const A_TIME: Holds = Holds::Number(Quantity::at_least(TIME, 0.0));
const A_SPEED: Holds = Holds::Number(Quantity::above(VELOCITY, 0.0));

/// A human.
pub static HUMAN: Section = Section {
    name: "a human",
    keys: &[
        Key::required(
            "points",
            Holds::List(&Holds::NewName),
            "Names of the tracked points: `points [chest, left_wrist]`. Each is a position in the world, `NAME.chest`.",
        ),
        Key::optional(
            "links",
            Holds::List(&Holds::List(&Holds::Name(Named::Point))),
            "Segments between two points: `links [[chest, left_wrist]]`. The host can read them from the program.",
        ),
        Key::or(
            "timeout",
            Holds::Number(Quantity::above(TIME, 0.0)),
            "0.2 s",
            "Time for which a reading is valid after it was received.",
        ),
        Key::or(
            "velocity",
            Holds::Choice(&["estimated", "measured", "none"]),
            "estimated",
            "Velocity of the points between readings: estimated from successive positions, sent by the host after each \
             position, or none.",
        ),
        Key::or(
            "cutoff",
            Holds::Number(Quantity::above(RATE, 0.0)),
            "5 Hz",
            "Cutoff of the first-order low-pass filter of an estimated velocity.",
        ),
        Key::optional("max_speed", A_SPEED, "The largest plausible speed; a larger velocity is shortened to it."),
        Key::or(
            "lost",
            Holds::Choice(&["fault", "hold"]),
            "fault",
            "Treatment of a point when its readings stop: it is absent, which is the fault `stale`; or its last \
             position remains valid, at rest, and `uncertainty(NAME)` grows.",
        ),
        Key::or("growth", A_SPEED, "1.6 m/s", "Growth rate of the uncertainty of a held point."),
    ],
};

/// What a human does.
pub static HUMAN_SCRIPT: Section = Section {
    name: "the script of a human",
    keys: &[
        Key::optional(
            "value",
            Holds::Vector(LENGTH),
            "Constant position of the body; `shape` gives the positions of its points.",
        ),
        Key::optional(
            "path",
            Holds::List(&Holds::Block(&WAYPOINT)),
            "Path of the body: `[{ at 0 s  value [..] m }, ..]`, along straight lines, without rotation; `shape` gives \
             the positions of its points.",
        ),
        Key::optional(
            "shape",
            Holds::Of(Named::Point, &Holds::Vector(LENGTH)),
            "Where each point is relative to the body, along the axes of the world.",
        ),
        Key::optional(
            "points",
            Holds::Of(Named::Point, &Holds::Block(&HUMAN_POINT)),
            "Instead of a body, a script for each point.",
        ),
        Key::optional(
            "file",
            Holds::Text,
            "Instead of both, a recording as a file of comma-separated values: a header \
             `time,chest.x,chest.y,chest.z,..`, then lines in s and m.",
        ),
        Key::or("from", A_TIME, "0 s", "Time of the first reading."),
        Key::optional("to", A_TIME, "Time after which no reading is sent; default: the end of the run."),
        Key::or(
            "noise",
            Holds::Number(Quantity::at_least(LENGTH, 0.0)),
            "0 m",
            "Standard deviation of the noise on each number of a position.",
        ),
        Key::or("delay", A_TIME, "0 s", "Time from the measurement of a reading to its arrival."),
        Key::or(
            "drop",
            Holds::Number(Quantity { min: 0.0, max: 1.0, ..Quantity::any(NONE) }),
            "0",
            "Fraction of the readings that are lost in transmission, for all points together, from 0 to 1.",
        ),
        Key::or("period", A_TIME, "0 s", "Time between two readings; 0 for one at every tick."),
        Key::optional(
            "nan",
            Holds::Numbers(Quantity::at_least(TIME, 0.0)),
            "Times at which a reading is sent that is not a number.",
        ),
        Key::optional(
            "lost",
            Holds::Blocks(&LOST),
            "Intervals in which nobody sees the person, who continues to move.",
        ),
    ],
};

/// What a point of a human does.
pub static HUMAN_POINT: Section = Section {
    name: "the way of a point",
    keys: &[
        Key::optional("value", Holds::Vector(LENGTH), "Constant position of the point."),
        Key::optional(
            "path",
            Holds::List(&Holds::Block(&WAYPOINT)),
            "Path of the point: `[{ at 0 s  value [..] m }, ..]`.",
        ),
    ],
};
