//! Physical dimensions: exponents of metre, kilogram, second and radian.
//!
//! The radian is kept as a dimension of its own, because confusing an angle with a length or with a bare number is
//! what goes wrong in practice; [`Dimension::accepts`] says where it may be left out.

use serde::{Deserialize, Serialize};

/// Exponents of the base units.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Dimension {
    /// Exponent of the metre.
    pub m: i8,
    /// Exponent of the kilogram.
    pub kg: i8,
    /// Exponent of the second.
    pub s: i8,
    /// Exponent of the radian.
    pub rad: i8,
}

const fn dimension(m: i8, kg: i8, s: i8, rad: i8) -> Dimension {
    Dimension { m, kg, s, rad }
}

/// A bare number.
pub const NONE: Dimension = dimension(0, 0, 0, 0);
/// Metre.
pub const LENGTH: Dimension = dimension(1, 0, 0, 0);
/// Radian.
pub const ANGLE: Dimension = dimension(0, 0, 0, 1);
/// Second.
pub const TIME: Dimension = dimension(0, 0, 1, 0);
/// Joule.
pub const ENERGY: Dimension = dimension(2, 1, -2, 0);
/// Kilogram second: time at work times the mass that is carried.
pub const WORKLOAD: Dimension = dimension(0, 1, 1, 0);
/// One over second.
pub const RATE: Dimension = dimension(0, 0, -1, 0);
/// Metre over second.
pub const VELOCITY: Dimension = dimension(1, 0, -1, 0);
/// Radian over second.
pub const ANGULAR_VELOCITY: Dimension = dimension(0, 0, -1, 1);
/// Metre over square second.
pub const ACCELERATION: Dimension = dimension(1, 0, -2, 0);
/// Radian over square second.
pub const ANGULAR_ACCELERATION: Dimension = dimension(0, 0, -2, 1);
/// Kilogram.
pub const MASS: Dimension = dimension(0, 1, 0, 0);
/// Kilogram times square metre.
pub const INERTIA: Dimension = dimension(2, 1, 0, 0);
/// Newton.
pub const FORCE: Dimension = dimension(1, 1, -2, 0);
/// Newton metre: a moment, and a moment per radian.
pub const MOMENT: Dimension = dimension(2, 1, -2, 0);
/// Newton over metre.
pub const STIFFNESS: Dimension = dimension(0, 1, -2, 0);
/// Newton second over metre.
pub const DAMPING: Dimension = dimension(0, 1, -1, 0);
/// Newton metre second, also per radian.
pub const ANGULAR_DAMPING: Dimension = dimension(2, 1, -1, 0);

/// Units that are better known by newtons than by base units.
const NEWTONS: &[(Dimension, &str)] =
    &[(FORCE, "N"), (MOMENT, "N m"), (STIFFNESS, "N/m"), (DAMPING, "N s/m"), (ANGULAR_DAMPING, "N m s")];

impl Dimension {
    /// The dimension of a product; `None` where an exponent leaves the range of an `i8`.
    pub fn times(self, other: Dimension) -> Option<Dimension> {
        Some(dimension(
            self.m.checked_add(other.m)?,
            self.kg.checked_add(other.kg)?,
            self.s.checked_add(other.s)?,
            self.rad.checked_add(other.rad)?,
        ))
    }

    /// The dimension of an integer power; `None` where an exponent leaves the range of an `i8`.
    pub fn power(self, exponent: i32) -> Option<Dimension> {
        let one = |x: i8| i8::try_from(i32::from(x).checked_mul(exponent)?).ok();
        Some(dimension(one(self.m)?, one(self.kg)?, one(self.s)?, one(self.rad)?))
    }

    /// True for a bare number or a plain angle.
    pub fn is_number(self) -> bool {
        self.m == 0 && self.kg == 0 && self.s == 0 && (self.rad == 0 || self.rad == 1)
    }

    /// True where a value of dimension `other` may stand for one of `self`: both are equal, or they differ in
    /// radians only and one of the two has none (an angle is a ratio of lengths, so `1/s` may stand for `rad/s`).
    pub fn accepts(self, other: Dimension) -> bool {
        self.m == other.m
            && self.kg == other.kg
            && self.s == other.s
            && (self.rad == other.rad || self.rad == 0 || other.rad == 0)
    }

    /// The dimension of a sum of both: that of the side which names radians.
    pub fn join(self, other: Dimension) -> Dimension {
        if self.rad == 0 { other } else { self }
    }

    /// Name in messages: "a length", "an angular velocity"; for dimensions without a name, the unit in words.
    pub fn describe(self) -> String {
        let known = [
            (NONE, "a bare number"),
            (LENGTH, "a length"),
            (ANGLE, "an angle"),
            (TIME, "a time"),
            (RATE, "a rate"),
            (VELOCITY, "a velocity"),
            (ANGULAR_VELOCITY, "an angular velocity"),
            (MASS, "a mass"),
            (ACCELERATION, "an acceleration"),
            (ANGULAR_ACCELERATION, "an angular acceleration"),
            (INERTIA, "a moment of inertia"),
            (FORCE, "a force"),
            (MOMENT, "a torque"),
            (STIFFNESS, "a stiffness"),
            (DAMPING, "a damping"),
            (ANGULAR_DAMPING, "an angular damping"),
            (dimension(2, 0, 0, 0), "an area"),
        ];
        match known.iter().find(|(d, _)| *d == self) {
            Some((_, name)) => (*name).to_string(),
            None => format!("a quantity in {self}"),
        }
    }
}

impl std::fmt::Display for Dimension {
    /// The SI unit, such as `m/s^2` or `N/m`; `1` for a bare number.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some((_, name)) = NEWTONS.iter().find(|n| n.0 == *self) {
            return f.write_str(name);
        }
        let parts = [(self.kg, "kg"), (self.m, "m"), (self.rad, "rad"), (self.s, "s")];
        let show = |e: i8, symbol: &str| {
            let e = i32::from(e).abs();
            if e == 1 { symbol.to_string() } else { format!("{symbol}^{e}") }
        };
        let over: Vec<String> = parts.iter().filter(|p| p.0 > 0).map(|p| show(p.0, p.1)).collect();
        let under: Vec<String> = parts.iter().filter(|p| p.0 < 0).map(|p| show(p.0, p.1)).collect();
        match (over.is_empty(), under.is_empty()) {
            (true, true) => write!(f, "1"),
            (false, true) => write!(f, "{}", over.join(" ")),
            (true, false) => write!(f, "1/{}", under.join("/")),
            (false, false) => write!(f, "{}/{}", over.join(" "), under.join("/")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_may_be_left_out_but_not_exchanged() {
        assert!(ANGULAR_VELOCITY.accepts(RATE));
        assert!(RATE.accepts(ANGULAR_VELOCITY));
        assert!(!LENGTH.accepts(ANGLE));
        assert!(!ANGLE.accepts(TIME));
    }

    #[test]
    fn units_read_well() {
        assert_eq!(VELOCITY.to_string(), "m/s");
        assert_eq!(RATE.to_string(), "1/s");
        assert_eq!(LENGTH.power(2).unwrap().times(MASS).unwrap().to_string(), "kg m^2");
        assert_eq!(FORCE.times(LENGTH).unwrap().to_string(), "N m");
        assert_eq!(STIFFNESS.times(TIME).unwrap().to_string(), "N s/m");
        assert_eq!(ACCELERATION.to_string(), "m/s^2");
        assert_eq!(LENGTH.power(200), None);
    }
}
