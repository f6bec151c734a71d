//! Initial configurations: the neutral one, and random ones for tests.

use std::f64::consts::{PI, TAU};

use crate::{Base, DofUnit, Model};

impl Model {
    /// Returns the configuration of zeros, each clamped to its limits; a floating base gets the identity quaternion.
    /// Length nq.
    pub fn neutral(&self) -> Vec<f64> {
        let mut q = vec![0.0; self.nq()];
        for base in self.bases.iter().filter(|base| base.kind == Base::Floating) {
            q[base.first_coordinate + 3] = 1.0;
        }
        for dof in &self.dofs {
            if let Some(i) = dof.q_index {
                q[i] = nearest(0.0, dof.lower, dof.upper);
            }
        }
        q
    }

    /// Returns a random configuration inside the limits. A missing limit is taken 2π rad or 2 m from the other one; if
    /// both are missing, the range is ±π rad or ±1 m. `rng` yields numbers uniform in 0..1.
    pub fn random_configuration(&self, rng: &mut impl FnMut() -> f64) -> Vec<f64> {
        let mut q = vec![0.0; self.nq()];
        for base in &self.bases {
            let q = &mut q[base.coordinates()];
            match base.kind {
                Base::Fixed => {}
                Base::Planar | Base::Unicycle => {
                    q[0] = 2.0 * rng() - 1.0;
                    q[1] = 2.0 * rng() - 1.0;
                    q[2] = PI * (2.0 * rng() - 1.0);
                }
                Base::Floating => {
                    for x in &mut q[..3] {
                        *x = 2.0 * rng() - 1.0;
                    }
                    // Uniform on the sphere of unit quaternions: Shoemake, Graphics Gems III (1992).
                    let (u, a, b) = (rng().clamp(0.0, 1.0), TAU * rng(), TAU * rng());
                    let (r, s) = ((1.0 - u).sqrt(), u.sqrt());
                    q[3..7].copy_from_slice(&[s * b.cos(), r * a.sin(), r * a.cos(), s * b.sin()]);
                }
            }
        }
        for dof in &self.dofs {
            if let Some(i) = dof.q_index {
                let reach = if dof.unit == DofUnit::Radian { PI } else { 1.0 };
                let (lower, upper) = match (dof.lower.is_finite(), dof.upper.is_finite()) {
                    (true, true) => (dof.lower, dof.upper),
                    (true, false) => (dof.lower, dof.lower + 2.0 * reach),
                    (false, true) => (dof.upper - 2.0 * reach, dof.upper),
                    (false, false) => (-reach, reach),
                };
                q[i] = nearest(lower + (upper - lower) * rng(), lower, upper);
            }
        }
        q
    }
}

/// Clamps `x` to `lower..upper`; does not panic if the limits cross.
pub(crate) fn nearest(x: f64, lower: f64, upper: f64) -> f64 {
    x.min(upper).max(lower)
}
