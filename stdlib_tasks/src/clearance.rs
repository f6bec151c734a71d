//! Bound on the curvature of a distance between two ticks: the sampled-time margin of curved barrier functions.
//!
//! A row `h' >= -φ (h - δ)` held constant over a period T yields `h_next >= (1 - φT) h + φT δ - A T²/2`, where A bounds
//! the downward acceleration of the distance. With `δ = A T / (2 φ)` the right side remains at or above zero if
//! `φ T <= 1` (mathematics, sampled time). For a point and a convex set on another link, A is at most the acceleration
//! of the point relative to that link at constant joint speeds: a distance to a convex set is a convex function of the
//! point.
//!
//! ```text
//! |p''| <= W² r_0 + U W + sum_i w_i (w_i + 2 W + 2 sum_{j<i} w_j) r_i + 2 sum_k u_k (W + sum_{j<k} w_j)
//! ```
//!
//! with `w_i` the largest speeds of revolute joints on the chain from the set's link to the point, `u_k` those of
//! prismatic joints, and `r_i` the largest distance that the point can have from joint i. The base contributes if the
//! set is fixed to the world: its velocity is constant in its own axes, `U` bounds the linear and `W` the angular part,
//! and `r_0` is the largest distance of the point from the root.

use robot::{DofUnit, Drive, Joint, JointId, JointKind, LinkId, Model};

/// Joint of the chain: its motion, and the distance from it to the next one (to the point, for the last).
struct Step {
    turns: bool,
    speed: f64,
    reach: f64,
}

/// Bound on the acceleration of a point of link `to`, at `offset` m from that link's origin, relative to link `from`
/// (`None`: the world), in m/s². `speed` bounds the velocity of each degree of freedom in rad/s or m/s, and joints are
/// inside their position limits. Infinite if a relevant joint of the chain has no speed limit, or slides without a
/// limit.
pub fn acceleration_bound(model: &Model, from: Option<LinkId>, to: LinkId, offset: f64, speed: &[f64]) -> f64 {
    let mut up = ancestors(model, to);
    let mut down = from.map(|link| ancestors(model, link)).unwrap_or_default();
    while up.last().is_some() && up.last() == down.last() {
        up.pop();
        down.pop();
    }
    let (mut linear, mut angular) = (0.0, 0.0);
    if from.is_none() {
        for (dof, s) in model.dofs.iter().zip(speed).take(model.base.nv()) {
            let sum = if dof.unit == DofUnit::Radian { &mut angular } else { &mut linear };
            *sum = f64::hypot(*sum, *s);
        }
    }
    // From the set to the common ancestor, and on to the point. A joint's `origin` lies between it and the joint
    // nearer to the root, its stroke between it and the one farther out.
    let mut root = 0.0;
    let mut steps: Vec<Step> = Vec::new();
    let add = |steps: &mut Vec<Step>, root: &mut f64, length: f64| match steps.last_mut() {
        Some(last) => last.reach += length,
        None => *root += length,
    };
    for joint in down.iter().map(|&j| model.joint_ref(j)) {
        add(&mut steps, &mut root, stroke(model, joint));
        steps.push(step(joint, speed));
        add(&mut steps, &mut root, joint.origin.translation.vector.norm());
    }
    for joint in up.iter().rev().map(|&j| model.joint_ref(j)) {
        add(&mut steps, &mut root, joint.origin.translation.vector.norm() + stroke(model, joint));
        steps.push(step(joint, speed));
    }
    add(&mut steps, &mut root, offset);

    // Zero times infinity is zero here: a point that stands still or turns on the spot does not accelerate.
    let times = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
    let reach = root + steps.iter().map(|s| s.reach).sum::<f64>();
    let mut bound = times(times(angular, angular), reach) + times(linear, angular);
    let mut turning = angular;
    for (i, s) in steps.iter().enumerate() {
        if s.turns {
            let reach: f64 = steps[i..].iter().map(|x| x.reach).sum();
            bound += times(times(s.speed, s.speed + 2.0 * turning), reach);
            turning += s.speed;
        } else {
            bound += 2.0 * times(s.speed, turning);
        }
    }
    bound
}

/// Joints from a link to the root.
pub(crate) fn ancestors(model: &Model, mut link: LinkId) -> Vec<JointId> {
    let mut joints = Vec::new();
    while let Some(j) = model.link_ref(link).parent_joint {
        joints.push(j);
        link = model.joint_ref(j).parent;
    }
    joints
}

fn step(joint: &Joint, speed: &[f64]) -> Step {
    let at = |dof: usize| speed.get(dof).copied().unwrap_or(f64::INFINITY);
    let speed = match joint.drive {
        Drive::Dof(dof) => at(dof),
        Drive::Mimic { dof, multiplier, .. } => at(dof) * multiplier.abs(),
        Drive::Fixed | Drive::Locked(_) => 0.0,
    };
    Step { turns: joint.kind != JointKind::Prismatic, speed, reach: 0.0 }
}

/// Largest distance of a sliding joint from its origin, in m.
pub fn stroke(model: &Model, joint: &Joint) -> f64 {
    if joint.kind != JointKind::Prismatic {
        return 0.0;
    }
    let range = |dof: usize| model.dofs.get(dof).map_or((f64::NEG_INFINITY, f64::INFINITY), |d| (d.lower, d.upper));
    let (low, high) = match joint.drive {
        Drive::Dof(dof) => range(dof),
        Drive::Mimic { dof, multiplier, offset } => {
            let (low, high) = range(dof);
            (multiplier * low + offset, multiplier * high + offset)
        }
        Drive::Locked(position) => (position, position),
        Drive::Fixed => (0.0, 0.0),
    };
    low.abs().max(high.abs())
}

/// `A T / (2 φ)`: depth below zero at which a row may settle, in m. Without a gain nothing brings the row back:
/// infinite, unless the distance has no curvature at all.
pub fn loss(acceleration: f64, period: f64, gain: f64) -> f64 {
    if acceleration == 0.0 {
        0.0
    } else if gain > 0.0 {
        acceleration * period / (2.0 * gain)
    } else {
        f64::INFINITY
    }
}
