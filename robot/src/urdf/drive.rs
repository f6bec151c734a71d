//! Drives of the joints: limits, locks, mimics.

use std::collections::BTreeMap;

use super::cx::{Cx, Spanned, list};
use super::followers::{self, Follows};
use super::read::{RawJoint, RawRobot};
use super::units;
use super::{Options, UrdfCode, UrdfMessage};
use crate::model::assemble::MAX_MOVING;
use crate::sample::nearest;
use crate::{Drive, JointKind};

/// Maximum plausible speed limit \[rad/s or m/s\].
const FASTEST: f64 = 1e3;

/// Drive and limits of one joint.
#[derive(Clone, Copy)]
pub(super) struct Driven {
    pub drive: Drive,
    pub lower: f64,
    pub upper: f64,
    pub velocity: f64,
    pub effort: f64,
    pub acceleration: f64,
}

/// Position limits of a joint.
enum Range {
    /// The type of the joint has no limits.
    Free,
    /// The type of the joint needs limits, but none are written.
    Unsaid,
    Between(f64, f64),
    Crossed,
}

fn range(joint: &RawJoint) -> Range {
    match (joint.kind, &joint.limit) {
        (JointKind::Fixed | JointKind::Continuous, _) => Range::Free,
        (_, None) => Range::Unsaid,
        (_, Some(limit)) => match (limit.lower, limit.upper) {
            (None, None) => Range::Unsaid,
            (lower, upper) => {
                // A missing attribute is 0: urdf.org, joint/limit.
                let (lower, upper) = (lower.unwrap_or(0.0), upper.unwrap_or(0.0));
                if lower > upper { Range::Crossed } else { Range::Between(lower, upper) }
            }
        },
    }
}

/// Determines the drive of every joint in `order`, in that order. The first `base_dofs` degrees of freedom are those of
/// the base.
pub(super) fn resolve(
    cx: &mut Cx,
    robot: &RawRobot,
    order: &[usize],
    base_dofs: usize,
    options: &Options,
) -> Vec<Driven> {
    known_names(cx, robot, options);
    let mut by_name = BTreeMap::new();
    for (k, &j) in order.iter().enumerate() {
        by_name.entry(robot.joints[j].name.value.as_str()).or_insert(k);
    }
    let mut driven = Vec::with_capacity(order.len());
    let mut follows: Vec<Option<Follows>> = vec![None; order.len()];
    let mut dofs = base_dofs;
    for (k, &j) in order.iter().enumerate() {
        let joint = &robot.joints[j];
        let mut result = limits(cx, joint);
        let lock = options.lock.get(&joint.name.value).copied();
        let movable = joint.kind != JointKind::Fixed;
        let mimic = joint.mimic.as_ref().filter(|_| movable && lock.is_none());
        if let Some(mimic) = mimic {
            match by_name.get(mimic.joint.value.as_str()) {
                Some(&leader) => {
                    follows[k] = Some(Follows { leader, multiplier: mimic.multiplier, offset: mimic.offset });
                }
                None => cx.error(no_leader(robot, &mimic.joint)),
            }
        } else if movable {
            let dropped = options.keep.as_ref().is_some_and(|k| !k.contains(&joint.name.value));
            if let Some(position) = lock {
                check_lock(cx, robot, joint, position, &result);
                result.drive = Drive::Locked(position);
            } else if dropped {
                result.drive = Drive::Locked(nearest(0.0, result.lower, result.upper));
            } else if result.lower == result.upper {
                immovable(cx, joint, result.lower);
                result.drive = Drive::Locked(result.lower);
            } else {
                remark_limits(cx, joint);
                result.drive = Drive::Dof(dofs);
                dofs += 1;
            }
        }
        driven.push(result);
    }
    followers::resolve(cx, robot, order, &follows, &mut driven);
    let moving = driven.iter().filter(|d| matches!(d.drive, Drive::Dof(_) | Drive::Mimic { .. })).count();
    if moving > MAX_MOVING {
        let text = format!("{moving} joints move, at most {MAX_MOVING} may");
        cx.error(
            UrdfMessage::new(UrdfCode::TooManyJoints, robot.tag.clone(), text)
                .help("name the ones that matter in `keep`"),
        );
    }
    driven
}

/// Returns the error for a mimic of an unknown joint. A copied hand often keeps the joint names without their prefix,
/// so the help lists names with a common suffix.
fn no_leader(robot: &RawRobot, wanted: &Spanned<String>) -> UrdfMessage {
    let leaders = robot.joints.iter().filter(|j| j.kind != JointKind::Fixed && j.mimic.is_none());
    let names = leaders.map(|j| j.name.value.as_str());
    let near: Vec<&str> = names.filter(|n| n.ends_with(&wanted.value) || wanted.value.ends_with(n)).collect();
    let help = if near.is_empty() {
        "name a joint of this file, or delete the `<mimic>` and let the joint move by itself".to_owned()
    } else {
        format!("joints of such a name are {}", list(near))
    };
    let text = format!("there is no joint `{}` to mimic", wanted.value);
    UrdfMessage::new(UrdfCode::UnknownJoint, wanted.span.clone(), text).help(help)
}

