//! Rows that pull a frame's position or orientation to a target: the closed-loop inverse kinematics of thesis (2.5),
//! `J v = rate_d + K e`, written separately for the position and the orientation.

use nalgebra::{UnitQuaternion, Vector3};
use robot::LinkId;

use crate::params::Input;
use crate::so3;
use crate::state::{Rows, State};

/// Target of a position, in the world.
#[derive(Clone, Copy, Debug)]
pub struct PositionTarget {
    /// In m.
    pub position: Vector3<f64>,
    /// Its rate in m/s.
    pub velocity: Vector3<f64>,
}

/// Target of an orientation, in the world.
#[derive(Clone, Copy, Debug)]
pub struct OrientationTarget {
    /// The orientation.
    pub orientation: UnitQuaternion<f64>,
    /// Its angular velocity in rad/s.
    pub angular_velocity: Vector3<f64>,
}

/// The world's axes.
pub fn axes() -> [Vector3<f64>; 3] {
    [Vector3::x(), Vector3::y(), Vector3::z()]
}

/// Writes three rows from `first` on for the position of a frame's origin; returns the error's norm in m; `gain` is
/// in 1/s.
pub fn position(state: &State, rows: &mut Rows, first: usize, link: LinkId, target: &PositionTarget, gain: f64) -> f64 {
    let p = state.data.pose(link).translation.vector;
    let error = target.position - p;
    for (i, axis) in axes().iter().enumerate() {
        state.data.add_point(state.model, link, &p, axis, rows.row(first + i));
        rows.equal(first + i, target.velocity[i] + gain * error[i]);
    }
    error.norm()
}

/// Writes three rows from `first` on for the orientation of a frame; returns the error angle in rad; `gain` is in
/// 1/s.
pub fn orientation(
    state: &State,
    rows: &mut Rows,
    first: usize,
    link: LinkId,
    target: &OrientationTarget,
    gain: f64,
) -> f64 {
    let error = so3::log(&(target.orientation * state.data.pose(link).rotation.inverse()));
    for (i, axis) in axes().iter().enumerate() {
        state.data.add_angular(state.model, link, axis, rows.row(first + i));
        rows.equal(first + i, target.angular_velocity[i] + gain * error[i]);
    }
    error.norm()
}

/// Reads a position target and its rate from the tables.
pub fn position_target(state: &State, at: Input<3>) -> PositionTarget {
    PositionTarget { position: Vector3::from(at.of(state.values)), velocity: Vector3::from(at.of(state.rates)) }
}

/// Reads an orientation target and its angular velocity from the tables.
pub fn orientation_target(state: &State, at: Input<4>) -> OrientationTarget {
    let (orientation, angular_velocity) = so3::target(at.of(state.values), at.of(state.rates));
    OrientationTarget { orientation, angular_velocity }
}
