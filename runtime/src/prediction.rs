//! Place of a tracked point or pose at a tick: its last reading, which goes on with the velocity until the next one, and
//! a low-pass filter.
//!
//! ```text
//! u(t) = x_k + (t - t_k) v          R_u(t) = exp((t - t_k) w) R_k
//! y' = v + 2π f (u - y)             R_y: angular velocity w + 2π f log(R_u R_y^-1)
//! ```
//!
//! with the reading `x_k`, `R_k` of the time `t_k`, the velocity v and the angular velocity w along the axes of the world;
//! both are zero for a place that is held between readings. The filtered place y goes on with the same velocity, so that
//! the filter acts on the steps at readings alone, and a steady motion has no lag. The velocity that belongs to it is its
//! own derivative y'. The filter is discretised exactly for velocities that are constant over the tick, of orientations
//! for a constant axis. Source: the g-h filter with a constant velocity, Brookner, Tracking and Kalman Filtering Made Easy
//! (1998), ch. 1, with the weight of a first-order low-pass.

use std::f64::consts::TAU;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use stdlib_tasks::so3;

/// Position and, of a pose, orientation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Place {
    /// Position in m.
    pub position: Vector3<f64>,
    /// Orientation, of a pose.
    pub orientation: Option<UnitQuaternion<f64>>,
}

/// Velocity of a place, along the axes of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Twist {
    /// Velocity in m/s.
    pub velocity: Vector3<f64>,
    /// Angular velocity of a pose in rad/s; zero for a point.
    pub angular: Vector3<f64>,
}

/// Largest plausible speeds; `None` for any.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plausible {
    /// Speed in m/s.
    pub speed: Option<f64>,
    /// Angular speed in rad/s.
    pub angular_speed: Option<f64>,
}

impl Plausible {
    /// Shortens velocities that are not plausible.
    pub fn believed(&self, twist: Twist) -> Twist {
        Twist { velocity: shortened(twist.velocity, self.speed), angular: shortened(twist.angular, self.angular_speed) }
    }
}

/// Shortens a vector to a length.
pub(crate) fn shortened(vector: Vector3<f64>, most: Option<f64>) -> Vector3<f64> {
    let largest = vector.amax();
    let Some(most) = most.filter(|_| largest > 0.0 && largest.is_finite()) else {
        return vector;
    };
    // Scaled first: the square of a huge number is not finite.
    let scaled = vector / largest;
    let length = scaled.norm();
    if largest * length > most { scaled * (most / length) } else { vector }
}

impl Twist {
    /// State of rest.
    pub const REST: Twist = Twist { velocity: Vector3::new(0.0, 0.0, 0.0), angular: Vector3::new(0.0, 0.0, 0.0) };

    fn scaled(self, factor: f64) -> Twist {
        Twist { velocity: self.velocity * factor, angular: self.angular * factor }
    }

    fn plus(self, other: Twist) -> Twist {
        Twist { velocity: self.velocity + other.velocity, angular: self.angular + other.angular }
    }
}

impl Place {
    /// The place after a time of constant velocity (s). A sum that is not finite stays where it was.
    pub fn after(self, dt: f64, twist: Twist) -> Place {
        let moved = self.position + twist.velocity * dt;
        let turned = |q: UnitQuaternion<f64>| UnitQuaternion::from_scaled_axis(twist.angular * dt) * q;
        Place {
            position: if moved.iter().all(|x| x.is_finite()) { moved } else { self.position },
            orientation: self.orientation.map(|q| {
                let q = turned(q);
                if q.coords.iter().all(|x| x.is_finite()) { q } else { self.orientation.unwrap_or(q) }
            }),
        }
    }

    /// The way to another place, as the velocity that covers it in 1 s.
    fn way_to(self, to: Place) -> Twist {
        let turn = |from: UnitQuaternion<f64>, to: UnitQuaternion<f64>| so3::log(&(to * from.inverse()));
        Twist {
            velocity: to.position - self.position,
            angular: self.orientation.zip(to.orientation).map_or(Vector3::zeros(), |(from, to)| turn(from, to)),
        }
    }

