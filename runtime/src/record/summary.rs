//! `summary.json`: what a run came to, task by task and level by level.

use std::collections::BTreeMap;

use serde::Serialize;
use solver::{Active, LevelStatus};
use stdlib_tasks::task::Nature;

use crate::controller::{Controller, Stage};
use crate::evaluator::Member;
use crate::fault::FaultKind;
use crate::program::{Program, Subject};
use crate::quantity::quantity;
use crate::record::csv;
use crate::record::expectations::ExpectationRecord;
use crate::record::held_back::{HeldBack, HeldBackRecorder};
use crate::record::roster::{Roster, RosterLevel};
use crate::record::verify::Verification;
use crate::simulate::{Recorder, Tick};

/// A margin counts as passed below minus this, in the row's SI unit. The solver meets a bound to about 1e-11 of the
/// row's size, and a joint that rests at its limit has a margin of zero up to rounding.
pub const MARGIN_TOLERANCE: f64 = 1e-9;

/// A run in numbers. SI units throughout.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Name of the program.
    pub program: String,
    /// Ticks that were run.
    pub ticks: usize,
    /// Simulated time, in s.
    pub duration_s: f64,
    /// True where every fault was answered and no margin fell below zero (by more than [`MARGIN_TOLERANCE`]).
    pub ok: bool,
    /// True where a fault that no transition answers keeps the robot still.
    #[serde(skip)]
    pub halted: bool,
    /// What became of the expectations of a scenario.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub expectations: Vec<ExpectationRecord>,
    /// Faults, in order. One that no transition answers keeps the robot still until the end.
    pub faults: Vec<FaultRecord>,
    /// States that the machine was in, in order; empty where none ran.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub states: Vec<StateRecord>,
    /// Tasks, by name.
    pub tasks: BTreeMap<String, TaskSummary>,
    /// Levels, the most important first.
    pub levels: Vec<LevelSummary>,
    /// Levels that gave way to limits above them, where the solver tells.
    pub held_back: Vec<HeldBack>,
    /// The second solver's opinion, if it was asked.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub verification: Option<Verification>,
    /// Time of the controller per tick, in microseconds; without the ticks after a fault, which compute nothing.
    pub tick_us: Percentiles,
    /// What to do about limits that were passed by no more than sampling in time can lose.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub hints: Vec<String>,
    /// Files that were written.
    pub outputs: Vec<String>,
}

/// A fault and when it came.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FaultRecord {
    /// Time, in s.
    pub time: f64,
    /// The word of its [`FaultKind`].
    pub kind: String,
    /// In words.
    pub text: String,
    /// A transition answered it; otherwise the robot was kept still from then on.
    pub answered: bool,
}

/// A stay in a state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StateRecord {
    /// The state's path.
    pub state: String,
    /// From when, in s.
    pub from_s: f64,
    /// Until when, in s.
    pub to_s: f64,
}

/// How a task fared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TaskSummary {
    /// Its type.
    pub kind: String,
    /// Its level.
    pub level: String,
    /// SI unit of the figures; `rad or m` where rows of several units stand in one task.
    pub unit: String,
    /// Limits: the smallest `h`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_margin: Option<f64>,
    /// Limits: the row that had it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_margin_row: Option<String>,
    /// Limits: the SI unit of that row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_margin_unit: Option<String>,
    /// Limits: the smallest `h` at the last tick.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub final_margin: Option<f64>,
    /// Targets: the largest norm of the error.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_error: Option<f64>,
    /// Targets: the norm of the error at the last tick.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub final_error: Option<f64>,
    /// Targets with several parts: each part's largest and last error.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub errors: BTreeMap<String, PartError>,
    /// When the smallest margin or the largest error was seen, in s.
    pub at_s: f64,
    /// Limits: share of ticks at which some row was at its bound.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub active_share: Option<f64>,
    /// Limits: rows that were ever at their bound.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub active_rows: Vec<String>,
    /// Ticks at which a row was undefined and left free.
    pub undefined_ticks: usize,
}

/// The error of a part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartError {
    /// SI unit.
    pub unit: String,
    /// The largest.
    pub max: f64,
    /// At the last tick.
    #[serde(rename = "final")]
    pub last: f64,
    /// When the largest was seen, in s.
    pub at_s: f64,
}

