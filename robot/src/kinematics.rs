//! Forward kinematics: one pass over the tape, one sine and cosine per turning joint.
//!
//! X_WC = X_WP · origin · motion(q);  a turning joint with world axis a through p moves the world
//! origin with p × a per rad/s, a sliding one with a per m/s.
//! Source: Featherstone, Rigid Body Dynamics Algorithms (2008), ch. 2 and 4.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use crate::model::assemble::Motor;
use crate::{Base, Data, Model, Motion};

impl Model {
    /// Computes the poses of all links and all motion columns for `q` (length nq). Does not allocate. Normalises the
    /// quaternion of a floating base. If `q` is not finite, neither are the poses.
    pub fn forward(&self, q: &[f64], data: &mut Data) {
        data.poses[0] = place_base(self.tape.root, &Isometry3::identity(), q, &mut data.columns);
        data.rotations[0] = data.poses[0].rotation.to_rotation_matrix().into_inner();
        for (k, step) in self.tape.steps.iter().enumerate() {
            let parent = step.parent as usize;
            let R_WP = data.rotations[parent];
            let X_WP = &data.poses[parent];
            let q_WP = X_WP.rotation.quaternion();
            let mut p = X_WP.translation.vector + R_WP * step.shift;
            let rotation = match step.motor {
                Motor::Still => q_WP * step.turn,
                Motor::Turn => {
                    let angle = step.multiplier * q[step.q_index as usize] + step.offset;
                    let (sin, cos) = (0.5 * angle).sin_cos();
                    let a = R_WP * step.axis * step.multiplier;
                    data.columns[step.column as usize] = Motion { linear: p.cross(&a), angular: a };
                    q_WP * (step.turn * cos + step.turn_axis * sin)
                }
                Motor::Slide => {
                    let position = step.multiplier * q[step.q_index as usize] + step.offset;
                    let a = R_WP * step.axis;
                    p += a * position;
                    data.columns[step.column as usize] =
                        Motion { linear: a * step.multiplier, angular: Vector3::zeros() };
                    q_WP * step.turn
                }
                Motor::Base(base) => {
                    let rotation = UnitQuaternion::new_unchecked(q_WP * step.turn);
                    let stands = Isometry3::from_parts(Translation3::from(p), rotation);
                    let columns = &mut data.columns[step.column as usize..];
                    let X_WB = place_base(base, &stands, &q[step.q_index as usize..], columns);
                    p = X_WB.translation.vector;
                    *X_WB.rotation.quaternion()
                }
            };
            let rotation = UnitQuaternion::new_unchecked(rotation);
            data.poses[k + 1] = Isometry3::from_parts(Translation3::from(p), rotation);
            data.rotations[k + 1] = rotation.to_rotation_matrix().into_inner();
        }
    }
}

/// Returns the pose of the link of a base that stands at `X_WO` if its coordinates `q` are zero, and computes its columns.
fn place_base(base: Base, X_WO: &Isometry3<f64>, q: &[f64], columns: &mut [Motion]) -> Isometry3<f64> {
    if base == Base::Fixed {
        return *X_WO;
    }
    let X_WB = X_WO * base_pose(base, q);
    let R = X_WB.rotation.to_rotation_matrix().into_inner();
    let p = X_WB.translation.vector;
    let shift = |i: usize| Motion { linear: R.column(i).into(), angular: Vector3::zeros() };
    let turn = |i: usize| {
        let a: Vector3<f64> = R.column(i).into();
        Motion { linear: p.cross(&a), angular: a }
    };
    match base {
        Base::Fixed => {}
        Base::Planar => {
            columns[0] = shift(0);
            columns[1] = shift(1);
            columns[2] = turn(2);
        }
        Base::Unicycle => {
            columns[0] = shift(0);
            columns[1] = turn(2);
        }
        Base::Floating => {
            for i in 0..3 {
                columns[i] = shift(i);
                columns[i + 3] = turn(i);
            }
        }
    }
    X_WB
}

/// Returns the pose of the link of a base, relative to where it stands if its coordinates are zero.
pub(crate) fn base_pose(base: Base, q: &[f64]) -> Isometry3<f64> {
    match base {
        Base::Fixed => Isometry3::identity(),
        Base::Planar | Base::Unicycle => {
            let (sin, cos) = (0.5 * q[2]).sin_cos();
            Isometry3::from_parts(
                Translation3::new(q[0], q[1], 0.0),
                UnitQuaternion::new_unchecked(Quaternion::new(cos, 0.0, 0.0, sin)),
            )
        }
        Base::Floating => Isometry3::from_parts(
            Translation3::new(q[0], q[1], q[2]),
            UnitQuaternion::new_normalize(Quaternion::new(q[3], q[4], q[5], q[6])),
        ),
    }
}
