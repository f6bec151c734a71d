//! The log of a mission of layers as CSV: where every agent is and what it does, one line an instant.

use std::io::Write;

use mission::kinds::layers::execution::LayeredExecution;
use mission::kinds::layers::problem::Problem;

use crate::csv::cell;

use super::layered_words::doing;
use super::{Instant, MissionRecorder};

/// Writes an instant a line: time in s; of each agent where it is in m, what it does, its task and the object of it, and how
/// many tasks it has done.
pub struct LayeredCsv<W: Write> {
    out: W,
}

impl<W: Write> LayeredCsv<W> {
    /// Writes the header.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn new(mut out: W, problem: &Problem) -> std::io::Result<LayeredCsv<W>> {
        write!(out, "time")?;
        for who in &problem.agents {
            for of in ["x", "y", "z", "doing", "task", "object", "tasks"] {
                write!(out, ",{}", cell(&format!("{}.{of}", who.name)))?;
            }
        }
        writeln!(out)?;
        Ok(LayeredCsv { out })
    }

    /// Writes what is left.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}

impl<W: Write> MissionRecorder for LayeredCsv<W> {
    fn instant(&mut self, _: &Instant) -> std::io::Result<()> {
        Ok(())
    }

    fn layered(&mut self, time: f64, execution: &LayeredExecution) -> std::io::Result<()> {
        let problem = execution.problem();
        write!(self.out, "{time}")?;
        for view in (0..).map_while(|agent| execution.agent(agent)) {
            let [x, y, z] = view.position;
            let task = view.work.and_then(|work| problem.tasks.get(work.task)).map(|task| cell(&task.name));
            let object = view.work.and_then(|work| problem.objects.get(work.object?)).map(|thing| cell(&thing.name));
            let (task, object) = (task.unwrap_or_default(), object.unwrap_or_default());
            write!(self.out, ",{x},{y},{z},{},{task},{object},{}", doing(view.doing), view.tasks)?;
        }
        writeln!(self.out)
    }
}
