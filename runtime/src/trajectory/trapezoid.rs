//! The trapezoid of velocity: the fastest motion of one number to rest with limited speed and acceleration, from any
//! velocity. Closed form; Biagiotti & Melchiorri 2008, 3.2 for motion from rest.
//!
//! The sign of the motion is that of the distance to the goal from the point at which immediate braking would end. In
//! this direction, with `x` the distance to the goal and `v` the velocity, the number is accelerated to
//! `min(V, sqrt(A x + v²/2))`, or braked to `V` if it is faster; it cruises, if that speed is `V`; and it brakes.

use super::profile::{Motion, Profile};

/// Profile from a position and velocity to rest at `goal`, with speed `speed` and acceleration `acceleration`, both
/// positive. A velocity above the limit is first braked down to it.
pub fn trapezoid(from: Motion, goal: f64, speed: f64, acceleration: f64) -> Profile {
    let from = Motion { acceleration: 0.0, ..from };
    let mut profile = Profile::from(from);
    let way = goal - from.position - from.velocity * from.velocity.abs() / (2.0 * acceleration);
    let sign = if way == 0.0 { from.velocity.signum() } else { way.signum() };
    let (x, v) = (sign * (goal - from.position), sign * from.velocity);
    let (a, peak) = (sign * acceleration, (acceleration * x + v * v / 2.0).max(0.0).sqrt());
    if v > speed {
        profile.then((v - speed) / acceleration, -a, 0.0);
        profile.then(((x - v * v / (2.0 * acceleration)) / speed).max(0.0), 0.0, 0.0);
        profile.then(speed / acceleration, -a, 0.0);
    } else if peak <= speed {
        // If immediate braking leads to the goal, rounding may put the peak below the velocity.
        let peak = peak.max(v);
        profile.then((peak - v) / acceleration, a, 0.0);
        profile.then(peak / acceleration, -a, 0.0);
    } else {
        let ramps = (2.0 * speed * speed - v * v) / (2.0 * acceleration);
        profile.then((speed - v) / acceleration, a, 0.0);
        profile.then(((x - ramps) / speed).max(0.0), 0.0, 0.0);
        profile.then(speed / acceleration, -a, 0.0);
    }
    profile.ending(Motion::rest(goal))
}

/// Duration of [`trapezoid`] for a distance `x` from the velocity `v`, in s.
pub(super) fn duration(x: f64, v: f64, speed: f64, acceleration: f64) -> f64 {
    let way = x - v * v.abs() / (2.0 * acceleration);
    let sign = if way == 0.0 { v.signum() } else { way.signum() };
    let (x, v) = (sign * x, sign * v);
    let peak = (acceleration * x + v * v / 2.0).max(0.0).sqrt().max(v);
    if v > speed {
        v / acceleration + ((x - v * v / (2.0 * acceleration)) / speed).max(0.0)
    } else if peak <= speed {
        (2.0 * peak - v) / acceleration
    } else {
        let ramps = (2.0 * speed * speed - v * v) / (2.0 * acceleration);
        (2.0 * speed - v) / acceleration + ((x - ramps) / speed).max(0.0)
    }
}

/// Profile along a line from speed `from` to speed `to`, neither above `speed`; the length must suffice for the change.
pub(super) fn along(length: f64, from: f64, to: f64, speed: f64, acceleration: f64) -> Profile {
    let mut profile = Profile::from(Motion { position: 0.0, velocity: from, acceleration: 0.0 });
    let peak = ((2.0 * acceleration * length + from * from + to * to) / 2.0).max(0.0).sqrt();
    let peak = peak.min(speed).max(from).max(to);
    let ramps = (2.0 * peak * peak - from * from - to * to) / (2.0 * acceleration);
    profile.then((peak - from) / acceleration, acceleration, 0.0);
    profile.then(((length - ramps) / peak).max(0.0), 0.0, 0.0);
    profile.then((peak - to) / acceleration, -acceleration, 0.0);
    profile.ending(Motion { position: length, velocity: to, acceleration: 0.0 })
}
