//! Motion of an orientation to rest at another.
//!
//! The rotation vector `psi` from the orientation at the time of planning moves as a vector: `R = exp(psi) R_0`. From
//! rest this is the geodesic, with the profile of one number. In motion, the angular velocity `omega = J_l(psi) psi'`
//! is continuous, because `J_l(0) = 1`. Since `J_l` stretches no direction, its norm is bounded by the speed. The norm
//! of the angular acceleration is bounded on geodesics; after a new goal in motion, the norm of `psi''` is bounded
//! instead.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use stdlib_tasks::so3::{left_jacobian, log};

use super::limits::Limits;
use super::path::{Path, State};

/// Step of the central difference that computes the angular acceleration, in s.
const BESIDE: f64 = 1e-6;

/// State of a rotating orientation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turning {
    /// The orientation.
    pub orientation: UnitQuaternion<f64>,
    /// Its angular velocity in the world, in rad/s.
    pub velocity: Vector3<f64>,
    /// Its angular acceleration, in rad/s^2.
    pub acceleration: Vector3<f64>,
}

/// The motion of an orientation to rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turn {
    reference: UnitQuaternion<f64>,
    goal: UnitQuaternion<f64>,
    path: Path,
}

fn state(from: &Turning) -> State {
    State { position: Vector3::zeros(), velocity: from.velocity, acceleration: from.acceleration }
}

fn way(from: &Turning, goal: &UnitQuaternion<f64>) -> Vector3<f64> {
    log(&(goal * from.orientation.inverse()))
}

impl Turn {
    /// Turn that stays at rest.
    pub fn rest(orientation: UnitQuaternion<f64>) -> Turn {
        Turn { reference: orientation, goal: orientation, path: Path::rest(Vector3::zeros()) }
    }

    /// Plans a turn from a state to rest at `goal`; `None` as for [`Path::plan`].
    pub fn plan(from: &Turning, goal: UnitQuaternion<f64>, limits: &Limits) -> Option<Turn> {
        let path = Path::plan(&state(from), way(from, &goal), limits)?;
        Some(Turn { reference: from.orientation, goal, path })
    }

    /// Plans the same motion in a time as close to `duration` as possible without going faster.
    pub fn within(from: &Turning, goal: UnitQuaternion<f64>, limits: &Limits, duration: f64) -> Option<Turn> {
        let path = Path::within(&state(from), way(from, &goal), limits, duration)?;
        Some(Turn { reference: from.orientation, goal, path })
    }

    /// Plans to come to rest at once, with the same errors as [`Path::stop`].
    pub fn stop(from: &Turning, limits: &Limits) -> Option<Turn> {
        let path = Path::stop(&state(from), limits)?;
        let goal = UnitQuaternion::from_scaled_axis(path.goal()) * from.orientation;
        Some(Turn { reference: from.orientation, goal, path })
    }

    /// Returns true if a plan from a state would first have to reduce the acceleration to zero.
    pub fn must_release(from: &Turning, goal: &UnitQuaternion<f64>, limits: &Limits) -> bool {
        Path::must_release(&state(from), &way(from, goal), limits)
    }

    /// Duration, in s.
    pub fn duration(&self) -> f64 {
        self.path.duration()
    }

    /// Orientation at a time since the beginning, in s, and its angular velocity in rad/s.
    pub fn at(&self, t: f64) -> (UnitQuaternion<f64>, Vector3<f64>) {
        let now = self.path.at(t);
        let turned = UnitQuaternion::from_scaled_axis(now.position) * self.reference;
        if t < self.duration() {
            return (turned, left_jacobian(&now.position) * now.velocity);
        }
        // Two quaternions represent the goal: take the one that the motion arrives at, so that the value does not jump.
        let flipped = turned.coords.dot(&self.goal.coords) < 0.0;
        let end = if flipped { UnitQuaternion::new_unchecked(-self.goal.into_inner()) } else { self.goal };
        (end, Vector3::zeros())
    }

    /// Complete state at a time since the beginning, in s.
    pub fn state(&self, t: f64) -> Turning {
        let (orientation, velocity) = self.at(t);
        if t >= self.duration() {
            return Turning { orientation, velocity, acceleration: Vector3::zeros() };
        }
        // Both times are inside one piece of the profile, except within a step of its ends.
        let (before, after) = ((t - BESIDE).max(0.0), t + BESIDE);
        let acceleration = (self.at(after).1 - self.at(before).1) / (after - before);
        Turning { orientation, velocity, acceleration }
    }
}

/// Rate of a quaternion `w x y z` whose rotation has this angular velocity in the world.
pub fn quaternion_rate(q: &UnitQuaternion<f64>, omega: &Vector3<f64>) -> Quaternion<f64> {
    Quaternion::from_imag(*omega) * q.into_inner() * 0.5
}
