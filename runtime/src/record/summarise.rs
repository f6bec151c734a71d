//! Gathers the summary of a run during the run.

use std::collections::BTreeMap;

use solver::{Active, LevelStatus};
use stdlib_tasks::task::RowKind;

use super::summary::{
    FaultRecord, LateTicks, LevelSummary, MARGIN_TOLERANCE, PartError, Percentiles, StateRecord, Summary, TaskSummary,
    TickTimes, Waited,
};
use crate::controller::{Controller, StackController};
use crate::evaluator::Member;
use crate::fault::FaultKind;
use crate::physics::PlantRecord;
use crate::program::{Program, Subject};
use crate::quantity::quantity;
use crate::record::columns;
use crate::record::held_back::HeldBackRecorder;
use crate::record::joint_motion::JointMotionRecorder;
use crate::record::remarks::RemarksRecorder;
use crate::record::roster::{Roster, RosterLevel};
use crate::record::slow_ticks::SlowTicksRecorder;
use crate::stopping;
use crate::tick::{Recorder, Tick};

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

/// Unit of a task's figures; several if its rows have several units.
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

/// Number of entries into each state of the machine; empty if no machine ran.
fn entries(controller: &Controller) -> BTreeMap<String, u64> {
    let all = controller.machine().states.iter().zip(controller.entries()).skip(1);
    all.filter(|(_, n)| **n > 0).map(|(s, n)| (s.name.clone(), *n)).collect()
}

