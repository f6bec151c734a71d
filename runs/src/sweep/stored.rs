//! A sweep in a file: opened or continued, executed, written when it is complete.

use std::path::Path;
use std::time::Instant;

use super::head::Head;
use super::journal::{self, Journal};
use super::row::Row;
use super::{Plan, execute, table};
use crate::project;

/// The runs of a sweep that are in its file, or in the journal beside it.
pub struct Stored {
    /// Metadata.
    pub head: Head,
    /// Runs that have ended, by their numbers.
    pub rows: Vec<Row>,
    /// Runs of this execution per second; `None` if the file was complete.
    pub speed: Option<f64>,
}

/// Settings of an execution, with its callbacks.
pub struct Execution<'a> {
    /// Runs at the same time.
    pub jobs: usize,
    /// Continues a sweep that was interrupted.
    pub resume: bool,
    /// Asked before and during each run; `false` interrupts the sweep.
    pub go_on: &'a (dyn Fn() -> bool + Sync),
    /// Told how many runs have ended, and how many the sweep has: before the first run, and after each one.
    pub progress: &'a mut (dyn FnMut(usize, usize) + Send),
}

/// Executes a sweep into the file `out`. Runs that have ended are in the journal beside it until all have.
///
/// # Errors
/// The file cannot be written, belongs to something else or to another sweep, or the spec has changed meanwhile.
pub fn run(plan: &Plan, out: &Path, execution: Execution<'_>) -> Result<Stored, String> {
    folder(out)?;
    // A completed sweep is only read.
    if execution.resume && !journal::path(out).exists() && out.exists() {
        let (head, rows) = table::read(out)?;
        return match plan.head.differs(&head) {
            Some(why) => Err(format!("{} belongs to another sweep, {why}; choose another `--out`", out.display())),
            None => Ok(Stored { head, rows, speed: None }),
        };
    }
    // Checked before any run.
    let target = table::target(out, &project::sources(plan.spec(), &plan.report))?;
    let (mut journal, mut rows) = Journal::open(out, &plan.head, execution.resume)?;
    let done: std::collections::BTreeSet<u64> = rows.iter().map(|r| r.run).collect();
    let pending: Vec<u64> = plan.head.own().filter(|run| !done.contains(run)).collect();
    let all = done.len() + pending.len();
    (execution.progress)(done.len(), all);
    let started = Instant::now();
    let mut finished = |row: Row| {
        journal.add(&row)?;
        rows.push(row);
        (execution.progress)(rows.len(), all);
        Ok(())
    };
    execute::execute(plan, &pending, execution.jobs, execution.go_on, &mut finished)?;
    let took = started.elapsed().as_secs_f64();
    rows.sort_by_key(|r| r.run);
    if rows.len() == all {
        table::write(target, &plan.head, &rows)?;
        journal.remove()?;
    }
    let speed = (rows.len() - done.len()) as f64 / took.max(1e-9);
    Ok(Stored { head: plan.head.clone(), rows, speed: Some(speed) })
}

/// Makes the folder of a file.
///
/// # Errors
/// It cannot be made.
pub fn folder(out: &Path) -> Result<(), String> {
    match out.parent().filter(|p| !p.as_os_str().is_empty()) {
        Some(folder) => std::fs::create_dir_all(folder).map_err(|e| format!("cannot create {}: {e}", folder.display())),
        None => Ok(()),
    }
}
