//! What a formula is worth at a tick: a robustness and the instant that it comes from, or an interval of these.
//!
//! Values are totally ordered, `and` is the smaller of two, `or` the larger. The order is that of the numbers, with -0
//! below +0, so that the sign alone says whether something is true, zero included, and `not` exchanges the two exactly.
//! Among equal numbers the earlier instant is the stronger: the larger of two that are true, the smaller of two that are
//! false. `not` thus reverses the order, ties included, and every law of a distributive lattice with such a `not`
//! (De Morgan's) holds for numbers *and* instants: whichever way a formula is computed, the instant is the same.
//!
//! Intervals: what ticks that are not there could still make of a formula. Deshmukh et al., *Robust online monitoring of
//! signal temporal logic*, 2017.

use std::cmp::Ordering;

/// A robustness and where it comes from.
#[derive(Clone, Copy, Debug)]
pub struct Value {
    /// How far from the other truth value; true where the sign is positive. Never NaN.
    pub robustness: f64,
    /// The tick that decides it.
    pub tick: u32,
}

impl Value {
    /// The largest: neutral for `and`.
    pub const TOP: Value = Value { robustness: f64::INFINITY, tick: 0 };
    /// The smallest: neutral for `or`.
    pub const BOTTOM: Value = Value { robustness: f64::NEG_INFINITY, tick: 0 };

    /// The value of a signal at a tick. Zero is true whatever its sign; NaN is false, by minus infinity.
    pub fn of_signal(x: f64, tick: u32) -> Value {
        // -0 + 0 is +0.
        Value { robustness: if x.is_nan() { f64::NEG_INFINITY } else { x + 0.0 }, tick }
    }

    /// True where the sign is positive.
    pub fn is_true(self) -> bool {
        self.robustness.is_sign_positive()
    }

    /// The negation, of the same instant.
    pub fn negated(self) -> Value {
        Value { robustness: -self.robustness, tick: self.tick }
    }

    /// The truth value alone: plus or minus infinity.
    pub fn truth(self) -> Value {
        Value { robustness: f64::INFINITY.copysign(self.robustness), tick: self.tick }
    }
}

impl Ord for Value {
    fn cmp(&self, other: &Value) -> Ordering {
        self.robustness.total_cmp(&other.robustness).then_with(|| {
            let later = self.tick.cmp(&other.tick);
            if self.is_true() { later.reverse() } else { later }
        })
    }
}

impl PartialOrd for Value {
    fn partial_cmp(&self, other: &Value) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Value {
    fn eq(&self, other: &Value) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Value {}

/// All that the value may be, whatever follows: it is exact where both ends are equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interval {
    /// The worst that may become of it.
    pub lower: Value,
    /// The best that may become of it.
    pub upper: Value,
}

impl Interval {
    /// True: neutral for `and`.
    pub const TRUE: Interval = Interval::exact(Value::TOP);
    /// False: neutral for `or`.
    pub const FALSE: Interval = Interval::exact(Value::BOTTOM);

    /// One value.
    pub const fn exact(value: Value) -> Interval {
        Interval { lower: value, upper: value }
    }

    /// Nothing is known; `tick` is the first that was not seen.
    pub const fn unknown(tick: u32) -> Interval {
        Interval {
            lower: Value { robustness: f64::NEG_INFINITY, tick },
            upper: Value { robustness: f64::INFINITY, tick },
        }
    }

    /// Both: the smaller ends.
    pub fn and(self, other: Interval) -> Interval {
        Interval { lower: self.lower.min(other.lower), upper: self.upper.min(other.upper) }
    }

    /// Either: the larger ends.
    pub fn or(self, other: Interval) -> Interval {
        Interval { lower: self.lower.max(other.lower), upper: self.upper.max(other.upper) }
    }

    /// The negation.
    pub fn negated(self) -> Interval {
        Interval { lower: self.upper.negated(), upper: self.lower.negated() }
    }

    /// The same, known at `tick` at the earliest.
    pub fn known_from(self, tick: u32) -> Interval {
        let later = |v: Value| Value { robustness: v.robustness, tick: v.tick.max(tick) };
        Interval { lower: later(self.lower), upper: later(self.upper) }
    }

    /// The truth values alone.
    pub fn truth(self) -> Interval {
        Interval { lower: self.lower.truth(), upper: self.upper.truth() }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::Value;

    fn value() -> impl Strategy<Value = Value> {
        let number =
            prop_oneof![(-2_i32..=2).prop_map(f64::from), Just(-0.0), Just(f64::INFINITY), Just(-f64::INFINITY)];
        (number, 0_u32..4).prop_map(|(robustness, tick)| Value { robustness, tick })
    }

    proptest! {
        #[test]
        fn the_order_is_reversed_by_not(a in value(), b in value()) {
            prop_assert_eq!(a.cmp(&b), b.negated().cmp(&a.negated()));
            prop_assert_eq!(a == b, a.robustness.to_bits() == b.robustness.to_bits() && a.tick == b.tick);
        }

        #[test]
        fn the_order_is_one(a in value(), b in value(), c in value()) {
            prop_assert!(!(a <= b && b <= c) || a <= c);
            prop_assert_eq!(a.max(b.min(c)), a.max(b).min(a.max(c)));
            prop_assert_eq!(a.max(a.min(b)), a);
            prop_assert!(a <= Value::TOP && a >= Value::BOTTOM);
        }

        #[test]
        fn the_sign_is_the_truth(x in -1.0..1.0_f64, y in prop_oneof![Just(0.0), Just(-0.0), Just(1.0), Just(-1.0)]) {
            prop_assert_eq!(Value::of_signal(x * y, 0).is_true(), x * y >= 0.0);
            prop_assert_eq!(Value::of_signal(x * y, 0).negated().is_true(), x * y < 0.0);
        }
    }

    #[test]
    fn no_number_is_false() {
        assert_eq!(Value::of_signal(f64::NAN, 3), Value { robustness: f64::NEG_INFINITY, tick: 3 });
    }
}
