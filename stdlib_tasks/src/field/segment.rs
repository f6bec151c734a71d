//! Mean distance between a point and a segment, exactly, with its gradient.
//!
//! With the ends `a`, `b` relative to the point, `S = |a| + |b|`, and in lengths of `S`: the middle
//! `m = (a + b) / (2 S)`, the direction `d = (b - a) / S`, `z = |d| <= 1`, and the part `p` of `m` perpendicular to
//! `d`:
//!
//! ```text
//! mean  int_0^1 |a + s (b - a)| ds = S (1/4 + |m|^2 + |p|^2 z^2 B)       B = (atanh(z) / z - 1) / z^2
//! g_0   int_0^1 u ds               = 2 (m + p z^2 B)                     u the unit vector from the point
//! g_1   int_0^1 (s - 1/2) u ds     = d (1/4 - x^2 - |p|^2 B) - 2 x z B p     x the part of m along d
//! ```
//!
//! and the gradients in `b`, `a` are `g_0 / 2 +- g_1`. This is thesis (4.2) for `chi = d`, with the potential of a rod,
//! `int dx / r = 2 atanh(L / (r_0 + r_1))`, instead of two logarithms. It needs no special case for a point on the
//! line, behind an end or far away, and a short segment becomes a point by the series of `B`. A point ON the segment
//! has `z = 1`, `p = 0`; `B` grows like a logarithm there, and `p B` vanishes.

use nalgebra::Vector3;

/// Mean along a segment, and its gradient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean {
    /// The mean, in the unit of the function.
    pub value: f64,
    /// Its gradient in the segment's start, per m.
    pub start: Vector3<f64>,
    /// Its gradient in the segment's end, per m.
    pub end: Vector3<f64>,
}

impl Mean {
    /// Zero with a zero gradient.
    pub const ZERO: Mean = Mean { value: 0.0, start: Vector3::new(0.0, 0.0, 0.0), end: Vector3::new(0.0, 0.0, 0.0) };

    /// Gradient in the point, per m: moving all three together changes nothing.
    pub fn point(&self) -> Vector3<f64> {
        -(self.start + self.end)
    }

    /// Mean of the distance to a point if both ends coincide.
    fn of_point(a: &Vector3<f64>, r: f64) -> Mean {
        let half = if r > 0.0 { a * (0.5 / r) } else { Vector3::zeros() };
        Mean { value: r, start: half, end: half }
    }
}

/// Mean distance \[m\] along the segment from `a` to `b`, both relative to the point. Finite for all ends shorter than
/// about 1e150 m. If the distance has no gradient, at a point-like segment at the point itself, zero is used.
pub fn mean_distance(a: &Vector3<f64>, b: &Vector3<f64>) -> Mean {
    let (ra, rb) = (a.norm(), b.norm());
    let sum = ra + rb;
    if sum <= 0.0 {
        return Mean::of_point(a, 0.0);
    }
    let (m, d) = ((a + b) * (0.5 / sum), (b - a) / sum);
    let length = d.norm();
    if length <= 0.0 {
        return Mean::of_point(a, ra);
    }
    // Rounding may make z 1 or more if the point is on the segment; p is as small there.
    let z = length.min(1.0 - f64::EPSILON);
    let e = d / length;
    let x = m.dot(&e);
    let p = m - e * x;
    let (bz, p2) = (rod(z), p.norm_squared());
    let g0 = m + p * (z * z * bz);
    let g1 = d * (0.25 - x * x - p2 * bz) - p * (2.0 * x * z * bz);
    Mean { value: sum * (0.25 + m.norm_squared() + p2 * z * z * bz), start: g0 - g1, end: g0 + g1 }
}