    /// Writes the numbers of the place: 3 of a point, of a pose also its quaternion `w x y z`.
    pub fn write(&self, value: &mut [f64]) {
        let [x, y, z, quaternion @ ..] = value else { return };
        [*x, *y, *z] = self.position.into();
        if let (Some(q), [w, i, j, k]) = (self.orientation, quaternion) {
            [*w, *i, *j, *k] = [q.w, q.i, q.j, q.k];
        }
    }

    /// Writes the rates of these numbers for a velocity: of a pose also those of the quaternion in 1/s, `q' = w q / 2`.
    pub fn write_rates(&self, twist: Twist, rates: &mut [f64]) {
        let [vx, vy, vz, quaternion @ ..] = rates else { return };
        [*vx, *vy, *vz] = twist.velocity.into();
        if let (Some(q), [w, i, j, k]) = (self.orientation, quaternion) {
            let rate = Quaternion::from_imag(twist.angular * 0.5) * q.into_inner();
            [*w, *i, *j, *k] = [rate.w, rate.i, rate.j, rate.k];
        }
    }
}

/// Place and velocity at a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moving {
    /// The place.
    pub place: Place,
    /// Its velocity.
    pub twist: Twist,
}

/// Low-pass filter of a place that moves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LowPass {
    /// Time of the last tick (s).
    time: f64,
    /// Filtered place.
    place: Place,
}

impl LowPass {
    /// Starts at a place.
    pub fn new(time: f64, place: Place) -> LowPass {
        LowPass { time, place }
    }

