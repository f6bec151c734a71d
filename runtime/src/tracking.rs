//! Motion of a tracked point or pose: its velocity, measured, or estimated from successive readings, and its place at a
//! tick.
//!
//! The estimate is the difference of two readings over the time between them, filtered by a first-order low-pass that
//! is exact for a difference that is constant between readings: `v += (1 - exp(-2 pi f dt)) (dx/dt - v)`. The difference
//! of two orientations is the rotation vector from one to the other along the shorter way. An estimate starts at
//! rest with the first reading, and with the first one after the point was lost. If a largest speed is set, each
//! difference and each measured velocity is shortened to it: a jump of the tracker does not count as a movement.
//!
//! All times are those that belong to the readings, so that irregular and lost readings do not change the velocity of a
//! steady motion. [`crate::prediction`] has the place between readings.

use std::f64::consts::TAU;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use stdlib_tasks::so3;

use crate::prediction::{LowPass, Moving, Place, Plausible, Twist, shortened};
use crate::program::{Between, Tracking, Velocity};

/// Readings closer together than this, in s, count as one instant and yield no speed.
const INSTANT: f64 = 1e-9;

/// Motion of one point or pose.
#[derive(Clone, Debug)]
pub(crate) struct Estimate {
    motion: Tracking,
    /// Cutoff of the filter of its place, in Hz; `None` for no filter.
    low_pass: Option<f64>,
    last: Option<Reading>,
    filter: Option<LowPass>,
    /// Velocity in m/s.
    velocity: Vector3<f64>,
    /// Angular velocity of a pose in rad/s, along the axes of the world; zero for a point.
    angular: Vector3<f64>,
}

/// A reading.
#[derive(Clone, Copy, Debug)]
struct Reading {
    /// Time in s.
    time: f64,
    place: Place,
}

impl Estimate {
    pub fn new(motion: &Tracking, low_pass: Option<f64>) -> Estimate {
        let (velocity, angular) = (Vector3::zeros(), Vector3::zeros());
        Estimate { motion: *motion, low_pass, last: None, filter: None, velocity, angular }
    }

    /// Forgets all readings.
    pub fn forget(&mut self) {
        *self = Estimate::new(&self.motion, self.low_pass);
    }

    /// Returns true if there is a valid reading.
    pub fn is_known(&self) -> bool {
        self.last.is_some()
    }

    /// Writes the value at a time, where it will be after another with its velocity (s), and its rates: of a point its position and 3 numbers, its velocity in m/s; of a pose its
    /// position and quaternion `w x y z` and 7 numbers, the velocity and the rates of the quaternion in 1/s, `q' = w q / 2`.
    /// Writes nothing if there is no valid reading.
    pub fn write(&mut self, time: f64, foresight: f64, value: &mut [f64], rates: &mut [f64]) {
        let Some(last) = self.last else { return };
        let twist = Twist { velocity: self.velocity, angular: self.angular };
        let (ahead, goes_on) = match self.motion.between {
            // The reading itself stays exact at its own time.
            Between::Extrapolate if time > last.time => (last.place.after(time - last.time, twist), twist),
            Between::Extrapolate => (last.place, twist),
            Between::Hold => (last.place, Twist::REST),
        };
        let shown = match self.low_pass {
            None => Moving { place: ahead, twist },
            Some(cutoff) => {
                let plausible =
                    Plausible { speed: self.motion.max_speed, angular_speed: self.motion.max_angular_speed };
                let filter = self.filter.get_or_insert(LowPass::new(time, ahead));
                filter.tick(time, Moving { place: ahead, twist: goes_on }, cutoff, &plausible)
            }
        };
        let foreseen = if foresight > 0.0 { shown.place.after(foresight, shown.twist) } else { shown.place };
        foreseen.write(value);
        shown.place.write_rates(shown.twist, rates);
    }

    /// Takes a reading of a point: finite numbers, its position in m, and its velocity in m/s if that is measured.
    pub fn point(&mut self, value: &[f64], time: f64) {
        let [x, y, z, velocity @ ..] = value else { return };
        let place = Place { position: Vector3::new(*x, *y, *z), orientation: None };
        self.take(Reading { time, place }, velocity);
    }

