//! The keys of a robot and of its parts.

use blocks::{ByName, Located, Unbound, Word, block};
use quantities::usual;
use runtime::program::MOST_BEHIND;
use stdlib_tasks::dimension::{RATE, TIME};
use stdlib_tasks::params::Quantity;

use super::obstacle::PIECES_WITHIN;
use super::{Key, Named, Place, ValueType};

/// The words for what carries the root link.
pub static BASES: &[&str] = &["fixed", "planar", "unicycle", "floating"];

/// The words for how the robot is stopped.
pub static STOPS: &[&str] = &["to_rest", "now"];

/// The words for who lets a robot go on that has taken no commands.
pub static RESUMES: &[&str] = &["told", "itself"];

/// A time by which drives are behind.
const BEHIND: ValueType =
    ValueType::Number(Quantity { min: 0.0, max: MOST_BEHIND, ..Quantity::any(TIME) }.usually(1e-4, 0.3));

/// Returns what stands before the names of the parts of a robot that is not the only one of its spec.
pub fn prefix(robot: &str) -> String {
    format!("{robot}_")
}

block! {
    /// A robot.
    pub struct RobotBlock = ROBOT, "a robot" {
        /// Path of the URDF, relative to the folder of the spec.
        urdf: Option<Located<String>> = required(ValueType::Urdf, "\"robots/arm7.urdf\"");
        /// Path of the SRDF, relative to the folder of the spec: groups of joints and links, named postures, and pairs of links
        /// that are not kept apart.
        srdf: Option<Located<String>> = optional(ValueType::Srdf);
        /// Mobility of the root link.
        base: Word = or(ValueType::Choice(BASES), "fixed");
        /// The place of the robot in the world, a position or a pose: `[1, 0, 0] m`, `pose([1, 0, 0] m, rpy(0, 0, 90 deg))`.
        at: Option<Located<Unbound>> = elsewhere(ValueType::Value);
        /// The rate of control, from 0.1 Hz to 100 kHz.
        rate: Option<Located<f64>> =
            required(ValueType::Number(Quantity { min: 0.1, max: 1e5, ..Quantity::any(RATE) }.usually(1.0, 2e4)), "100 Hz");
        /// Arms by name: `left { shoulder ..  elbow ..  wrist ..  tip ..  points [..] }`.
        arms: Vec<ByName<ArmBlock>> = optional(ValueType::Each(&ValueType::Block(&ARM)));
        /// Points by name: `NAME LINK`, or `NAME { link LINK  offset [x, y, z] m }`.
        points: Vec<ByName<PointBlock>> = optional(ValueType::Each(&ValueType::LinkOr(&POINT)));
        /// Segments by name: `NAME { link LINK  from [..] m  to [..] m }`.
        segments: Vec<ByName<SegmentBlock>> = optional(ValueType::Each(&ValueType::Block(&SEGMENT)));
        /// Groups of points, segments and links by name.
        groups: Option<Located<Unbound>> = elsewhere(ValueType::Each(&ValueType::Geometries));
        /// Groups of joints by name: `torso [torso_yaw, torso_lift]  arm "arm_*"`.
        joints: Option<Located<Unbound>> = elsewhere(ValueType::Each(&ValueType::Joints));
        /// Initial configuration. A joint that is not named starts at zero, or at the limit nearest to it. The name of a posture
        /// of the `srdf` stands for its positions.
        home: Option<Located<Unbound>> = elsewhere(ValueType::Positions);
        /// Joints that are removed from the model: fixed at `home`, or at a given position.
        lock: Option<Located<Unbound>> = elsewhere(ValueType::Locks);
        /// Limits that replace those of the URDF: `elbow { lower 0 rad  upper 2 rad  velocity 1 rad/s }`.
        limits: Vec<ByName<LimitBlock>> = optional(ValueType::PerJoint(&ValueType::Block(&LIMIT)));
        /// Links whose cylinders and meshes are capsules around them, or `all` links: the default. They are the fastest, and the
        /// largest.
        capsules: Option<Located<Unbound>> = elsewhere(ValueType::Links);
        /// Links whose cylinders are exact and whose meshes are their convex hulls, or `all` links.
        hulls: Option<Located<Unbound>> = elsewhere(ValueType::Links);
        /// Links whose cylinders are exact and whose meshes are convex pieces that contain them, or `all` links: for links with
        /// hollows.
        pieces: Option<Located<Unbound>> = elsewhere(ValueType::Links);
        /// Distance by which pieces may exceed their mesh.
        pieces_within: Located<f64> = or(ValueType::Number(PIECES_WITHIN), "0.005 m");
        /// Maximum time between two calls; a longer one is the fault `deadline`. More than a period; default: two
        /// periods, and at least a period and 20 ms.
        deadline: Option<Located<f64>> = optional(ValueType::Number(Quantity::above(TIME, 0.0).usually(1e-5, 30.0)));
        /// Time constant of the drives: how fast the velocity of the robot follows the one that it is told. It tells the controller where the
        /// robot will be; a simulator has its own.
        lag: Option<Located<f64>> = optional(BEHIND);
        /// Time that passes before a command begins to move the robot: of buses, buffers and drives together.
        dead_time: Option<Located<f64>> = optional(BEHIND);
        /// Gain that pulls the measured configuration to the reference, at most the rate of control; default: 2 /s, or a quarter of the
        /// rate if this is less; with a `lag` or `dead_time`, a quarter of one divided by both and a period.
        tracking_gain: Option<Located<f64>> = optional(ValueType::Number(usual::GAIN));
        /// How the robot is stopped, at faults and in states without a stack: `to_rest`, a motion within the limits of the stack that moved it, or `now`,
        /// velocity zero at once, for hosts that stop the robot themselves.
        stop: Word = or(ValueType::Choice(STOPS), "to_rest");
        /// The signal that tells whether the robot takes commands, because its program runs and its brakes are open: it does while the signal is true.
        /// It does not while the signal is false, absent, or older than its `timeout`. A host may say no as well: both must say yes.
        enabled: Option<Located<Unbound>> = elsewhere(ValueType::Name(Named::Flag));
        /// Who lets the robot go on when it takes commands again, after a protective stop or with its drives on: the host that is `told` to, or it
        /// goes on by `itself`.
        resume: Word = or(ValueType::Choice(RESUMES), "told");
        /// Folder for `package://` addresses of the URDF, relative to the folder of the spec.
        package_path: Option<String> = optional(ValueType::Text);
    }
    also [
        Key::optional(
            "from",
            ValueType::Name(Named::Robot),
            "The robot from which this one is made; keys of this robot replace those of the other.",
        )
        .at(Place::Yaml),
    ]
}