/// How a level fared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LevelSummary {
    /// Its stack, where a machine ran.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stack: Option<String>,
    /// Its name.
    pub name: String,
    /// Takes no slack.
    pub hard: bool,
    /// Number of rows.
    pub rows: usize,
    /// Share of ticks at which the level could not be met in full.
    pub relaxed_share: f64,
    /// Share of ticks at which one of its inequality rows was at its bound.
    pub saturated_share: f64,
    /// The largest weighted norm of its slack.
    pub max_violation: f64,
    /// The fewest degrees of freedom that it left.
    pub min_freedom: usize,
}

/// Percentiles of a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Percentiles {
    /// Half of the ticks took longer.
    pub median: f64,
    /// One in a hundred took longer.
    pub p99: f64,
    /// The longest.
    pub max: f64,
}

impl Percentiles {
    /// Of a sample, which is sorted in place; zeros for an empty one.
    pub fn of(sample: &mut [f32]) -> Percentiles {
        if sample.is_empty() {
            return Percentiles::default();
        }
        sample.sort_unstable_by(f32::total_cmp);
        let at = |share: f64| f64::from(sample[((sample.len() - 1) as f64 * share).round() as usize]);
        Percentiles { median: at(0.5), p99: at(0.99), max: at(1.0) }
    }
}

#[derive(Clone, Copy)]
struct PartStatistics {
    worst: f64,
    at: f64,
    last: f64,
}

struct TaskStatistics {
    ticks: usize,
    worst: f64,
    worst_row: usize,
    at: f64,
    last: f64,
    parts: Vec<PartStatistics>,
    active: usize,
    rows_active: Vec<bool>,
    undefined: usize,
}

/// The unit of a task's figures; several where rows of several units stand in it.
fn unit(m: &Member) -> String {
    let infos = m.row_info.iter().map(|r| r.dimension);
    let mut units: Vec<String> = Vec::new();
    for d in infos {
        let text = d.to_string();
        if !units.contains(&text) {
            units.push(text);
        }
    }
    units.join(" or ")
}

/// What to do about a limit that was passed without a reserve, by no more than a tick can lose.
fn sampling_hint(controller: &Controller, m: &Member, s: &TaskStatistics) -> Option<String> {
    let (evaluator, member) = controller.stages().iter().find_map(|stage| {
        let members = stage.evaluator().members();
        Some((stage.evaluator(), members.iter().position(|x| x.program_index == m.program_index)?))
    })?;
    let (loss, reserve) = (evaluator.sampled_loss(member), evaluator.reserve(member));
    let (loss, reserve) = (*loss.get(s.worst_row)?, *reserve.get(s.worst_row)?);
    let explained = m.nature == Nature::Limit && s.worst < -MARGIN_TOLERANCE && -s.worst <= loss && reserve < loss;
    let text = |bound: String| {
        format!(
            "`{}` was passed by {}, and sampling in time can lose {bound}: use `sampled_margin auto`",
            m.name,
            quantity(-s.worst, "m")
        )
    };
    explained.then(|| match loss.is_finite() {
        true => text(format!("up to {}", quantity(loss, "m"))),
        false => text("as much".to_string()) + ", with `joint_velocity_limits` on a hard level down to its own",
    })
}

struct LevelStatistics {
    ticks: usize,
    relaxed: usize,
    saturated: usize,
    violation: f64,
    freedom: usize,
}

/// Gathers a summary while a run goes on.
pub struct SummaryRecorder {
    roster: Roster,
    tasks: Vec<TaskStatistics>,
    levels: Vec<LevelStatistics>,
    ticks: usize,
    faults: Vec<FaultRecord>,
    /// The kind of fault of the last tick.
    fault: Option<FaultKind>,
    halted: bool,
    states: Vec<StateRecord>,
    elapsed_us: Vec<f32>,
    held_back: HeldBackRecorder,
}

