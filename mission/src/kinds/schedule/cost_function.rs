//! Minimum cost of reaching a state by an instant: a convex, non-increasing function of that instant.
//!
//! The function is piecewise linear, with the steepest pieces first, and constant after the last one. A leg of variable
//! duration is an infimal convolution, which for such functions merges their pieces by slope.

use super::instance::Way;

/// A convex, non-increasing, piecewise linear function. It is infinite before its start.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Curve {
    /// Earliest possible instant (s).
    pub start: f64,
    /// Value at the start.
    value: f64,
    /// Negative slopes in ascending order, each with the length of its piece (s), more than 0.
    pieces: Vec<(f64, f64)>,
}

impl Curve {
    /// A function that is constant from an instant on.
    pub fn step(start: f64, value: f64) -> Curve {
        Curve { start, value, pieces: Vec::new() }
    }

    /// Lower bound on the energy of a leg as a function of its duration, from `tangents` + 1 tangents at durations in a
    /// geometric sequence from the shortest to the cheapest. Longer durations are never better, since waiting costs no
    /// energy.
    pub fn of_way(way: &Way, tangents: usize) -> Curve {
        let last = way.cheapest();
        let mut curve = Curve::step(way.low, way.cost(way.low));
        if last <= way.low || way.bend <= 0.0 {
            return curve;
        }
        let tangents = tangents.max(1);
        let point = |k: usize| way.low * (last / way.low).powf(k as f64 / tangents as f64);
        let mut from = way.low;
        for k in 0..=tangents {
            let here = point(k);
            // Two tangents of `b / D` intersect at the harmonic mean of their points of contact.
            let to = if k < tangents { 2.0 / (1.0 / here + 1.0 / point(k + 1)) } else { last };
            curve.push(way.rate - way.bend / (here * here), to - from);
            from = to;
        }
        curve
    }

    fn push(&mut self, slope: f64, length: f64) {
        if slope < 0.0 && length > 0.0 {
            self.pieces.push((slope, length));
        }
    }

    /// Returns the number of pieces.
    pub fn pieces(&self) -> usize {
        self.pieces.len()
    }

    /// Returns the value at an instant that is not before the start.
    pub fn at(&self, instant: f64) -> f64 {
        let (mut value, mut left) = (self.value, instant - self.start);
        for &(slope, length) in &self.pieces {
            value += slope * length.min(left);
            left -= length;
            if left <= 0.0 {
                break;
            }
        }
        value
    }

