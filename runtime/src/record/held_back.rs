//! Levels that limits held back, for how long and how hard: from the multipliers of the solver.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::controller::{Controller, StackController};
use crate::evaluator::Member;
use crate::tick::{Recorder, Tick};

/// Level that could not reach its goal because of a row above it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeldBack {
    /// Name of the level that was held back.
    pub level: String,
    /// Name of the task that held it back.
    pub by_task: String,
    /// Name of that task's row.
    pub by_row: String,
    /// Fraction of the ticks.
    pub share: f64,
    /// Largest multiplier: decrease of half the cost of the level per unit of the bound.
    pub max_multiplier: f64,
    /// Time of the largest multiplier, in s.
    pub at_s: f64,
}

#[derive(Clone, Copy, Default)]
struct Count {
    ticks: usize,
    most: f64,
    at: f64,
}

/// Counts the levels that are held back during a run.
pub struct HeldBackRecorder {
    /// Tasks of each stack, and names of its levels.
    stacks: Vec<(Vec<Member>, Vec<String>)>,
    counts: BTreeMap<(usize, usize, usize, usize), Count>,
    ticks: usize,
}

impl HeldBackRecorder {
    /// Prepares for a run of this controller.
    pub fn new(controller: &Controller) -> Self {
        let stack = |s: &StackController| (s.evaluator().members().to_vec(), s.level_names().to_vec());
        HeldBackRecorder { stacks: controller.stacks().iter().map(stack).collect(), counts: BTreeMap::new(), ticks: 0 }
    }

    /// Counts so far, sorted by level, then by decreasing duration.
    pub fn result(&self) -> Vec<HeldBack> {
        let mut all: Vec<((usize, usize), usize, HeldBack)> = Vec::new();
        for (&(stack, level, by_level, by_row), c) in &self.counts {
            let (members, levels) = &self.stacks[stack];
            let Some(m) = members.iter().find(|m| m.level == by_level && m.rows.contains(&by_row)) else {
                continue;
            };
            let row = m.row_info.get(by_row - m.rows.start);
            let held = HeldBack {
                level: levels.get(level).cloned().unwrap_or_default(),
                by_task: m.name.clone(),
                by_row: row.map_or_else(String::new, |r| r.name.clone()),
                share: c.ticks as f64 / self.ticks.max(1) as f64,
                max_multiplier: c.most,
                at_s: c.at,
            };
            all.push(((stack, level), c.ticks, held));
        }
        all.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.cmp(&a.1)));
        all.into_iter().map(|x| x.2).collect()
    }
}

impl Recorder for HeldBackRecorder {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        self.ticks += 1;
        if tick.is_still() {
            return Ok(());
        }
        for b in &tick.solution.blocking {
            let c = self.counts.entry((tick.stack, b.level, b.by_level, b.by_row)).or_default();
            c.ticks += 1;
            if b.multiplier > c.most {
                (c.most, c.at) = (b.multiplier, tick.time);
            }
        }
        Ok(())
    }
}
