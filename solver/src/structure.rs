//! What is known of a row's coefficients before a tick begins, so that no tick looks at them again.
//!
//! A promise that whoever fills the problem makes with [`Level::fix`](crate::Level::fix): the
//! norm of a constant row is known, and a row with a single coefficient is a bound of one
//! variable, whose value needs no product. All bounds of a level on one variable are read as one
//! interval while the point lies inside it.

/// What is known of a row's coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Structure {
    /// Nothing: they may be new at every tick.
    Open,
    /// They stay the same.
    Constant {
        /// Their Euclidean norm.
        norm: f64,
    },
    /// They stay the same, and all but one are zero.
    Bound {
        /// The variable.
        column: usize,
        /// Its coefficient, not zero.
        coefficient: f64,
    },
    /// The row takes no part: zero coefficients, no bounds.
    Absent,
}

/// The structure of a row that will stay as it is; open where a number is not finite or too large
/// or small for its square.
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

/// Whether a square is an ordinary number.
pub(crate) fn usable(square: f64) -> bool {
    square > 1e-200 && square < 1e200
}
