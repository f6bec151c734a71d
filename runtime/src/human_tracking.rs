//! Motion of the tracked point of a person: its velocity, measured, or estimated from successive positions.
//!
//! The estimate is the difference of two readings over the time between them, filtered by a first-order low-pass that
//! is exact for a difference that is constant between readings: `v += (1 - exp(-2 pi f dt)) (dx/dt - v)`. It starts at
//! rest with the first reading, and with the first one after the point was lost. If a largest speed is set, each
//! difference and each measured velocity is shortened to it: a jump of the tracker does not count as a movement.

use std::f64::consts::TAU;

use crate::program::{Tracking, Velocity};

/// Readings closer together than this, in s, count as one instant and yield no speed.
const INSTANT: f64 = 1e-9;

/// Motion of one point.
#[derive(Clone, Debug)]
pub(crate) struct Estimate {
    motion: Tracking,
    /// Last reading: its time in s and its position in m.
    last: Option<(f64, [f64; 3])>,
    /// Velocity in m/s.
    velocity: [f64; 3],
}

impl Estimate {
    pub fn new(motion: &Tracking) -> Estimate {
        Estimate { motion: *motion, last: None, velocity: [0.0; 3] }
    }

    /// Forgets all readings.
    pub fn forget(&mut self) {
        (self.last, self.velocity) = (None, [0.0; 3]);
    }

    /// Returns true if there is a valid reading.
    pub fn is_known(&self) -> bool {
        self.last.is_some()
    }

    /// Velocity in m/s.
    pub fn velocity(&self) -> &[f64; 3] {
        &self.velocity
    }

    /// Takes a reading of finite numbers: a position in m, followed by the velocity in m/s if that is measured.
    pub fn reading(&mut self, value: &[f64], time: f64) {
        let [x, y, z, rest @ ..] = value else { return };
        let position = [*x, *y, *z];
        match (self.motion.velocity, rest) {
            (Velocity::Measured, [x, y, z]) => self.velocity = self.believed([*x, *y, *z]),
            (Velocity::Estimated(cutoff), _) => self.estimate(position, time, cutoff),
            _ => {}
        }
        // If readings arrive in the wrong order, the newest instant remains the reference.
        let at = self.last.map_or(time, |(before, _)| before.max(time));
        self.last = Some((at, position));
    }

    fn estimate(&mut self, position: [f64; 3], time: f64, cutoff: f64) {
        let Some((before, from)) = self.last else { return };
        let elapsed = time - before;
        if elapsed < INSTANT {
            return;
        }
        let mut difference = [0.0; 3];
        for ((d, to), from) in difference.iter_mut().zip(position).zip(from) {
            *d = (to - from) / elapsed;
        }
        let difference = self.believed(difference);
        let share = -(-TAU * cutoff * elapsed).exp_m1();
        for (v, d) in self.velocity.iter_mut().zip(difference) {
            *v += share * (d - *v);
        }
        if self.velocity.iter().any(|v| !v.is_finite()) {
            self.velocity = [0.0; 3];
        }
    }

