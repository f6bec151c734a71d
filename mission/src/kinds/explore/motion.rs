//! Dynamics of robots: linear, the same for both axes, with an input that is held for a period (armchair (1), (2), (15)).
//!
//! The matrix `A` printed in (15) has zero rows for the velocities; a double integrator has ones there, which are used here.
//! Discretisations are exact, so that the motion between two samples is known too. It stays in the triangle of the positions at
//! both samples and a third point, `y + middle v`: constraints on the three hold in between.

use serde::{Deserialize, Serialize};

use super::polygon::Point;

/// Dynamics of a robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Dynamics {
    /// The input is the velocity.
    Velocity,
    /// The input is the acceleration: a double integrator.
    Acceleration,
    /// The input is a velocity that the robot follows with a time constant (s), more than 0.
    Lag(f64),
}

/// Position (m) and velocity (m/s).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Position (m).
    pub at: Point,
    /// Velocity (m/s).
    pub velocity: Point,
}

/// Dynamics over a time: `y' = y + position_velocity v + position_input u` and `v' = velocity_velocity v + velocity_input u`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discrete {
    /// Factor of the velocity in the position (s).
    pub position_velocity: f64,
    /// Factor of the input in the position.
    pub position_input: f64,
    /// Factor of the velocity in the velocity.
    pub velocity_velocity: f64,
    /// Factor of the input in the velocity.
    pub velocity_input: f64,
    /// Time (s) for which the velocity at the begin leads to the third point of the triangle.
    pub middle: f64,
}

impl Dynamics {
    /// Words of the language, in the order of the variants.
    pub const NAMES: [&'static str; 3] = ["velocity", "acceleration", "lag"];

    /// The exact discretisation for an input that is held for a time (s), more than 0.
    pub fn over(self, time: f64) -> Discrete {
        match self {
            Dynamics::Velocity => Discrete {
                position_velocity: 0.0,
                position_input: time,
                velocity_velocity: 0.0,
                velocity_input: 1.0,
                middle: 0.0,
            },
            Dynamics::Acceleration => Discrete {
                position_velocity: time,
                position_input: 0.5 * time * time,
                velocity_velocity: 1.0,
                velocity_input: time,
                middle: 0.5 * time,
            },
            Dynamics::Lag(constant) => {
                let left = (-time / constant).exp();
                let own = constant * (1.0 - left);
                Discrete {
                    position_velocity: own,
                    position_input: time - own,
                    velocity_velocity: left,
                    velocity_input: 1.0 - left,
                    // The tangents at both ends meet there, for every velocity and input.
                    middle: own - (time - own) / (1.0 - left) * left,
                }
            }
        }
    }

    /// The state after a time (s), zero or more, with an input that is held.
    pub fn after(self, state: State, input: Point, time: f64) -> State {
        if time <= 0.0 {
            return state;
        }
        self.over(time).step(state, input)
    }
}

impl Discrete {
    /// The next state.
    pub fn step(&self, state: State, input: Point) -> State {
        let State { at, velocity } = state;
        let axis = |i: usize| at[i] + self.position_velocity * velocity[i] + self.position_input * input[i];
        let speed = |i: usize| self.velocity_velocity * velocity[i] + self.velocity_input * input[i];
        State { at: [axis(0), axis(1)], velocity: [speed(0), speed(1)] }
    }

    /// The third point of the triangle in which the motion stays (m).
    pub fn third(&self, state: State) -> Point {
        [0, 1].map(|i| state.at[i] + self.middle * state.velocity[i])
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::polygon::Convex;
    use super::*;

    proptest! {
        /// Against the integration of the differential equations in small steps, and the triangle against points of the motion.
        #[test]
        fn motions_are_exact_and_stay_in_their_triangle(kind in 0..3_usize, constant in 0.05..3.0_f64, time in 0.1..2.0_f64, v in [-2.0..2.0_f64, -2.0..2.0_f64], u in [-2.0..2.0_f64, -2.0..2.0_f64]) {
            let dynamics = [Dynamics::Velocity, Dynamics::Acceleration, Dynamics::Lag(constant)][kind];
            let start = State { at: [1.0, -1.0], velocity: v };
            let steps = 20_000;
            let h = time / f64::from(steps);
            let (mut y, mut w) = (start.at, if kind == 0 { u } else { v });
            for _ in 0..steps {
                for i in 0..2 {
                    let a = [0.0, u[i], (u[i] - w[i]) / constant][kind];
                    // The midpoint rule has an error of the second order.
                    let half = w[i] + 0.5 * h * a;
                    let a = [0.0, u[i], (u[i] - half) / constant][kind];
                    y[i] += h * half;
                    w[i] += h * a;
                }
            }
            let end = dynamics.after(start, u, time);
            for i in 0..2 {
                prop_assert!((end.at[i] - y[i]).abs() < 1e-6 && (end.velocity[i] - w[i]).abs() < 1e-6, "{end:?} {y:?} {w:?}");
            }
            let discrete = dynamics.over(time);
            if let Some(triangle) = Convex::hull(&[start.at, discrete.third(start), end.at]) {
                for i in 0..=20 {
                    let at = dynamics.after(start, u, time * f64::from(i) / 20.0).at;
                    prop_assert!(triangle.contains(at, 1e-9), "{at:?} {triangle:?}");
                }
            }
        }
    }
}
