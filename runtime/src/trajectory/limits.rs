//! What bounds a trajectory.

/// The largest speed, acceleration and jerk, in the unit of what moves per s, s^2 and s^3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The largest speed.
    pub speed: f64,
    /// The largest acceleration.
    pub acceleration: f64,
    /// The largest jerk; none where nothing bounds it.
    pub jerk: Option<f64>,
}

impl Limits {
    /// Whether all of them are finite and positive.
    pub fn are_sound(&self) -> bool {
        let good = |x: f64| x.is_finite() && x > 0.0;
        good(self.speed) && good(self.acceleration) && self.jerk.is_none_or(good)
    }

    /// Those of the same motion in `factor` times the time.
    pub(super) fn slower(&self, factor: f64) -> Limits {
        Limits {
            speed: self.speed / factor,
            acceleration: self.acceleration / (factor * factor),
            jerk: self.jerk.map(|j| j / (factor * factor * factor)),
        }
    }

    /// A share of the acceleration and jerk, and another speed.
    pub(super) fn share(&self, speed: f64, share: f64) -> Limits {
        Limits { speed, acceleration: self.acceleration * share, jerk: self.jerk.map(|j| j * share) }
    }
}
