//! Slowest ticks of a run, with the rows that came to their bounds or left them. A tick takes long if many rows do, or
//! if a stack runs for the first time.

use serde::Serialize;
use solver::Active;

use crate::controller::Controller;
use crate::tick::{Recorder, Tick};

/// Number of ticks that are kept.
const KEPT: usize = 3;

/// Number of rows that are named for each of them.
const NAMED: usize = 12;

/// A slow tick.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SlowTick {
    /// Computing time of the controller, in microseconds.
    pub us: f64,
    /// Time of the tick, in s.
    pub at_s: f64,
    /// Path of the machine's state; `None` if no machine runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub state: Option<String>,
    /// True for the first tick of its stack after another one ran: there is no previous tick to compare with.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub first: bool,
    /// Number of rows that changed between free, a bound and violated since the previous tick.
    pub changed: usize,
    /// Some of these rows, as `TASK ROW`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rows: Vec<String>,
}

/// Keeps the slowest ticks.
pub struct SlowTicksRecorder {
    /// Slowest ticks, the slowest first.
    slowest: Vec<SlowTick>,
    /// Stack of the last tick, and the states of its rows by level.
    stack: Option<usize>,
    before: Vec<Vec<Active>>,
    machine: bool,
}

impl SlowTicksRecorder {
    /// Prepares for a run of this controller.
    pub fn new(controller: &Controller) -> Self {
        let machine = controller.machine().states.iter().any(|s| !s.name.is_empty());
        SlowTicksRecorder { slowest: Vec::with_capacity(KEPT + 1), stack: None, before: Vec::new(), machine }
    }

    /// Slowest ticks, the slowest first.
    pub fn result(&self) -> Vec<SlowTick> {
        self.slowest.clone()
    }

    /// Number of rows whose state differs from the previous tick, and the names of some of them.
    fn changed(&self, tick: &Tick) -> (usize, Vec<String>) {
        let members = tick.controller.stacks()[tick.stack].evaluator().members();
        let (mut changed, mut rows) = (0, Vec::new());
        for (l, (now, before)) in tick.solution.levels.iter().zip(&self.before).enumerate() {
            for row in (0..now.active.len()).filter(|i| before.get(*i) != now.active.get(*i)) {
                changed += 1;
                let member = members.iter().find(|m| m.level == l && m.rows.contains(&row));
                if let Some(m) = member.filter(|_| rows.len() < NAMED) {
                    let name = m.row_info.get(row - m.rows.start).map_or("", |r| r.name.as_str());
                    rows.push(format!("{} {name}", m.name).trim_end().to_string());
                }
            }
        }
        (changed, rows)
    }
}

impl Recorder for SlowTicksRecorder {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        if tick.is_still() {
            // Nothing was solved, so the next tick has nothing to compare with.
            self.stack = None;
            return Ok(());
        }
        let us = tick.elapsed * 1e6;
        let first = self.stack != Some(tick.stack);
        if self.slowest.len() < KEPT || self.slowest.last().is_some_and(|s| us > s.us) {
            let (changed, rows) = if first { (0, Vec::new()) } else { self.changed(tick) };
            let state = self.machine.then(|| tick.state.to_string());
            let at = self.slowest.partition_point(|s| s.us >= us);
            self.slowest.insert(at, SlowTick { us, at_s: tick.time, state, first, changed, rows });
            self.slowest.truncate(KEPT);
        }
        self.stack = Some(tick.stack);
        self.before.resize_with(tick.solution.levels.len(), Vec::new);
        for (before, level) in self.before.iter_mut().zip(&tick.solution.levels) {
            before.clear();
            before.extend_from_slice(&level.active);
        }
        Ok(())
    }
}
