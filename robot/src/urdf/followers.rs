//! Followers: their drives, and mistakes in them.

use std::collections::BTreeMap;

use super::cx::Cx;
use super::drive::Driven;
use super::read::RawRobot;
use super::{UrdfCode, UrdfMessage};
use crate::Drive;
use crate::followers::{Limits, ROUNDING};

/// A `<mimic>` whose leader is known.
#[derive(Clone, Copy)]
pub(super) struct Follows {
    /// Index of the leader in the order of the model.
    pub leader: usize,
    pub multiplier: f64,
    pub offset: f64,
}

/// Determines the drives of the followers, and reports those that cannot be followed.
pub(super) fn resolve(
    cx: &mut Cx,
    robot: &RawRobot,
    order: &[usize],
    follows: &[Option<Follows>],
    driven: &mut [Driven],
) {
    follow(cx, robot, order, follows, driven);
    held_outside(cx, robot, order, follows, driven);
    one_position(cx, robot, order, driven);
    apart(cx, robot, order, driven);
}

/// Resolves chains of mimics down to a degree of freedom or a fixed position. Each joint is visited once, however long
/// the chains.
fn follow(cx: &mut Cx, robot: &RawRobot, order: &[usize], follows: &[Option<Follows>], driven: &mut [Driven]) {
    let mut done: Vec<bool> = follows.iter().map(Option::is_none).collect();
    let mut on_path = vec![false; follows.len()];
    for start in 0..follows.len() {
        let mut path = Vec::new();
        let mut at = start;
        while !done[at] {
            if on_path[at] {
                let joint = &robot.joints[order[at]];
                let text = format!("joint `{}` mimics itself, in a circle", joint.name.value);
                let span = joint.mimic.as_ref().map_or(&joint.tag, |mimic| &mimic.joint.span).clone();
                cx.error(UrdfMessage::new(UrdfCode::MimicCycle, span, text));
                break;
            }
            on_path[at] = true;
            path.push(at);
            let Some(follows) = follows[at] else { break };
            at = follows.leader;
        }
        while let Some(k) = path.pop() {
            done[k] = true;
            let Some(Follows { leader, multiplier, offset }) = follows[k] else { continue };
            driven[k].drive = compose(driven[leader].drive, multiplier, offset);
            if !finite(driven[k].drive) {
                let joint = &robot.joints[order[k]];
                let text = format!("joint `{}` mimics with a factor beyond all numbers", joint.name.value);
                cx.error(UrdfMessage::new(UrdfCode::BadNumber, joint.tag.clone(), text));
            }
        }
    }
}

/// Warns of followers that are held still outside their own limits.
fn held_outside(cx: &mut Cx, robot: &RawRobot, order: &[usize], follows: &[Option<Follows>], driven: &[Driven]) {
    for (k, own) in driven.iter().enumerate() {
        let (Some(follows), Drive::Locked(x)) = (follows[k], own.drive) else { continue };
        if x >= own.lower - ROUNDING && x <= own.upper + ROUNDING {
            continue;
        }
        let joint = &robot.joints[order[k]];
        let leader = &robot.joints[order[follows.leader]].name.value;
        let span = joint.limit.as_ref().map_or(&joint.tag, |l| &l.span).clone();
        let text = format!("joint `{}` follows `{leader}` to {x}, outside its own limits", joint.name.value);
        let help = format!("hold `{leader}` where both are within their limits, or correct `<mimic>`");
        cx.warn(UrdfMessage::new(UrdfCode::Ignored, span, text).help(help));
    }
}

/// Leaves out the limits of followers that name a single position, with a warning: a joint that follows another one moves.
fn one_position(cx: &mut Cx, robot: &RawRobot, order: &[usize], driven: &mut [Driven]) {
    for (k, own) in driven.iter_mut().enumerate() {
        if matches!(own.drive, Drive::Mimic { .. }) && own.lower == own.upper {
            let joint = &robot.joints[order[k]];
            let span = joint.limit.as_ref().map_or(&joint.tag, |l| &l.span).clone();
            let name = &joint.name.value;
            let text = format!("joint `{name}` follows another one, but its limits leave it only {}", own.lower);
            let help = "write `lower` and `upper`; until then it has no limits of position";
            cx.warn(UrdfMessage::new(UrdfCode::Ignored, span, text).help(help));
            (own.lower, own.upper) = (f64::NEG_INFINITY, f64::INFINITY);
        }
    }
}

/// Reports followers that leave their leader no motion within the limits of both.
fn apart(cx: &mut Cx, robot: &RawRobot, order: &[usize], driven: &[Driven]) {
    let limits =
        |d: &Driven| Limits { lower: d.lower, upper: d.upper, velocity: d.velocity, acceleration: d.acceleration };
    let mut leaders: BTreeMap<usize, (usize, Limits)> = BTreeMap::new();
    for (k, d) in driven.iter().enumerate() {
        if let Drive::Dof(dof) = d.drive {
            leaders.insert(dof, (k, limits(d)));
        }
    }
    for (k, own) in driven.iter().enumerate() {
        let Drive::Mimic { dof, multiplier, offset } = own.drive else { continue };
        let Some((leader, kept)) = leaders.get_mut(&dof) else { continue };
        let both = kept.narrowed(limits(own).of_leader(multiplier, offset), multiplier);
        if both.leave_no_motion() {
            let joint = &robot.joints[order[k]];
            let leader = &robot.joints[order[*leader]].name.value;
            let span = joint.limit.as_ref().map_or(&joint.tag, |l| &l.span).clone();
            let name = &joint.name.value;
            let text = format!("joint `{name}` follows `{leader}`, which cannot move within the limits of both");
            let help = format!("correct the limits or `<mimic>`, or lock `{leader}`");
            cx.error(UrdfMessage::new(UrdfCode::CrossedLimits, span, text).help(help));
        } else {
            *kept = both;
        }
    }
}

/// Returns the drive of a follower at `multiplier * leader + offset`.
fn compose(leader: Drive, multiplier: f64, offset: f64) -> Drive {
    match leader {
        Drive::Fixed => Drive::Locked(offset),
        Drive::Locked(x) => Drive::Locked(multiplier * x + offset),
        Drive::Dof(_) | Drive::Mimic { .. } if multiplier == 0.0 => Drive::Locked(offset),
        Drive::Dof(dof) => Drive::Mimic { dof, multiplier, offset },
        Drive::Mimic { dof, multiplier: m, offset: o } => {
            Drive::Mimic { dof, multiplier: multiplier * m, offset: multiplier * o + offset }
        }
    }
}

fn finite(drive: Drive) -> bool {
    match drive {
        Drive::Fixed | Drive::Dof(_) => true,
        Drive::Locked(x) => x.is_finite(),
        Drive::Mimic { multiplier, offset, .. } => multiplier.is_finite() && offset.is_finite(),
    }
}
