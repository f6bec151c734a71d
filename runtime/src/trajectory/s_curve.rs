//! The S-curve: motion of one number to rest with limited speed, acceleration and jerk, from any velocity and
//! acceleration.
//!
//! A ramp brings `(v, a)` to `(u, 0)` with at most three pieces of constant jerk: up to a peak of acceleration, along
//! it, and down. A profile is a ramp to a velocity `u`, a cruise, and a ramp to rest. The distance that the two ramps
//! cover is a continuous function `D(u)`. If the goal lies beyond `D(V)` or `D(-V)`, a cruise with `u = V` or `u = -V`
//! covers the rest. Otherwise some `u` in between reaches the goal. It is searched for in each interval between `-V`,
//! 0, the velocity that remains when the acceleration is reduced to zero, and `V`. The shortest of the profiles found
//! is used. From rest it is the classical one of seven pieces (Biagiotti & Melchiorri 2008, 3.4), which is the fastest.
//! From other states it need not be the fastest, but limits, continuity and arrival always hold.
//!
//! This is an implementation of our own instead of `rsruckig`, the port of Ruckig. That library bounds every axis
//! separately, while the limits declared here are those of a norm along a path; and most of it concerns goals in
//! motion, which do not occur here. From a state in motion its plans would be the faster ones.

use super::profile::{Motion, Profile};

/// Largest number of steps of the search for a velocity; it stops as soon as no number lies between its ends.
const STEPS: usize = 100;

/// Share of the distance, or of the least time that it takes, that may be left for a cruise.
const CLOSE: f64 = 1e-10;

/// Share of the distance that counts as rounding error.
const ROUNDING: f64 = 1e-14;

/// Limits of one number.
#[derive(Clone, Copy, Debug)]
struct Limits {
    acceleration: f64,
    jerk: f64,
}

/// Pieces of a ramp, each with its duration and its jerk.
type Ramp = [(f64, f64); 3];

impl Limits {
    /// Ramp from a velocity and an acceleration to the velocity `to` without acceleration.
    fn ramp(self, velocity: f64, acceleration: f64, to: f64) -> Ramp {
        let Limits { acceleration: most, jerk } = self;
        let left = velocity + acceleration * acceleration.abs() / (2.0 * jerk);
        let sign = if to < left { -1.0 } else { 1.0 };
        let (a, gain) = (sign * acceleration, sign * (to - velocity));
        let peak = (jerk * gain + a * a / 2.0).max(0.0).sqrt();
        let j = sign * jerk;
        if peak <= most {
            [((peak.max(a) - a) / jerk, j), (0.0, 0.0), (peak.max(a) / jerk, -j)]
        } else if a <= most {
            let along = (gain - (2.0 * most * most - a * a) / (2.0 * jerk)) / most;
            [((most - a) / jerk, j), (along.max(0.0), 0.0), (most / jerk, -j)]
        } else {
            let along = (gain - a * a / (2.0 * jerk)) / most;
            [((a - most) / jerk, -j), (along.max(0.0), 0.0), (most / jerk, -j)]
        }
    }

    /// Distance that the ramps over the velocity `u` cover until rest, and their duration.
    fn way(self, from: Motion, u: f64) -> (f64, f64) {
        let mut now = Motion { position: 0.0, ..from };
        let mut time = 0.0;
        for (duration, jerk) in self.ramp(from.velocity, from.acceleration, u) {
            now = now.after(duration, jerk);
            time += duration;
        }
        // The ramp from `u` to rest is point symmetric.
        let rise = self.ramp(u, 0.0, 0.0).iter().map(|p| p.0).sum::<f64>();
        (now.position + u * rise / 2.0, time + rise)
    }
}

/// Profile from a state to rest at `goal`, with positive limits.
pub fn s_curve(from: Motion, goal: f64, speed: f64, acceleration: f64, jerk: f64) -> Profile {
    let limits = Limits { acceleration, jerk };
    let wanted = goal - from.position;
    let make = |u: f64, cruise: f64| {
        let mut profile = Profile::from(from);
        limits.ramp(from.velocity, from.acceleration, u).iter().for_each(|&(t, j)| profile.jerk(t, j));
        profile.then(cruise, 0.0, 0.0);
        let stop = limits.ramp(u, 0.0, 0.0);
        if u != 0.0 {
            profile.then(stop[0].0, 0.0, stop[0].1);
            profile.jerk(stop[1].0, stop[1].1);
            profile.jerk(stop[2].0, stop[2].1);
        }
        profile.ending(Motion::rest(goal))
    };
    let (low, high) = (limits.way(from, -speed).0, limits.way(from, speed).0);
    if wanted >= high {
        return make(speed, (wanted - high) / speed);
    }
    if wanted <= low {
        return make(-speed, (low - wanted) / speed);
    }
    let left = from.velocity + from.acceleration * from.acceleration.abs() / (2.0 * jerk);
    let mut ends = [-speed, 0.0, left.max(-speed).min(speed), speed];
    ends.sort_unstable_by(f64::total_cmp);
    let mut best: Option<(f64, f64, f64)> = None;
    let mut before = (ends[0], low - wanted);
    for &end in &ends[1..] {
        let here = (end, limits.way(from, end).0 - wanted);
        if before.1 * here.1 <= 0.0 && before.0 < here.0 {
            let (u, cruise) = search(|u| limits.way(from, u).0 - wanted, before, here, (wanted.abs(), speed));
            let total = limits.way(from, u).1 + cruise;
            if best.is_none_or(|b| total < b.2) {
                best = Some((u, cruise, total));
            }
        }
        before = here;
    }
    match best {
        Some((u, cruise, _)) => make(u, cruise),
        // An input is NaN.
        None => Profile::from(Motion { position: f64::NAN, ..from }),
    }
}

/// Finds the zero of `f` between two velocities, each given with its value of `f`. Returns the velocity, and the
/// duration of a cruise with it that covers the rest exactly: `f` can be so steep that the next number is too far. The
/// interval has no inner point zero. `all` contains the whole distance and the largest speed.
fn search(f: impl Fn(f64) -> f64, mut a: (f64, f64), mut b: (f64, f64), all: (f64, f64)) -> (f64, f64) {
    let (way, speed) = all;
    let cruise = |end: (f64, f64)| if end.1.abs() <= ROUNDING * way { 0.0 } else { -end.1 / end.0 };
    let near = |end: (f64, f64)| (0.0..=CLOSE * way / speed).contains(&cruise(end));
    for step in 0..STEPS {
        let middle = 0.5 * (a.0 + b.0);
        if near(a) || near(b) || middle <= a.0 || middle >= b.0 {
            break;
        }
        // The chord, and every third time the middle, so that the interval shrinks for every shape of `f`.
        let chord = a.0 - a.1 * (b.0 - a.0) / (b.1 - a.1);
        let at = if step % 3 == 2 || !(chord > a.0 && chord < b.0) { middle } else { chord };
        let here = (at, f(at));
        if (here.1 <= 0.0) == (a.1 <= 0.0) {
            a = here;
        } else {
            b = here;
        }
    }
    let usable = |end: (f64, f64)| cruise(end) >= 0.0 && cruise(end).is_finite();
    match (usable(a), usable(b)) {
        (true, false) => (a.0, cruise(a)),
        (false, true) => (b.0, cruise(b)),
        (true, true) if cruise(a) <= cruise(b) => (a.0, cruise(a)),
        (true, true) => (b.0, cruise(b)),
        _ => (a.0, 0.0),
    }
}
