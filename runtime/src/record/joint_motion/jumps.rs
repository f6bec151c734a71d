//! Jumps of a joint's velocity that neither a limit of its acceleration nor its usual motion explains.
//!
//! Let dv be the change of the velocity from a tick to the next and T the period. If the running stack contains
//! `joint_acceleration_limits`, a tick is a jump if |dv| exceeds a_max T. Otherwise it is a jump if |dv| exceeds ten
//! times the median of |dv| over the ticks at which the joint moves, but at least 20/s v_max T and at most v_max / 2. A
//! change that takes the joint from rest to its speed limit v_max in more than 50 ms is thus no jump, and one by half
//! its speed limit always is. v_max is 1 rad/s or m/s for a joint without a speed limit.
//!
//! The median is known at the end only, so |dv| is counted in a histogram of fixed size. The median counts as the upper
//! edge of its bin, at most 16 % more. Source: ours.

use super::reversals::{scale, threshold};

/// Bins of the histogram per decade; [`ABOVE_MEDIAN`] is a whole number of bins.
const PER_DECADE: usize = 16;

/// Ten times the median, in bins.
const ABOVE_MEDIAN: usize = PER_DECADE;

/// Lower edge of the first bin, in rad/s or m/s; smaller changes are counted in it too.
const SMALLEST: f64 = 1e-9;

/// Number of bins, up to 1e4 rad/s or m/s.
const BINS: usize = 13 * PER_DECADE;

/// Time from rest to the speed limit from which on a change is never a jump, in s.
const TO_FULL_SPEED: f64 = 0.05;

/// Share of the speed limit above which a change is always a jump.
const ALWAYS: f64 = 0.5;

/// Relative rounding error of a limit that is met exactly.
const ROUNDING: f64 = 1e-6;

/// Counts of a bin.
#[derive(Clone, Copy, Debug, Default)]
struct Bin {
    /// Ticks at which the joint moved.
    moving: u32,
    /// Ticks whose change may be a jump, depending on the median.
    candidates: u32,
    /// Time of the first of these, in s.
    first: f64,
}

/// Number of jumps, and time of the first one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Jumps {
    /// Number of jumps.
    pub count: usize,
    /// Time of the first jump, in s.
    pub first: Option<f64>,
}

impl Jumps {
    fn add(&mut self, count: usize, first: f64) {
        if count > 0 {
            self.count += count;
            self.first = Some(self.first.map_or(first, |f| f.min(first)));
        }
    }
}

/// Change of a joint's velocity at a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct VelocityChange {
    /// Time of the tick, in s.
    pub time: f64,
    /// Velocity at the previous tick, in rad/s or m/s.
    pub before: f64,
    /// Velocity at this tick.
    pub now: f64,
    /// Limit of its acceleration, in rad/s² or m/s²; infinite if the stack has none.
    pub limit: f64,
}

/// Counts the jumps of a joint. Allocates nothing while it counts.
#[derive(Clone, Debug)]
pub(super) struct JumpCounter {
    period: f64,
    /// Speed up to which the joint counts as stationary.
    stands: f64,
    /// Change up to which there is no jump, unless the joint has an acceleration limit.
    least: f64,
    /// Change above which there always is a jump.
    most: f64,
    /// Jumps that are certain already.
    certain: Jumps,
    bins: Vec<Bin>,
}

fn bin(change: f64) -> usize {
    let place = (change / SMALLEST).log10() * PER_DECADE as f64;
    // The conversion maps negative numbers and NaN to zero.
    (place as usize).min(BINS - 1)
}

impl JumpCounter {
    /// Creates a counter for a joint with this speed limit in rad/s or m/s, infinite if it has none; the period is in
    /// s.
    pub fn new(speed_limit: f64, period: f64) -> JumpCounter {
        let most = ALWAYS * scale(speed_limit);
        JumpCounter {
            period,
            stands: threshold(speed_limit),
            least: (scale(speed_limit) * period / TO_FULL_SPEED).min(most),
            most,
            certain: Jumps::default(),
            bins: vec![Bin::default(); BINS],
        }
    }

    /// Takes the change of the next tick. An `explained` change is no jump, however large.
    pub fn tick(&mut self, change: VelocityChange, explained: bool) {
        let dv = (change.now - change.before).abs();
        if !dv.is_finite() {
            return;
        }
        if change.limit.is_finite() {
            let jumps = dv > change.limit * self.period * (1.0 + ROUNDING) && !explained;
            self.certain.add(usize::from(jumps), change.time);
            return;
        }
        if change.now.abs().max(change.before.abs()) <= self.stands {
            return;
        }
        let bin = &mut self.bins[bin(dv)];
        bin.moving += 1;
        if explained {
            return;
        }
        if dv > self.most {
            self.certain.add(1, change.time);
        } else if dv > self.least {
            if bin.candidates == 0 {
                bin.first = change.time;
            }
            bin.candidates += 1;
        }
    }

    /// Jumps so far.
    pub fn result(&self) -> Jumps {
        let moving: usize = self.bins.iter().map(|b| b.moving as usize).sum();
        let mut below = 0;
        let median = self.bins.iter().position(|b| {
            below += b.moving as usize;
            2 * below >= moving.max(1)
        });
        let mut jumps = self.certain;
        for bin in self.bins.iter().skip(median.unwrap_or(0) + 1 + ABOVE_MEDIAN) {
            jumps.add(bin.candidates as usize, bin.first);
        }
        jumps
    }
}

