//! A safety field as a leaf of an expression: its points are operations that come before it.
//!
//! ```text
//! F' = dF/dq v + sum_j dF/dp_j p_j'
//! ```
//!
//! The first part is the leaf's row; the second is propagated to the operations of the points.

use nalgebra::Vector3;
use robot::Model;

use crate::closest_points::SeparationError;
use crate::field::{Field, FieldProgram, HumanPoint};
use crate::state::State;

/// A safety field with its points.
#[derive(Clone, Debug)]
pub(super) struct HumanField {
    /// `None` for a field that cannot be created, which a checked expression excludes.
    field: Option<Field>,
    operations: Vec<[usize; 3]>,
    points: Vec<HumanPoint>,
    /// Largest distance of the ends of its segments from the world's origin, in m.
    far: f64,
}

impl HumanField {
    /// Prepares the field. All memory is allocated here.
    pub fn new(program: &FieldProgram, model: &Model) -> Self {
        HumanField {
            field: program.field(model).ok(),
            operations: program.points.clone(),
            points: vec![HumanPoint::at_rest(Vector3::zeros()); program.points.len()],
            far: 0.0,
        }
    }

    /// Computes the field at this tick; `registers` are the values of the operations before it.
    ///
    /// # Errors
    /// A point is not finite.
    pub fn find(&mut self, state: &State, registers: &[f64]) -> Result<f64, SeparationError> {
        for (point, ops) in self.points.iter_mut().zip(&self.operations) {
            let at = |i: usize| registers.get(i).copied().unwrap_or(f64::NAN);
            point.position = Vector3::from(ops.map(at));
        }
        if !self.points.iter().all(|p| p.position.iter().all(|x| x.is_finite())) {
            // The point of an absent signal, in the branch of an `if` that may not be chosen.
            return Ok(f64::NAN);
        }
        let field = self.field.as_mut().ok_or(SeparationError::NotFinite)?;
        field.update(state.model, state.data, &self.points).map_err(|_| SeparationError::NotFinite)?;
        self.far = field.body().ends().iter().flatten().fold(0.0, |far: f64, p| far.max(p.norm()));
        Ok(field.value())
    }

    /// Propagates the adjoint `g` of the field to the operations of its points.
    pub fn pull(&self, g: f64, adjoints: &mut [f64]) {
        let gradients = self.field.as_ref().map_or(&[][..], Field::human_gradients);
        for (gradient, ops) in gradients.iter().zip(&self.operations) {
            for (&op, x) in ops.iter().zip(gradient.iter()) {
                if let Some(adjoint) = adjoints.get_mut(op) {
                    *adjoint += g * x;
                }
            }
        }
    }

    /// Adds its row for the adjoint `g`. Returns the magnitude of the terms that were summed.
    pub fn add_row(&self, g: f64, row: &mut [f64]) -> f64 {
        let Some(field) = &self.field else { return 0.0 };
        for (x, dof) in row.iter_mut().zip(field.gradient()) {
            *x += g * dof;
        }
        g.abs() * (1.0 + self.far)
    }
}