impl SummaryRecorder {
    /// For a run of so many ticks.
    pub fn new(controller: &Controller, ticks: usize) -> Self {
        let roster = Roster::new(controller);
        let tasks = (roster.members.iter())
            .map(|m| TaskStatistics {
                ticks: 0,
                worst: if m.nature == Nature::Limit { f64::INFINITY } else { 0.0 },
                worst_row: 0,
                at: 0.0,
                last: f64::NAN,
                parts: vec![PartStatistics { worst: 0.0, at: 0.0, last: f64::NAN }; m.measure_info.len()],
                active: 0,
                rows_active: vec![false; m.row_info.len()],
                undefined: 0,
            })
            .collect();
        let nv = controller.evaluator().model().nv();
        let level = |_| LevelStatistics { ticks: 0, relaxed: 0, saturated: 0, violation: 0.0, freedom: nv };
        let levels = roster.levels.iter().map(level).collect();
        SummaryRecorder {
            roster,
            tasks,
            levels,
            ticks: 0,
            faults: Vec::new(),
            fault: None,
            halted: false,
            states: Vec::new(),
            elapsed_us: Vec::with_capacity(ticks),
            held_back: HeldBackRecorder::new(controller),
        }
    }

    /// The summary so far.
    pub fn summary(&mut self, program: &Program, controller: &Controller, outputs: Vec<String>) -> Summary {
        let machine = program.run.subject == Subject::Machine;
        let share = |n: usize, of: usize| if of == 0 { 0.0 } else { n as f64 / of as f64 };
        let level_of = |m: &Member| {
            let named = |s: &Stage| {
                let own = s.evaluator().members().iter().find(|x| x.program_index == m.program_index)?;
                s.level_names().get(own.level).cloned()
            };
            controller.stages().iter().find_map(named).unwrap_or_default()
        };
        let mut tasks = BTreeMap::new();
        for (m, s) in self.roster.members.iter().zip(&self.tasks).filter(|(_, s)| s.ticks > 0 || !machine) {
            let limit = m.nature == Nature::Limit;
            let named = |used: &[bool]| {
                m.row_info.iter().zip(used).filter(|(_, u)| **u).map(|(r, _)| r.name.clone()).collect::<Vec<_>>()
            };
            let errors = if m.measure_info.len() > 1 {
                let part = |(x, p): (&stdlib_tasks::task::Measure, &PartStatistics)| {
                    (
                        x.name.clone(),
                        PartError { unit: x.dimension.to_string(), max: p.worst, last: p.last, at_s: p.at },
                    )
                };
                m.measure_info.iter().zip(&s.parts).map(part).collect()
            } else {
                BTreeMap::new()
            };
            let summary = TaskSummary {
                kind: m.kind.to_string(),
                level: level_of(m),
                unit: unit(m),
                min_margin: limit.then_some(s.worst),
                min_margin_row: limit.then(|| m.row_info.get(s.worst_row).map(|r| r.name.clone())).flatten(),
                min_margin_unit: limit.then(|| m.row_info.get(s.worst_row).map(|r| r.dimension.to_string())).flatten(),
                final_margin: limit.then_some(s.last),
                max_error: (!limit).then_some(s.worst),
                final_error: (!limit).then_some(s.last),
                errors,
                at_s: s.at,
                active_share: limit.then(|| share(s.active, s.ticks)),
                active_rows: if limit { named(&s.rows_active) } else { Vec::new() },
                undefined_ticks: s.undefined,
            };
            tasks.insert(m.name.clone(), summary);
        }
        let stack = |l: &RosterLevel| program.stacks.get(l.stack).map(|s| s.name.clone()).filter(|_| machine);
        let level = |(l, s): (&RosterLevel, &LevelStatistics)| LevelSummary {
            stack: stack(l),
            name: l.name.clone(),
            hard: l.hard,
            rows: l.rows,
            relaxed_share: share(s.relaxed, s.ticks),
            saturated_share: share(s.saturated, s.ticks),
            max_violation: s.violation,
            min_freedom: s.freedom.saturating_sub(l.locked),
        };
        let levels = self.roster.levels.iter().zip(&self.levels).filter(|(_, s)| s.ticks > 0 || !machine);
        let levels = levels.map(level).collect();
        let hints = self.roster.members.iter().zip(&self.tasks);
        let hints = hints.filter_map(|(m, s)| sampling_hint(controller, m, s)).collect();
        let passed = tasks.values().any(|t| t.min_margin.is_some_and(|m| m < -MARGIN_TOLERANCE));
        Summary {
            program: program.name.clone(),
            ticks: self.ticks,
            duration_s: self.ticks as f64 * program.robot.period,
            ok: !self.halted && !passed,
            halted: self.halted,
            expectations: Vec::new(),
            faults: self.faults.clone(),
            states: self.states.clone(),
            tasks,
            levels,
            held_back: self.held_back.result(),
            verification: None,
            tick_us: Percentiles::of(&mut self.elapsed_us),
            hints,
            outputs,
        }
    }
}

