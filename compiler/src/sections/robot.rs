//! The keys of a robot and of its parts.

use stdlib_tasks::dimension::{LENGTH, RATE, TIME};
use stdlib_tasks::params::Quantity;

use super::{Holds, Key, Named, Place, Section};

/// The words for what carries the root link.
pub static BASES: &[&str] = &["fixed", "planar", "unicycle", "floating"];

/// A robot.
pub static ROBOT: Section = Section {
    name: "a robot",
    keys: &[
        Key::optional(
            "from",
            Holds::Name(Named::Robot),
            "The robot that this one is made from; a key of its own replaces the other one's.",
        )
        .at(Place::Yaml),
        Key::required("urdf", Holds::Urdf, "The path of the URDF, from the folder of the spec."),
        Key::or("base", Holds::Choice(BASES), "fixed", "What carries the root link."),
        Key::required(
            "rate",
            Holds::Number(Quantity { min: 0.1, max: 1e5, ..Quantity::any(RATE) }),
            "The rate of control, from 0.1 Hz to 100 kHz.",
        ),
        Key::optional(
            "arms",
            Holds::Each(&Holds::Block(&ARM)),
            "Arms by name: `left { shoulder ..  elbow ..  wrist ..  tip ..  points [..] }`.",
        ),
        Key::optional(
            "points",
            Holds::Each(&Holds::LinkOr(&POINT)),
            "Points by name: `NAME LINK`, or `NAME { link LINK  offset [x, y, z] m }`.",
        ),
        Key::optional(
            "segments",
            Holds::Each(&Holds::Block(&SEGMENT)),
            "Segments by name: `NAME { link LINK  from [..] m  to [..] m }`.",
        ),
        Key::optional("groups", Holds::Each(&Holds::Geometries), "Groups of points, segments and links by name."),
        Key::optional(
            "joints",
            Holds::Each(&Holds::Joints),
            "Groups of joints by name: `torso [torso_yaw, torso_lift]  arm \"arm_*\"`.",
        ),
        Key::optional(
            "home",
            Holds::Positions,
            "The configuration at the start. A joint that is left out stands at zero, or at the limit nearest to it.",
        ),
        Key::optional(
            "lock",
            Holds::Locks,
            "Joints that are taken out of the model: held at `home`, or where a position says.",
        ),
        Key::optional(
            "limits",
            Holds::PerJoint(&Holds::Block(&LIMIT)),
            "Limits that replace those of the URDF: `elbow { lower 0 rad  upper 2 rad  velocity 1 rad/s }`.",
        ),
        Key::optional(
            "deadline",
            Holds::Number(Quantity::above(TIME, 0.0)),
            "A tick that comes later than this after the one before is the fault `deadline`: more than a period, two where left out.",
        ),
        Key::or(
            "tracking_gain",
            Holds::Number(Quantity::at_least(RATE, 0.0)),
            "0 /s",
            "How strongly the measured configuration is pulled to the reference, up to the rate of control.",
        ),
        Key::optional(
            "package_path",
            Holds::Text,
            "A folder in which `package://` addresses of the URDF are looked for, from the folder of the spec.",
        ),
    ],
};

/// An arm.
pub static ARM: Section = Section {
    name: "an arm",
    keys: &[
        Key::optional(
            "shoulder",
            Holds::Link,
            "The link at the shoulder of a human-like arm; `swivel_angle` needs it.",
        ),
        Key::optional("elbow", Holds::Link, "The link at the elbow; `swivel_angle` needs it."),
        Key::optional("wrist", Holds::Link, "The link at the wrist; `swivel_angle` needs it."),
        Key::required("tip", Holds::Link, "The link at the end. The arm's name stands for it where a frame is wanted."),
        Key::optional(
            "points",
            Holds::Geometries,
            "Points, segments and links that the groups `arms` and `arms.NAME` stand for.",
        ),
    ],
};

/// A point.
pub static POINT: Section = Section {
    name: "a point",
    keys: &[
        Key::required("link", Holds::Link, "The link that carries it."),
        Key::or("offset", Holds::Vector(LENGTH), "[0, 0, 0] m", "Where it is in the frame of the link."),
    ],
};

/// A segment.
pub static SEGMENT: Section = Section {
    name: "a segment",
    keys: &[
        Key::required("link", Holds::Link, "The link that carries it."),
        Key::required("from", Holds::Vector(LENGTH), "One end in the frame of the link."),
        Key::required("to", Holds::Vector(LENGTH), "The other end in the frame of the link."),
    ],
};

/// Limits of a joint.
pub static LIMIT: Section = Section {
    name: "a joint limit",
    keys: &[
        Key::optional("lower", Holds::OfJoint { speed: false }, "The lowest position."),
        Key::optional("upper", Holds::OfJoint { speed: false }, "The highest position."),
        Key::optional("velocity", Holds::OfJoint { speed: true }, "The greatest speed, more than zero."),
    ],
};
