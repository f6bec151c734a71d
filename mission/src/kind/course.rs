//! Members whose bases are driven by controllers of their own: the way that one follows, and what becomes of it.
//!
//! A kind gives the planned way of a driven member as a [`Course`], and is told at each tick of the controller where the base
//! truly is. Where the base should be now is a matter of time, and where it is told to go one of both: the target is ahead of
//! the planned point by a time, and never farther ahead of the base, along the way, than a length. A base that had to stop or to
//! go round somebody thus comes back to the way, and cuts no corner of it.

use serde::{Deserialize, Serialize};

use super::WorkState;

/// A place on the ground, and a direction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GroundPose {
    /// Position (m).
    pub at: [f64; 2],
    /// Direction (rad), from the x axis.
    pub heading: f64,
}

/// A member that a controller may drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drivable {
    /// Pose at the start.
    pub start: GroundPose,
    /// Speed with which its ways are planned (m/s).
    pub speed: f64,
}

/// A member that a controller drives in a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Driven {
    /// Index of the member.
    pub member: usize,
    /// Distance (m) from a place within which its base counts as being there.
    pub tolerance: f64,
}

/// The way of a driven member at the present.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Course<'e> {
    /// [`WorkState::Works`] while it is on a way.
    pub state: WorkState,
    /// The way as a polyline (m); one point where it stands.
    pub points: &'e [[f64; 2]],
    /// Planned times (s) of the points; empty: of a way with an even speed.
    pub times: &'e [f64],
    /// Share of the way's length that its base has covered.
    pub share: f64,
    /// A share of the way, and the time (s) at which it is planned.
    pub from: [f64; 2],
    /// Planned time (s) of the end of the way.
    pub ends: f64,
    /// Direction (rad) where the way has none.
    pub heading: f64,
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    f64::hypot(b[0] - a[0], b[1] - a[1])
}

/// Returns the length of a polyline (m).
fn length(points: &[[f64; 2]]) -> f64 {
    points.windows(2).map(|two| distance(two[0], two[1])).sum()
}

impl Course<'_> {
    /// Length of the way (m).
    pub fn length(&self) -> f64 {
        length(self.points)
    }

    /// The share of the way that is planned for a time (s).
    fn planned(&self, time: f64) -> f64 {
        if !self.times.is_empty() {
            let mut passed = 0.0;
            for (two, times) in self.points.windows(2).zip(self.times.windows(2)) {
                let share = ((time - times[0]) / (times[1] - times[0])).clamp(0.0, 1.0);
                passed += share * distance(two[0], two[1]);
            }
            let whole = length(self.points);
            return if whole > 0.0 { passed / whole } else { 1.0 };
        }
        let [share, since] = self.from;
        if self.ends > since {
            (share + (1.0 - share) * (time - since) / (self.ends - since)).clamp(0.0, 1.0)
        } else {
            1.0
        }
    }

    /// The pose that its base is told to go to at a time (s): `lead` (s) ahead of the planned one, and at most `ahead` (m)
    /// farther along the way than the base.
    pub fn target(&self, time: f64, lead: f64, ahead: f64) -> GroundPose {
        let whole = length(self.points);
        let wanted = (self.planned(time + lead) * whole).min(self.share * whole + ahead);
        let mut pose = GroundPose { at: self.points.first().copied().unwrap_or_default(), heading: self.heading };
        let mut left = wanted.clamp(0.0, whole);
        for two in self.points.windows(2) {
            let step = distance(two[0], two[1]);
            if step <= 0.0 {
                continue;
            }
            let share = (left / step).min(1.0);
            pose.heading = f64::atan2(two[1][1] - two[0][1], two[1][0] - two[0][0]);
            pose.at = [0, 1].map(|i| two[0][i] + share * (two[1][i] - two[0][i]));
            left -= step;
            if left <= 0.0 {
                break;
            }
        }
        pose
    }

    /// Returns true if a base that is at a point has reached the end of the way. `near` is the length (m) of the last part of
    /// the way, on which it may arrive.
    pub fn is_reached(&self, at: [f64; 2], tolerance: f64, near: f64) -> bool {
        let rest = (1.0 - self.share) * length(self.points);
        rest <= near && self.points.last().is_some_and(|end| distance(*end, at) <= tolerance)
    }
}

