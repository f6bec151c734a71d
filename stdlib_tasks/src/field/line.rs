//! Mean of `chi(distance)` along a segment: thesis (4.2), (4.19).
//!
//! The distance itself is exact ([`mean_distance`]). A function without a closed form is split,
//!
//! ```text
//! chi(d) = chi(0) + chi'(0) d + rest(d)
//! ```
//!
//! where the linear part is exact. The rest starts with `d^2` and so has no kink if the point is on the segment; it is
//! integrated by 8 Gauss-Legendre nodes on each side of the point's foot. For [`Chi::Saturating`] with a reach not
//! below the length of the segment the error is below 1e-8 of the reach (tests), in the gradient below 1e-6.

use nalgebra::Vector3;

use crate::field::chi::Chi;
use crate::field::quadrature::GaussLegendre;
use crate::field::segment::{Mean, mean_distance};

/// Mean of `chi` of the distance along the segment from `a` to `b`, both relative to the point \[m\].
pub fn line_mean(chi: &Chi, rule: &GaussLegendre, a: &Vector3<f64>, b: &Vector3<f64>) -> Mean {
    match chi {
        Chi::Distance => mean_distance(a, b),
        Chi::Clamped { reach } => clamped(*reach, a, b),
        Chi::Saturating { .. } | Chi::Given(_) => integrated(chi, rule, a, b),
    }
}

/// `min(d, reach)`: the segment is cut at the sphere. `chi` is continuous there, so that the motion of the cuts does
/// not contribute to the gradient.
fn clamped(reach: f64, a: &Vector3<f64>, b: &Vector3<f64>) -> Mean {
    let out = Mean { value: reach, ..Mean::ZERO };
    let d = b - a;
    let n = d.norm_squared();
    if n <= 0.0 {
        return if a.norm() < reach { mean_distance(a, b) } else { out };
    }
    // |a + s d|^2 = n (s - s0)^2 + rho^2.
    let s0 = -a.dot(&d) / n;
    let rho2 = (a + d * s0).norm_squared();
    let half2 = (reach * reach - rho2) / n;
    if half2.is_nan() || half2 <= 0.0 {
        return out;
    }
    let half = half2.sqrt();
    let (from, to) = ((s0 - half).max(0.0), (s0 + half).min(1.0));
    let share = to - from;
    if share.is_nan() || share <= 0.0 {
        return out;
    }
    let inside = mean_distance(&(a + d * from), &(a + d * to));
    // A weight s on the whole segment is from + share t on the part.
    let sum = inside.start + inside.end;
    let end = (sum * from + inside.end * share) * share;
    Mean { value: inside.value * share + reach * (1.0 - share), start: sum * share - end, end }
}