    /// Filters the place `to`, which moves with the velocity `with` since the last tick, below a cutoff in Hz.
    pub fn tick(&mut self, time: f64, to: Moving, cutoff: f64, plausible: &Plausible) -> Moving {
        let dt = (time - self.time).max(0.0);
        self.time = time;
        let share = -(-TAU * cutoff * dt).exp_m1();
        let moved = self.place.after(dt, to.twist);
        let mut next = moved.after(1.0, moved.way_to(to.place).scaled(share));
        // A jump of the tracker is no movement: the place goes to it at a speed that is plausible.
        if dt > 0.0 {
            let way = self.place.way_to(next).scaled(1.0 / dt);
            let believed = plausible.believed(way);
            if believed != way {
                next = self.place.after(dt, believed);
            }
        }
        // Rounding of a product at every tick adds up.
        next.orientation = next.orientation.map(|q| UnitQuaternion::new_normalize(q.into_inner()));
        self.place = next;
        let twist = to.twist.plus(next.way_to(to.place).scaled(TAU * cutoff));
        Moving { place: next, twist: plausible.believed(twist) }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const ANY: Plausible = Plausible { speed: None, angular_speed: None };

    fn vector(range: f64) -> impl Strategy<Value = Vector3<f64>> {
        prop::array::uniform3(-range..range).prop_map(Vector3::from)
    }

    fn pose(position: Vector3<f64>, turn: Vector3<f64>) -> Place {
        Place { position, orientation: Some(UnitQuaternion::from_scaled_axis(turn)) }
    }

    /// Numbers of a place and their rates.
    fn numbers(of: Moving) -> ([f64; 7], [f64; 7]) {
        let (mut value, mut rates) = ([0.0; 7], [0.0; 7]);
        of.place.write(&mut value);
        of.place.write_rates(of.twist, &mut rates);
        (value, rates)
    }

    proptest! {
        /// The rates of a place that goes on, against central differences.
        #[test]
        fn a_place_goes_on_with_its_velocity(
            x in vector(2.0), turn in vector(1.5), velocity in vector(1.0), angular in vector(2.0), time in 0.0..0.5_f64,
        ) {
            let twist = Twist { velocity, angular };
            let at = |time: f64| numbers(Moving { place: pose(x, turn).after(time, twist), twist });
            let (before, after, (_, rates)) = (at(time - 1e-6).0, at(time + 1e-6).0, at(time));
            for i in 0..7 {
                prop_assert!((rates[i] - (after[i] - before[i]) / 2e-6).abs() < 1e-8, "{i}");
            }
        }

        /// The filter against its equation, integrated in steps that are a thousand times as fine.
        #[test]
        fn the_filter_is_that_of_its_equation(
            from in vector(0.5), to in vector(0.5), velocity in vector(0.5), cutoff in 0.2..10.0_f64, dt in 1e-3..0.02_f64,
        ) {
            let twist = Twist { velocity, angular: Vector3::zeros() };
            let point = |position| Place { position, orientation: None };
            let mut filter = LowPass::new(0.0, point(from));
            let (mut exact, mut u) = (from, to);
            for k in 1..20 {
                let time = f64::from(k) * dt;
                let end = to + velocity * time;
                let shown = filter.tick(time, Moving { place: point(end), twist }, cutoff, &ANY);
                // Midpoint rule.
                let (steps, h) = (1000, dt / 1000.0);
                for _ in 0..steps {
                    let rate = |y: Vector3<f64>, u: Vector3<f64>| velocity + (u - y) * (TAU * cutoff);
                    let half = exact + rate(exact, u) * (h / 2.0);
                    exact += rate(half, u + velocity * (h / 2.0)) * h;
                    u += velocity * h;
                }
                prop_assert!((shown.place.position - exact).norm() < 1e-7, "{time}: {} and {exact}", shown.place.position);
                let rate = velocity + (end - exact) * (TAU * cutoff);
                prop_assert!((shown.twist.velocity - rate).norm() < 1e-5);
            }
        }

        /// Position and orientation belong to their rates: the difference of two ticks is their mean up to the curvature.
        #[test]
        fn the_filtered_velocity_is_the_derivative(
            x in vector(0.3), turn in vector(1.0), step in vector(0.1), twisted in vector(0.4),
            velocity in vector(0.5), angular in vector(1.0), cutoff in 0.2..5.0_f64,
        ) {
            let twist = Twist { velocity, angular };
            let (start, dt) = (pose(x, turn), 1e-3);
            let mut filter = LowPass::new(0.0, start);
            let jumped = pose(x + step, turn).after(1.0, Twist { velocity: Vector3::zeros(), angular: twisted });
            let mut before: Option<([f64; 7], [f64; 7])> = None;
            for k in 0..200 {
                let time = f64::from(k) * dt;
                let now = numbers(filter.tick(time, Moving { place: jumped.after(time, twist), twist }, cutoff, &ANY));
                if let Some((value, rates)) = before {
                    for i in 0..7 {
                        let (slope, mean) = ((now.0[i] - value[i]) / dt, (now.1[i] + rates[i]) / 2.0);
                        // The first tick still shows the place from before the step.
                        prop_assert!((slope - mean).abs() < 2e-2, "{k}, {i}: {slope} and {mean}");
                    }
                }
                before = Some(now);
            }
            let (end, goal) = (before.map(|b| b.0), numbers(Moving { place: jumped.after(0.199, twist), twist }).0);
            let left = (-TAU * cutoff * 0.199).exp();
            let gone = |i: usize| end.map_or(f64::NAN, |e| (e[i] - goal[i]).abs());
            for i in 0..3 {
                prop_assert!((gone(i) - step[i].abs() * left).abs() < 1e-9, "{i}");
            }
        }

        #[test]
        fn nothing_moves_faster_than_is_plausible(
            steps in prop::collection::vec((vector(1e3), vector(10.0), 0.0..0.1_f64), 1..30), most in 0.1..5.0_f64, cutoff in 0.1..50.0_f64,
        ) {
            let plausible = Plausible { speed: Some(most), angular_speed: Some(most) };
            let mut filter = LowPass::new(0.0, pose(Vector3::zeros(), Vector3::zeros()));
            let (mut time, mut before) = (0.0, Vector3::zeros());
            for (to, turn, step) in steps {
                time += step;
                let shown = filter.tick(time, Moving { place: pose(to, turn), twist: Twist::REST }, cutoff, &plausible);
                prop_assert!((shown.place.position - before).norm() <= most * step * (1.0 + 1e-9) + 1e-12);
                prop_assert!(shown.twist.velocity.norm() <= most * (1.0 + 1e-12));
                prop_assert!(shown.twist.angular.norm() <= most * (1.0 + 1e-12));
                before = shown.place.position;
            }
        }
    }
}
