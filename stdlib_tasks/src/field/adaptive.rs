//! Adaptive quadrature, as a reference for tests.

/// Adaptive Simpson quadrature to about 1e-12.
pub fn adaptive(f: &dyn Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    fn simpson(f: &dyn Fn(f64) -> f64, a: [f64; 2], fa: [f64; 3], whole: f64, depth: u32) -> f64 {
        let m = 0.5 * (a[0] + a[1]);
        let (l, r) = (f(0.5 * (a[0] + m)), f(0.5 * (m + a[1])));
        let h = a[1] - a[0];
        let left = h / 12.0 * (fa[0] + 4.0 * l + fa[1]);
        let right = h / 12.0 * (fa[1] + 4.0 * r + fa[2]);
        let error = left + right - whole;
        if depth == 0 || error.abs() < 1e-13 {
            return left + right + error / 15.0;
        }
        simpson(f, [a[0], m], [fa[0], l, fa[1]], left, depth - 1)
            + simpson(f, [m, a[1]], [fa[1], r, fa[2]], right, depth - 1)
    }
    if to <= from {
        return 0.0;
    }
    let fa = [f(from), f(0.5 * (from + to)), f(to)];
    simpson(f, [from, to], fa, (to - from) / 6.0 * (fa[0] + 4.0 * fa[1] + fa[2]), 24)
}
