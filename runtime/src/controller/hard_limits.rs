//! Limits of hard levels that the robot passes at run time: a fault, whether or not a transition asks for it.

use std::collections::BTreeSet;

use crate::evaluator::Evaluator;
use crate::fault::Fault;
use crate::program::{Program, StackProgram};

/// State of the limits of a stack's hard levels, by the stack's margins.
pub(super) struct HardLimits {
    /// For each margin, true if its limit is on a hard level and no signal moves it. A limit that a person moves can be
    /// passed although the robot gives way as fast as its row requires, and must go on to do so.
    hard: Vec<bool>,
    /// For each margin, true if the robot was within the limit at some tick since the entry, and has not passed it since.
    within: Vec<bool>,
}

impl HardLimits {
    /// Finds the limits of a stack.
    pub fn new(evaluator: &Evaluator, program: &Program, stack: &StackProgram) -> HardLimits {
        let mut hard = vec![false; evaluator.margins().len()];
        for m in evaluator.members().iter().filter(|m| stack.levels.get(m.level).is_some_and(|l| l.hard)) {
            let read: BTreeSet<usize> = m.slots.iter().copied().collect();
            if program.values.tape.only(&read).signals().is_empty() {
                hard[m.margins.clone()].fill(true);
            }
        }
        HardLimits { within: vec![false; hard.len()], hard }
    }

    /// The stack is entered: limits that are violated now are restored, and count from the tick at which they hold.
    pub fn enter(&mut self) {
        self.within.fill(false);
    }

    /// Returns the first limit that the robot passed at this tick: it was within the limit before, and its margin is now
    /// below `-tolerance`.
    pub fn passed(&mut self, evaluator: &Evaluator, tolerance: f64) -> Option<Fault> {
        let mut first = None;
        let limits = self.within.iter_mut().zip(evaluator.margins()).enumerate();
        for (i, (within, h)) in limits.filter(|(i, _)| self.hard[*i]) {
            let holds = *h >= -tolerance;
            if *within && !holds && first.is_none() {
                first = Some(i);
            }
            *within = holds;
        }
        let at = first?;
        let members = evaluator.members().iter();
        let (member, m) = members.enumerate().find(|(_, m)| m.margins.contains(&at))?;
        Some(Fault::Limit { member, row: at - m.margins.start })
    }
}
