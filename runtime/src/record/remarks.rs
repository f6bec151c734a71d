//! Remarks of a verdict, although no limit was passed: targets that were never reached, a machine that changes its state at
//! every tick, many handled faults.

use stdlib_tasks::dimension::{ANGLE, LENGTH};
use stdlib_tasks::task::RowKind;

use super::roster::Roster;
use super::summary::FaultRecord;
use crate::controller::Controller;
use crate::quantity::quantity;
use crate::tick::{Recorder, Tick};

/// Error (m, rad) up to which a target counts as reached.
const REACHED: f64 = 0.005;

/// Share of its largest error up to which a target counts as reached: it moves, or is followed with a lag.
const NEAR: f64 = 0.1;

/// Time (s) from which a target counts as never reached; a shorter run shows only its beginning.
const LONG: f64 = 1.0;

/// Largest number of ticks between two changes of state that belong to one sequence.
const GAP: usize = 2;

/// Number of changes of state in a sequence that is named.
const MANY_CHANGES: usize = 10;

/// Number of handled faults that are named.
pub const MANY_FAULTS: usize = 10;

/// Errors of a part of a target.
struct PartErrors {
    member: usize,
    name: String,
    unit: String,
    measure: usize,
    least: f64,
    largest: f64,
    ticks: usize,
}

/// Changes of state in a sequence, with no more than [`GAP`] ticks between two of them.
#[derive(Clone, Copy, Default)]
struct Changes {
    number: usize,
    /// Ticks of the first and the last one.
    first: usize,
    last: usize,
}

/// Gathers the remarks on a run.
pub(super) struct RemarksRecorder {
    roster: Roster,
    parts: Vec<PartErrors>,
    /// Sum of the entries into all states at the last tick.
    entries: u64,
    now: Changes,
    most: Changes,
}

impl RemarksRecorder {
    /// Prepares for a run.
    pub fn new(controller: &Controller) -> Self {
        let roster = Roster::new(controller);
        let mut parts = Vec::new();
        for (member, m) in roster.members.iter().enumerate().filter(|(_, m)| m.row_kind == RowKind::Equality) {
            // The lowest of several levels of targets is a preference: the robot follows it as far as the others allow.
            let prefers = controller.stacks().iter().any(|s| {
                let all = s.evaluator().members();
                let levels = || all.iter().filter(|o| o.row_kind == RowKind::Equality).map(|o| o.level);
                let own = all.iter().find(|o| o.program_index == m.program_index).map(|o| o.level);
                own.is_some_and(|own| levels().max() == Some(own) && levels().min() != Some(own))
            });
            let measured = m.measure_info.iter().enumerate().filter(|(_, x)| matches!(x.dimension, LENGTH | ANGLE));
            parts.extend(measured.filter(|_| !prefers).map(|(measure, x)| PartErrors {
                member,
                name: x.name.clone(),
                unit: x.dimension.to_string(),
                measure,
                least: f64::INFINITY,
                largest: 0.0,
                ticks: 0,
            }));
        }
        RemarksRecorder { roster, parts, entries: 0, now: Changes::default(), most: Changes::default() }
    }

    /// The remarks, each a sentence without its full stop. `period` is the time of a tick (s).
    pub fn result(&self, faults: &[FaultRecord], period: f64) -> Vec<String> {
        let mut all = Vec::new();
        let handled: Vec<f64> = faults.iter().filter(|f| f.answered).map(|f| f.time).collect();
        if let (Some(first), true) = (handled.first(), handled.len() >= MANY_FAULTS) {
            all.push(format!("The machine handled {} faults, the first at {first:.2} s", handled.len()));
        }
        let Changes { number, first, last } = self.most;
        if number >= MANY_CHANGES {
            all.push(format!(
                "The machine changed its state {number} times in {} ticks, from {:.2} s",
                last - first + 1,
                first as f64 * period
            ));
        }
        for p in &self.parts {
            if p.ticks as f64 * period >= LONG && p.least > REACHED.max(NEAR * p.largest) {
                let name = &self.roster.members[p.member].name;
                let distance = quantity(p.least, &p.unit);
                all.push(match self.parts.iter().filter(|o| o.member == p.member).count() {
                    1 => format!("`{name}` never came closer than {distance} to its target"),
                    _ => format!("`{name}` never came closer than {distance} to its target, {}", p.name),
                });
            }
        }
        all
    }

    fn note_changes(&mut self, tick: &Tick) {
        let entries = tick.controller.entries().iter().sum();
        if std::mem::replace(&mut self.entries, entries) == entries || tick.index == 0 {
            return;
        }
        if self.now.number == 0 || tick.index - self.now.last > GAP {
            self.now = Changes { number: 0, first: tick.index, last: tick.index };
        }
        self.now = Changes { number: self.now.number + 1, last: tick.index, ..self.now };
        if self.now.number > self.most.number {
            self.most = self.now;
        }
    }
}

impl Recorder for RemarksRecorder {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        self.note_changes(tick);
        if tick.is_still() {
            return Ok(());
        }
        for (member, m) in self.roster.running(tick) {
            let measures = &tick.evaluator.measures()[m.measures.clone()];
            for p in self.parts.iter_mut().filter(|p| p.member == member) {
                let error = measures[p.measure].abs();
                if error.is_finite() {
                    p.least = p.least.min(error);
                    p.largest = p.largest.max(error);
                    p.ticks += 1;
                }
            }
        }
        Ok(())
    }
}