impl Recorder for SummaryRecorder {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        self.ticks += 1;
        self.held_back.tick(tick)?;
        if !self.halted {
            self.elapsed_us.push((tick.elapsed * 1e6) as f32);
        }
        self.note_fault(tick);
        self.note_state(tick);
        let frozen = tick.fault.is_some();
        let running: Vec<(usize, &Member)> = self.roster.running(tick).collect();
        for (place, (i, m)) in running.into_iter().enumerate() {
            task(&mut self.tasks[i], place, m, tick, frozen);
        }
        if frozen {
            return Ok(());
        }
        for (l, s) in tick.solution.levels.iter().zip(&mut self.levels[self.roster.running_levels(tick)]) {
            s.ticks += 1;
            s.relaxed += usize::from(l.status == LevelStatus::Relaxed);
            s.saturated += usize::from(l.active.iter().any(|a| matches!(a, Active::Lower | Active::Upper)));
            if l.status != LevelStatus::NotSolved {
                s.violation = s.violation.max(l.violation);
                s.freedom = s.freedom.min(l.freedom);
            }
        }
        Ok(())
    }
}

impl SummaryRecorder {
    fn note_fault(&mut self, tick: &Tick) {
        let kind = tick.fault.map(|f| f.kind());
        if let (Some(fault), true) = (&tick.fault, kind != self.fault) {
            let text = tick.controller.describe(fault);
            let kind = fault.kind().word().to_string();
            self.faults.push(FaultRecord { time: tick.time, kind, text, answered: true });
        }
        self.fault = kind;
        self.halted = tick.controller.is_halted();
        // A fault that was found while a tick was worked out is answered, or not, at the next one.
        if let Some(last) = self.faults.last_mut().filter(|_| self.halted) {
            last.answered = false;
        }
    }

    fn note_state(&mut self, tick: &Tick) {
        if tick.state.is_empty() {
            return;
        }
        match self.states.last_mut() {
            Some(last) if last.state == tick.state => last.to_s = tick.time,
            _ => self.states.push(StateRecord { state: tick.state.to_string(), from_s: tick.time, to_s: tick.time }),
        }
    }
}

/// Takes note of a task at a tick; `place` is its place in the stack.
fn task(s: &mut TaskStatistics, place: usize, m: &Member, tick: &Tick, frozen: bool) {
    let e = tick.evaluator;
    s.ticks += 1;
    s.undefined += usize::from(e.undefined()[place] && !frozen);
    match m.nature {
        Nature::Limit => {
            for (row, &h) in e.margins()[m.margins.clone()].iter().enumerate() {
                if h < s.worst {
                    (s.worst, s.worst_row, s.at) = (h, row, tick.time);
                }
            }
            s.last = csv::margin(e, m);
            let active = &tick.solution.levels[m.level].active;
            let mut any = false;
            for (row, r) in m.rows.clone().enumerate() {
                let bound = active.get(r).is_some_and(|a| *a != Active::Free) && !frozen;
                any |= bound;
                s.rows_active[row] |= bound;
            }
            s.active += usize::from(any);
        }
        Nature::Target => {
            let error = csv::error(e, m);
            s.last = error;
            if error > s.worst {
                (s.worst, s.at) = (error, tick.time);
            }
            for (part, &x) in s.parts.iter_mut().zip(&e.measures()[m.measures.clone()]) {
                part.last = x;
                if x > part.worst {
                    (part.worst, part.at) = (x, tick.time);
                }
            }
        }
    }
}