/// Reports names in `lock` and `keep` that no joint has, or that belong to a fixed joint.
fn known_names(cx: &mut Cx, robot: &RawRobot, options: &Options) {
    let kinds: BTreeMap<&str, JointKind> = robot.joints.iter().map(|j| (j.name.value.as_str(), j.kind)).collect();
    let locked = options.lock.keys().map(|name| ("locked", name));
    let kept = options.keep.iter().flatten().map(|name| ("kept", name));
    for (what, name) in locked.chain(kept) {
        match kinds.get(name.as_str()) {
            None => {
                let text = format!("joint `{name}` is to be {what}, but there is no such joint");
                let span = robot.tag.clone();
                cx.error(UrdfMessage::new(UrdfCode::UnknownJoint, span, text));
            }
            Some(JointKind::Fixed) => {
                let text = format!("joint `{name}` is to be {what}, but it is fixed anyway");
                cx.warn(UrdfMessage::new(UrdfCode::Ignored, robot.tag.clone(), text));
            }
            Some(_) => {}
        }
    }
}

fn limits(cx: &mut Cx, joint: &RawJoint) -> Driven {
    let (lower, upper) = match range(joint) {
        Range::Free | Range::Unsaid => (f64::NEG_INFINITY, f64::INFINITY),
        Range::Between(lower, upper) => (lower, upper),
        Range::Crossed => {
            if let Some(limit) = &joint.limit {
                let text = format!("joint `{}`: the lower limit is above the upper one", joint.name.value);
                let mut message = UrdfMessage::new(UrdfCode::CrossedLimits, limit.span.clone(), text);
                if limit.lower.is_none() || limit.upper.is_none() {
                    message = message.help("a limit that is not written is 0");
                }
                cx.error(message);
            }
            (f64::NEG_INFINITY, f64::INFINITY)
        }
    };
    let fixed = joint.kind == JointKind::Fixed;
    let limit = joint.limit.as_ref().filter(|_| !fixed);
    let believed = |v: &f64| *v > 0.0 && *v <= FASTEST;
    let velocity = limit.and_then(|l| l.velocity).filter(believed).unwrap_or(f64::INFINITY);
    let effort = limit.map_or(f64::INFINITY, |l| l.effort);
    let acceleration = limit.map_or(f64::INFINITY, |l| l.acceleration);
    Driven { drive: Drive::Fixed, lower, upper, velocity, effort, acceleration }
}

/// Warns about missing limits of a degree of freedom.
fn remark_limits(cx: &mut Cx, joint: &RawJoint) {
    let name = &joint.name.value;
    let span = joint.limit.as_ref().map_or(&joint.tag, |l| &l.span).clone();
    if matches!(range(joint), Range::Unsaid) {
        let text = format!("joint `{name}` has no limits of position; it is taken to be unlimited");
        let help = "write `<limit lower=\"..\" upper=\"..\" velocity=\"..\" effort=\"..\"/>`";
        cx.warn(UrdfMessage::new(UrdfCode::NoLimits, span.clone(), text).help(help).joint(name));
    }
    units::degrees(cx, joint);
    let velocity = joint.limit.as_ref().and_then(|l| l.velocity);
    let text = match velocity {
        None => format!("joint `{name}` has no limit of speed"),
        Some(v) if v > 0.0 && v <= FASTEST => return,
        Some(v) => format!("joint `{name}` has the limit of speed {v}, which is taken as none"),
    };
    cx.warn(UrdfMessage::new(UrdfCode::NoVelocityLimit, span, text).joint(name));
}

fn immovable(cx: &mut Cx, joint: &RawJoint, position: f64) {
    let span = joint.limit.as_ref().map_or(&joint.tag, |l| &l.span).clone();
    let text = format!("joint `{}` cannot leave {position}; it is locked there", joint.name.value);
    let help = match joint.kind {
        JointKind::Revolute => "if it turns without end, its type is `continuous`",
        _ => "write `lower` and `upper`, or make the joint `fixed`",
    };
    cx.warn(UrdfMessage::new(UrdfCode::Immovable, span, text).help(help));
}

fn check_lock(cx: &mut Cx, robot: &RawRobot, joint: &RawJoint, position: f64, limits: &Driven) {
    let name = &joint.name.value;
    if !position.is_finite() {
        let text = format!("joint `{name}` is to be locked at {position}, which is no position");
        cx.error(UrdfMessage::new(UrdfCode::BadLock, robot.tag.clone(), text));
    } else if position < limits.lower || position > limits.upper {
        let span = joint.limit.as_ref().map_or(&joint.tag, |l| &l.span).clone();
        let text = format!("joint `{name}` is locked at {position}, outside its limits");
        cx.warn(UrdfMessage::new(UrdfCode::BadLock, span, text));
    }
}
