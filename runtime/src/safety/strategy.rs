//! The planner and the two baselines that it is compared with: thesis 4.4.1.3.

/// Method that decides about the inputs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Strategy {
    /// A1: the quadratic program (4.27)-(4.30).
    #[default]
    Program,
    /// A2, evasive motion, (4.50)-(4.51): `v = m v_task + (I - m J^+ J) v_0`, `v_0` along the gradient of the field and
    /// `m` the share of [`task_share`]. Never slows the clock; its command is [`crate::safety::Plan::velocity`].
    Evasive {
        /// epsilon: half width of the band around the threshold, as a share of it; in (0, 1).
        band: f64,
    },
    /// A3, emergency stop, (4.52): the clock stops while the field is not above the threshold; no deviation, no
    /// internal motion.
    Stop,
}

/// Share `m` of the task in evasive motion, thesis (4.51): 1 from `(1 + band)` times the threshold upwards, 0 from
/// `(1 - band)` times the threshold downwards, and a sine between.
pub fn task_share(value: f64, threshold: f64, band: f64) -> f64 {
    if value >= (1.0 + band) * threshold {
        1.0
    } else if value <= (1.0 - band) * threshold {
        0.0
    } else {
        0.5 + 0.5 * (std::f64::consts::FRAC_PI_2 * (value - threshold) / (band * threshold)).sin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_share_rises_smoothly_from_zero_to_one() {
        let share = |f| task_share(f, 0.8, 0.25);
        assert_eq!([share(0.6), share(1.0), share(0.1), share(f64::INFINITY)], [0.0, 1.0, 0.0, 1.0]);
        assert!((share(0.8) - 0.5).abs() < 1e-15);
        let slope = |f: f64| (share(f + 1e-5) - share(f - 1e-5)) / 2e-5;
        for k in 0..=1000 {
            let f = 0.5 + 0.0006 * f64::from(k);
            assert!(slope(f) >= 0.0);
        }
        assert!(slope(0.6) < 1e-3 && slope(1.0) < 1e-3, "no kink at the ends");
        assert_eq!([task_share(0.1, 0.0, 0.3), task_share(-0.1, 0.0, 0.3)], [1.0, 0.0]);
    }
}
