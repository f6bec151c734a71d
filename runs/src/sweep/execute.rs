//! Executes runs of a sweep in parallel. The results do not depend on the assignment of runs to threads.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use compiler::Compiled;
use dsl::Severity;
use mission::kind::Execution;
use runtime::missions::{self, End, Instant, MissionRecorder};
use runtime::program::{MissionProgram, MissionScenarioProgram, Program, ScenarioProgram};
use runtime::record::expectations::ExpectationRecord;

use super::head::{Head, Measured, Subject};
use super::plan::{Plan, texts};
use super::row::{Closest, Ended, Expected, Row};
use super::subject;
use crate::project::{self, Settings};
use crate::scenario_runner::{self, Found};

/// Executes runs, `jobs` at a time, and passes each to `finished` as soon as it is complete. Ends early if `go_on`
/// returns false; interrupted runs are not passed on.
///
/// # Errors
/// The spec changed after the sweep began, or has different expectations, limits or members with some of the values; or
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

/// A thread with its last compiled spec, which is reused for runs that differ only in their seeds.
struct Worker<'p> {
    plan: &'p Plan,
    compiled: Option<(Settings, Result<Box<Compiled>, String>)>,
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
        let compiled = match &self.compiled {
            Some((_, Ok(compiled))) => compiled,
            Some((_, Err(codes))) => {
                row.refused = Some(codes.clone());
                row.expectations = vec![Expected::default(); plan.head.expectations.len()];
                row.limits = vec![Closest::default(); plan.head.limits.len()];
                row.mission = (plan.head.subject == Subject::Mission).then(Ended::default);
                row.measures = vec![None; plan.head.measures.len()];
                return Ok(Some(row));
            }
            None => return Ok(None),
        };
        let found = subject::choose(compiled, Some(&plan.head.scenario))?;
        let finished = match found {
            Found::Controller(program, scenario) => controller(plan, &mut row, program, scenario, go_on)?,
            Found::Mission(mission, scenario) => executed(plan, &mut row, mission, scenario, go_on)?,
        };
        Ok(finished.then_some(row))
    }
}

/// Compiles the spec of a run, or returns the codes of its errors.
fn compile(plan: &Plan, settings: &Settings) -> Result<Result<Box<Compiled>, String>, String> {
    let compiled = project::load(plan.spec(), settings);
    if texts(&compiled.report) != plan.head.texts {
        let spec = &plan.head.spec;
        return Err(format!(
            "`{spec}`, or a file that it brings in, changed while the sweep ran: bring it back and go on with `--resume`, \
             or begin again"
        ));
    }
    if compiled.is_good() {
        return Ok(Ok(Box::new(compiled)));
    }
    let mut codes: Vec<&str> =
        compiled.report.diagnostics.iter().filter(|d| d.severity == Severity::Error).map(|d| d.code).collect();
    codes.sort_unstable();
    codes.dedup();
    Ok(Err(codes.join(", ")))
}

/// Runs a controller and fills the row; false if it was interrupted.
fn controller(
    plan: &Plan,
    row: &mut Row,
    program: &Program,
    scenario: &ScenarioProgram,
    go_on: &dyn Fn() -> bool,
) -> Result<bool, String> {
    let scenario = scenario_runner::seeded(scenario, row.seed);
    let mut cut = false;
    let judged = scenario_runner::judged(program, &scenario, &mut |tick| {
        cut |= tick.is_multiple_of(16) && !go_on();
        !cut
    })?;
    if cut {
        return Ok(false);
    }
    let (head, summary) = (&plan.head, &judged.summary);
    let known = |task: &String| head.limits.iter().any(|l| l.task == *task);
    let same = judged.expectations.len() == head.expectations.len()
        && summary.tasks.iter().all(|(name, t)| t.min_margin.is_none() || known(name));
    if !same {
        return Err(others(plan, row, "expectations or limits"));
    }
    row.holds = judged.ok;
    row.halted = summary.halted;
    row.faults = summary.faults.len() as u64;
    row.first_fault_tick = summary.faults.first().map(|f| (f.time / program.robot.period).round() as u64);
    row.first_fault = summary.faults.first().map(|f| f.kind.clone());
    row.duration = summary.duration_s;
    row.expectations = judged.expectations.iter().map(expected).collect();
    let closest = |l: &super::head::Limit| {
        let task = summary.tasks.get(&l.task);
        let margin = finite(task.and_then(|t| t.min_margin));
        Closest { margin, at: margin.and(task.map(|t| t.at_s)) }
    };
    row.limits = head.limits.iter().map(closest).collect();
    Ok(true)
}

/// Reads the measures of a mission at its end.
struct Measures<'h> {
    head: &'h Head,
    values: Vec<Option<f64>>,
}

impl MissionRecorder for Measures<'_> {
    fn instant(&mut self, _: &Instant) -> std::io::Result<()> {
        Ok(())
    }

    fn end(&mut self, execution: &dyn Execution) {
        let value = |of: &Measured| {
            let value = finite(execution.measure(&of.name, of.member).get(of.axis).copied());
            // The truth values of measures are 1 and -1.
            if of.unit.is_some() { value } else { value.map(|value| f64::from(value > 0.0)) }
        };
        self.values = self.head.measures.iter().map(value).collect();
    }
}

/// Executes a mission and fills the row; false if it was interrupted.
fn executed(
    plan: &Plan,
    row: &mut Row,
    mission: &MissionProgram,
    scenario: &MissionScenarioProgram,
    go_on: &dyn Fn() -> bool,
) -> Result<bool, String> {
    let head = &plan.head;
    if subject::measures(mission) != head.measures || scenario.expectations.len() != head.expectations.len() {
        return Err(others(plan, row, "members or expectations"));
    }
    let scenario = MissionScenarioProgram { seed: row.seed, ..scenario.clone() };
    let mut measures = Measures { head, values: vec![None; head.measures.len()] };
    let run = missions::run(mission, &scenario, &mut measures, &mut |_| go_on()).map_err(|e| e.to_string())?;
    let summary = run.summary;
    let (how, done_at) = match &summary.end {
        End::Done { at_s } => ("done", Some(*at_s)),
        End::Unfinished => ("unfinished", None),
        End::Stranded { .. } => ("stranded", None),
        End::Refused { .. } => ("refused", None),
        End::Interrupted => return Ok(false),
    };
    row.holds = summary.ok;
    row.duration = summary.duration_s;
    row.expectations = summary.expectations.iter().map(expected).collect();
    row.mission = Some(Ended {
        how: Some(how.to_string()),
        done_at,
        new_plans: summary.results.as_ref().map_or(0, |results| results.reallocations as u64),
        broken: summary.workers.iter().filter(|worker| worker.broke_down.is_some()).count() as u64,
        trouble: summary.trouble().into_iter().next().map(|(_, text)| text),
    });
    row.measures = measures.values;
    Ok(true)
}

fn finite(x: Option<f64>) -> Option<f64> {
    x.filter(|x| x.is_finite())
}

fn expected(e: &ExpectationRecord) -> Expected {
    Expected { verdict: Some(e.verdict), margin: finite(e.margin), at: finite(e.worst_s) }
}

/// Message for values with which the columns would be others.
fn others(plan: &Plan, row: &Row, what: &str) -> String {
    let values = plan.head.sets(&row.values).iter().map(|(n, v)| format!("{n}={v}")).collect::<Vec<_>>().join(", ");
    format!(
        "with {values} the spec has other {what} than with the first values: sweep a param that says how many there are \
         in several sweeps"
    )
}
