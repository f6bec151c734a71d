//! Limits of a trajectory.

/// Largest speed, per s, that counts as zero.
const STANDS: f64 = 1e-12;

/// Largest speed, acceleration and jerk, in the unit of the moving value per s, s^2 and s^3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The largest speed.
    pub speed: f64,
    /// The largest acceleration.
    pub acceleration: f64,
    /// The largest jerk; `None` if it is not limited.
    pub jerk: Option<f64>,
}

impl Limits {
    /// Returns true if all of them are finite and positive.
    pub fn are_sound(&self) -> bool {
        let good = |x: f64| x.is_finite() && x > 0.0;
        good(self.speed) && good(self.acceleration) && self.jerk.is_none_or(good)
    }

    /// Returns true if the speed is zero, and the other limits are sound: a motion within them stands still.
    pub fn stop(&self) -> bool {
        (0.0..=STANDS).contains(&self.speed) && Limits { speed: 1.0, ..*self }.are_sound()
    }

    /// Limits of the same motion in `factor` times the time.
    pub(super) fn slower(&self, factor: f64) -> Limits {
        Limits {
            speed: self.speed / factor,
            acceleration: self.acceleration / (factor * factor),
            jerk: self.jerk.map(|j| j / (factor * factor * factor)),
        }
    }

    /// Limits with a share of the acceleration and jerk, and another speed.
    pub(super) fn share(&self, speed: f64, share: f64) -> Limits {
        Limits { speed, acceleration: self.acceleration * share, jerk: self.jerk.map(|j| j * share) }
    }
}
