//! Gauss-Legendre quadrature with a fixed number of nodes.

use std::f64::consts::PI;

/// Number of nodes on each panel.
const NODES: usize = 8;

/// Rule with 8 nodes on [0, 1], exact for polynomials of degree 15.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussLegendre {
    /// Nodes and weights; the weights add to one.
    nodes: [(f64, f64); NODES],
}

impl Default for GaussLegendre {
    fn default() -> Self {
        Self::new()
    }
}

impl GaussLegendre {
    /// Creates the rule. The nodes are the roots of the Legendre polynomial, by Newton's method from Tricomi's guess.
    pub fn new() -> Self {
        let n = NODES as f64;
        let nodes = std::array::from_fn(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (n + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..20 {
                let (value, derivative) = legendre(x);
                slope = derivative;
                x -= value / slope;
            }
            (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
        });
        GaussLegendre { nodes }
    }

    /// The nodes and weights for the panel `from..to`: the weights add to its length.
    #[inline]
    pub fn on(&self, from: f64, to: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        let length = to - from;
        self.nodes.iter().map(move |(s, w)| (from + s * length, w * length))
    }
}

/// The Legendre polynomial of degree [`NODES`] and its derivative, by the recurrence of Bonnet.
fn legendre(x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for k in 2..=NODES {
        let k = k as f64;
        (before, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
    }
    (value, NODES as f64 * (x * value - before) / (x * x - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_to_degree_fifteen_and_no_further() {
        let rule = GaussLegendre::new();
        let error = |k: i32| {
            let sum: f64 = rule.on(0.0, 1.0).map(|(s, w)| w * s.powi(k)).sum();
            (sum - 1.0 / f64::from(k + 1)).abs()
        };
        assert!((0..16).all(|k| error(k) < 2e-16), "{:?}", (0..16).map(error).collect::<Vec<_>>());
        assert!(error(16) > 1e-12);
        let sum: f64 = rule.on(-1.0, 2.0).map(|(x, w)| w * x * x).sum();
        assert!((sum - 3.0).abs() < 1e-14);
    }
}