    /// Returns an evaluator for ascending instants.
    pub fn along(&self) -> Along<'_> {
        Along { rest: &self.pieces, from: self.start, value: self.value }
    }

    /// Shifts the function by `time` to later instants, and by `cost` to higher values.
    pub fn moved(mut self, time: f64, cost: f64) -> Curve {
        self.start += time;
        self.value += cost;
        self
    }

    /// Infimal convolution: first this, then a duration whose cost is `way`.
    pub fn then(&self, way: &Curve) -> Curve {
        let mut pieces = Vec::with_capacity(self.pieces.len() + way.pieces.len());
        let (mut a, mut b) = (self.pieces.iter().peekable(), way.pieces.iter().peekable());
        loop {
            let first = match (a.peek(), b.peek()) {
                (Some(x), Some(y)) => x.0 <= y.0,
                (Some(_), None) => true,
                (None, Some(_)) => false,
                (None, None) => break,
            };
            pieces.extend(if first { a.next() } else { b.next() });
        }
        Curve { start: self.start + way.start, value: self.value + way.value, pieces }
    }

    /// Minimum cost of having started by an instant, if the start is possible from `release` on and after this
    /// function's state is reached, and each second of the start costs `rate`, zero or more.
    pub fn started(&self, release: f64, rate: f64) -> Curve {
        let start = self.start.max(release);
        let mut curve = Curve::step(start, self.at(start) + rate * start);
        let mut passed = start - self.start;
        for &(slope, length) in &self.pieces {
            let left = length - passed;
            passed = (passed - length).max(0.0);
            if slope + rate >= 0.0 {
                break;
            }
            curve.push(slope + rate, left);
        }
        curve
    }

    /// As [`Curve::started`] for a function of minus the instant, which is the cost of the remaining jobs: the start
    /// follows the instant immediately, but not before `release`, and each second of it costs `rate`, zero or more.
    /// `None` if `release` is too late.
    pub fn held(&self, release: f64, rate: f64) -> Option<Curve> {
        if -release < self.start {
            return None;
        }
        let mut curve = Curve::step(self.start, self.value - rate * self.start);
        let mut left = -release - self.start;
        for &(slope, length) in &self.pieces {
            curve.push(slope - rate, length.min(left));
            left = (left - length).max(0.0);
        }
        curve.push(-rate, left);
        Some(curve)
    }

    /// A function that falls at this rate for this length, and then is constant.
    pub fn falling(start: f64, value: f64, rate: f64, length: f64) -> Curve {
        let mut curve = Curve::step(start, value);
        curve.push(-rate, length);
        curve
    }

    /// Returns the sum of both functions.
    pub fn with(&self, other: &Curve) -> Curve {
        let start = self.start.max(other.start);
        let mut curve = Curve::step(start, self.at(start) + other.at(start));
        let (mut a, mut b) = (Cursor::new(self, start), Cursor::new(other, start));
        loop {
            let length = a.left.min(b.left);
            if length == f64::INFINITY {
                return curve;
            }
            curve.push(a.slope + b.slope, length);
            a.pass(length);
            b.pass(length);
        }
    }

    /// Minimum over the instant of this function plus `rate` for each second of the later of the instant and `busy`.
    pub fn least(&self, rate: f64, busy: f64) -> f64 {
        let (mut instant, mut value) = (self.start, self.value);
        for &(slope, length) in &self.pieces {
            if slope + rate >= 0.0 && instant >= busy {
                break;
            }
            let step = if slope + rate < 0.0 { length } else { length.min(busy - instant) };
            instant += step;
            value += slope * step;
        }
        value + rate * instant.max(busy)
    }

    /// Returns true if this function nowhere exceeds the other one.
    pub fn beats(&self, other: &Curve) -> bool {
        if self.start > other.start {
            return false;
        }
        let mut over = self.at(other.start) - other.value;
        let (mut a, mut b) = (Cursor::new(self, other.start), Cursor::new(other, other.start));
        while over <= 0.0 {
            let length = a.left.min(b.left);
            if length == f64::INFINITY {
                return true;
            }
            over += (a.slope - b.slope) * length;
            a.pass(length);
            b.pass(length);
        }
        false
    }
}

/// Evaluates a curve at ascending instants.
pub(crate) struct Along<'a> {
    rest: &'a [(f64, f64)],
    from: f64,
    value: f64,
}

impl Along<'_> {
    /// Returns the value at an instant that is before neither the start nor the previous instant.
    pub fn at(&mut self, instant: f64) -> f64 {
        while let Some(((slope, length), rest)) = self.rest.split_first() {
            if instant < self.from + length {
                return self.value + slope * (instant - self.from);
            }
            (self.rest, self.from, self.value) = (rest, self.from + length, self.value + slope * length);
        }
        self.value
    }

    /// Returns true if the value is the same at all later instants.
    pub fn is_flat(&self) -> bool {
        self.rest.is_empty()
    }
}

/// A position on a curve.
struct Cursor<'a> {
    rest: std::slice::Iter<'a, (f64, f64)>,
    slope: f64,
    left: f64,
}

