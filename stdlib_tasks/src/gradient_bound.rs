//! Bounds on the slope of a distance: its derivative by each degree of freedom, for all joint positions.
//!
//! A turning joint moves a point at most as fast as the point is far from its axis; a sliding joint moves it at its own
//! speed. The possible positions of the point, as seen from a joint, are enclosed in a ball: from a part outwards to
//! the root, a joint that turns by any angle widens the ball about its axis, and a sliding joint widens it by its
//! largest distance from its origin. A distance between two bodies changes as fast as their closest points move along
//! the line between them; what carries both bodies does not change it. A base moves to any place and turns there. The same
//! balls bound the position of a point: [`reach`].

use nalgebra::{Point3, Vector3};
use robot::{Drive, Joint, JointKind, LinkId, MobileBase, Model};

use crate::bound::Geometry;
use crate::clearance::{Mover, Movers, stroke};
use crate::sampled_margin::is_ball;

/// Bounds of `|dh/dq|` for the distance between parts of two links: one number for each degree of freedom, in m/rad or
/// m/m.
pub fn between(model: &Model, a: &Geometry, b: &Geometry) -> Vec<f64> {
    let mut slopes = vec![0.0; model.nv()];
    let Movers { up, down } = Movers::between(model, Some(b.link), a.link);
    towards_root(model, &up, Ball::around(a), &mut slopes);
    towards_root(model, &down, Ball::around(b), &mut slopes);
    slopes
}

/// Bounds of `|dh/dq|` for the height of a part over a plane, which is carried by link `on`, or fixed in the world with
/// the normal `n`.
pub fn over_plane(model: &Model, on: Option<LinkId>, n: &Vector3<f64>, part: &Geometry) -> Vec<f64> {
    let mut slopes = vec![0.0; model.nv()];
    let Movers { up, down } = Movers::between(model, on, part.link);
    let ball = towards_root(model, &up, Ball::around(part), &mut slopes);
    outwards(model, &down, ball, &mut slopes);
    let drives = |base: &&MobileBase| on.is_none() && base.kind.drives();
    if let Some(base) = model.base_of(part.link).filter(drives) {
        // A base on wheels moves along its floor, and turns about the normal of that.
        let n = model.place(base).inverse_transform_vector(n);
        let level = n.x.hypot(n.y);
        for slope in &mut slopes[base.dofs()] {
            *slope = if level == 0.0 { 0.0 } else { level * *slope };
        }
    }
    slopes
}

/// Bounds of `|dh/dq|` for the distance of a part from a body that is fixed in the world.
pub fn over_world(model: &Model, part: &Geometry) -> Vec<f64> {
    let mut slopes = vec![0.0; model.nv()];
    let Movers { up, .. } = Movers::between(model, None, part.link);
    towards_root(model, &up, Ball::around(part), &mut slopes);
    slopes
}

/// Ball that contains a point of link `to` as seen from link `from`, or from the world, for any angles of the joints:
/// its centre, and its radius in m. The radius is infinite if a base moves one of both, or a joint slides without a limit.
pub fn reach(model: &Model, from: Option<LinkId>, to: LinkId, point: &Vector3<f64>) -> (Vector3<f64>, f64) {
    let Movers { up, down } = Movers::between(model, from, to);
    let ball = towards_root(model, &up, Ball { centre: Point3::from(*point), radius: 0.0 }, &mut []);
    let ball = outwards(model, &down, ball, &mut []);
    (ball.centre.coords, ball.radius)
}

/// Ball that contains the possible positions of a point.
struct Ball {
    centre: Point3<f64>,
    radius: f64,
}

impl Ball {
    /// Encloses the points of a part that can be nearest to something, in its link's frame. The distance of a ball is
    /// that of its centre minus a constant.
    fn around(g: &Geometry) -> Ball {
        let radius = if is_ball(&g.shape) { 0.0 } else { g.shape.bounding_radius() };
        Ball { centre: g.center(), radius }
    }

    /// Largest distance from an axis through the origin.
    fn distance_from_axis(&self, axis: &Vector3<f64>) -> f64 {
        axis.cross(&self.centre.coords).norm() + self.radius
    }
}

/// Adds the slopes of movers from a link towards the root; returns the ball as seen from the last one.
fn towards_root(model: &Model, movers: &[Mover], mut ball: Ball, slopes: &mut [f64]) -> Ball {
    for mover in movers {
        match mover {
            Mover::Base(base) => {
                move_with(model, base, &ball, slopes);
                ball.radius = f64::INFINITY;
            }
            Mover::Joint(j) => {
                let joint = model.joint_ref(*j);
                cross_joint(model, joint, &mut ball, slopes);
                ball.centre = joint.origin * ball.centre;
            }
        }
    }
    ball
}

/// Adds the slopes of movers from the root towards the link that they are given for; returns the ball as seen from it. A motion
/// of that link is equivalent to the opposite motion of everything else.
fn outwards(model: &Model, movers: &[Mover], mut ball: Ball, slopes: &mut [f64]) -> Ball {
    for mover in movers.iter().rev() {
        match mover {
            Mover::Base(base) => {
                ball.radius = f64::INFINITY;
                move_with(model, base, &ball, slopes);
            }
            Mover::Joint(j) => {
                let joint = model.joint_ref(*j);
                ball.centre = joint.origin.inverse_transform_point(&ball.centre);
                cross_joint(model, joint, &mut ball, slopes);
            }
        }
    }
    ball
}

/// Adds the slopes of a base, in whose frame the ball is expressed.
fn move_with(model: &Model, base: &MobileBase, ball: &Ball, slopes: &mut [f64]) {
    let far = match base.kind.drives() {
        true => ball.distance_from_axis(&Vector3::z()),
        false => ball.centre.coords.norm() + ball.radius,
    };
    for dof in base.dofs() {
        if let Some(sum) = slopes.get_mut(dof) {
            *sum += model.dofs[dof].unit.select(1.0, far);
        }
    }
}

/// Adds the slope of a joint, in whose frame the ball is expressed, and widens the ball by the joint's motion.
fn cross_joint(model: &Model, joint: &Joint, ball: &mut Ball, slopes: &mut [f64]) {
    let slides = joint.kind == JointKind::Prismatic;
    let slope = if slides { 1.0 } else { ball.distance_from_axis(&joint.axis) };
    let driven = match joint.drive {
        Drive::Dof(dof) => Some((dof, 1.0)),
        Drive::Mimic { dof, multiplier, .. } => Some((dof, multiplier.abs())),
        Drive::Fixed | Drive::Locked(_) => None,
    };
    if let Some((dof, factor)) = driven
        && let Some(sum) = slopes.get_mut(dof)
        && slope * factor > 0.0
    {
        *sum += slope * factor;
    }
    if slides {
        ball.radius += stroke(model, joint);
    } else if joint.kind != JointKind::Fixed {
        let along = joint.axis * joint.axis.dot(&ball.centre.coords);
        ball.radius += (ball.centre.coords - along).norm();
        ball.centre = Point3::from(along);
    }
}
