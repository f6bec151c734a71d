//! The log of a mission as CSV: where every robot is and what everybody does, one line an instant.

use std::io::Write;

use mission::kinds::schedule::execution::{Doing, Stage};
use mission::kinds::schedule::problem::Problem;

use crate::csv::cell;

use super::{Instant, MissionRecorder};

/// Writes an instant a line: time in s; of each robot its position in m, its speed in m/s and what it does; of each agent
/// its place in m, what it does, how many operations were served, and its waits so far in s; of each working robot that
/// runs a controller the state that its machine is in.
pub struct MissionCsv<W: Write> {
    out: W,
    /// How many working robots run controllers.
    running: usize,
}

/// The word for what a robot does.
pub fn stage(stage: Stage) -> &'static str {
    match stage {
        Stage::Home => "home",
        Stage::Going => "going",
        Stage::Waiting => "waiting",
        Stage::Approaching => "approaching",
        Stage::Serving => "serving",
        Stage::Returning => "returning",
        Stage::Unloading => "unloading",
        Stage::Recalled => "recalled",
        Stage::Lost => "lost",
    }
}

/// The word for what an agent does.
pub fn doing(doing: Doing) -> &'static str {
    match doing {
        Doing::Ready => "ready",
        Doing::Working => "working",
        Doing::Waiting => "waiting",
        Doing::Served => "served",
        Doing::Finished => "finished",
        Doing::Lost => "lost",
    }
}

impl<W: Write> MissionCsv<W> {
    /// Writes the header of a problem whose agents of these indices run controllers.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn new(mut out: W, problem: &Problem, running: &[usize]) -> std::io::Result<MissionCsv<W>> {
        write!(out, "time")?;
        for m in &problem.robots {
            for of in ["x", "y", "speed", "stage"] {
                write!(out, ",{}", cell(&format!("{}.{of}", m.name)))?;
            }
        }
        for a in &problem.agents {
            for of in ["x", "y", "doing", "served", "waited"] {
                write!(out, ",{}", cell(&format!("{}.{of}", a.name)))?;
            }
        }
        for name in running.iter().map(|i| problem.agents.get(*i).map_or("", |a| &a.name)) {
            write!(out, ",{}", cell(&format!("{name}.state")))?;
        }
        writeln!(out)?;
        Ok(MissionCsv { out, running: running.len() })
    }

    /// Writes what is left.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn finish(mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}

impl<W: Write> MissionRecorder for MissionCsv<W> {
    fn instant(&mut self, instant: &Instant) -> std::io::Result<()> {
        let execution = instant.execution;
        write!(self.out, "{}", instant.time)?;
        for view in (0..).map_while(|i| execution.robot(i)) {
            let ([x, y], [vx, vy]) = (view.position, view.velocity);
            write!(self.out, ",{x},{y},{},{}", f64::hypot(vx, vy), stage(view.stage))?;
        }
        let served = execution.statistics();
        for (i, view) in (0..).map_while(|i| execution.agent(i)).enumerate() {
            let [x, y] = view.place;
            let count = served.agents.get(i).map_or(0, |a| a.served);
            let waited = instant.waited.get(i).copied().unwrap_or(f64::NAN);
            write!(self.out, ",{x},{y},{},{count},{waited}", doing(view.doing))?;
        }
        for state in instant.workers.states().take(self.running) {
            write!(self.out, ",{}", cell(state))?;
        }
        writeln!(self.out)
    }
}