block! {
    /// An arm.
    pub struct ArmBlock = ARM, "an arm" {
        /// The link at the shoulder of a human-like arm; `swivel_angle` needs it.
        shoulder: Option<Located<String>> = optional(ValueType::Link);
        /// The link at the elbow; `swivel_angle` needs it.
        elbow: Option<Located<String>> = optional(ValueType::Link);
        /// The link at the wrist; `swivel_angle` needs it.
        wrist: Option<Located<String>> = optional(ValueType::Link);
        /// The link at the end. The arm's name can be used as a frame.
        tip: Option<Located<String>> = required(ValueType::Link, "left_tool");
        /// Points, segments and links of the groups `arms` and `arms.NAME`.
        points: Option<Located<Unbound>> = elsewhere(ValueType::Geometries);
    }
}

block! {
    /// A point.
    pub struct PointBlock = POINT, "a point" {
        /// The link that carries the point.
        link: Option<Located<String>> = required(ValueType::Link, "link_4");
        /// Position in the frame of the link.
        offset: [f64; 3] = or(ValueType::Vector(usual::OFFSET), "[0, 0, 0] m");
    }
}

block! {
    /// A segment.
    pub struct SegmentBlock = SEGMENT, "a segment" {
        /// The link that carries the segment.
        link: Option<Located<String>> = required(ValueType::Link, "link_4");
        /// One end in the frame of the link.
        from: Option<Located<[f64; 3]>> = required(ValueType::Vector(usual::OFFSET), "[0, 0, 0] m");
        /// The other end in the frame of the link.
        to: Option<Located<[f64; 3]>> = required(ValueType::Vector(usual::OFFSET), "[0, 0, 0.3] m");
    }
}

block! {
    /// Limits of a joint.
    pub struct LimitBlock = LIMIT, "a joint limit" {
        /// The lowest position.
        lower: Option<Located<Unbound>> = elsewhere(ValueType::OfJoint { speed: false });
        /// The highest position.
        upper: Option<Located<Unbound>> = elsewhere(ValueType::OfJoint { speed: false });
        /// The highest speed, more than zero.
        velocity: Option<Located<Unbound>> = elsewhere(ValueType::OfJoint { speed: true });
    }
}
