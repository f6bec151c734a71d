//! Value of a parameter that takes an expression.

use super::Expression;
use crate::slot::Slot;

/// A number, vector, orientation or pose, which may depend on the robot's present state.
#[derive(Clone, Debug, PartialEq)]
pub enum Operand {
    /// It depends on time alone.
    Slot(Slot),
    /// It depends on the robot's state.
    Expression(Expression),
}

impl Operand {
    /// Number of its numbers.
    pub fn len(&self) -> usize {
        match self {
            Operand::Slot(slot) => slot.len,
            Operand::Expression(e) => e.outputs.len(),
        }
    }

    /// Returns true if it has no numbers.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