    /// Takes a reading of a pose: finite numbers, its position in m and a unit quaternion `w x y z`, and if they are
    /// measured, its velocity in m/s and its angular velocity in rad/s.
    pub fn pose(&mut self, value: &[f64], time: f64) {
        let [x, y, z, qw, qx, qy, qz, velocity @ ..] = value else { return };
        let orientation = UnitQuaternion::new_unchecked(Quaternion::new(*qw, *qx, *qy, *qz));
        let place = Place { position: Vector3::new(*x, *y, *z), orientation: Some(orientation) };
        self.take(Reading { time, place }, velocity);
    }

    fn take(&mut self, reading: Reading, sent: &[f64]) {
        match (self.motion.velocity, sent) {
            (Velocity::Measured, [x, y, z, turning @ ..]) => {
                self.velocity = shortened(Vector3::new(*x, *y, *z), self.motion.max_speed);
                if let [x, y, z] = turning {
                    self.angular = shortened(Vector3::new(*x, *y, *z), self.motion.max_angular_speed);
                }
            }
            (Velocity::Estimated(cutoff), _) => self.estimate(&reading, cutoff),
            _ => {}
        }
        self.last = Some(reading);
    }

    fn estimate(&mut self, reading: &Reading, cutoff: f64) {
        let Some(before) = self.last else { return };
        // Readings that arrive in the wrong order say nothing of a speed; the next one is compared with the older place.
        let elapsed = reading.time - before.time;
        if elapsed < INSTANT {
            return;
        }
        let share = -(-TAU * cutoff * elapsed).exp_m1();
        let moved = (reading.place.position - before.place.position) / elapsed;
        filter(&mut self.velocity, &shortened(moved, self.motion.max_speed), share);
        if let (Some(from), Some(to)) = (before.place.orientation, reading.place.orientation) {
            let turned = so3::log(&(to * from.inverse())) / elapsed;
            filter(&mut self.angular, &shortened(turned, self.motion.max_angular_speed), share);
        }
    }
}

