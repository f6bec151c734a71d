//! `log.csv`: one row per tick.
//!
//! | column | content | unit |
//! |---|---|---|
//! | `time` | start of the tick | s |
//! | `state` | state of the machine, if one runs | |
//! | `q.JOINT` | true position; the base as `base_x`, `base_y`, `base_yaw` | rad or m |
//! | `v.JOINT` | velocity that the hierarchy chose | rad/s or m/s |
//! | `cmd.JOINT` | velocity that was commanded, after the low-level layer | rad/s or m/s |
//! | `margin.TASK` | smallest `h` over the rows of a limit | that of the rows |
//! | `error.TASK` | norm of a target's whole error | that of the rows; rad and m mixed for a pose |
//! | `error.TASK.PART` | norm of a part of it, such as `left.position` | m or rad |
//! | `signal.NAME.PART` | value that the controller uses for a signal or a variable, such as `signal.stem.x` | SI |
//! | `late` | 1 if the tick's budget was spent before its hierarchy was solved; present if there is a budget | |
//! | `fault` | fault that was found at this tick, or that keeps the robot still | |
//!
//! Names are quoted if necessary (RFC 4180). Numbers are written so that reading them yields the same double. Undefined
//! numbers, and those of tasks that do not run and of signals that are absent, are empty cells.

use std::io::Write;

use super::roster::Roster;
use super::signals::numbers;
use crate::controller::Controller;
use crate::csv::cell;
use crate::evaluator::{Evaluator, Member};
use crate::program::{Program, Subject};
use crate::tick::{Recorder, Tick};
use stdlib_tasks::task::RowKind;

/// Writes ticks to a stream.
pub struct CsvRecorder<W: Write> {
    out: W,
    roster: Roster,
    machine: bool,
    budget: bool,
    /// Indices of the numbers of signals in their table.
    signals: Vec<usize>,
}

impl<W: Write> CsvRecorder<W> {
    /// Writes the header.
    ///
    /// # Errors
    /// The stream failed.
    pub fn new(mut out: W, program: &Program, controller: &Controller) -> std::io::Result<Self> {
        let roster = Roster::new(controller);
        let names = header(program, &roster.members);
        writeln!(out, "{}", names.iter().map(|name| cell(name)).collect::<Vec<_>>().join(","))?;
        let signals = numbers(&program.interface).iter().map(|n| n.at).collect();
        Ok(CsvRecorder {
            out,
            roster,
            machine: program.run.subject == Subject::Machine,
            budget: program.run.tick_budget.is_some(),
            signals,
        })
    }

    /// Writes the buffered rows.
    ///
    /// # Errors
    /// The stream failed.
    pub fn finish(mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}

/// Names of the columns, unquoted.
pub fn header(program: &Program, members: &[Member]) -> Vec<String> {
    let mut names = vec!["time".to_string()];
    if program.run.subject == Subject::Machine {
        names.push("state".to_string());
    }
    names.extend(program.robot.q_names().iter().map(|n| format!("q.{n}")));
    for prefix in ["v", "cmd"] {
        names.extend(program.robot.model.dofs.iter().map(|d| format!("{prefix}.{}", d.name)));
    }
    for m in members {
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
    if program.run.tick_budget.is_some() {
        names.push("late".to_string());
    }
    names.push("fault".to_string());
    names
}

/// Smallest margin of a limit at the last tick.
pub fn margin(e: &Evaluator, m: &Member) -> f64 {
    e.margins()[m.margins.clone()].iter().copied().fold(f64::INFINITY, f64::min)
}

/// Norm of a target's whole error at the last tick.
pub fn error(e: &Evaluator, m: &Member) -> f64 {
    e.measures()[m.measures.clone()].iter().map(|x| x * x).sum::<f64>().sqrt()
}

impl<W: Write> Recorder for CsvRecorder<W> {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let out = &mut self.out;
        write!(out, "{}", tick.time)?;
        if self.machine {
            write!(out, ",{}", cell(tick.state))?;
        }
        let mut number = |x: f64| if x.is_finite() { write!(out, ",{x}") } else { write!(out, ",") };
        for x in tick.q.iter().chain(tick.v).chain(tick.command) {
            number(*x)?;
        }
        let running: Vec<(usize, &Member)> = self.roster.running(tick).collect();
        for (i, m) in self.roster.members.iter().enumerate() {
            let now = running.iter().find(|r| r.0 == i).map(|r| r.1);
            match m.row_kind {
                RowKind::Inequality => number(now.map_or(f64::NAN, |m| margin(tick.evaluator, m)))?,
                RowKind::Equality => {
                    number(now.map_or(f64::NAN, |m| error(tick.evaluator, m)))?;
                    for part in (0..m.measure_info.len()).filter(|_| m.measure_info.len() > 1) {
                        number(now.map_or(f64::NAN, |m| tick.evaluator.measures()[m.measures.start + part]))?;
                    }
                }
            }
        }
        let table = tick.controller.signal_table();
        for &at in &self.signals {
            number(table[at])?;
        }
        if self.budget {
            write!(out, ",{}", u8::from(tick.controller.is_late()))?;
        }
        writeln!(out, ",{}", tick.fault.map_or("", |f| f.kind().word()))
    }
}
