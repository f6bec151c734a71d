//! The numbers of a run as columns, one row per tick: what `log.csv` and tables in memory have in common.
//!
//! | column | content | unit |
//! |---|---|---|
//! | `time` | start of the tick | s |
//! | `q.JOINT` | true position; the base as `base_x`, `base_y`, `base_yaw` | rad or m |
//! | `v.JOINT` | velocity that the hierarchy chose | rad/s or m/s |
//! | `cmd.JOINT` | velocity that was commanded, after the low-level layer | rad/s or m/s |
//! | `margin.TASK` | smallest `h` over the rows of a limit | that of the rows |
//! | `error.TASK` | norm of a target's whole error | that of the rows; rad and m mixed for a pose |
//! | `error.TASK.PART` | norm of a part of it, such as `left.position` | m or rad |
//! | `signal.NAME.PART` | value that the controller uses for a signal or a variable, such as `signal.stem.x` | SI |
//! | `late` | 1 if the tick's budget was spent before its hierarchy was solved; present if there is a budget | |

use std::ops::Range;

use stdlib_tasks::task::RowKind;

use super::roster::Roster;
use super::signals::numbers;
use crate::controller::{Controller, StackController};
use crate::evaluator::{Evaluator, Member};
use crate::program::Program;
use crate::tick::Tick;

/// The columns of a run. A number that is not defined, of a task that does not run or of a signal that is absent, is not
/// finite.
pub struct Columns {
    roster: Roster,
    /// For each stack, the numbers of all tasks.
    sources: Vec<Vec<Source>>,
    budget: bool,
    /// Indices of the numbers of signals in their table.
    signals: Vec<usize>,
}

/// A number of a task, from an evaluator.
#[derive(Clone, Debug)]
enum Source {
    /// Smallest of some margins.
    Margin(Range<usize>),
    /// Norm of some measures.
    Error(Range<usize>),
    /// A measure.
    Part(usize),
    /// The task does not run.
    Absent,
}

impl Source {
    fn number(&self, e: &Evaluator) -> f64 {
        match self {
            Source::Margin(range) => e.margins()[range.clone()].iter().copied().fold(f64::INFINITY, f64::min),
            Source::Error(range) => e.measures()[range.clone()].iter().map(|x| x * x).sum::<f64>().sqrt(),
            Source::Part(i) => e.measures()[*i],
            Source::Absent => f64::NAN,
        }
    }
}

/// Numbers of all tasks while a stack runs. They are looked up once: a tick allocates nothing.
fn sources(roster: &Roster, stack: &StackController) -> Vec<Source> {
    let mut all = Vec::new();
    for m in &roster.members {
        let now = stack.evaluator().members().iter().find(|n| n.program_index == m.program_index);
        let of = |source: &dyn Fn(&Member) -> Source| now.map_or(Source::Absent, source);
        match m.row_kind {
            RowKind::Inequality => all.push(of(&|m| Source::Margin(m.margins.clone()))),
            RowKind::Equality => {
                all.push(of(&|m| Source::Error(m.measures.clone())));
                for part in (0..m.measure_info.len()).filter(|_| m.measure_info.len() > 1) {
                    all.push(of(&|m| Source::Part(m.measures.start + part)));
                }
            }
        }
    }
    all
}

impl Columns {
    /// Prepares the columns of a controller.
    pub fn new(program: &Program, controller: &Controller) -> Columns {
        let roster = Roster::new(controller);
        Columns {
            sources: controller.stacks().iter().map(|stack| sources(&roster, stack)).collect(),
            roster,
            budget: program.run.tick_budget.is_some(),
            signals: numbers(&program.interface).iter().map(|n| n.at).collect(),
        }
    }

    /// Names of the columns.
    pub fn names(&self, program: &Program) -> Vec<String> {
        let mut names = vec!["time".to_string()];
        names.extend(program.robot.q_names().iter().map(|n| format!("q.{n}")));
        for prefix in ["v", "cmd"] {
            names.extend(program.robot.model.dofs.iter().map(|d| format!("{prefix}.{}", d.name)));
        }
        for m in &self.roster.members {
            match m.row_kind {
                RowKind::Inequality => names.push(format!("margin.{}", m.name)),
                RowKind::Equality => {
                    names.push(format!("error.{}", m.name));
                    if m.measure_info.len() > 1 {
                        names.extend(m.measure_info.iter().map(|x| format!("error.{}.{}", m.name, x.name)));
                    }
                }
            }
        }
        let signal =
            |n: super::signals::SignalNumber| format!("signal.{}{}", program.interface.signals[n.signal].name, n.part);
        names.extend(numbers(&program.interface).into_iter().map(signal));
        if self.budget {
            names.push("late".to_string());
        }
        names
    }

    /// Replaces a row by the numbers of a tick.
    pub fn fill(&self, tick: &Tick, row: &mut Vec<f64>) {
        row.clear();
        row.push(tick.time);
        row.extend(tick.q.iter().chain(tick.v).chain(tick.command));
        row.extend(self.sources[tick.stack].iter().map(|source| source.number(tick.evaluator)));
        let table = tick.controller.signal_table();
        row.extend(self.signals.iter().map(|&at| table[at]));
        if self.budget {
            row.push(f64::from(u8::from(tick.controller.is_late())));
        }
    }
}

/// Smallest margin of a limit at the last tick.
pub fn margin(e: &Evaluator, m: &Member) -> f64 {
    Source::Margin(m.margins.clone()).number(e)
}

/// Norm of a target's whole error at the last tick.
pub fn error(e: &Evaluator, m: &Member) -> f64 {
    Source::Error(m.measures.clone()).number(e)
}
