//! The keys of a robot and of its parts.

use stdlib_tasks::dimension::{LENGTH, RATE, TIME};
use stdlib_tasks::params::Quantity;

use super::{BlockSchema, Key, Named, Place, ValueType};

/// The words for what carries the root link.
pub static BASES: &[&str] = &["fixed", "planar", "unicycle", "floating"];

/// A robot.
pub static ROBOT: BlockSchema = BlockSchema {
    name: "a robot",
    keys: &[
        Key::optional(
            "from",
            ValueType::Name(Named::Robot),
            "The robot from which this one is made; keys of this robot replace those of the other.",
        )
        .at(Place::Yaml),
        Key::required("urdf", ValueType::Urdf, "Path of the URDF, relative to the folder of the spec."),
        Key::or("base", ValueType::Choice(BASES), "fixed", "Mobility of the root link."),
        Key::required(
            "rate",
            ValueType::Number(Quantity { min: 0.1, max: 1e5, ..Quantity::any(RATE) }),
            "The rate of control, from 0.1 Hz to 100 kHz.",
        ),
        Key::optional(
            "arms",
            ValueType::Each(&ValueType::Block(&ARM)),
            "Arms by name: `left { shoulder ..  elbow ..  wrist ..  tip ..  points [..] }`.",
        ),
        Key::optional(
            "points",
            ValueType::Each(&ValueType::LinkOr(&POINT)),
            "Points by name: `NAME LINK`, or `NAME { link LINK  offset [x, y, z] m }`.",
        ),
        Key::optional(
            "segments",
            ValueType::Each(&ValueType::Block(&SEGMENT)),
            "Segments by name: `NAME { link LINK  from [..] m  to [..] m }`.",
        ),
        Key::optional(
            "groups",
            ValueType::Each(&ValueType::Geometries),
            "Groups of points, segments and links by name.",
        ),
        Key::optional(
            "joints",
            ValueType::Each(&ValueType::Joints),
            "Groups of joints by name: `torso [torso_yaw, torso_lift]  arm \"arm_*\"`.",
        ),
        Key::optional(
            "home",
            ValueType::Positions,
            "Initial configuration. A joint that is not named starts at zero, or at the limit nearest to it.",
        ),
        Key::optional(
            "lock",
            ValueType::Locks,
            "Joints that are removed from the model: fixed at `home`, or at a given position.",
        ),
        Key::optional(
            "limits",
            ValueType::PerJoint(&ValueType::Block(&LIMIT)),
            "Limits that replace those of the URDF: `elbow { lower 0 rad  upper 2 rad  velocity 1 rad/s }`.",
        ),
        Key::optional(
            "deadline",
            ValueType::Number(Quantity::above(TIME, 0.0)),
            "Maximum time between two ticks; a longer one is the fault `deadline`. More than a period; default: two \
             periods.",
        ),
        Key::or(
            "tracking_gain",
            ValueType::Number(Quantity::at_least(RATE, 0.0)),
            "0 /s",
            "Gain that pulls the measured configuration to the reference, at most the rate of control.",
        ),
        Key::optional(
            "package_path",
            ValueType::Text,
            "Folder for `package://` addresses of the URDF, relative to the folder of the spec.",
        ),
    ],
};

/// An arm.
pub static ARM: BlockSchema = BlockSchema {
    name: "an arm",
    keys: &[
        Key::optional(
            "shoulder",
            ValueType::Link,
            "The link at the shoulder of a human-like arm; `swivel_angle` needs it.",
        ),
        Key::optional("elbow", ValueType::Link, "The link at the elbow; `swivel_angle` needs it."),
        Key::optional("wrist", ValueType::Link, "The link at the wrist; `swivel_angle` needs it."),
        Key::required("tip", ValueType::Link, "The link at the end. The arm's name can be used as a frame."),
        Key::optional(
            "points",
            ValueType::Geometries,
            "Points, segments and links of the groups `arms` and `arms.NAME`.",
        ),
    ],
};

/// A point.
pub static POINT: BlockSchema = BlockSchema {
    name: "a point",
    keys: &[
        Key::required("link", ValueType::Link, "The link that carries the point."),
        Key::or("offset", ValueType::Vector(LENGTH), "[0, 0, 0] m", "Position in the frame of the link."),
    ],
};

/// A segment.
pub static SEGMENT: BlockSchema = BlockSchema {
    name: "a segment",
    keys: &[
        Key::required("link", ValueType::Link, "The link that carries the segment."),
        Key::required("from", ValueType::Vector(LENGTH), "One end in the frame of the link."),
        Key::required("to", ValueType::Vector(LENGTH), "The other end in the frame of the link."),
    ],
};

/// Limits of a joint.
pub static LIMIT: BlockSchema = BlockSchema {
    name: "a joint limit",
    keys: &[
        Key::optional("lower", ValueType::OfJoint { speed: false }, "The lowest position."),
        Key::optional("upper", ValueType::OfJoint { speed: false }, "The highest position."),
        Key::optional("velocity", ValueType::OfJoint { speed: true }, "The highest speed, more than zero."),
    ],
};
