//! Reversals of a joint: its velocity changes direction, and back again at once.
//!
//! Let θ be 1 % of the joint's speed limit, or 0.01 rad/s or m/s if it has none. The joint *turns* at a tick at which
//! it moves faster than θ in one direction and moved faster than θ in the other direction before; slower motion in
//! between is ignored. Two turns less than 0.2 s apart are a *reversal*, counted at the second one: a lobe shorter than
//! 0.2 s between two lobes of the other sign. A sine of up to 2.5 Hz has none, one of 5 Hz has ten a second. Source:
//! ours.

/// Share of its speed limit up to which a joint counts as stationary.
const THRESHOLD: f64 = 0.01;

/// Two turns less than this apart are a reversal, in s.
const WINDOW: f64 = 0.2;

/// Times are multiples of the period up to rounding: a lobe of exactly [`WINDOW`] does not count as shorter, in s.
const ROUNDING: f64 = 1e-9;

/// Reference speed for the thresholds of a joint, in rad/s or m/s: its speed limit, or 1 if it has none.
pub(super) fn scale(speed_limit: f64) -> f64 {
    if speed_limit.is_finite() { speed_limit } else { 1.0 }
}

/// Speed up to which a joint with this speed limit counts as stationary, in rad/s or m/s.
pub(super) fn threshold(speed_limit: f64) -> f64 {
    THRESHOLD * scale(speed_limit)
}

/// Reversals of a joint so far. Allocates nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reversals {
    threshold: f64,
    /// Direction in which it last moved faster than the threshold, 1 or -1; 0 if it never did.
    direction: f64,
    /// Time of the last turn, in s.
    turned: f64,
    count: usize,
    first: Option<f64>,
}

impl Reversals {
    /// Creates a counter for a joint with this speed limit in rad/s or m/s, infinite if it has none.
    pub fn new(speed_limit: f64) -> Reversals {
        let threshold = threshold(speed_limit);
        Reversals { threshold, direction: 0.0, turned: f64::NEG_INFINITY, count: 0, first: None }
    }

    /// Takes the velocity of the next tick, in rad/s or m/s, at a time in s.
    pub fn tick(&mut self, velocity: f64, time: f64) {
        if velocity.is_nan() || velocity.abs() <= self.threshold || velocity.signum() == self.direction {
            return;
        }
        if self.direction != 0.0 {
            if time - self.turned < WINDOW - ROUNDING {
                self.count += 1;
                self.first = self.first.or(Some(time));
            }
            self.turned = time;
        }
        self.direction = velocity.signum();
    }

    /// Number of reversals.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Time at which the first was counted, in s.
    pub fn first(&self) -> Option<f64> {
        self.first
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::Reversals;

    /// The reversals of a velocity over 10 s at 1 kHz, of a joint with a speed limit of 2 rad/s.
    fn of(velocity: impl Fn(f64) -> f64) -> Reversals {
        let mut reversals = Reversals::new(2.0);
        for k in 0..10_000 {
            let time = f64::from(k) * 1e-3;
            reversals.tick(velocity(time), time);
        }
        reversals
    }

    #[test]
    fn fast_swings_count_and_slow_ones_do_not() {
        let sine = |f: f64| of(|t| (TAU * f * t).sin()).count();
        assert_eq!((sine(0.1), sine(1.0), sine(2.4)), (0, 0, 0));
        // 100 lobes in 10 s: the first turn is from the first lobe into the second, so that 98 lobes lie between two
        // turns.
        assert_eq!(sine(5.0), 98);
        assert_eq!(sine(50.0), 998);
        // Half a period of exactly 0.2 s is not shorter than 0.2 s.
        let square =
            |half: usize| of(|t| if ((t * 1e3).round() as usize / half).is_multiple_of(2) { 1.0 } else { -1.0 });
        assert_eq!(square(200).count(), 0);
        assert_eq!(square(199).count(), 10_000_usize.div_ceil(199) - 2);
    }

    #[test]
    fn slow_lobes_do_not_count() {
        assert_eq!(of(|t| 0.0199 * (TAU * 5.0 * t).sin()).count(), 0, "below 1 % of the speed limit");
        assert!(of(|t| 0.021 * (TAU * 5.0 * t).sin()).count() > 90);
        // A swing about a velocity does not turn the joint.
        assert_eq!(of(|t| 1.0 + 0.9 * (TAU * 5.0 * t).sin()).count(), 0);
        // Nor does the rounding error of a joint at rest.
        assert_eq!(of(|t| if t < 1.0 { 1.0 } else { 1e-12 * (TAU * 100.0 * t).sin() }).count(), 0);
    }

    #[test]
    fn a_single_swing_back_is_one_reversal_at_its_end() {
        let swing = of(|t| if (3.0..3.1).contains(&t) { -1.0 } else { 1.0 });
        assert_eq!(swing.count(), 1);
        assert!((swing.first().expect("one") - 3.1).abs() < 2e-3, "{swing:?}");
        // A pause does not end a lobe, unless it makes the lobe longer than 0.2 s.
        let pause = |to: f64| {
            of(|t| {
                if t < 3.0 {
                    1.0
                } else if t < 3.05 {
                    -1.0
                } else if t < to {
                    0.0
                } else {
                    1.0
                }
            })
        };
        assert_eq!((pause(3.15).count(), pause(3.25).count()), (1, 0));
    }

    #[test]
    fn without_a_speed_limit_the_threshold_is_a_hundredth() {
        let swing = |size: f64| {
            let mut reversals = Reversals::new(f64::INFINITY);
            for k in 0..100 {
                reversals.tick(if k % 2 == 0 { size } else { -size }, f64::from(k) * 0.01);
            }
            reversals.count()
        };
        assert_eq!((swing(0.0099), swing(0.0101)), (0, 98));
        let mut reversals = Reversals::new(2.0);
        [f64::NAN, 1.0, f64::NAN, -1.0, 1.0].iter().enumerate().for_each(|(k, v)| reversals.tick(*v, k as f64 * 0.01));
        assert_eq!(reversals.count(), 1);
    }
}
