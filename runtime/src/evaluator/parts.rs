//! Parts of a merged stack: those of regions that go on when another region changes the stack.
//!
//! A part has values with a clock, captured numbers and trajectories of its own. They move from the stack that ran to the
//! one that is entered, and so does what the tasks of the part remember.

use super::{Evaluator, Member, TickInputs};
use crate::values::ValueTable;

impl Evaluator {
    /// Number of parts; a stack that was not merged has one.
    pub(crate) fn parts(&self) -> usize {
        self.values.len()
    }

    /// Table of a value: of the first part that computes it.
    pub(super) fn table_of(&self, at: usize) -> &ValueTable {
        let computes = self.values.iter().skip(1).find(|table| table.computes(at) && !self.values[0].computes(at));
        computes.unwrap_or(&self.values[0])
    }

    /// Makes all parts enter with the stack.
    pub(crate) fn begin_anew(&mut self) {
        self.fresh.fill(true);
        self.goes_on.fill(false);
        self.clocks.fill(None);
    }

    /// Sets the time at which a part was entered (s), and whether it is entered with the stack.
    pub(crate) fn set_part(&mut self, part: usize, entered: f64, fresh: bool) {
        if let (Some(clock), Some(is)) = (self.clocks.get_mut(part), self.fresh.get_mut(part)) {
            (*clock, *is) = (Some(entered), fresh);
        }
    }

    /// Returns true if a member of the stack goes on from the stack before.
    pub(crate) fn goes_on(&self, member: usize) -> bool {
        self.members.get(member).is_some_and(|m| m.parts.iter().any(|part| !self.fresh[*part]))
    }

    /// Notes which members go on: those of a part that does.
    pub(crate) fn keep_members(&mut self) {
        for (goes_on, m) in self.goes_on.iter_mut().zip(&self.members) {
            *goes_on = m.parts.iter().any(|part| !self.fresh[*part]);
        }
    }

    /// Takes over the parts that go on from the evaluator of the stack that ran: `before` is the part there of each part
    /// that goes on. Called after [`Evaluator::set_part`]; the other evaluator must be entered before it is used again.
    /// Never allocates.
    pub(crate) fn take_over(&mut self, from: &mut Evaluator, before: impl Iterator<Item = Option<usize>>) {
        for (part, before) in before.enumerate() {
            if let Some((mine, theirs)) =
                before.and_then(|b| Some((self.values.get_mut(part)?, from.values.get_mut(b)?)))
            {
                std::mem::swap(mine, theirs);
            }
        }
        self.keep_members();
        for ((goes_on, m), task) in
            self.goes_on.iter_mut().zip(&self.members).zip(&mut self.tasks).filter(|(g, _)| *g.0)
        {
            let there = from.members.iter().position(|o| o.program_index == m.program_index);
            let other = there.and_then(|k| from.tasks.get_mut(k));
            *goes_on = other.is_some_and(|other| task.take_over(other.as_mut()));
        }
        for p in &mut self.planners {
            if !self.fresh[self.members[p.task].part()]
                && let Some(other) = from.planners.iter_mut().find(|o| o.program_index == p.program_index)
            {
                p.take_over(other);
            }
        }
    }

    /// Returns true if a task, given by its index in the program, goes on from the stack before.
    pub(crate) fn task_goes_on(&self, task: usize) -> bool {
        self.members.iter().position(|m| m.program_index == task).is_some_and(|member| self.goes_on(member))
    }

    /// Takes over the clock of a task from an evaluator of another stack with this task.
    pub(crate) fn follow_clock(&mut self, leader: &Evaluator, task: usize) {
        let part = |e: &Evaluator| e.members.iter().find(|m| m.program_index == task).map(Member::part);
        if let Some((mine, theirs)) = part(self).zip(part(leader)) {
            self.clocks[mine] = leader.clocks[theirs];
            self.values[mine].wait_as(&leader.values[theirs]);
        }
    }

    /// Lets the time of its targets stand for a while (s).
    pub(crate) fn wait(&mut self, time: f64) {
        self.clocks.iter_mut().flatten().for_each(|clock| *clock += time);
        self.values.iter_mut().for_each(|table| table.wait(time));
    }

    /// Enters the same stack as another evaluator, at another configuration, with the captured values and the clocks of that one. Never allocates.
    pub(crate) fn enter_beside(&mut self, q: &[f64], tick: TickInputs, leader: &Evaluator) {
        self.begin_anew();
        self.clocks.copy_from_slice(&leader.clocks);
        self.enter_fresh(q, tick);
        for (mine, theirs) in self.values.iter_mut().zip(&leader.values) {
            mine.inputs.copy_from_slice(&theirs.inputs);
        }
    }

    /// Takes over the clocks of the parts, and which of them go on, from the evaluator of the same stack.
    pub(crate) fn follow_parts(&mut self, leader: &Evaluator) {
        self.clocks.copy_from_slice(&leader.clocks);
        self.values.iter_mut().zip(&leader.values).for_each(|(mine, theirs)| mine.wait_as(theirs));
        self.fresh.copy_from_slice(&leader.fresh);
        self.keep_members();
    }
}
