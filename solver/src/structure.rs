//! Structure of rows that is known before a tick begins, so that solvers need not read the coefficients again.
//!
//! The caller that fills the problem declares it with [`Level::fix`](crate::Level::fix): the norm of a constant row is
//! known, and a row with a single coefficient is a bound of one variable, whose value needs no product. All bounds of a
//! level on one variable are checked as one interval while the point is inside it.

/// Known structure of a row's coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Structure {
    /// Unknown: the coefficients may change at every tick.
    Open,
    /// The coefficients are constant.
    Constant {
        /// Their Euclidean norm.
        norm: f64,
    },
    /// The coefficients are constant, and all but one are zero.
    Bound {
        /// The variable.
        column: usize,
        /// Its coefficient, not zero.
        coefficient: f64,
    },
    /// The row is absent: zero coefficients, no bounds.
    Absent,
}

/// Returns the structure of a row that stays constant; open if a number is not finite, or too large or too small to be
/// squared.
pub(crate) fn of(row: &[f64]) -> Structure {
    let mut others = row.iter().enumerate().filter(|(_, a)| **a != 0.0);
    match (others.next(), others.next()) {
        (None, _) => Structure::Constant { norm: 0.0 },
        (Some((column, &coefficient)), None) if usable(coefficient * coefficient) => {
            Structure::Bound { column, coefficient }
        }
        _ => {
            let square: f64 = row.iter().map(|a| a * a).sum();
            if usable(square) { Structure::Constant { norm: square.sqrt() } } else { Structure::Open }
        }
    }
}

/// Returns true if a squared norm is far from overflow and underflow.
pub(crate) fn usable(square: f64) -> bool {
    square > 1e-200 && square < 1e200
}
