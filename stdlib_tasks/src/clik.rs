//! Rows that pull a frame's position or orientation to a target: the closed-loop inverse kinematics of thesis (2.5),
//! `J v = rate_d + K e`, written separately for the position and the orientation.

use nalgebra::{UnitQuaternion, Vector3};
use robot::LinkId;

use crate::so3;
use crate::state::{Rows, State};

/// The world's axes.
pub fn axes() -> [Vector3<f64>; 3] {
    [Vector3::x(), Vector3::y(), Vector3::z()]
}

/// Writes three rows from `first` on for the position of a frame's origin; returns the error's norm in m. `target` is
/// the position in m and its rate in m/s, both in the world; `gain` is in 1/s.
pub fn position(
    state: &State,
    rows: &mut Rows,
    first: usize,
    link: LinkId,
    target: (Vector3<f64>, Vector3<f64>),
    gain: f64,
) -> f64 {
    let p = state.data.pose(link).translation.vector;
    let error = target.0 - p;
    for (i, axis) in axes().iter().enumerate() {
        state.data.add_point(state.model, link, &p, axis, rows.row(first + i));
        rows.equal(first + i, target.1[i] + gain * error[i]);
    }
    error.norm()
}

/// Writes three rows from `first` on for the orientation of a frame; returns the error angle in rad. `target` is the
/// orientation and its angular velocity in rad/s, both in the world; `gain` is in 1/s.
pub fn orientation(
    state: &State,
    rows: &mut Rows,
    first: usize,
    link: LinkId,
    target: (UnitQuaternion<f64>, Vector3<f64>),
    gain: f64,
) -> f64 {
    let error = so3::log(&(target.0 * state.data.pose(link).rotation.inverse()));
    for (i, axis) in axes().iter().enumerate() {
        state.data.add_angular(state.model, link, axis, rows.row(first + i));
        rows.equal(first + i, target.1[i] + gain * error[i]);
    }
    error.norm()
}

/// Reads a position target and its rate from the tables.
pub fn position_target(state: &State, at: crate::params::Input<3>) -> (Vector3<f64>, Vector3<f64>) {
    (Vector3::from(at.of(state.values)), Vector3::from(at.of(state.rates)))
}

/// Reads an orientation target and its angular velocity from the tables.
pub fn orientation_target(state: &State, at: crate::params::Input<4>) -> (UnitQuaternion<f64>, Vector3<f64>) {
    so3::target(at.of(state.values), at.of(state.rates))
}