fn integrated(chi: &Chi, rule: &GaussLegendre, a: &Vector3<f64>, b: &Vector3<f64>) -> Mean {
    let (zero, slope) = chi.evaluate(0.0);
    let linear = mean_distance(a, b);
    let d = b - a;
    let n = d.norm_squared();
    let mut mean = Mean { value: zero + slope * linear.value, start: linear.start * slope, end: linear.end * slope };
    let mut panel = |from: f64, to: f64| {
        for (s, w) in rule.on(from, to) {
            let x = a + d * s;
            let r = x.norm();
            let (value, derivative) = chi.evaluate(r);
            mean.value += w * (value - zero - slope * r);
            if r > 0.0 {
                let g = x * (w * (derivative - slope) / r);
                mean.start += g * (1.0 - s);
                mean.end += g * s;
            }
        }
    };
    let foot = if n > 0.0 { -a.dot(&d) / n } else { 0.0 };
    if foot > 0.0 && foot < 1.0 {
        panel(0.0, foot);
        panel(foot, 1.0);
    } else {
        panel(0.0, 1.0);
    }
    mean
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::adaptive::adaptive;
    use crate::field::chi::DistanceFunction;
    use crate::field::testing::vector;
    use proptest::prelude::*;

    /// Smooth, with a slope that first grows and then falls, and a value at zero.
    struct Sigmoid;

    impl DistanceFunction for Sigmoid {
        fn evaluate(&self, d: f64) -> (f64, f64) {
            let t = (3.0 * (d - 0.5)).tanh();
            (1.0 + t, 3.0 * (1.0 - t * t))
        }
    }

    /// Arguments: s, the point there, and chi's value and slope.
    type Integrand<'a> = &'a dyn Fn(f64, &Vector3<f64>, f64, f64) -> f64;

    /// Brute-force reference, integrated between the points at which the integrand may have a kink.
    fn oracle(chi: &Chi, a: &Vector3<f64>, b: &Vector3<f64>, f: Integrand) -> f64 {
        let d = b - a;
        let n = d.norm_squared();
        let mut cuts = vec![0.0, 1.0];
        if n > 0.0 {
            let foot = -a.dot(&d) / n;
            let rho2 = (a + d * foot).norm_squared();
            cuts.extend([foot, foot - 1e-3, foot + 1e-3]);
            if let Chi::Clamped { reach } = chi {
                let half = ((reach * reach - rho2) / n).max(0.0).sqrt();
                cuts.extend([foot - half, foot + half]);
            }
        }
        cuts.retain(|s| (0.0..=1.0).contains(s));
        cuts.sort_by(f64::total_cmp);
        let g = |s: f64| {
            let x = a + d * s;
            let (value, slope) = chi.evaluate(x.norm());
            f(s, &x, value, slope)
        };
        cuts.windows(2).map(|w| adaptive(&g, w[0], w[1])).sum()
    }

    fn check(chi: &Chi, a: &Vector3<f64>, b: &Vector3<f64>, errors: [f64; 2]) -> Result<(), TestCaseError> {
        let mean = line_mean(chi, &GaussLegendre::new(), a, b);
        let value = oracle(chi, a, b, &|_, _, value, _| value);
        prop_assert!((mean.value - value).abs() < errors[0], "{chi:?} value {} {value}", mean.value);
        for i in 0..3 {
            let unit = |x: &Vector3<f64>| x[i] / x.norm().max(1e-300);
            let start = oracle(chi, a, b, &|s, x, _, slope| (1.0 - s) * slope * unit(x));
            let end = oracle(chi, a, b, &|s, x, _, slope| s * slope * unit(x));
            prop_assert!((mean.start[i] - start).abs() < errors[1], "{chi:?} start {} {start}", mean.start[i]);
            prop_assert!((mean.end[i] - end).abs() < errors[1], "{chi:?} end {} {end}", mean.end[i]);
        }
        Ok(())
    }

    proptest! {
        #[test]
        fn clamped_is_exact(a in vector(1.0), b in vector(1.0), reach in 0.05..2.0f64) {
            check(&Chi::Clamped { reach }, &a, &b, [1e-9, 1e-6])?;
        }

        /// Order of the rule: 8 nodes on each panel, with a reach not below the length.
        #[test]
        fn saturating_meets_its_error(a in vector(1.0), b in vector(1.0), more in 1.0..10.0f64) {
            prop_assume!((b - a).norm() > 1e-2);
            let reach = more * (b - a).norm();
            check(&Chi::Saturating { reach }, &a, &b, [1e-8 * reach, 1e-6])?;
        }

        #[test]
        fn saturating_near_the_segment(a in vector(1.0), b in vector(1.0), s in 0.0..1.0f64, away in -9.0..0.0f64, n in vector(1.0)) {
            prop_assume!((b - a).norm() > 1e-2);
            let point = a + (b - a) * s + n * 10f64.powf(away);
            let reach = (b - a).norm();
            check(&Chi::Saturating { reach }, &(a - point), &(b - point), [1e-8 * reach, 1e-6])?;
        }

        #[test]
        fn a_given_function(a in vector(1.0), b in vector(1.0)) {
            let b = a + (b - a) * 0.3;
            check(&Chi::Given(std::sync::Arc::new(Sigmoid)), &a, &b, [1e-5, 1e-4])?;
        }
    }

    #[test]
    fn a_point_is_evaluated_as_one() {
        let a = Vector3::new(0.3, 0.0, 0.4);
        let rule = GaussLegendre::new();
        for chi in [Chi::Clamped { reach: 0.7 }, Chi::Clamped { reach: 0.2 }, Chi::Saturating { reach: 0.3 }] {
            let mean = line_mean(&chi, &rule, &a, &a);
            let (value, slope) = chi.evaluate(0.5);
            assert!((mean.value - value).abs() < 1e-15, "{chi:?}");
            assert!((mean.point() + a * (slope / 0.5)).norm() < 1e-14, "{chi:?}");
            let at = line_mean(&chi, &rule, &Vector3::zeros(), &Vector3::zeros());
            assert_eq!((at.value, at.point()), (0.0, Vector3::zeros()), "{chi:?}");
        }
    }
}