    /// Limits a velocity to the largest plausible speed.
    fn believed(&self, velocity: [f64; 3]) -> [f64; 3] {
        let largest = velocity.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        let Some(most) = self.motion.max_speed.filter(|_| largest > 0.0 && largest.is_finite()) else {
            return velocity;
        };
        // Scaled first: the square of a huge number is not finite.
        let speed = largest * velocity.iter().map(|v| (v / largest).powi(2)).sum::<f64>().sqrt();
        if speed > most { velocity.map(|v| v / largest * (most / (speed / largest))) } else { velocity }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::program::Lost;

    fn motion(velocity: Velocity, max_speed: Option<f64>) -> Tracking {
        Tracking { velocity, max_speed, lost: Lost::Fault }
    }

    fn speed(v: &[f64; 3]) -> f64 {
        v.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// Someone who starts to walk steadily: the response of a first-order filter to a step, `v (1 - exp(-2 pi f t))`.
    #[test]
    fn a_steady_walk_is_known_as_the_filter_says() {
        let (walk, cutoff) = ([1.2, -0.4, 0.1], 5.0);
        let mut e = Estimate::new(&motion(Velocity::Estimated(cutoff), None));
        let mut time = 0.0;
        for step in [0.0, 0.01, 0.02, 0.005, 0.05, 0.01, 0.1, 0.002] {
            time += step;
            e.reading(&walk.map(|v| 0.3 + v * time), time);
            let share = 1.0 - (-TAU * cutoff * time).exp();
            for (v, w) in e.velocity().iter().zip(walk) {
                assert!((v - w * share).abs() < 1e-12, "{time}: {v} and {}", w * share);
            }
        }
    }

    /// A hand that swings: the filter of `A w cos(w t)` is known in closed form, and fine sampling comes close to it.
    #[test]
    fn a_swinging_hand_is_known_with_the_lag_of_the_filter() {
        let (amplitude, w, cutoff, dt) = (0.3, 4.0, 3.0, 1e-4);
        let a = TAU * cutoff;
        let mut e = Estimate::new(&motion(Velocity::Estimated(cutoff), None));
        let mut worst = 0.0_f64;
        for k in 0..30_000 {
            let t = f64::from(k) * dt;
            e.reading(&[amplitude * (w * t).sin(), 0.0, 0.0], t);
            // y' = a (A w cos(w t) - y), y(0) = 0.
            let steady = |t: f64| amplitude * w * a * (a * (w * t).cos() + w * (w * t).sin()) / (a * a + w * w);
            let exact = steady(t) - steady(0.0) * (-a * t).exp();
            worst = worst.max((e.velocity()[0] - exact).abs());
        }
        // Half a step of the largest acceleration, twice for good measure.
        assert!(worst < amplitude * w * w * dt + a * amplitude * w * dt, "{worst}");
    }

    #[test]
    fn what_is_measured_counts_at_once_and_what_is_not_wanted_not_at_all() {
        let mut e = Estimate::new(&motion(Velocity::Measured, None));
        e.reading(&[0.0, 0.0, 0.0, 1.0, 2.0, 3.0], 0.0);
        assert_eq!(e.velocity(), &[1.0, 2.0, 3.0]);
        let mut e = Estimate::new(&motion(Velocity::None, None));
        e.reading(&[0.0; 3], 0.0);
        e.reading(&[1.0; 3], 0.1);
        assert_eq!(e.velocity(), &[0.0; 3]);
    }

    #[test]
    fn the_first_reading_and_those_of_one_instant_say_nothing_of_a_speed() {
        let mut e = Estimate::new(&motion(Velocity::Estimated(5.0), None));
        e.reading(&[1e9; 3], 3.0);
        e.reading(&[0.0; 3], 3.0);
        assert_eq!(e.velocity(), &[0.0; 3]);
        e.reading(&[0.1; 3], 3.1);
        assert!(e.velocity()[0] > 0.0);
        e.forget();
        assert!(!e.is_known() && e.velocity() == &[0.0; 3]);
    }

    fn numbers() -> impl Strategy<Value = f64> {
        prop_oneof![-2.0..2.0_f64, -1e300..1e300_f64, Just(0.0), Just(1e-300), Just(f64::MAX)]
    }

    proptest! {
        #[test]
        fn a_velocity_is_finite_and_never_beyond_what_is_believed(
            readings in prop::collection::vec((prop::array::uniform3(numbers()), 0.0..0.2_f64), 1..40),
            cutoff in 0.01..100.0_f64,
            most in 0.01..20.0_f64,
        ) {
            let mut bounded = Estimate::new(&motion(Velocity::Estimated(cutoff), Some(most)));
            let mut free = Estimate::new(&motion(Velocity::Estimated(cutoff), None));
            let mut time = 0.0;
            for (position, step) in readings {
                time += step;
                bounded.reading(&position, time);
                free.reading(&position, time);
                prop_assert!(free.velocity().iter().all(|v| v.is_finite()));
                let s = speed(bounded.velocity());
                prop_assert!(s <= most * (1.0 + 1e-12), "{s} and {most}");
            }
        }
    }
}
