//! Serde of numbers that may be infinite: text formats use `"inf"` and `"-inf"`, because JSON has no infinite numbers.

use std::fmt;

use serde::de::{Error, Visitor};
use serde::{Deserializer, Serializer};

/// Serialises a number; infinities as text.
pub(crate) fn serialize<S: Serializer>(x: &f64, s: S) -> Result<S::Ok, S::Error> {
    if x.is_finite() || !s.is_human_readable() {
        s.serialize_f64(*x)
    } else if *x > 0.0 {
        s.serialize_str("inf")
    } else if *x < 0.0 {
        s.serialize_str("-inf")
    } else {
        Err(serde::ser::Error::custom("not a number"))
    }
}

/// Deserialises the output of [`serialize`]; NaN is an error.
pub(crate) fn deserialize<'de, D: Deserializer<'de>>(d: D) -> Result<f64, D::Error> {
    let x = if d.is_human_readable() { d.deserialize_any(Limit)? } else { d.deserialize_f64(Limit)? };
    if x.is_nan() { Err(Error::custom("not a number")) } else { Ok(x) }
}

/// Returns infinity (no limit): the default for files of older versions.
pub(crate) fn none() -> f64 {
    f64::INFINITY
}

struct Limit;

impl Visitor<'_> for Limit {
    type Value = f64;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number, \"inf\" or \"-inf\"")
    }

    fn visit_f64<E: Error>(self, x: f64) -> Result<f64, E> {
        Ok(x)
    }

    fn visit_i64<E: Error>(self, x: i64) -> Result<f64, E> {
        Ok(x as f64)
    }

    fn visit_u64<E: Error>(self, x: u64) -> Result<f64, E> {
        Ok(x as f64)
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<f64, E> {
        match text {
            "inf" => Ok(f64::INFINITY),
            "-inf" => Ok(f64::NEG_INFINITY),
            _ => Err(E::invalid_value(serde::de::Unexpected::Str(text), &self)),
        }
    }
}
