//! Value of a formula at a tick: a robustness and the instant that determines it, or an interval of these.
//!
//! Values are totally ordered, `and` is the smaller of two, `or` the larger. The order is that of the numbers, with -0
//! below +0. The sign alone therefore decides whether a value is true, zero included, and `not` exchanges the two
//! exactly. Among equal numbers the earlier instant is the stronger: the larger of two that are true, the smaller of
//! two that are false. `not` thus reverses the order, ties included, and every law of a distributive lattice with such
//! a `not` (De Morgan's) holds for numbers *and* instants: the instant does not depend on how a formula is computed.
//!
//! An interval contains the values that a formula can still take, depending on ticks that are missing. Deshmukh et al.,
//! *Robust online monitoring of signal temporal logic*, 2017.

/// A robustness and the instant that determines it.
///
/// Stored as one integer that has the order of values. The bits above the lowest 32 are those of the number in the
/// order of [`f64::total_cmp`]. The lowest 32 are the tick, complemented if the number is positive. Inverting all bits
/// is then `not`, and no comparison needs a branch.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Value(i128);

impl Value {
    /// Largest value: neutral for `and`.
    pub const TOP: Value = Value::new(f64::INFINITY, 0);
    /// Smallest value: neutral for `or`.
    pub const BOTTOM: Value = Value::new(f64::NEG_INFINITY, 0);

    /// Creates a value from a robustness, which is not NaN, and its instant.
    pub const fn new(robustness: f64, tick: u32) -> Value {
        let bits = robustness.to_bits() as i64;
        let (number, time) = if bits >= 0 { (bits, !tick) } else { (bits ^ i64::MAX, tick) };
        Value((number as i128) << 32 | time as i128)
    }

    /// Value of a signal at a tick. Zero is true whatever its sign; NaN is false, as minus infinity.
    pub fn of_signal(x: f64, tick: u32) -> Value {
        // -0 + 0 is +0.
        Value::new(if x.is_nan() { f64::NEG_INFINITY } else { x + 0.0 }, tick)
    }

    /// Distance from the other truth value; its sign is positive if the value is true.
    pub fn robustness(self) -> f64 {
        let number = (self.0 >> 32) as i64;
        f64::from_bits(if number >= 0 { number } else { number ^ i64::MAX } as u64)
    }

    /// Tick that determines the value.
    pub fn tick(self) -> u32 {
        let time = self.0 as u32;
        if self.is_true() { !time } else { time }
    }

    /// Returns true if the sign is positive.
    pub fn is_true(self) -> bool {
        self.0 >= 0
    }

    /// Negation, with the same instant.
    pub fn negated(self) -> Value {
        Value(!self.0)
    }

    /// Truth value alone: plus or minus infinity.
    pub fn truth(self) -> Value {
        Value::new(if self.is_true() { f64::INFINITY } else { f64::NEG_INFINITY }, self.tick())
    }
}

impl std::fmt::Debug for Value {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:?} at tick {}", self.robustness(), self.tick())
    }
}

/// Range of the values that are still possible; it is exact if both ends are equal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interval {
    /// Smallest value that is possible.
    pub lower: Value,
    /// Largest value that is possible.
    pub upper: Value,
}

impl Interval {
    /// True: neutral for `and`.
    pub const TRUE: Interval = Interval::exact(Value::TOP);
    /// False: neutral for `or`.
    pub const FALSE: Interval = Interval::exact(Value::BOTTOM);

    /// Interval of a single value.
    pub const fn exact(value: Value) -> Interval {
        Interval { lower: value, upper: value }
    }

    /// Unknown value; `tick` is the first tick that was not seen.
    pub const fn unknown(tick: u32) -> Interval {
        Interval { lower: Value::new(f64::NEG_INFINITY, tick), upper: Value::new(f64::INFINITY, tick) }
    }

    /// Conjunction: the smaller ends.
    pub fn and(self, other: Interval) -> Interval {
        Interval { lower: self.lower.min(other.lower), upper: self.upper.min(other.upper) }
    }

    /// Disjunction: the larger ends.
    pub fn or(self, other: Interval) -> Interval {
        Interval { lower: self.lower.max(other.lower), upper: self.upper.max(other.upper) }
    }

    /// Negation.
    pub fn negated(self) -> Interval {
        Interval { lower: self.upper.negated(), upper: self.lower.negated() }
    }

    /// Same robustness, dated at `tick` or later.
    pub fn known_from(self, tick: u32) -> Interval {
        let later = |v: Value| Value::new(v.robustness(), v.tick().max(tick));
        Interval { lower: later(self.lower), upper: later(self.upper) }
    }

    /// Truth values of both ends.
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
        let tick = prop_oneof![0_u32..4, Just(u32::MAX)];
        (number, tick).prop_map(|(robustness, tick)| Value::new(robustness, tick))
    }

    proptest! {
        #[test]
        fn the_order_is_reversed_by_not(a in value(), b in value()) {
            prop_assert_eq!(a.cmp(&b), b.negated().cmp(&a.negated()));
            // Numbers first; of equal numbers the earlier instant is stronger.
            let ticks = if a.is_true() { b.tick().cmp(&a.tick()) } else { a.tick().cmp(&b.tick()) };
            prop_assert_eq!(a.cmp(&b), a.robustness().total_cmp(&b.robustness()).then(ticks));
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
    fn what_is_put_in_comes_out() {
        for x in [0.0, -0.0, 1.5, -1.5, f64::INFINITY, f64::NEG_INFINITY, 5e-324] {
            for tick in [0, 1, u32::MAX] {
                for (value, x) in [(Value::new(x, tick), x), (Value::new(x, tick).negated(), -x)] {
                    assert_eq!((value.robustness().to_bits(), value.tick()), (x.to_bits(), tick));
                    assert_eq!(value.is_true(), x.is_sign_positive());
                }
            }
        }
        assert_eq!(Value::of_signal(f64::NAN, 3), Value::new(f64::NEG_INFINITY, 3));
    }
}
