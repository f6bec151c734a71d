//! A tick as a log keeps it: plain numbers in storage that is used again, so that taking one is a copy.

use runtime::program::{Interface, Program};
use runtime::record::columns::Columns;
use runtime::record::roster::Roster;
use runtime::{Controller, Fault, Tick};
use solver::Active;

/// Bytes for the description of a fault.
const FAULT: usize = 256;

/// A level at a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LevelNumbers {
    /// Weighted norm of its slack.
    pub violation: f64,
    /// Number of rows at a bound.
    pub at_bound: usize,
}

/// A tick.
#[derive(Clone, Debug, Default)]
pub struct Snapshot {
    /// Its index, from 0.
    pub index: usize,
    /// Start of the tick, in s.
    pub time: f64,
    /// The numbers of [`Columns`].
    pub row: Vec<f64>,
    /// Table of signals that the controller used.
    pub signals: Vec<f64>,
    /// Index in the roster of the first level that ran.
    pub first_level: usize,
    /// The levels that ran; empty if they are not known.
    pub levels: Vec<LevelNumbers>,
    /// State of the machine; empty without one.
    pub state: String,
    /// Kind of the fault, with its description if that is known; empty without a fault.
    pub fault: String,
}

/// Takes snapshots of the ticks of a controller.
pub struct Camera {
    blank: Snapshot,
    columns: Columns,
    roster: Roster,
    /// Fault of the last tick with the stack that ran, and its description.
    fault: Option<(Fault, usize)>,
    description: String,
}

impl Camera {
    /// Prepares snapshots.
    pub fn new(program: &Program, controller: &Controller) -> Camera {
        let roster = Roster::new(controller);
        let columns = Columns::new(program, controller);
        let levels = controller.stacks().iter().map(|s| s.level_names().len()).max().unwrap_or(0);
        let states = program.machine.iter().flat_map(|m| &m.states);
        Camera {
            // Memory that has been written to once is there.
            blank: Snapshot {
                row: vec![f64::NAN; columns.names(program).len()],
                signals: vec![f64::NAN; program.interface.width()],
                levels: vec![LevelNumbers::default(); levels],
                state: " ".repeat(states.map(|s| s.name.len() + 3).sum()),
                fault: " ".repeat(FAULT),
                ..Snapshot::default()
            },
            columns,
            roster,
            fault: None,
            description: String::new(),
        }
    }

    /// A snapshot in which there is room for every tick, but for long descriptions of faults.
    pub fn blank(&self) -> Snapshot {
        self.blank.clone()
    }

    /// Replaces a snapshot by a tick.
    pub fn take(&mut self, tick: &Tick, into: &mut Snapshot) {
        (into.index, into.time) = (tick.index, tick.time);
        self.columns.fill(tick, &mut into.row);
        into.signals.clear();
        into.signals.extend_from_slice(tick.controller.signal_table());
        into.first_level = self.roster.running_levels(tick).start;
        let at_bound = |a: &&Active| matches!(a, Active::Lower | Active::Upper | Active::Violated);
        into.levels.clear();
        into.levels.extend(tick.solution.levels.iter().map(|level| LevelNumbers {
            violation: level.violation,
            at_bound: level.active.iter().filter(at_bound).count(),
        }));
        into.state.clear();
        into.state.push_str(tick.state);
        let fault = tick.fault.map(|fault| (fault, tick.stack));
        if self.fault != fault {
            self.fault = fault;
            let described = |f: &Fault| format!("{}: {}", f.kind().word(), tick.controller.describe(f));
            self.description = tick.fault.as_ref().map(described).unwrap_or_default();
        }
        into.fault.clear();
        into.fault.push_str(&self.description);
    }
}

/// Leaves of a tick what `log.csv` has of it: neither the levels, nor the description of a fault, nor more of a signal than its
/// value. `signals_at` is the index of the first number of a signal in a row. What is not finite is NaN.
pub fn as_in_csv(tick: &mut Snapshot, interface: &Interface, signals_at: usize) {
    tick.row.iter_mut().filter(|x| !x.is_finite()).for_each(|x| *x = f64::NAN);
    tick.levels.clear();
    tick.signals = table_of(interface, tick.row.get(signals_at..).unwrap_or_default());
    // The kind of a fault stands before its description.
    let kind = tick.fault.find(':').unwrap_or(tick.fault.len());
    tick.fault.truncate(kind);
}

/// The table of signals of which only the values are known; one that is not finite is absent.
fn table_of(interface: &Interface, values: &[f64]) -> Vec<f64> {
    let mut table = interface.absent();
    let mut values = values.iter();
    for signal in &interface.signals {
        let own: Vec<f64> = values.by_ref().take(signal.len).copied().collect();
        let known = own.len() == signal.len && own.iter().all(|x| x.is_finite());
        if known {
            table[signal.at + 1..=signal.at + signal.len].copy_from_slice(&own);
        }
        let presence = if known { 1.0 } else { -1.0 };
        (table[signal.at], table[signal.known_at()]) = (presence, presence);
    }
    table
}
