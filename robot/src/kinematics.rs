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
        self.place_root(q, data);
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
            };
            let rotation = UnitQuaternion::new_unchecked(rotation);
            data.poses[k + 1] = Isometry3::from_parts(Translation3::from(p), rotation);
            data.rotations[k + 1] = rotation.to_rotation_matrix().into_inner();
        }
    }

    /// Computes the pose of the root and the columns of the base.
    fn place_root(&self, q: &[f64], data: &mut Data) {
        let X_WB = base_pose(self.base, q);
        data.poses[0] = X_WB;
        let R = X_WB.rotation.to_rotation_matrix().into_inner();
        data.rotations[0] = R;
        let p = X_WB.translation.vector;
        let shift = |i: usize| Motion { linear: R.column(i).into(), angular: Vector3::zeros() };
        let turn = |i: usize| {
            let a: Vector3<f64> = R.column(i).into();
            Motion { linear: p.cross(&a), angular: a }
        };
        match self.base {
            Base::Fixed => {}
            Base::Planar => {
                data.columns[0] = shift(0);
                data.columns[1] = shift(1);
                data.columns[2] = turn(2);
            }
            Base::Unicycle => {
                data.columns[0] = shift(0);
                data.columns[1] = turn(2);
            }
            Base::Floating => {
                for i in 0..3 {
                    data.columns[i] = shift(i);
                    data.columns[i + 3] = turn(i);
                }
            }
        }
    }
}

/// Returns the pose of the root link in the world.
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
