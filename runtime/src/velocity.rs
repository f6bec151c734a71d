//! Velocity of a value of a task, computed from values a little before and a little after.

use nalgebra::{Quaternion, UnitQuaternion};
use stdlib_tasks::so3::log;

/// Time step before and after, in s.
pub(crate) const STEP: f64 = 1e-5;

/// Number of numbers in the velocity of a value of so many numbers.
pub(crate) fn width(value: usize) -> usize {
    match value {
        4 => 3,
        7 => 6,
        n => n,
    }
}

/// Computes the velocity between two values of 1 or 3 numbers, 4 of an orientation or 7 of a pose. Its unit is per s.
pub(crate) fn between(before: &[f64], after: &[f64], out: &mut [f64]) {
    let turning = if before.len() == 7 { 3 } else { 0 };
    if let (4 | 7, Some(a), Some(b)) = (before.len(), quaternion(&before[turning..]), quaternion(&after[turning..])) {
        let omega = log(&(b * a.inverse()));
        out.iter_mut().skip(turning).zip(&omega).for_each(|(x, w)| *x = w / (2.0 * STEP));
    }
    let plain = if before.len() == 4 { 0 } else { before.len().min(3) };
    for (x, (a, b)) in out.iter_mut().zip(before.iter().zip(after)).take(plain) {
        *x = (b - a) / (2.0 * STEP);
    }
}

fn quaternion(q: &[f64]) -> Option<UnitQuaternion<f64>> {
    let [w, i, j, k] = *q else { return None };
    UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 0.0)
}
