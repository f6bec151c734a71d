//! The slowest ticks of a run, and what changed at them: the rows that came to their bounds or left them. A tick takes long
//! where many do, or where a stack runs for the first time.

use serde::Serialize;
use solver::Active;

use crate::controller::Controller;
use crate::tick::{Recorder, Tick};

/// So many are kept.
const KEPT: usize = 3;

/// So many rows of each are named.
const NAMED: usize = 12;

/// A slow tick.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SlowTick {
    /// Time of the controller, in microseconds.
    pub us: f64,
    /// When, in s.
    pub at_s: f64,
    /// The state of the machine, by its path; none where no machine runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub state: Option<String>,
    /// The first tick of its stack since another one ran: nothing is known of the tick before.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub first: bool,
    /// Number of rows that changed between free, a bound and violated since the tick before.
    pub changed: usize,
    /// Some of them, as `TASK ROW`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rows: Vec<String>,
}

/// Keeps the slowest ticks.
pub struct SlowTicksRecorder {
    /// The slowest first.
    slowest: Vec<SlowTick>,
    /// The stack of the last tick, and for each level how its rows stood.
    stage: Option<usize>,
    before: Vec<Vec<Active>>,
    machine: bool,
}

impl SlowTicksRecorder {
    /// For a run of this controller.
    pub fn new(controller: &Controller) -> Self {
        let machine = controller.machine().states.iter().any(|s| !s.name.is_empty());
        SlowTicksRecorder { slowest: Vec::with_capacity(KEPT + 1), stage: None, before: Vec::new(), machine }
    }

    /// The slowest ticks, the slowest first.
    pub fn result(&self) -> Vec<SlowTick> {
        self.slowest.clone()
    }

    /// Number of rows that stand otherwise than at the tick before, and the names of some.
    fn changed(&self, tick: &Tick) -> (usize, Vec<String>) {
        let members = tick.controller.stages()[tick.stage].evaluator().members();
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
        if tick.fault.is_some() {
            // Nothing was solved.
            self.stage = None;
            return Ok(());
        }
        let us = tick.elapsed * 1e6;
        let first = self.stage != Some(tick.stage);
        if self.slowest.len() < KEPT || self.slowest.last().is_some_and(|s| us > s.us) {
            let (changed, rows) = if first { (0, Vec::new()) } else { self.changed(tick) };
            let state = self.machine.then(|| tick.state.to_string());
            let at = self.slowest.partition_point(|s| s.us >= us);
            self.slowest.insert(at, SlowTick { us, at_s: tick.time, state, first, changed, rows });
            self.slowest.truncate(KEPT);
        }
        self.stage = Some(tick.stage);
        self.before.resize_with(tick.solution.levels.len(), Vec::new);
        for (before, level) in self.before.iter_mut().zip(&tick.solution.levels) {
            before.clear();
            before.extend_from_slice(&level.active);
        }
        Ok(())
    }
}
