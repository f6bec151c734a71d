//! What a parameter that takes an expression holds.

use super::Expression;
use crate::slot::Slot;

/// A number, vector, orientation or pose, in which the robot's present state may stand.
#[derive(Clone, Debug, PartialEq)]
pub enum Operand {
    /// It depends on time alone.
    Slot(Slot),
    /// It depends on the robot's state.
    Expression(Expression),
}

impl Operand {
    /// How many numbers it has.
    pub fn len(&self) -> usize {
        match self {
            Operand::Slot(slot) => slot.len,
            Operand::Expression(e) => e.outputs.len(),
        }
    }

    /// True for none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