#[cfg(test)]
mod tests {
    use super::{JumpCounter, Jumps, VelocityChange};

    const PERIOD: f64 = 1e-3;

    /// The jumps of a series of velocities at 1 kHz, of a joint with a speed limit of 2 rad/s.
    fn of(velocities: &[f64], limit: f64) -> Jumps {
        let mut jumps = JumpCounter::new(2.0, PERIOD);
        for (k, pair) in velocities.windows(2).enumerate() {
            let change = VelocityChange { time: (k + 1) as f64 * PERIOD, before: pair[0], now: pair[1], limit };
            jumps.tick(change, false);
        }
        jumps.result()
    }

    /// The definition, implemented literally with all changes available.
    fn by_definition(velocities: &[f64]) -> usize {
        let moves = |p: &[f64]| p[0].abs() > 0.02 || p[1].abs() > 0.02;
        let mut changes: Vec<f64> = velocities.windows(2).filter(|p| moves(p)).map(|p| (p[1] - p[0]).abs()).collect();
        changes.sort_by(f64::total_cmp);
        let median = changes.get(changes.len().saturating_sub(1) / 2).copied().unwrap_or(0.0);
        let threshold = (10.0 * median).clamp(20.0 * 2.0 * PERIOD, 1.0);
        changes.iter().filter(|c| **c > threshold).count()
    }

    /// A sine of this frequency (Hz) and amplitude (rad/s) for 10 s, with some velocities displaced for a tick.
    fn thrown((frequency, size): (f64, f64), off: f64, at: &[usize]) -> Vec<f64> {
        let sine = |k: usize| size * (std::f64::consts::TAU * frequency * k as f64 * PERIOD).sin();
        (0..10_000).map(|k| sine(k) + if at.contains(&k) { off } else { 0.0 }).collect()
    }

    #[test]
    fn what_stands_out_is_a_jump() {
        for at in [vec![], vec![500], vec![123, 4567, 9000]] {
            let velocities = thrown((0.3, 1.0), 0.3, &at);
            let jumps = of(&velocities, f64::INFINITY);
            assert_eq!(jumps.count, 2 * at.len(), "off, and back");
            assert_eq!(jumps.count, by_definition(&velocities));
            let first = at.first().map(|k| *k as f64 * PERIOD);
            assert_eq!(jumps.first.is_some(), first.is_some());
            assert!(jumps.first.zip(first).is_none_or(|(a, b)| (a - b).abs() < 1e-9), "{jumps:?}");
        }
    }

    #[test]
    fn what_the_joint_does_all_the_time_is_none() {
        // Half of the changes are above 0.018 rad/s.
        for (off, expected) in [(0.1, 0), (0.4, 6)] {
            let velocities = thrown((2.0, 2.0), off, &[500, 3000, 7000]);
            assert_eq!(of(&velocities, f64::INFINITY).count, expected, "{off}");
            assert_eq!(by_definition(&velocities), expected, "{off}");
        }
    }

    #[test]
    fn quick_but_steady_motion_is_none() {
        // From rest to the speed limit in 0.1 s, cruising, and back: most of the time nothing changes.
        let trapezoid = |k: usize| (k as f64 * 0.02).min((10_000 - k) as f64 * 0.02).min(2.0);
        let velocities: Vec<f64> = (0..10_000).map(trapezoid).collect();
        assert_eq!(of(&velocities, f64::INFINITY), Jumps::default());
        assert_eq!(by_definition(&velocities), 0);
        // A joint at rest, up to rounding and noise.
        let noise: Vec<f64> = (0..10_000).map(|k| 1e-4 * f64::from((k * 7919) % 13)).collect();
        assert_eq!(of(&noise, f64::INFINITY), Jumps::default());
    }

    #[test]
    fn half_the_speed_limit_at_once_is_a_jump_however_often() {
        let chatter: Vec<f64> = (0..1000).map(|k| if k % 2 == 0 { 2.0 } else { -2.0 }).collect();
        assert_eq!(of(&chatter, f64::INFINITY), Jumps { count: 999, first: Some(PERIOD) });
        assert_eq!(by_definition(&chatter), 999);
    }

    #[test]
    fn a_limit_of_the_acceleration_decides_where_there_is_one() {
        // 5 rad/s² are 0.005 rad/s in a tick.
        let velocities = [0.0, 0.005, 0.010, 0.0151, 0.0201, 0.5];
        assert_eq!(of(&velocities, 5.0), Jumps { count: 2, first: Some(3.0 * PERIOD) });
        assert_eq!(of(&velocities, 1000.0).count, 0);
    }

    #[test]
    fn what_is_explained_is_none() {
        let mut jumps = JumpCounter::new(2.0, PERIOD);
        for limit in [f64::INFINITY, 5.0] {
            jumps.tick(VelocityChange { time: 1.0, before: -2.0, now: 2.0, limit }, true);
        }
        assert_eq!(jumps.result(), Jumps::default());
        jumps.tick(VelocityChange { time: 2.0, before: f64::NAN, now: 2.0, limit: 5.0 }, false);
        assert_eq!(jumps.result(), Jumps::default());
    }
}
