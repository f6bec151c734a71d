//! Keys of humans, and of what they do in a scenario.

use stdlib_tasks::dimension::{LENGTH, NONE, RATE, TIME, VELOCITY};
use stdlib_tasks::params::Quantity;

use super::{Holds, Key, LOST, Section, WAYPOINT};

const A_TIME: Holds = Holds::Number(Quantity::at_least(TIME, 0.0));
const A_SPEED: Holds = Holds::Number(Quantity::above(VELOCITY, 0.0));

/// A human.
pub static HUMAN: Section = Section {
    name: "a human",
    keys: &[
        Key::required(
            "points",
            Holds::List(&Holds::NewName),
            "Names of the points that are tracked: `points [chest, left_wrist]`. Each is a position in the world, `NAME.chest`.",
        ),
        Key::optional(
            "links",
            Holds::List(&Holds::List(&Holds::NewName)),
            "Segments between two points: `links [[chest, left_wrist]]`. The host can read them from the program.",
        ),
        Key::or(
            "timeout",
            Holds::Number(Quantity::above(TIME, 0.0)),
            "0.2 s",
            "How long a reading counts after it was received.",
        ),
        Key::or(
            "velocity",
            Holds::Choice(&["estimated", "measured", "none"]),
            "estimated",
            "How fast points move between readings: estimated from successive positions, sent by the host behind each position, or not at all.",
        ),
        Key::or(
            "cutoff",
            Holds::Number(Quantity::above(RATE, 0.0)),
            "5 Hz",
            "Of the first-order low-pass behind an estimated velocity.",
        ),
        Key::optional("max_speed", A_SPEED, "The largest speed that is believed; faster ones are shortened to it."),
        Key::or(
            "lost",
            Holds::Choice(&["fault", "hold"]),
            "fault",
            "What becomes of a point when its readings stop: it is absent, which is the fault `stale`; or its last position counts on, at rest, and `uncertainty(NAME)` grows.",
        ),
        Key::or("growth", A_SPEED, "1.6 m/s", "How fast the uncertainty of a held point grows."),
    ],
};

/// What a human does.
pub static HUMAN_SCRIPT: Section = Section {
    name: "the script of a human",
    keys: &[
        Key::optional(
            "value",
            Holds::Vector(LENGTH),
            "Where the body stands all the time; `shape` says where its points are.",
        ),
        Key::optional(
            "path",
            Holds::List(&Holds::Block(&WAYPOINT)),
            "Where the body goes: `[{ at 0 s  value [..] m }, ..]`, on straight lines, without turning; `shape` says where its points are.",
        ),
        Key::optional(
            "shape",
            Holds::Each(&Holds::Vector(LENGTH)),
            "Where each point is from where the body is, along the axes of the world.",
        ),
        Key::optional(
            "points",
            Holds::Each(&Holds::Block(&HUMAN_POINT)),
            "Instead of a body, the way of each point by itself.",
        ),
        Key::optional(
            "file",
            Holds::Text,
            "Instead of both, a recorded file of comma-separated values: a head `time,chest.x,chest.y,chest.z,..`, then lines in s and m.",
        ),
        Key::or("from", A_TIME, "0 s", "When the first reading is sent."),
        Key::optional("to", A_TIME, "From when on none is sent; the end of the run where left out."),
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
            "The share of readings that are lost on the way, of all points together, from 0 to 1.",
        ),
        Key::or("period", A_TIME, "0 s", "Time from a reading to the next; 0 for one at every tick."),
        Key::optional(
            "nan",
            Holds::Numbers(Quantity::at_least(TIME, 0.0)),
            "Instants at which a reading that is not a number is sent.",
        ),
        Key::optional("lost", Holds::Blocks(&LOST), "Spans of time in which nobody sees the person, who goes on."),
    ],
};

/// What a point of a human does.
pub static HUMAN_POINT: Section = Section {
    name: "the way of a point",
    keys: &[
        Key::optional("value", Holds::Vector(LENGTH), "Where it is all the time."),
        Key::optional(
            "path",
            Holds::List(&Holds::Block(&WAYPOINT)),
            "Where it goes: `[{ at 0 s  value [..] m }, ..]`.",
        ),
    ],
};
