//! Function `chi` of the distance; the safety field is its mean: thesis (4.1).

use std::fmt;
use std::sync::Arc;

use crate::field::error::{SafetyError, setting};

/// A function of a distance in m >= 0 with its derivative: continuously differentiable, not decreasing and with a
/// bounded slope, as thesis (4.1) requires. It never allocates and never panics.
pub trait DistanceFunction: Send + Sync {
    /// Value and derivative at `d` >= 0. A number that is not finite makes the tick fail.
    fn evaluate(&self, d: f64) -> (f64, f64);
}

/// Function of the distance.
#[derive(Clone, Default)]
pub enum Chi {
    /// The distance itself, as in the experiments of the thesis. Exact.
    #[default]
    Distance,
    /// `min(d, reach)`: distances beyond `reach` do not count. Exact: the part of a segment inside the sphere is
    /// integrated as a segment of its own.
    Clamped {
        /// \[m\], positive.
        reach: f64,
    },
    /// `reach (1 - exp(-d / reach))`: it grows like the distance near zero, and never exceeds `reach`. It has no closed
    /// form and is computed by quadrature, see [`crate::field::line_mean`].
    Saturating {
        /// \[m\], positive.
        reach: f64,
    },
    /// A user-defined function, by quadrature.
    Given(Arc<dyn DistanceFunction>),
}

impl fmt::Debug for Chi {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Chi::Distance => write!(f, "Distance"),
            Chi::Clamped { reach } => write!(f, "Clamped({reach})"),
            Chi::Saturating { reach } => write!(f, "Saturating({reach})"),
            Chi::Given(_) => write!(f, "Given"),
        }
    }
}

impl Chi {
    /// Rejects a reach that is not positive and finite.
    ///
    /// # Errors
    /// [`SafetyError::Setting`]
    pub fn check(&self) -> Result<(), SafetyError> {
        match self {
            Chi::Clamped { reach } | Chi::Saturating { reach } => {
                setting("reach", *reach, *reach > 0.0 && reach.is_finite(), "positive and finite")
            }
            Chi::Distance | Chi::Given(_) => Ok(()),
        }
    }

    /// Value and derivative at the distance `d` \[m\].
    #[inline]
    pub fn evaluate(&self, d: f64) -> (f64, f64) {
        match self {
            Chi::Distance => (d, 1.0),
            Chi::Clamped { reach } => {
                if d < *reach {
                    (d, 1.0)
                } else {
                    (*reach, 0.0)
                }
            }
            Chi::Saturating { reach } => {
                let rest = (-d / reach).exp();
                (-reach * (-d / reach).exp_m1(), rest)
            }
            Chi::Given(function) => function.evaluate(d),
        }
    }
}
