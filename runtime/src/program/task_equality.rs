//! Equivalence of two tasks whose parameters have different places in the table of values.

use std::collections::BTreeSet;

use stdlib_tasks::bound::{Bound, Slot};

use super::{Op, Program};
use crate::planning;

impl Program {
    /// Returns true if two tasks have the same type and equal parameters: the same references, the same constants, and
    /// moving numbers that the same operations of the tape compute.
    pub fn same_task(&self, a: usize, b: usize) -> bool {
        let (Some(x), Some(y)) = (self.tasks.get(a), self.tasks.get(b)) else { return false };
        let both = || x.params.iter().zip(&y.params);
        a == b
            || (x.kind == y.kind
                && x.params.len() == y.params.len()
                && both().all(|((m, p), (n, q))| m == n && self.same(p, q)))
    }

    /// Returns true if the goal of a task depends on the time or the configuration at which its stack was entered.
    pub fn depends_on_entry(&self, task: usize) -> bool {
        // The clock of the planner starts with the stack.
        if planning::planner_of(self, task).is_some() {
            return true;
        }
        let Some(task) = self.tasks.get(task) else { return false };
        if planning::protected_by(task).is_some() {
            return true;
        }
        let places: BTreeSet<usize> =
            task.params.values().flat_map(|b| b.slots()).flat_map(|s| s.at..s.at + s.len).collect();
        self.values.tape.only(&places).ops.iter().any(|op| matches!(op, Op::T | Op::Input(_) | Op::Trajectory(_)))
    }

    fn same(&self, a: &Bound, b: &Bound) -> bool {
        match (a, b) {
            (Bound::Value(x), Bound::Value(y)) => self.same_slot(x, y),
            (Bound::PerJoint(x), Bound::PerJoint(y)) => {
                x.len() == y.len() && x.iter().zip(y).all(|(x, y)| x.0 == y.0 && self.same_slot(&x.1, &y.1))
            }
            (Bound::PerArm(x), Bound::PerArm(y)) => {
                x.len() == y.len() && x.iter().zip(y).all(|(x, y)| x.0 == y.0 && self.same_slot(&x.1, &y.1))
            }
            (Bound::Expression(x), Bound::Expression(y)) => {
                let place = |at: &usize| Slot { at: *at, len: 1 };
                x.ops == y.ops
                    && x.leaves == y.leaves
                    && x.outputs == y.outputs
                    && x.inputs.len() == y.inputs.len()
                    && x.inputs.iter().zip(&y.inputs).all(|(x, y)| self.same_slot(&place(x), &place(y)))
            }
            (Bound::Group(x), Bound::Group(y)) => {
                x.len() == y.len() && x.iter().zip(y).all(|((m, p), (n, q))| m == n && self.same(p, q))
            }
            _ => a == b,
        }
    }

    fn same_slot(&self, a: &Slot, b: &Slot) -> bool {
        a.len == b.len && (0..a.len).all(|i| self.number(a.at + i) == self.number(b.at + i))
    }

    /// Number of the table: its value if it is constant, otherwise the operation that computes it.
    fn number(&self, at: usize) -> (Option<usize>, u64) {
        let moving = self.values.tape.outputs.iter().find(|o| o.at == at);
        let value = self.values.initial.get(at).copied().unwrap_or(f64::NAN);
        moving.map_or((None, value.to_bits()), |o| (Some(o.value), 0))
    }
}
