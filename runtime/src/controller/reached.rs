//! Criterion that a target is reached, evaluated for the last tick of a stack: the target is at rest, the errors are within
//! their tolerances, and the robot moves slowly along the rows of the task:
//!
//! ```text
//! ||J v||  <=  bound        over the rows of one unit, v the velocity of the tick
//! ```
//!
//! For a target at rest, `J v` is the rate of the task's error.

use super::stack_controller::StackController;
use crate::evaluator::Member;
use crate::program::{Reached, SpeedBound};

impl StackController {
    /// Returns true if the target of a task was reached at the last tick. Never allocates.
    pub(super) fn has_reached(&self, criterion: &Reached) -> bool {
        let Some(member) = self.evaluator.members().iter().find(|m| m.program_index == criterion.task) else {
            return false;
        };
        let errors = self.measured().measures().get(member.measures.clone()).unwrap_or_default();
        member.slots.iter().all(|&at| self.evaluator.is_settled(at))
            && errors.len() == criterion.tolerances.len()
            && errors.iter().zip(&criterion.tolerances).all(|(e, t)| e.abs() <= *t)
            && criterion.speeds.iter().all(|bound| self.is_slow(member, bound))
    }

    /// Returns true if the robot moves along rows of a task more slowly than the bound.
    fn is_slow(&self, member: &Member, bound: &SpeedBound) -> bool {
        let Some(level) = self.problem().levels.get(member.level) else { return false };
        let speed = |row: &usize| {
            let row = level.row(member.rows.start + row);
            row.iter().zip(self.velocity()).map(|(j, v)| j * v).sum::<f64>()
        };
        let inside = bound.rows.iter().all(|row| *row < member.rows.len());
        // The rows leave out joints that the stack locks, which may still be coming to rest.
        inside
            && !self.has_moving_locked_joints()
            && bound.rows.iter().map(|row| speed(row).powi(2)).sum::<f64>().sqrt() <= bound.most
    }
}
