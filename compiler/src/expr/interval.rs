//! Interval arithmetic: bounds of the value of an operation, for all operands within their intervals.
//!
//! Source: Moore, Kearfott, Cloud, Introduction to Interval Analysis (2009), ch. 2 and 5. The ends are widened by more
//! than the rounding error.

use std::f64::consts::{FRAC_PI_2, PI};

use runtime::program::Op;

/// All numbers from `low` to `high`, both included; ends may be infinite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// Product with zero times infinity equal to zero: an infinite end means arbitrarily large, but finite numbers.
fn times(a: f64, b: f64) -> f64 {
    if a == 0.0 || b == 0.0 { 0.0 } else { a * b }
}

impl Interval {
    /// All numbers.
    pub const ALL: Interval = Interval { low: f64::NEG_INFINITY, high: f64::INFINITY };

    /// Interval from `low` to `high`; all numbers if the ends are NaN or in the wrong order.
    pub fn new(low: f64, high: f64) -> Self {
        if low <= high { Interval { low, high } } else { Interval::ALL }
    }

    /// Interval of one number.
    pub fn point(x: f64) -> Self {
        Interval::new(x, x)
    }

    /// Numbers of at most this absolute value.
    pub fn within(size: f64) -> Self {
        Interval::new(-size, size)
    }

    /// Intersection; `self` if rounding made the intervals disjoint.
    pub fn meet(self, other: Interval) -> Interval {
        let (low, high) = (self.low.max(other.low), self.high.min(other.high));
        if low <= high { Interval { low, high } } else { self }
    }

    /// Smallest interval that contains both.
    pub fn hull(self, other: Interval) -> Interval {
        Interval { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Distance between the two intervals; zero or negative if they overlap.
    pub fn gap(self, other: Interval) -> f64 {
        (self.low - other.high).max(other.low - self.high)
    }

    /// Largest absolute value.
    pub fn size(self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// Smallest absolute value.
    pub fn smallest(self) -> f64 {
        self.low.max(-self.high).max(0.0)
    }

    /// Interval of the sum.
    pub fn plus(self, other: Interval) -> Interval {
        Interval::new(self.low + other.low, self.high + other.high)
    }

    /// Interval of the negation.
    pub fn negated(self) -> Interval {
        Interval { low: -self.high, high: -self.low }
    }

    /// Interval of the product.
    pub fn by(self, other: Interval) -> Interval {
        let all = [
            times(self.low, other.low),
            times(self.low, other.high),
            times(self.high, other.low),
            times(self.high, other.high),
        ];
        Interval::new(all.into_iter().fold(f64::INFINITY, f64::min), all.into_iter().fold(f64::NEG_INFINITY, f64::max))
    }

    /// Interval of the inverse; all numbers if the interval contains zero.
    fn inverse(self) -> Interval {
        if self.low > 0.0 || self.high < 0.0 { Interval::new(1.0 / self.high, 1.0 / self.low) } else { Interval::ALL }
    }

    /// Image under a monotone, non-decreasing function.
    fn through(self, f: impl Fn(f64) -> f64) -> Interval {
        Interval::new(f(self.low), f(self.high))
    }

    fn sine(self) -> Interval {
        let turn = 2.0 * PI;
        if !(self.size() < 1e6 && self.high - self.low < turn) {
            return Interval::within(1.0);
        }
        // True if a number `at + k 2 pi` is inside, up to rounding.
        let meets = |at: f64| ((self.low - at) / turn - 1e-9).ceil() <= ((self.high - at) / turn + 1e-9).floor();
        let (a, b) = (self.low.sin(), self.high.sin());
        let high = if meets(FRAC_PI_2) { 1.0 } else { a.max(b) };
        let low = if meets(-FRAC_PI_2) { -1.0 } else { a.min(b) };
        Interval::new(low, high)
    }

    fn power(self, n: i32) -> Interval {
        if n < 0 {
            return self.power(n.saturating_neg()).inverse();
        }
        if n % 2 == 0 {
            Interval::new(self.smallest().powi(n), self.size().powi(n))
        } else {
            self.through(|x| x.powi(n))
        }
    }

    /// Interval widened by more than the rounding error.
    fn outward(self) -> Interval {
        let out = |x: f64| if x.is_finite() { 4.0 * f64::EPSILON * x.abs() } else { 0.0 };
        Interval { low: self.low - out(self.low), high: self.high + out(self.high) }
    }

    /// Interval of a truth value: true, false, or either.
    fn truth(yes: bool, no: bool) -> Interval {
        match (yes, no) {
            (true, _) => Interval::point(1.0),
            (_, true) => Interval::point(-1.0),
            _ => Interval::within(1.0),
        }
    }

    /// Interval of an operation, from those of its operands (`r`) and of values from outside of the graph (`leaf`).
    /// Undefined values (the root of a negative number) are ignored, because the controller stops there.
    pub fn of(op: Op, r: impl Fn(usize) -> Interval, leaf: impl Fn(Op) -> Interval) -> Interval {
        let found = match op {
            Op::Const(x) => return Interval::point(x),
            Op::T | Op::Time | Op::Input(_) | Op::State(_) | Op::Signal(_) | Op::Trajectory(_) => return leaf(op),
            Op::Less(a, b) => return Interval::truth(r(a).high < r(b).low, r(a).low >= r(b).high),
            Op::LessEqual(a, b) => return Interval::truth(r(a).high <= r(b).low, r(a).low > r(b).high),
            Op::Neg(a) => return r(a).negated(),
            Op::Min(a, b) => return Interval { low: r(a).low.min(r(b).low), high: r(a).high.min(r(b).high) },
            Op::Max(a, b) => return Interval { low: r(a).low.max(r(b).low), high: r(a).high.max(r(b).high) },
            Op::Abs(a) => return Interval::new(r(a).smallest(), r(a).size()),
            Op::Select(test, b, c) => {
                return match r(test) {
                    t if t.low >= 0.0 => r(b),
                    t if t.high < 0.0 => r(c),
                    _ => r(b).hull(r(c)),
                };
            }
            Op::Sub(a, b) if a == b => return Interval::point(0.0),
            Op::Mul(a, b) if a == b => r(a).power(2),
            Op::Add(a, b) => r(a).plus(r(b)),
            Op::Sub(a, b) => r(a).plus(r(b).negated()),
            Op::Mul(a, b) => r(a).by(r(b)),
            Op::Div(a, b) => r(a).by(r(b).inverse()),
            Op::Sin(a) => r(a).sine(),
            Op::Cos(a) => r(a).plus(Interval::point(FRAC_PI_2)).sine(),
            Op::Asin(a) => r(a).through(|x| x.clamp(-1.0, 1.0).asin()),
            Op::Acos(a) => r(a).negated().through(|x| (-x).clamp(-1.0, 1.0).acos()),
            Op::Atan2(_, x) if r(x).low >= 0.0 => Interval::within(FRAC_PI_2),
            Op::Atan2(..) => Interval::within(PI),
            Op::Exp(a) => r(a).through(f64::exp),
            Op::Log(a) => r(a).through(|x| x.max(0.0).ln()),
            Op::Sqrt(a) => r(a).through(|x| x.max(0.0).sqrt()),
            Op::Powi(a, n) => r(a).power(n),
        };
        found.outward()
    }
}
