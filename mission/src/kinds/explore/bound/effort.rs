//! The least effort of a robot that has to be in an interval along an axis at the end of a period, and stands at the end of the plan.

use super::super::motion::{Dynamics, State};
use super::super::problem::Robot;
use super::ways::SLACK;

/// An interval along an axis in which a robot has to be at the end of a period.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    /// The least position (m).
    pub low: f64,
    /// The greatest position (m).
    pub high: f64,
    /// Number of the period, from 1 on.
    pub step: usize,
}

/// A lower bound on the sum of the absolute inputs along an axis, which are held for a time (s) each.
pub(super) fn least_effort(time: f64, who: &Robot, now: State, axis: usize, there: Interval) -> f64 {
    let (at, v) = (now.at[axis], now.velocity[axis]);
    let (step, low, high) = (there.step as f64, there.low - SLACK, there.high + SLACK);
    match who.dynamics {
        // With inputs u_j in the periods j = 0, 1, .. the position is x + k T v + T^2 sum_(j < k) (k - j - 1/2) u_j. The sum of the positive inputs P
        // has (k - 1/2) P T^2 >= what is missing without inputs. The velocity is zero at the end, so that the sum of the negative ones is
        // P + v / T.
        Dynamics::Acceleration => {
            let ahead = at + step * time * v;
            let each = (step - 0.5) * time * time;
            let braking = (v / time).abs();
            let up = 2.0 * (low - ahead).max(0.0) / each + v / time;
            let down = 2.0 * (ahead - high).max(0.0) / each - v / time;
            braking.max(up).max(down)
        }
        Dynamics::Velocity => (low - at).max(at - high).max(0.0) / time,
        // The velocity at the begin leads at most the time constant ahead, and an input at most as far as at its own speed.
        Dynamics::Lag(constant) => {
            let [least, most] = [at + constant * v.min(0.0), at + constant * v.max(0.0)];
            (low - most).max(least - high).max(0.0) / time
        }
    }
}

/// A lower bound on the sum of the absolute inputs along an axis of a robot that only stands at the end.
pub(super) fn braking(time: f64, who: &Robot, now: State, axis: usize) -> f64 {
    match who.dynamics {
        Dynamics::Acceleration => (now.velocity[axis] / time).abs(),
        Dynamics::Velocity | Dynamics::Lag(_) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use proptest::prelude::*;

    use super::super::super::polygon::Convex;
    use super::*;
    use crate::engine::{Budget, Microlp, Milp, Model};

    fn robot(dynamics: Dynamics) -> Robot {
        let body = Convex::rectangle([0.5, 0.5]).expect("a rectangle");
        Robot { name: "r".into(), start: [0.0; 2], body, dynamics, speed: 2.5, acceleration: 5.0 }
    }

    /// The optimum of the linear program: inputs as differences of two that are not negative.
    fn optimum(who: &Robot, now: State, there: Interval, periods: usize, period: f64) -> Option<f64> {
        let d = who.over(period);
        let mut model = Model::default();
        let inputs: Vec<[usize; 2]> =
            (0..periods).map(|_| [(); 2].map(|()| model.real(1.0, 0.0, who.most_input()))).collect();
        // Position and velocity as sums of the inputs, and what they are without.
        let (mut at, mut v) = (now.at[0], now.velocity[0]);
        let (mut of_at, mut of_v) = (vec![0.0; periods], vec![0.0; periods]);
        for step in 1..=periods {
            (at, v) = (at + d.position_velocity * v, d.velocity_velocity * v);
            for i in 0..periods {
                of_at[i] += d.position_velocity * of_v[i];
                of_v[i] *= d.velocity_velocity;
            }
            of_at[step - 1] += d.position_input;
            of_v[step - 1] += d.velocity_input;
            let terms = |of: &[f64]| {
                let terms = of.iter().zip(&inputs).flat_map(|(factor, [up, down])| [(*up, *factor), (*down, -factor)]);
                terms.collect::<Vec<(usize, f64)>>()
            };
            model.row(-who.speed - v, terms(&of_v), who.speed - v);
            if step == there.step {
                model.row(there.low - at, terms(&of_at), there.high - at);
            }
            if step == periods {
                model.row(-v, terms(&of_v), -v);
            }
        }
        let budget = Budget { time: Duration::from_secs(10), nodes: 100, gap: 1e-6 };
        let values = Microlp.solve(&model, &[], &budget).ok()?.values?;
        Some(inputs.iter().flatten().map(|column| values[*column]).sum())
    }

    proptest! {
        #[test]
        fn no_inputs_have_less_effort(
            kind in 0..3_usize,
            velocity in -2.0..2.0_f64,
            low in -6.0..6.0_f64,
            width in 0.0..1.0_f64,
            step in 1..6_usize,
            more in 1..5_usize,
            period in 0.5..1.5_f64,
        ) {
            let who = robot([Dynamics::Acceleration, Dynamics::Velocity, Dynamics::Lag(0.4)][kind]);
            let now = State { at: [0.0; 2], velocity: [velocity, 0.0] };
            let there = Interval { low, high: low + width, step };
            if let Some(optimum) = optimum(&who, now, there, step + more, period) {
                let bound = least_effort(period, &who, now, 0, there).max(braking(period, &who, now, 0));
                prop_assert!(bound <= optimum + 1e-6, "{bound} {optimum}");
                // From rest, and within what one period can accelerate, nothing is lost but the slack.
                let ahead = (low.abs() - width).max(0.0) / ((step as f64 - 0.5) * period * period);
                if kind == 0 && velocity.abs() < 1e-12 && ahead < 1.0 {
                    prop_assert!(optimum - bound < 0.02, "{bound} {optimum}");
                }
            }
        }
    }
}
