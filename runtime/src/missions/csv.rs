//! The log of a mission as CSV: the state of every member, one line an instant.

use std::io::Write;

use mission::kind::{Cell, Execution};

use crate::csv::cell;

use super::{Instant, MissionRecorder};

/// Writes an instant a line: time in s, the columns of the kind of mission, and for each member that runs a controller the
/// state that its machine is in.
pub struct MissionCsv<W: Write> {
    out: W,
}

impl<W: Write> MissionCsv<W> {
    /// A log; its header is written when the run begins.
    pub fn new(out: W) -> MissionCsv<W> {
        MissionCsv { out }
    }

    /// Writes what is left.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(mut self) -> std::io::Result<()> {
        self.out.flush()
    }

    fn header(&mut self, execution: &dyn Execution, running: &[String]) -> std::io::Result<()> {
        write!(self.out, "time")?;
        for column in execution.columns() {
            write!(self.out, ",{}", cell(&column))?;
        }
        for name in running {
            write!(self.out, ",{}", cell(&format!("{name}.state")))?;
        }
        writeln!(self.out)
    }
}

impl<W: Write> MissionRecorder for MissionCsv<W> {
    fn begin(&mut self, execution: &dyn Execution, running: &[String]) -> std::io::Result<()> {
        self.header(execution, running)
    }

    fn instant(&mut self, instant: &Instant) -> std::io::Result<()> {
        write!(self.out, "{}", instant.time)?;
        for value in instant.execution.row() {
            match value {
                Cell::Text(text) => write!(self.out, ",{}", cell(&text))?,
                Cell::Count(count) => write!(self.out, ",{count}")?,
                Cell::Number(x, _) => write!(self.out, ",{x}")?,
            }
        }
        for state in instant.workers.states() {
            write!(self.out, ",{}", cell(state))?;
        }
        writeln!(self.out)
    }
}
