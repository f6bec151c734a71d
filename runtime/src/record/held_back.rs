//! Which limit held which level back, for how long and how hard: from the multipliers of the
//! solver.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::controller::{Controller, Stage};
use crate::evaluator::Member;
use crate::tick::{Recorder, Tick};

/// A level that could not do all it asked for, because of a row above it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HeldBack {
    /// The level that gave way.
    pub level: String,
    /// The task it gave way to.
    pub by_task: String,
    /// The row of that task.
    pub by_row: String,
    /// Share of ticks.
    pub share: f64,
    /// The largest multiplier: by how much half the cost of the level would fall per unit of the bound.
    pub max_multiplier: f64,
    /// When it was seen, in s.
    pub at_s: f64,
}

#[derive(Clone, Copy, Default)]
struct Count {
    ticks: usize,
    most: f64,
    at: f64,
}

/// Counts them during a run.
pub struct HeldBackRecorder {
    /// The tasks of each stage, and the names of its levels.
    stages: Vec<(Vec<Member>, Vec<String>)>,
    counts: BTreeMap<(usize, usize, usize, usize), Count>,
    ticks: usize,
}

impl HeldBackRecorder {
    /// For a run of this controller.
    pub fn new(controller: &Controller) -> Self {
        let stage = |s: &Stage| (s.evaluator().members().to_vec(), s.level_names().to_vec());
        HeldBackRecorder { stages: controller.stages().iter().map(stage).collect(), counts: BTreeMap::new(), ticks: 0 }
    }

    /// What was seen so far: by level, then the longest first.
    pub fn result(&self) -> Vec<HeldBack> {
        let mut all: Vec<((usize, usize), usize, HeldBack)> = Vec::new();
        for (&(stage, level, by_level, by_row), c) in &self.counts {
            let (members, levels) = &self.stages[stage];
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
            all.push(((stage, level), c.ticks, held));
        }
        all.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.cmp(&a.1)));
        all.into_iter().map(|x| x.2).collect()
    }
}

impl Recorder for HeldBackRecorder {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        self.ticks += 1;
        if tick.fault.is_some() {
            return Ok(());
        }
        for b in &tick.solution.blocking {
            let c = self.counts.entry((tick.stage, b.level, b.by_level, b.by_row)).or_default();
            c.ticks += 1;
            if b.multiplier > c.most {
                (c.most, c.at) = (b.multiplier, tick.time);
            }
        }
        Ok(())
    }
}
