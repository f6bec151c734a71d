//! Obstacles that move, where they will be when the robot has done what it is told.
//!
//! A robot whose drives are behind its commands by a time τ meets an obstacle where this is τ later: its place is `p + τ p'`, at the velocity that its
//! expression has. What follows a person is foreseen already, with the person; see [`Signals`](crate::Signals). Source: ours.

use stdlib_tasks::bound::Slot;

use super::Evaluator;
use crate::program::Program;
use crate::values::ValueTable;

/// Numbers that are foreseen.
#[derive(Default)]
pub(super) struct Foresight {
    /// Time by which they are (s).
    time: f64,
    slots: Vec<Slot>,
}

impl Foresight {
    /// Moves the numbers that a table computed to where they will be. A quaternion keeps its direction, and not its length.
    pub fn apply(&self, table: &mut ValueTable) {
        for at in self.slots.iter().flat_map(|slot| slot.at..slot.at + slot.len) {
            table.current[at] += self.time * table.rates[at];
        }
    }
}

impl Evaluator {
    /// Lets the tasks see moving obstacles where they will be after a time (s).
    pub(crate) fn foresee(&mut self, program: &Program, time: f64) {
        let follows_person = |slot: &Slot| {
            let tape = program.values.tape.only(&(slot.at..slot.at + slot.len).collect());
            let signals = &program.interface.signals;
            tape.signals().iter().any(|at| program.interface.signal_of(*at).is_some_and(|s| signals[s].is_of_person()))
        };
        let slots = program.obstacles.iter().flat_map(|o| [o.position, o.orientation]);
        self.foresight = Foresight { time, slots: slots.filter(|slot| time > 0.0 && !follows_person(slot)).collect() };
    }
}