/// Moves a filtered velocity a share of the way to a new value.
fn filter(velocity: &mut Vector3<f64>, to: &Vector3<f64>, share: f64) {
    *velocity += share * (to - *velocity);
    if velocity.iter().any(|v| !v.is_finite()) {
        *velocity = Vector3::zeros();
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::program::Lost;

    fn motion(velocity: Velocity, max_speed: Option<f64>) -> Tracking {
        Tracking {
            person: true,
            velocity,
            between: Between::Hold,
            max_speed,
            max_angular_speed: None,
            lost: Lost::Fault,
        }
    }

    /// Velocity at the time of the last reading; zero if there is none.
    fn velocity(e: &Estimate) -> [f64; 3] {
        let (mut value, mut rates) = ([0.0; 3], [0.0; 3]);
        e.clone().write(f64::NEG_INFINITY, 0.0, &mut value, &mut rates);
        rates
    }

    /// Someone who starts to walk steadily: the response of a first-order filter to a step, `v (1 - exp(-2 pi f t))`.
    #[test]
    fn a_steady_walk_is_known_as_the_filter_says() {
        let (walk, cutoff) = ([1.2, -0.4, 0.1], 5.0);
        let mut e = Estimate::new(&motion(Velocity::Estimated(cutoff), None), None);
        let mut time = 0.0;
        for step in [0.0, 0.01, 0.02, 0.005, 0.05, 0.01, 0.1, 0.002] {
            time += step;
            e.point(&walk.map(|v| 0.3 + v * time), time);
            let share = 1.0 - (-TAU * cutoff * time).exp();
            for (v, w) in velocity(&e).iter().zip(walk) {
                assert!((v - w * share).abs() < 1e-12, "{time}: {v} and {}", w * share);
            }
        }
    }

    /// A hand that swings: the filter of `A w cos(w t)` is known in closed form, and fine sampling comes close to it.
    #[test]
    fn a_swinging_hand_is_known_with_the_lag_of_the_filter() {
        let (amplitude, w, cutoff, dt) = (0.3, 4.0, 3.0, 1e-4);
        let a = TAU * cutoff;
        let mut e = Estimate::new(&motion(Velocity::Estimated(cutoff), None), None);
        let mut worst = 0.0_f64;
        for k in 0..30_000 {
            let t = f64::from(k) * dt;
            e.point(&[amplitude * (w * t).sin(), 0.0, 0.0], t);
            // y' = a (A w cos(w t) - y), y(0) = 0.
            let steady = |t: f64| amplitude * w * a * (a * (w * t).cos() + w * (w * t).sin()) / (a * a + w * w);
            let exact = steady(t) - steady(0.0) * (-a * t).exp();
            worst = worst.max((velocity(&e)[0] - exact).abs());
        }
        // Half a step of the largest acceleration, twice for good measure.
        assert!(worst < amplitude * w * w * dt + a * amplitude * w * dt, "{worst}");
    }

    #[test]
    fn what_is_measured_counts_at_once_and_what_is_not_wanted_not_at_all() {
        let mut e = Estimate::new(&motion(Velocity::Measured, None), None);
        e.point(&[0.0, 0.0, 0.0, 1.0, 2.0, 3.0], 0.0);
        assert_eq!(velocity(&e), [1.0, 2.0, 3.0]);
        let mut e = Estimate::new(&motion(Velocity::None, None), None);
        e.point(&[0.0; 3], 0.0);
        e.point(&[1.0; 3], 0.1);
        assert_eq!(velocity(&e), [0.0; 3]);
    }

    #[test]
    fn the_first_reading_and_those_of_one_instant_say_nothing_of_a_speed() {
        let mut e = Estimate::new(&motion(Velocity::Estimated(5.0), None), None);
        e.point(&[1e9; 3], 3.0);
        e.point(&[0.0; 3], 3.0);
        assert_eq!(velocity(&e), [0.0; 3]);
        e.point(&[0.1; 3], 3.1);
        assert!(velocity(&e)[0] > 0.0);
        e.forget();
        assert!(!e.is_known() && velocity(&e) == [0.0; 3]);
    }

    /// A body that turns at a constant rate: the rates of its quaternion are its derivative, and the filter answers as to a
    /// step.
    #[test]
    fn a_steady_turn_is_known_as_the_filter_says() {
        let (w, v, cutoff) = (Vector3::new(0.3, -1.1, 0.7), Vector3::new(0.2, 0.1, -0.4), 4.0);
        let start = UnitQuaternion::from_euler_angles(0.4, -0.9, 2.0);
        let pose = |time: f64| {
            let q = UnitQuaternion::from_scaled_axis(w * time) * start;
            let x = v * time;
            [x.x, x.y, x.z, q.w, q.i, q.j, q.k]
        };
        let mut e = Estimate::new(&motion(Velocity::Estimated(cutoff), None), None);
        let mut time = 0.0;
        for (k, step) in [0.0, 0.01, 0.02, 0.005, 0.05, 0.01, 0.1, 0.002].into_iter().enumerate() {
            time += step;
            // A quaternion and its negative are the same orientation.
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            let mut reading = pose(time);
            reading[3..].iter_mut().for_each(|x| *x *= sign);
            e.pose(&reading, time);
            let share = 1.0 - (-TAU * cutoff * time).exp();
            let mut rates = [0.0; 7];
            e.write(time, 0.0, &mut [0.0; 7], &mut rates);
            let (d, before, after) = (1e-6, pose(time - 1e-6), pose(time + 1e-6));
            for i in 0..7 {
                let exact = share * (after[i] - before[i]) / (2.0 * d) * if i < 3 { 1.0 } else { sign };
                assert!((rates[i] - exact).abs() < 1e-8, "{time}, {i}: {} and {exact}", rates[i]);
            }
        }
    }

    #[test]
    fn a_measured_turn_counts_up_to_what_is_plausible() {
        let tracking = Tracking { max_angular_speed: Some(2.0), ..motion(Velocity::Measured, Some(1.0)) };
        let mut e = Estimate::new(&tracking, None);
        e.pose(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 3.0, 4.0, 0.0, 0.0, 8.0], 0.0);
        let mut rates = [0.0; 7];
        e.write(0.0, 0.0, &mut [0.0; 7], &mut rates);
        // At the identity, the rates of the quaternion are half the angular velocity.
        let expected = [0.0, 0.6, 0.8, 0.0, 0.0, 0.0, 1.0];
        assert!(rates.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{rates:?}");
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
            let mut bounded = Estimate::new(&motion(Velocity::Estimated(cutoff), Some(most)), None);
            let mut free = Estimate::new(&motion(Velocity::Estimated(cutoff), None), None);
            let mut time = 0.0;
            for (position, step) in readings {
                time += step;
                bounded.point(&position, time);
                free.point(&position, time);
                prop_assert!(velocity(&free).iter().all(|v| v.is_finite()));
                let s = bounded.velocity.norm();
                prop_assert!(s <= most * (1.0 + 1e-12), "{s} and {most}");
            }
        }
    }
}
