//! `log.csv`: one row per tick, with the numbers of [`Columns`] and two texts: `state`, the state of the machine, if one runs, after
//! the time, and `fault` at the end, the fault that was found at this tick or that keeps the robot still.
//!
//! Names are quoted if necessary (RFC 4180). Numbers are written so that reading them yields the same double. Undefined
//! numbers, and those of tasks that do not run and of signals that are absent, are empty cells.

use std::io::Write;

use super::columns::Columns;
use crate::controller::Controller;
use crate::csv::cell;
use crate::program::{Program, Subject};
use crate::tick::{Recorder, Tick};

/// Writes ticks to a stream.
pub struct CsvRecorder<W: Write> {
    out: W,
    columns: Columns,
    machine: bool,
    row: Vec<f64>,
}

impl<W: Write> CsvRecorder<W> {
    /// Writes the header.
    ///
    /// # Errors
    /// The stream failed.
    pub fn new(mut out: W, program: &Program, controller: &Controller) -> std::io::Result<Self> {
        let columns = Columns::new(program, controller);
        let machine = program.run.subject == Subject::Machine;
        let names = header(program, &columns);
        writeln!(out, "{}", names.iter().map(|name| cell(name)).collect::<Vec<_>>().join(","))?;
        Ok(CsvRecorder { out, columns, machine, row: Vec::new() })
    }

    /// Writes the buffered rows.
    ///
    /// # Errors
    /// The stream failed.
    pub fn finish(mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}

/// Names of all columns, unquoted.
pub fn header(program: &Program, columns: &Columns) -> Vec<String> {
    let mut names = columns.names(program);
    if program.run.subject == Subject::Machine {
        names.insert(1, "state".to_string());
    }
    names.push("fault".to_string());
    names
}

impl<W: Write> Recorder for CsvRecorder<W> {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        self.columns.fill(tick, &mut self.row);
        let out = &mut self.out;
        write!(out, "{}", tick.time)?;
        if self.machine {
            write!(out, ",{}", cell(tick.state))?;
        }
        for &x in &self.row[1..] {
            if x.is_finite() { write!(out, ",{x}")? } else { write!(out, ",")? }
        }
        writeln!(out, ",{}", tick.fault.map_or("", |f| f.kind().word()))
    }
}
