//! How much a distance can bend between two ticks: the sampled-time margin of curved barrier functions.
//!
//! A row `h' >= -φ (h - δ)` held constant over a period T gives `h_next >= (1 - φT) h + φT δ - A T²/2`, where A bounds
//! how fast the distance can curve downwards. With `δ = A T / (2 φ)` the right side stays at or above zero
//! (mathematics, sampled time). For a point and a convex set carried by another link, A is at most the acceleration of
//! the point relative to that link at constant joint speeds: a distance to a convex set is a convex function of the point.
//!
//! ```text
//! |p''| <= sum_i w_i (w_i + 2 sum_{j<i} w_j) r_i + 2 sum_k u_k sum_{j<k} w_j
//! ```
//!
//! with `w_i` the largest speeds of revolute joints along the way from the set's link to the point, `u_k` those of prismatic
//! joints, and `r_i` the greatest distance that the point can have from joint i.

use robot::{Drive, JointKind, LinkId, Model};

/// A bound of the acceleration of a point of link `to`, at `offset` m from that link's origin, as seen from link `from`
/// (`None`: from the world), in m/s^2. Infinite where a joint on the way has no speed limit.
pub fn acceleration_bound(model: &Model, from: Option<LinkId>, to: LinkId, offset: f64, speed: &[f64]) -> f64 {
    let ancestors = |mut link: LinkId| {
        let mut joints = Vec::new();
        while let Some(j) = model.link_ref(link).parent_joint {
            joints.push(j);
            link = model.joint_ref(j).parent;
        }
        joints
    };
    let mut up = ancestors(to);
    let mut down = from.map(ancestors).unwrap_or_default();
    while let (Some(a), Some(b)) = (up.last(), down.last()) {
        if a != b {
            break;
        }
        up.pop();
        down.pop();
    }
    // Steps from the set to the point: joints, each with its speed and how far it is from the next one.
    let mut steps: Vec<(bool, f64, f64)> = Vec::new();
    if from.is_none() {
        for (dof, d) in model.dofs.iter().enumerate().take(model.base.nv()) {
            steps.push((d.unit == robot::DofUnit::Radian, speed[dof], 0.0));
        }
    }
    for j in down.into_iter().chain(up.into_iter().rev()) {
        let joint = model.joint_ref(j);
        let reach = joint.origin.translation.vector.norm();
        if let Some(last) = steps.last_mut() {
            last.2 += reach;
        }
        let (s, stroke) = match joint.drive {
            Drive::Dof(dof) => (speed[dof], joint.lower.abs().max(joint.upper.abs())),
            Drive::Mimic { dof, multiplier, .. } => (speed[dof] * multiplier.abs(), joint.lower.abs().max(joint.upper.abs())),
            Drive::Fixed | Drive::Locked(_) => (0.0, 0.0),
        };
        match joint.kind {
            JointKind::Prismatic => {
                let stroke = if stroke.is_finite() { stroke } else { 0.0 };
                if let Some(last) = steps.last_mut() {
                    last.2 += stroke;
                }
                steps.push((false, s, 0.0));
            }
            _ => steps.push((true, s, 0.0)),
        }
    }
    if let Some(last) = steps.last_mut() {
        last.2 += offset;
    }
    let (mut turning, mut bound) = (0.0, 0.0);
    for (i, &(revolute, s, _)) in steps.iter().enumerate() {
        if s == 0.0 {
            continue;
        }
        if revolute {
            let r: f64 = steps[i..].iter().map(|x| x.2).sum();
            bound += s * (s + 2.0 * turning) * r;
            turning += s;
        } else {
            bound += 2.0 * s * turning;
        }
    }
    bound
}

/// `A T / (2 φ)`: how far below zero a row may settle, in m. Zero for a zero gain.
pub fn loss(acceleration: f64, period: f64, gain: f64) -> f64 {
    if gain > 0.0 { acceleration * period / (2.0 * gain) } else { 0.0 }
}
