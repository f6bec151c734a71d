//! Integration of a configuration along a velocity, and the velocity between two configurations.
//!
//! A base moves by the exponential of its body velocity, so that a step at constant velocity is exact:
//! SE(2): Δp = sinc(θ/2) R(θ/2) u,  θ = ω dt, u = v dt
//! SE(3): Δp = (I + b [θ]× + c [θ]×²) u,  b = (1 - cos θ)/θ²,  c = (θ - sin θ)/θ³
//! Joints step linearly, continuous ones too: their angle counts turns. The difference of joints on the circle is that to the
//! nearest turn.
//! Source: Solà, Deray, Atchuthan, A micro Lie theory (2018), eqs. (132), (145)-(146), (174).

use nalgebra::{Quaternion, UnitQuaternion, Vector2, Vector3};

use crate::kinematics::base_pose;
use crate::model::nearest_turn;
use crate::{Base, Model};

impl Model {
    /// Moves `q` (length nq) along `v` (length nv) for `dt` seconds; exact for constant `v`. Keeps the quaternion of a
    /// floating base at unit length. Limits are not applied.
    pub fn integrate(&self, q: &mut [f64], v: &[f64], dt: f64) {
        for base in &self.bases {
            let (q, v) = (&mut q[base.coordinates()], &v[base.dofs()]);
            match base.kind {
                Base::Fixed => {}
                Base::Planar => step_plane(q, v[0] * dt, v[1] * dt, v[2] * dt),
                Base::Unicycle => step_plane(q, v[0] * dt, 0.0, v[1] * dt),
                Base::Floating => step_space(q, v, dt),
            }
        }
        for (dof, v) in self.dofs.iter().zip(v) {
            if let Some(i) = dof.q_index {
                q[i] += v * dt;
            }
        }
    }

    /// Moves the bases of `reference` that cannot move sideways to beside where they are in `q`, if they are further than `least` (m) to the side of
    /// it: no velocity leads back there.
    pub fn slip(&self, q: &[f64], reference: &mut [f64], least: f64) {
        for base in self.bases.iter().filter(|base| base.kind == Base::Unicycle) {
            let (q, to) = (&q[base.coordinates()], &mut reference[base.coordinates()]);
            let (u, _) = between_plane(to, q);
            if u.y.abs() > least {
                step_plane(to, 0.0, u.y, 0.0);
            }
        }
    }

    /// Computes the velocity that leads from `q0` to `q1` in one second: `integrate(q0, v, 1)` returns the pose `q1`,
    /// with the base turning by at most half a turn. A unicycle cannot slip sideways: its velocity is the planar one
    /// without the lateral component, which is the nearest feasible one. A joint on the circle, see
    /// [`Model::is_on_circle`], turns by at most half a turn too.
    pub fn difference(&self, q0: &[f64], q1: &[f64], v: &mut [f64]) {
        for base in &self.bases {
            let (q0, q1) = (&q0[base.coordinates()], &q1[base.coordinates()]);
            let v = &mut v[base.dofs()];
            match base.kind {
                Base::Fixed => {}
                Base::Planar => {
                    let (u, turn) = between_plane(q0, q1);
                    v.copy_from_slice(&[u.x, u.y, turn]);
                }
                Base::Unicycle => {
                    let (u, turn) = between_plane(q0, q1);
                    v.copy_from_slice(&[u.x, turn]);
                }
                Base::Floating => between_space(q0, q1, v),
            }
        }
        for ((k, dof), v) in self.dofs.iter().enumerate().zip(v) {
            if let Some(i) = dof.q_index {
                let way = q1[i] - q0[i];
                *v = if self.is_on_circle(k) { nearest_turn(way) } else { way };
            }
        }
    }
}

/// sin(x)/x.
fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

fn step_plane(q: &mut [f64], ux: f64, uy: f64, turn: f64) {
    let (sin, cos) = (q[2] + 0.5 * turn).sin_cos();
    let chord = sinc(0.5 * turn);
    q[0] += chord * (cos * ux - sin * uy);
    q[1] += chord * (sin * ux + cos * uy);
    q[2] += turn;
}

fn between_plane(q0: &[f64], q1: &[f64]) -> (Vector2<f64>, f64) {
    let (sin, cos) = (q1[2] - q0[2]).sin_cos();
    let turn = sin.atan2(cos);
    let (sin, cos) = (q0[2] + 0.5 * turn).sin_cos();
    let chord = sinc(0.5 * turn);
    let (dx, dy) = (q1[0] - q0[0], q1[1] - q0[1]);
    (Vector2::new(cos * dx + sin * dy, -sin * dx + cos * dy) / chord, turn)
}

fn step_space(q: &mut [f64], v: &[f64], dt: f64) {
    let X = base_pose(Base::Floating, q);
    let u = Vector3::new(v[0], v[1], v[2]) * dt;
    let theta = Vector3::new(v[3], v[4], v[5]) * dt;
    let angle = theta.norm();
    let half = sinc(0.5 * angle);
    let b = 0.5 * half * half;
    let c = if angle < 1e-2 {
        let x = angle * angle;
        1.0 / 6.0 - x / 120.0 + x * x / 5040.0
    } else {
        (angle - angle.sin()) / (angle * angle * angle)
    };
    let swing = theta.cross(&u);
    let p = X.translation.vector + X.rotation * (u + swing * b + theta.cross(&swing) * c);
    let turn = Quaternion::from_parts((0.5 * angle).cos(), theta * (0.5 * half));
    let r = UnitQuaternion::new_normalize(X.rotation.quaternion() * turn);
    q[..7].copy_from_slice(&[p.x, p.y, p.z, r.w, r.i, r.j, r.k]);
}

fn between_space(q0: &[f64], q1: &[f64], v: &mut [f64]) {
    let X_01 = base_pose(Base::Floating, q0).inv_mul(&base_pose(Base::Floating, q1));
    let r = X_01.rotation.quaternion();
    let (w, im) = if r.w < 0.0 { (-r.w, -r.imag()) } else { (r.w, r.imag()) };
    let sin = im.norm();
    let angle = 2.0 * sin.atan2(w);
    let theta = im * if sin < 1e-8 { 2.0 } else { angle / sin };
    let x = angle * angle;
    let d = if angle < 1e-2 {
        1.0 / 12.0 + x / 720.0 + x * x / 30240.0
    } else {
        (1.0 - 0.5 * angle * (0.5 * angle).cos() / (0.5 * angle).sin()) / x
    };
    let p = X_01.translation.vector;
    let swing = theta.cross(&p);
    let u = p - swing * 0.5 + theta.cross(&swing) * d;
    v[..6].copy_from_slice(&[u.x, u.y, u.z, theta.x, theta.y, theta.z]);
}
