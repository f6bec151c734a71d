//! The end of a search on the lattice: a point in time, or an amount of work.
//!
//! A search that is bounded by work alone does the same on every machine. One that is bounded by time looks at the clock after each piece of
//! work that takes some tens of microseconds, also within the turn of a robot, so that it ends in time.

use std::cell::Cell;
use std::time::Instant;

/// Work between two looks at the clock.
const GRAIN: u64 = 8192;

/// The end of a search on the lattice, with the work that was done so far: the number of motions and of pairs of positions that were looked at.
#[derive(Debug)]
pub struct Deadline {
    end: End,
    work: Cell<u64>,
    /// Work at which the clock is looked at again.
    next: Cell<u64>,
    over: Cell<bool>,
}

#[derive(Clone, Copy, Debug)]
enum End {
    Time(Instant),
    Work(u64),
    Never,
}

impl Deadline {
    fn new(end: End) -> Deadline {
        Deadline { end, work: Cell::new(0), next: Cell::new(0), over: Cell::new(false) }
    }

    /// The search ends at this time.
    pub fn at(time: Instant) -> Deadline {
        Deadline::new(End::Time(time))
    }

    /// The search ends after this work.
    pub fn after(work: u64) -> Deadline {
        Deadline::new(End::Work(work))
    }

    /// The search ends by itself.
    pub fn never() -> Deadline {
        Deadline::new(End::Never)
    }

    /// The work so far.
    pub fn work(&self) -> u64 {
        self.work.get()
    }

    /// True if the end is reached.
    pub fn is_over(&self) -> bool {
        self.is_over_after(0)
    }

    /// Adds work that was done or is about to be done; true if the end is reached.
    pub(super) fn is_over_after(&self, work: usize) -> bool {
        self.work.set(self.work.get().saturating_add(work as u64));
        if self.over.get() {
            return true;
        }
        let over = match self.end {
            End::Never => false,
            End::Work(most) => self.work.get() > most,
            // Work that is not done is no reason to look.
            End::Time(time) if work == 0 || self.work.get() >= self.next.get() => {
                self.next.set(self.work.get() + GRAIN);
                Instant::now() >= time
            }
            End::Time(_) => false,
        };
        self.over.set(over);
        over
    }
}
