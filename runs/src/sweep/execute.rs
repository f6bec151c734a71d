//! Executes runs of a sweep in parallel. The results do not depend on the assignment of runs to threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use dsl::Severity;
use runtime::Program;

use super::plan::{Plan, texts};
use super::row::{Closest, Expected, Row};
use crate::project::{self, Settings};
use crate::scenario_runner::{self, Judged};

/// Executes runs, `jobs` at a time, and passes each to `finished` as soon as it is complete. Ends early if `go_on`
/// returns false; interrupted runs are not passed on.
///
/// # Errors
/// The spec changed after the sweep began, or has different expectations or limits with some of the values; or
/// `finished` failed.
pub fn execute(
    plan: &Plan,
    runs: &[u64],
    jobs: usize,
    go_on: &(dyn Fn() -> bool + Sync),
    finished: &mut (dyn FnMut(Row) -> Result<(), String> + Send),
) -> Result<(), String> {
    let (next, stopped) = (AtomicUsize::new(0), AtomicBool::new(false));
    let trouble: Mutex<Option<String>> = Mutex::new(None);
    let finished = Mutex::new(finished);
    let on = || go_on() && !stopped.load(Ordering::Relaxed);
    let stop = |message: String| {
        stopped.store(true, Ordering::Relaxed);
        if let Ok(mut trouble) = trouble.lock() {
            trouble.get_or_insert(message);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..jobs.clamp(1, runs.len().max(1)) {
            scope.spawn(|| {
                let mut worker = Worker { plan, compiled: None };
                while let (true, Some(&run)) = (on(), runs.get(next.fetch_add(1, Ordering::Relaxed))) {
                    let result = worker.run(run, &on).and_then(|row| match (row, finished.lock()) {
                        (Some(row), Ok(mut finished)) => finished(row),
                        _ => Ok(()),
                    });
                    if let Err(message) = result {
                        stop(message);
                    }
                }
            });
        }
    });
    trouble.into_inner().unwrap_or_default().map_or(Ok(()), Err)
}

/// A thread with its last compiled program, which is reused for runs that differ only in their seeds.
struct Worker<'p> {
    plan: &'p Plan,
    compiled: Option<(Settings, Result<Box<Program>, String>)>,
}

impl Worker<'_> {
    /// Executes a run; `None` if it was interrupted.
    fn run(&mut self, run: u64, go_on: &dyn Fn() -> bool) -> Result<Option<Row>, String> {
        let plan = self.plan;
        let point = plan.point(run);
        let settings = plan.settings(&point.values);
        if self.compiled.as_ref().is_none_or(|(known, _)| *known != settings) {
            let compiled = compile(plan, &settings)?;
            self.compiled = Some((settings, compiled));
        }
        let mut row = Row { run, seed: point.seed, values: point.values, ..Row::default() };
        let program = match &self.compiled {
            Some((_, Ok(program))) => program,
            Some((_, Err(codes))) => {
                row.refused = Some(codes.clone());
                row.expectations = vec![Expected::default(); plan.head.expectations.len()];
                row.limits = vec![Closest::default(); plan.head.limits.len()];
                return Ok(Some(row));
            }
            None => return Ok(None),
        };
        let scenario =
            scenario_runner::seeded(scenario_runner::of_controller(program, &plan.head.scenario)?, point.seed);
        let mut cut = false;
        let judged = scenario_runner::judged(program, &scenario, &mut |tick| {
            cut |= tick.is_multiple_of(16) && !go_on();
            !cut
        })?;
        if cut {
            return Ok(None);
        }
        fill(plan, &mut row, &judged, program.robot.period)?;
        Ok(Some(row))
    }
}

/// Compiles the program of a run, or returns the codes of its errors.
fn compile(plan: &Plan, settings: &Settings) -> Result<Result<Box<Program>, String>, String> {
    let compiled = project::load(plan.spec(), settings);
    if texts(&compiled.report) != plan.head.texts {
        let spec = &plan.head.spec;
        return Err(format!(
            "`{spec}`, or a file that it brings in, changed while the sweep ran: bring it back and go on with `--resume`, \
             or begin again"
        ));
    }
    Ok(compiled.program.map(Box::new).ok_or_else(|| {
        let mut codes: Vec<&str> =
            compiled.report.diagnostics.iter().filter(|d| d.severity == Severity::Error).map(|d| d.code).collect();
        codes.sort_unstable();
        codes.dedup();
        codes.join(", ")
    }))
}

/// Fills a row with the results of its run.
fn fill(plan: &Plan, row: &mut Row, judged: &Judged, period: f64) -> Result<(), String> {
    let (head, summary) = (&plan.head, &judged.summary);
    let known = |task: &String| head.limits.iter().any(|l| l.task == *task);
    let same = judged.expectations.len() == head.expectations.len()
        && summary.tasks.iter().all(|(name, t)| t.min_margin.is_none() || known(name));
    if !same {
        let values = head.sets(&row.values).iter().map(|(n, v)| format!("{n}={v}")).collect::<Vec<_>>().join(", ");
        return Err(format!(
            "with {values} the spec has other expectations or limits than with the first values: sweep a param that \
             says how many there are in several sweeps"
        ));
    }
    let finite = |x: Option<f64>| x.filter(|x| x.is_finite());
    row.holds = judged.ok;
    row.halted = summary.halted;
    row.faults = summary.faults.len() as u64;
    row.first_fault_tick = summary.faults.first().map(|f| (f.time / period).round() as u64);
    row.first_fault = summary.faults.first().map(|f| f.kind.clone());
    row.duration = summary.duration_s;
    let expected = judged.expectations.iter().map(|e| Expected {
        verdict: Some(e.verdict),
        margin: finite(e.margin),
        at: finite(e.worst_s),
    });
    row.expectations = expected.collect();
    let closest = |l: &super::head::Limit| {
        let task = summary.tasks.get(&l.task);
        let margin = finite(task.and_then(|t| t.min_margin));
        Closest { margin, at: margin.and(task.map(|t| t.at_s)) }
    };
    row.limits = head.limits.iter().map(closest).collect();
    Ok(())
}
