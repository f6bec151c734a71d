//! A number, vector, orientation or pose that a task reads from the table of values or from an expression of the state.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use robot::Model;

use super::Evaluation;
use super::Operand;
use crate::closest_points::SeparationError;
use crate::state::State;

/// [`Operand`] prepared for evaluation.
#[derive(Clone, Debug)]
pub enum Term {
    /// Depends on time alone: its index in the table of values, and its number of numbers.
    Slot(usize, usize),
    /// Depends on the robot's state.
    State(Box<Evaluation>),
}

impl Term {
    /// Prepares an operand. All memory is allocated here.
    pub fn new(operand: &Operand, model: &Model) -> Self {
        match operand {
            Operand::Slot(slot) => Term::Slot(slot.at, slot.len),
            Operand::Expression(e) => Term::State(Box::new(Evaluation::new(e, model))),
        }
    }

    /// Number of its numbers: 1, 3, 4 or 7.
    pub fn len(&self) -> usize {
        match self {
            Term::Slot(_, len) => *len,
            Term::State(e) => e.len(),
        }
    }

    /// Returns true if it has no numbers, which no checked operand has.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns true if it depends on the robot's state.
    pub fn is_state(&self) -> bool {
        matches!(self, Term::State(_))
    }

    /// Forgets the directions between parts that were last valid.
    pub fn forget(&mut self) {
        if let Term::State(e) = self {
            e.forget();
        }
    }

    /// Computes its value of this tick; must be called before the other methods.
    ///
    /// # Errors
    /// See [`Evaluation::forward`].
    pub fn forward(&mut self, state: &State) -> Result<(), SeparationError> {
        match self {
            Term::Slot(..) => Ok(()),
            Term::State(e) => e.forward(state),
        }
    }

    /// Number `i` of its value.
    pub fn value(&self, state: &State, i: usize) -> f64 {
        match self {
            Term::Slot(at, _) => state.values[at + i],
            Term::State(e) => e.value(i),
        }
    }

    /// Its value as a vector; for a pose, the position.
    pub fn vector(&self, state: &State) -> Vector3<f64> {
        Vector3::from_fn(|i, _| self.value(state, i))
    }

    /// Its value as a quaternion, of any length; for a pose, the orientation.
    pub fn quaternion(&self, state: &State) -> Quaternion<f64> {
        let first = if self.len() == 7 { 3 } else { 0 };
        let x = |i: usize| self.value(state, first + i);
        Quaternion::new(x(0), x(1), x(2), x(3))
    }

    /// Magnitude of the terms of which the last row is the sum.
    fn size(&self) -> f64 {
        match self {
            Term::Slot(..) => 0.0,
            Term::State(e) => e.size(),
        }
    }

    /// Adds to `row` the coefficients of `v` in the rate of `sum_i seeds[i] value(i)`, and returns that rate while the
    /// robot stands still.
    pub fn add_row(&mut self, state: &State, seeds: &[f64], row: &mut [f64]) -> f64 {
        match self {
            Term::Slot(at, len) => state.rates[*at..*at + *len].iter().zip(seeds).map(|(r, s)| r * s).sum(),
            Term::State(e) => e.add_row(state, seeds, row),
        }
    }
}

/// Relative size of a coefficient that counts as rounding error. Parts of one rigid body, whose distance no joint
/// changes, leave coefficients of about 1e-17, which must not be taken for a direction.
const ROUNDING: f64 = 1e-12;

/// Clears the coefficients of a row that are rounding errors only; the row is the sum of these terms.
pub fn settle(row: &mut [f64], terms: &[&Term]) {
    let size: f64 = terms.iter().map(|t| t.size()).sum();
    for x in row {
        if x.abs() <= ROUNDING * size {
            *x = 0.0;
        }
    }
}

/// Seeds that turn the rate of a quaternion `q` into the angular velocity about the world's axis `axis` (0 x, 1 y, 2
/// z): `ω = 2 vec(q' conj(q)) / |q|²`.
pub fn turn_seeds(q: &UnitQuaternion<f64>, axis: usize) -> [f64; 4] {
    let e = Vector3::ith(axis, 1.0);
    let v = q.imag();
    // e·(w v' - w' v + v × v') = w e·v' - (e·v) w' + (e × v)·v'
    let part = e * q.w + e.cross(&v);
    [-2.0 * e.dot(&v), 2.0 * part.x, 2.0 * part.y, 2.0 * part.z]
}
