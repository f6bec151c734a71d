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
//! prismatic joints, and `r_i` the largest distance that the point can have from joint i. A base on the way from the set to the
//! point contributes, its velocity constant in its own axes: `U` bounds the linear and `W` the angular part. Above, it is the
//! first on the way, and `r_0` is the largest distance of the point from it. Since a base may be anywhere, a point beyond it is
//! arbitrarily far from what comes before it.

use robot::{Drive, Joint, JointId, JointKind, LinkId, MobileBase, Model};

/// Something that moves a link relative to the one that carries it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Mover {
    /// A base, relative to where it stands.
    Base(MobileBase),
    /// A joint.
    Joint(JointId),
}

/// Largest speeds of a mover: along its axes in m/s, and about them in rad/s.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MoverSpeed {
    pub linear: f64,
    pub angular: f64,
}

/// The movers of one link relative to another.
pub(crate) struct Movers {
    /// Movers of the link `to` and not of `from`, from the link towards the root.
    pub up: Vec<Mover>,
    /// Movers of the link `from` and not of `to`, from the link towards the root.
    pub down: Vec<Mover>,
}

impl Movers {
    /// Movers of `to` relative to `from`; `None` is the world.
    pub fn between(model: &Model, from: Option<LinkId>, to: LinkId) -> Movers {
        let mut up = movers(model, to);
        let mut down = from.map(|link| movers(model, link)).unwrap_or_default();
        while up.last().is_some() && up.last() == down.last() {
            up.pop();
            down.pop();
        }
        Movers { up, down }
    }
}

/// Mover of the chain: its speeds, and the distance from it to the next one (to the point, for the last).
struct Step {
    speed: MoverSpeed,
    reach: f64,
}

/// Bound on the acceleration of a point of link `to`, at `offset` m from that link's origin, relative to link `from`
/// (`None`: the world), in m/s². `speed` bounds the velocity of each degree of freedom in rad/s or m/s, and joints are
/// inside their position limits. Infinite if a relevant joint of the chain has no speed limit, or slides without a
/// limit.
pub fn acceleration_bound(model: &Model, from: Option<LinkId>, to: LinkId, offset: f64, speed: &[f64]) -> f64 {
    let Movers { up, down } = Movers::between(model, from, to);
    // From the set to the common ancestor, and on to the point. A joint's `origin` lies between it and the joint
    // nearer to the root, its stroke between it and the one farther out. A base turns about its own link.
    let mut steps: Vec<Step> = Vec::new();
    let add = |steps: &mut Vec<Step>, length: f64| {
        if let Some(last) = steps.last_mut() {
            last.reach += length;
        }
    };
    for mover in &down {
        match mover {
            Mover::Base(base) => {
                steps.push(Step { speed: base_speed(model, base, speed), reach: f64::INFINITY });
            }
            Mover::Joint(j) => {
                let joint = model.joint_ref(*j);
                add(&mut steps, stroke(model, joint));
                steps.push(step(joint, speed));
                add(&mut steps, joint.origin.translation.vector.norm());
            }
        }
    }
    for mover in up.iter().rev() {
        match mover {
            Mover::Base(base) => {
                add(&mut steps, f64::INFINITY);
                steps.push(Step { speed: base_speed(model, base, speed), reach: 0.0 });
            }
            Mover::Joint(j) => {
                let joint = model.joint_ref(*j);
                add(&mut steps, joint.origin.translation.vector.norm() + stroke(model, joint));
                steps.push(step(joint, speed));
            }
        }
    }
    add(&mut steps, offset);

    // Zero times infinity is zero here: a point that stands still or turns on the spot does not accelerate.
    let times = |a: f64, b: f64| if a == 0.0 || b == 0.0 { 0.0 } else { a * b };
    let (mut bound, mut turning) = (0.0, 0.0);
    for (i, Step { speed: MoverSpeed { linear, angular }, .. }) in steps.iter().enumerate() {
        let reach: f64 = steps[i..].iter().map(|x| x.reach).sum();
        bound += times(times(*angular, angular + 2.0 * turning), reach) + times(*linear, angular + 2.0 * turning);
        turning += angular;
    }
    bound
}

/// Movers from a link to the world.
pub(crate) fn movers(model: &Model, mut link: LinkId) -> Vec<Mover> {
    let mut movers = Vec::new();
    loop {
        movers.extend(model.base_at(link).map(|base| Mover::Base(*base)));
        let Some(j) = model.link_ref(link).parent_joint else { return movers };
        movers.push(Mover::Joint(j));
        link = model.joint_ref(j).parent;
    }
}

/// Largest speeds of a base whose degrees of freedom are as fast as `speed`.
pub(crate) fn base_speed(model: &Model, base: &MobileBase, speed: &[f64]) -> MoverSpeed {
    let mut fastest = MoverSpeed::default();
    for dof in base.dofs() {
        let sum = model.dofs[dof].unit.select(&mut fastest.linear, &mut fastest.angular);
        *sum = f64::hypot(*sum, speed.get(dof).copied().unwrap_or(f64::INFINITY));
    }
    fastest
}

fn step(joint: &Joint, speed: &[f64]) -> Step {
    let at = |dof: usize| speed.get(dof).copied().unwrap_or(f64::INFINITY);
    let speed = match joint.drive {
        Drive::Dof(dof) => at(dof),
        Drive::Mimic { dof, multiplier, .. } => at(dof) * multiplier.abs(),
        Drive::Fixed | Drive::Locked(_) => 0.0,
    };
    let speed = match joint.kind {
        JointKind::Prismatic => MoverSpeed { linear: speed, angular: 0.0 },
        _ => MoverSpeed { linear: 0.0, angular: speed },
    };
    Step { speed, reach: 0.0 }
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