/// Hint for a limit that was violated without a reserve, by no more than a tick can lose.
fn sampling_hint(controller: &Controller, m: &Member, s: &TaskStatistics) -> Option<String> {
    let (stack, member) = controller.stacks().iter().find_map(|stack| {
        let members = stack.evaluator().members();
        Some((stack, members.iter().position(|x| x.program_index == m.program_index)?))
    })?;
    let evaluator = stack.evaluator();
    let hard = stack.problem().levels.get(evaluator.members().get(member)?.level)?.hard;
    if hard && evaluator.looks_ahead(member) {
        return None;
    }
    let (loss, reserve) = (evaluator.sampled_loss(member), evaluator.sampled_margin(member));
    let (loss, reserve) = (*loss.get(s.worst_row)?, *reserve.get(s.worst_row)?);
    let explained =
        m.row_kind == RowKind::Inequality && s.worst < -MARGIN_TOLERANCE && -s.worst <= loss && reserve < loss;
    // A limit on a hard level that writes no reserve looks ahead, and nothing is lost.
    let remedy = if hard { "remove its `sampled_margin`" } else { "use `sampled_margin auto`" };
    let text = |bound: String| {
        format!(
            "`{}` was passed by {}, and sampling in time can lose {bound}: {remedy}",
            m.name,
            quantity(-s.worst, "m")
        )
    };
    explained.then(|| match loss.is_finite() {
        true => text(format!("up to {}", quantity(loss, "m"))),
        false if hard => text("as much".to_string()),
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

/// Gathers a summary during a run.
pub struct SummaryRecorder {
    roster: Roster,
    tasks: Vec<TaskStatistics>,
    levels: Vec<LevelStatistics>,
    ticks: usize,
    faults: Vec<FaultRecord>,
    /// Kind of fault at the last tick.
    fault: Option<FaultKind>,
    /// True if a fault keeps the robot still.
    halted: bool,
    states: Vec<StateRecord>,
    /// Number of entries into the state of the last record before that record.
    entered_before: u64,
    elapsed_us: Vec<f32>,
    held_back: HeldBackRecorder,
    joints: JointMotionRecorder,
    slow: SlowTicksRecorder,
    remarks: RemarksRecorder,
    late: LateTicks,
    waited: Option<Waited>,
    /// Number of consecutive late ticks up to the last one.
    late_now: usize,
    plant: Option<PlantRecord>,
    diverged: Option<String>,
}

impl SummaryRecorder {
    /// Prepares for a run of so many ticks.
    pub fn new(controller: &Controller, ticks: usize) -> Self {
        let roster = Roster::new(controller);
        let tasks = (roster.members.iter())
            .map(|m| TaskStatistics {
                ticks: 0,
                worst: if m.row_kind == RowKind::Inequality { f64::INFINITY } else { 0.0 },
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
            entered_before: 0,
            elapsed_us: Vec::with_capacity(ticks),
            held_back: HeldBackRecorder::new(controller),
            joints: JointMotionRecorder::new(controller),
            slow: SlowTicksRecorder::new(controller),
            remarks: RemarksRecorder::new(controller),
            late: LateTicks::default(),
            waited: None,
            late_now: 0,
            plant: None,
            diverged: None,
        }
    }

    /// Summary so far.
    pub fn summary(&mut self, program: &Program, controller: &Controller, outputs: Vec<String>) -> Summary {
        let machine = program.run.subject == Subject::Machine;
        let share = |n: usize, of: usize| if of == 0 { 0.0 } else { n as f64 / of as f64 };
        let level_of = |m: &Member| {
            let named = |s: &StackController| {
                let own = s.evaluator().members().iter().find(|x| x.program_index == m.program_index)?;
                s.level_names().get(own.level).cloned()
            };
            controller.stacks().iter().find_map(named).unwrap_or_default()
        };
        let mut tasks = BTreeMap::new();
        for (m, s) in self.roster.members.iter().zip(&self.tasks).filter(|(_, s)| s.ticks > 0 || !machine) {
            let limit = m.row_kind == RowKind::Inequality;
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
            interrupted: false,
            diverged: self.diverged.clone(),
            plant: self.plant.clone(),
            ok: self.faults.iter().all(|f| f.answered) && !passed && self.diverged.is_none(),
            halted: self.halted,
            expectations: Vec::new(),
            faults: self.faults.clone(),
            states: self.states.clone(),
            entries: entries(controller),
            stopping: program.run_stacks().into_iter().filter_map(|s| stopping::of_stack(program, s)).collect(),
            tasks,
            levels,
            held_back: self.held_back.result(),
            joints: self.joints.result(),
            verification: None,
            late: program
                .run
                .tick_budget
                .map(|budget| LateTicks { budget_us: (1e9 * budget).round() * 1e-3, ..self.late }),
            waited: self.waited.clone(),
            tick_us: TickTimes { all: Percentiles::of(&mut self.elapsed_us), slowest: self.slow.result() },
            remarks: self.remarks.result(&self.faults, program.robot.period),
            hints,
            allowed: program.allowed.clone(),
            outputs,
        }
    }
}

impl Recorder for SummaryRecorder {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        self.ticks += 1;
        self.held_back.tick(tick)?;
        self.joints.tick(tick)?;
        self.slow.tick(tick)?;
        self.remarks.tick(tick)?;
        if !self.halted {
            self.elapsed_us.push((tick.elapsed * 1e6) as f32);
        }
        self.note_fault(tick);
        self.note_state(tick);
        self.note_late(tick);
        self.note_wait(tick);
        let frozen = tick.is_still();
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

    fn moved_by(&mut self, plant: &PlantRecord) {
        self.plant = Some(plant.clone());
    }

    fn diverged(&mut self, why: &str) {
        self.diverged = Some(why.to_string());
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
        self.halted = tick.controller.is_halted() || tick.controller.stands();
        // A fault that was found during a tick is answered, or not, at the next one.
        if let Some(last) = self.faults.last_mut().filter(|_| self.halted) {
            last.answered = false;
        }
    }

    fn note_late(&mut self, tick: &Tick) {
        if !tick.controller.is_late() {
            self.late_now = 0;
            return;
        }
        if self.late.ticks == 0 {
            self.late.first_s = tick.time;
        }
        self.late.ticks += 1;
        self.late_now += 1;
        self.late.in_a_row = self.late.in_a_row.max(self.late_now);
    }

    fn note_wait(&mut self, tick: &Tick) {
        let Some(signal) = tick.controller.awaited() else { return };
        let signal = tick.controller.signal_name(signal);
        match &mut self.waited {
            // The last one that was missing is the one to be told.
            Some(waited) => {
                waited.ticks += 1;
                if waited.signal != signal {
                    waited.signal = signal.to_string();
                }
            }
            None => self.waited = Some(Waited { signal: signal.to_string(), from_s: tick.time, ticks: 1 }),
        }
    }

    fn note_state(&mut self, tick: &Tick) {
        if tick.state.is_empty() {
            return;
        }
        let of = |s: &usize| tick.controller.entries().get(*s).copied().unwrap_or(1);
        let entries: u64 = tick.controller.leaves().iter().map(of).sum();
        match self.states.last_mut() {
            Some(last) if last.state == tick.state => {
                (last.to_s, last.entries) = (tick.time, entries.saturating_sub(self.entered_before));
            }
            _ => {
                self.entered_before = entries.saturating_sub(1);
                let (state, at) = (tick.state.to_string(), tick.time);
                self.states.push(StateRecord { state, from_s: at, to_s: at, entries: 1 });
            }
        }
    }
}

/// Records a task at a tick; `place` is its index in the stack.
fn task(s: &mut TaskStatistics, place: usize, m: &Member, tick: &Tick, frozen: bool) {
    let e = tick.evaluator;
    s.ticks += 1;
    s.undefined += usize::from(e.undefined()[place] && !frozen);
    match m.row_kind {
        RowKind::Inequality => {
            for (row, &h) in e.margins()[m.margins.clone()].iter().enumerate() {
                if h < s.worst {
                    (s.worst, s.worst_row, s.at) = (h, row, tick.time);
                }
            }
            s.last = columns::margin(e, m);
            let active = &tick.solution.levels[m.level].active;
            let mut any = false;
            for (row, r) in m.rows.clone().enumerate() {
                let bound = active.get(r).is_some_and(|a| *a != Active::Free) && !frozen;
                any |= bound;
                s.rows_active[row] |= bound;
            }
            s.active += usize::from(any);
        }
        RowKind::Equality => {
            let error = columns::error(e, m);
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