impl<'a> Cursor<'a> {
    /// Creates a cursor at an instant that is not before the start of the curve.
    fn new(curve: &'a Curve, instant: f64) -> Cursor<'a> {
        let mut cursor = Cursor { rest: curve.pieces.iter(), slope: 0.0, left: 0.0 };
        cursor.next();
        let mut passed = instant - curve.start;
        while cursor.left <= passed {
            passed -= cursor.left;
            cursor.next();
        }
        cursor.left -= passed;
        cursor
    }

    fn next(&mut self) {
        (self.slope, self.left) = self.rest.next().copied().unwrap_or((0.0, f64::INFINITY));
    }

    fn pass(&mut self, length: f64) {
        self.left -= length;
        if self.left <= 0.0 {
            self.next();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn way(low: f64, high: f64, rate: f64, bend: f64) -> Way {
        Way { length: 1.0, weight: 1.0, low, high, rate, bend, constant: 0.3 }
    }

    fn curves() -> impl Strategy<Value = Curve> {
        let piece = (0.01..3.0_f64, 0.1..4.0_f64);
        (-3.0..3.0_f64, -1.0..1.0_f64, proptest::collection::vec(piece, 0..6)).prop_map(|(start, value, pieces)| {
            let mut pieces: Vec<(f64, f64)> = pieces.into_iter().map(|(slope, length)| (-slope, length)).collect();
            pieces.sort_by(|a, b| a.0.total_cmp(&b.0));
            Curve { start, value, pieces }
        })
    }

    /// Minimum of `f` on a grid of this step, from `from` to `to`.
    fn scan(from: f64, to: f64, step: f64, f: impl Fn(f64) -> f64) -> f64 {
        (0..=((to - from) / step) as usize).map(|k| f(from + k as f64 * step)).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn tangents_touch_from_below_and_close_in() {
        let way = way(2.0, 9.0, 1.0, 30.0);
        let mut worst = f64::INFINITY;
        for tangents in [2, 4, 8, 16] {
            let curve = Curve::of_way(&way, tangents);
            let mut gap = 0.0_f64;
            for k in 0..=100 {
                let time = way.low + (way.cheapest() - way.low) * k as f64 / 100.0;
                let under = way.cost(time) - curve.at(time);
                assert!(under > -1e-12, "{tangents} tangents at {time}: {under}");
                gap = gap.max(under);
            }
            assert!(gap < 0.4 * worst, "{tangents} tangents: {gap} after {worst}");
            worst = gap;
        }
    }

    #[test]
    fn a_way_of_one_duration_is_a_step() {
        let fixed = way(3.0, 3.0, 1.0, 5.0);
        assert_eq!(Curve::of_way(&fixed, 8), Curve::step(3.0, fixed.cost(3.0)));
    }

    proptest! {
        #[test]
        fn a_convolution_is_the_least_over_all_splits(a in curves(), b in curves(), more in 0.0..20.0_f64) {
            let both = a.then(&b);
            let instant = both.start + more;
            let split = |first: f64| a.at(first) + b.at(instant - first);
            let least = scan(a.start, instant - b.start, 1e-3, split);
            prop_assert!((both.at(instant) - least).abs() < 1e-2, "{} or {least}", both.at(instant));
            prop_assert!(both.at(instant) <= least + 1e-9);
        }

        #[test]
        fn a_start_is_the_least_over_all_instants(
            a in curves(), release in -3.0..9.0_f64, rate in 0.0..2.0_f64, more in 0.0..20.0_f64,
        ) {
            let started = a.started(release, rate);
            prop_assert_eq!(started.start, a.start.max(release));
            let instant = started.start + more;
            let least = scan(started.start, instant, 1e-3, |s| a.at(s) + rate * s);
            prop_assert!((started.at(instant) - least).abs() < 1e-2);
            prop_assert!(started.at(instant) <= least + 1e-9);
        }

        #[test]
        fn what_is_still_to_come_is_held_until_it_may_start(
            a in curves(), release in -20.0..9.0_f64, rate in 0.0..2.0_f64, more in 0.0..20.0_f64,
        ) {
            let Some(held) = a.held(release, rate) else { return Err(TestCaseError::reject("too late")) };
            prop_assert_eq!(held.start, a.start);
            // The robot is free at `-instant`, and starts then or at the release.
            let instant = a.start + more;
            let start = (-instant).max(release);
            prop_assert!((held.at(instant) - a.at(-start) - rate * start).abs() < 1e-9);
            let mut along = held.along();
            for step in 0..9 {
                let instant = a.start + more * f64::from(step) / 8.0;
                prop_assert!((along.at(instant) - held.at(instant)).abs() < 1e-9);
            }
        }

        #[test]
        fn a_sum_is_one_and_beats_says_what_it_does(a in curves(), b in curves(), more in 0.0..20.0_f64) {
            let both = a.with(&b);
            let instant = both.start + more;
            prop_assert!((both.at(instant) - a.at(instant) - b.at(instant)).abs() < 1e-9);
            let (from, to) = (b.start, b.start + 40.0);
            let over = a.start > b.start || scan(from, to, 1e-2, |s| b.at(s) - a.at(s)) < -1e-6;
            prop_assert!(!(a.beats(&b) && over));
            prop_assert!(a.beats(&b) || over || scan(from, to, 1e-3, |s| b.at(s) - a.at(s)) < 1e-1);
            prop_assert!(a.beats(&a));
        }

        #[test]
        fn the_least_with_an_end(a in curves(), rate in 0.0..2.0_f64, busy in -3.0..9.0_f64) {
            let least = scan(a.start, a.start + 40.0, 1e-3, |s| a.at(s) + rate * s.max(busy));
            prop_assert!((a.least(rate, busy) - least).abs() < 1e-2, "{} or {least}", a.least(rate, busy));
        }
    }
}