/// Returns the share of a way that a base at a point has covered, of which it had covered `share` before: that of the nearest
/// point of the next part of the way, which is `reach` (m) long.
pub fn covered(points: &[[f64; 2]], share: f64, at: [f64; 2], reach: f64) -> f64 {
    let whole = length(points);
    if whole <= 0.0 {
        return 1.0;
    }
    let (from, to) = (share * whole, (share * whole + reach).min(whole));
    let (mut best, mut nearest, mut begin) = (from, f64::INFINITY, 0.0);
    for two in points.windows(2) {
        let step = distance(two[0], two[1]);
        let (low, high) = ((from - begin).max(0.0), (to - begin).min(step));
        if step > 0.0 && low <= high {
            let dot: f64 = (0..2).map(|i| (at[i] - two[0][i]) * (two[1][i] - two[0][i])).sum();
            let along = (dot / step).clamp(low, high);
            let foot = [0, 1].map(|i| two[0][i] + along / step * (two[1][i] - two[0][i]));
            let off = distance(foot, at);
            // Of equally near points the first one counts: nothing is skipped.
            if off < nearest - 1e-12 {
                (best, nearest) = (begin + along, off);
            }
        }
        begin += step;
    }
    (best / whole).clamp(share, 1.0)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const WAY: [[f64; 2]; 3] = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.0]];

    fn course(share: f64) -> Course<'static> {
        let (state, from) = (WorkState::Works, [0.0, 10.0]);
        Course { state, points: &WAY, times: &[], share, from, ends: 22.0, heading: 0.0 }
    }

    #[test]
    fn the_target_is_ahead_of_the_plan_and_near_the_base() {
        // 6 m in 12 s: half a metre a second.
        assert_eq!(course(0.5).target(14.0, 0.0, 9.0).at, [2.0, 0.0]);
        assert_eq!(course(0.5).target(14.0, 2.0, 9.0).at, [3.0, 0.0]);
        // The base has stopped after 1 m.
        let held = course(1.0 / 6.0).target(20.0, 1.0, 0.5);
        assert!((held.at[0] - 1.5).abs() < 1e-12 && held.at[1] == 0.0, "{held:?}");
        let last = course(1.0).target(99.0, 1.0, 0.5);
        assert_eq!((last.at, last.heading), ([4.0, 2.0], std::f64::consts::FRAC_PI_2));
        assert!(course(0.95).is_reached([4.0, 1.9], 0.2, 0.5) && !course(0.5).is_reached([4.0, 1.9], 0.2, 0.5));
        let stands = Course { points: &WAY[..1], heading: 2.0, ..course(1.0) };
        assert_eq!(stands.target(15.0, 1.0, 0.5), GroundPose { at: [0.0, 0.0], heading: 2.0 });
    }

    /// The first leg takes 2 s, and the second one 8 s.
    #[test]
    fn the_target_of_a_way_with_times_is_ahead_in_time() {
        let timed = Course { times: &[10.0, 12.0, 20.0], ..course(1.0) };
        assert_eq!(timed.target(11.0, 0.0, 9.0).at, [2.0, 0.0]);
        assert_eq!(timed.target(11.0, 5.0, 9.0).at, [4.0, 1.0]);
        assert_eq!((timed.target(9.0, 0.0, 9.0).at, timed.target(30.0, 0.0, 9.0).at), ([0.0, 0.0], [4.0, 2.0]));
    }

    proptest! {
        /// Against the nearest of many points of the part that is ahead.
        #[test]
        fn a_base_covers_what_it_is_nearest_to(share in 0.0..1.0_f64, x in -1.0..5.0_f64, y in -1.0..3.0_f64, reach in 0.1..2.0_f64) {
            let found = covered(&WAY, share, [x, y], reach);
            prop_assert!((share..=1.0).contains(&found) && found - share <= reach / 6.0 + 1e-9);
            let point = |s: f64| if s <= 4.0 { [s, 0.0] } else { [4.0, s - 4.0] };
            let off = |share: f64| distance(point(6.0 * share), [x, y]);
            let least = (0..=2000).map(|i| share + (reach / 6.0).min(1.0 - share) * f64::from(i) / 2000.0).map(off).fold(f64::INFINITY, f64::min);
            prop_assert!(off(found) <= least + 1e-9, "{} {least}", off(found));
        }
    }
}