/// `(atanh(z) / z - 1) / z^2 = 1/3 + z^2/5 + z^4/7 + ..` for z in [0, 1).
fn rod(z: f64) -> f64 {
    let z2 = z * z;
    if z < 0.25 {
        // 13 terms: the next is below 1e-17.
        return (0..13).rev().fold(0.0, |sum, k| sum * z2 + 1.0 / f64::from(2 * k + 3));
    }
    (z.atanh() / z - 1.0) / z2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::adaptive::adaptive;
    use crate::field::testing::vector;
    use proptest::prelude::*;

    /// Reference by quadrature, in lengths of the problem's own size.
    fn oracle(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
        let size = a.norm() + b.norm();
        let (a, d) = (a / size, (b - a) / size);
        let n = d.norm_squared();
        let foot = if n > 0.0 { (-a.dot(&d) / n).clamp(0.0, 1.0) } else { 0.0 };
        let f = |s: f64| (a + d * s).norm();
        size * (adaptive(&f, 0.0, foot) + adaptive(&f, foot, 1.0))
    }

    fn check(a: Vector3<f64>, b: Vector3<f64>) {
        let mean = mean_distance(&a, &b);
        let size = 1e-12 + a.norm() + b.norm();
        let expected = oracle(&a, &b);
        assert!((mean.value - expected).abs() < 1e-10 * size, "{} {expected} {a} {b}", mean.value);
        let step = 1e-5 * size;
        for i in 0..3 {
            let mut e = Vector3::zeros();
            e[i] = step;
            let slope = |f: &dyn Fn(f64) -> f64| (f(1.0) - f(-1.0)) / (2.0 * step);
            let start = slope(&|k| mean_distance(&(a + e * k), &b).value);
            let end = slope(&|k| mean_distance(&a, &(b + e * k)).value);
            assert!((mean.start[i] - start).abs() < 2e-4, "start {} {start} {a} {b}", mean.start[i]);
            assert!((mean.end[i] - end).abs() < 2e-4, "end {} {end} {a} {b}", mean.end[i]);
        }
        assert!(mean.point().norm() <= 1.0 + 1e-12, "the distance is Lipschitz with 1");
    }

    #[test]
    fn known_values() {
        // A point at the middle of a segment of 2 m: 0.5 m on average; at its end: 1 m; 3 m beyond its end: 4 m.
        let x = Vector3::x();
        assert!((mean_distance(&-x, &x).value - 0.5).abs() < 1e-15);
        assert!((mean_distance(&Vector3::zeros(), &(x * 2.0)).value - 1.0).abs() < 1e-15);
        assert!((mean_distance(&(x * 3.0), &(x * 5.0)).value - 4.0).abs() < 1e-15);
        // Beside the end of a unit segment, 1 m across: (sqrt 2 + asinh 1) / 2.
        let beside = mean_distance(&Vector3::y(), &(Vector3::y() + x)).value;
        assert!((beside - 0.5 * (2f64.sqrt() + 1f64.asinh())).abs() < 1e-15);
    }

    #[test]
    fn special_places_are_finite_and_right() {
        let x = Vector3::x();
        let y = Vector3::y();
        for (a, b) in [
            (-x, x * 0.3),
            (-x, x * 0.3 + y * 1e-9),
            (-x + y * 1e-13, x * 0.3 + y * 1e-13),
            (x * 1e-12 - y * 1e-14, x * 2e-12),
            (x * 5.0, x * 5.0 + y * 1e-9),
            (x * 5.0, x * 5.0 + x * 1e-13),
            (x * 1e9, x * 1e9 + y),
            (x, x),
        ] {
            check(a, b);
        }
        let at = mean_distance(&Vector3::zeros(), &Vector3::zeros());
        assert_eq!(at, Mean::ZERO);
        for far in [1e20, 1e100, 1e150] {
            let mean = mean_distance(&(x * far), &(x * far + y));
            assert!((mean.value / far - 1.0).abs() < 1e-12 && (mean.point() + x).norm() < 1e-12);
        }
        for near in [1e-20, 1e-100, 1e-170, 1e-300] {
            let mean = mean_distance(&(y * near), &(x + y * near));
            assert!((mean.value - 0.5).abs() < 1e-12 && mean.start.norm() + mean.end.norm() < 3.0);
        }
    }

    proptest! {
        #[test]
        fn value_and_gradient(a in vector(2.0), b in vector(2.0), length in -8.0..0.0f64) {
            check(a, b);
            check(a, a + b * 10f64.powf(length));
        }

        #[test]
        fn near_the_segment(a in vector(1.0), b in vector(1.0), s in 0.05..0.95f64, away in -12.0..-1.0f64, n in vector(1.0)) {
            prop_assume!((b - a).norm() > 0.1);
            let point = a + (b - a) * s + n * 10f64.powf(away);
            let (a, b) = (a - point, b - point);
            let mean = mean_distance(&a, &b);
            prop_assert!((mean.value - oracle(&a, &b)).abs() < 1e-9);
            // The gradient compared with the integrals of unit vectors, each half separately.
            let d = b - a;
            let foot = (-a.dot(&d) / d.norm_squared()).clamp(0.0, 1.0);
            for i in 0..3 {
                let f = |s: f64| { let x = a + d * s; s * x[i] / x.norm().max(1e-300) };
                // A layer as thin as the distance itself: split it off.
                let thin = 1e-3f64.min(foot).min(1.0 - foot);
                let parts = [0.0, foot - thin, foot, foot + thin, 1.0];
                let expected: f64 = parts.windows(2).map(|w| adaptive(&f, w[0], w[1])).sum();
                prop_assert!((mean.end[i] - expected).abs() < 1e-6, "{} {expected}", mean.end[i]);
            }
        }
    }
}
