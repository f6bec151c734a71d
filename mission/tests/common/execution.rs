//! Common parts of the tests of executed missions.

use std::collections::BTreeMap;
use std::time::Duration;

use hierarq_mission::engine::Budget;
use hierarq_mission::kinds::schedule::choose::{Formulation, Options};
use hierarq_mission::kinds::schedule::execution::{Event, LogEntry, Record, ScheduleExecution, Settings};
use hierarq_mission::kinds::schedule::plan::{Activity, Actor, Phase, Plan, Target};

pub fn near(a: f64, b: f64, by: f64) {
    assert!((a - b).abs() <= by, "{a} is not {b}");
}

/// Options of fast planning.
pub fn quick() -> Options {
    let budget = Budget { time: Duration::from_secs(60), nodes: 20, ..Budget::default() };
    Options { formulation: Some(Formulation::Batches), batch: 2, budget, ..Options::default() }
}

/// Settings with fast planning.
pub fn settings() -> Settings {
    Settings { planning: quick(), ..Settings::default() }
}

/// Runs a mission to its end.
pub fn run(execution: &mut ScheduleExecution) {
    let mut steps = 0;
    while let Some(next) = execution.next() {
        execution.advance(next);
        steps += 1;
        assert!(
            steps < 20_000,
            "the mission does not end: {:?}",
            &execution.records()[execution.records().len() - 5..]
        );
    }
}

/// Recorded starts and ends of the phases, by operation.
pub type Times = BTreeMap<(usize, usize), BTreeMap<&'static str, f64>>;

pub fn happened(records: &[Record]) -> Times {
    let mut times = Times::new();
    for record in records {
        let (key, name) = match record.what {
            LogEntry::OperationBegan { agent, operation } => ((agent, operation), "start"),
            LogEntry::OperationEnded { agent, operation } => ((agent, operation), "end"),
            LogEntry::Left { agent, operation, .. } => ((agent, operation), "going"),
            LogEntry::Waits { agent, operation, .. } => ((agent, operation), "waiting"),
            LogEntry::Approaches { agent, operation, .. } => ((agent, operation), "proximity"),
            LogEntry::Serves { agent, operation, .. } => ((agent, operation), "serving"),
            LogEntry::Served { agent, operation, .. } => ((agent, operation), "depositing"),
            LogEntry::BrokenOff { agent, operation, .. } => {
                let of = times.entry((agent, operation)).or_default();
                of.retain(|name, _| matches!(*name, "start" | "end"));
                continue;
            }
            LogEntry::Handled { event: Event::Lost { who: Actor::Agent(lost) } } => {
                // An operation that was not served counts as not begun.
                times.retain(|(agent, _), of| *agent != lost || of.contains_key("depositing"));
                continue;
            }
            _ => continue,
        };
        times.entry(key).or_default().insert(name, record.time);
    }
    times
}

pub fn part(plan: &Plan, (agent, operation): (usize, usize), phase: Phase) -> Option<&Activity> {
    plan.activities.iter().find(|a| a.target == Target { agent, operation } && a.phase == phase)
}

/// Checks that the plan holds all recorded times.
pub fn keeps(plan: &Plan, records: &[Record]) -> Result<(), String> {
    for (key, times) in happened(records) {
        for (name, time) in times {
            let (phase, starts) = match name {
                "start" => (Phase::Operation, true),
                "end" => (Phase::Operation, false),
                "going" => (Phase::Going, true),
                "waiting" => (Phase::Waiting, true),
                "proximity" => (Phase::Proximity, true),
                "serving" => (Phase::Serving, true),
                _ => (Phase::Depositing, true),
            };
            let found = part(plan, key, phase).map(|a| if starts { a.start } else { a.end });
            if !found.is_some_and(|t| (t - time).abs() < 1e-6) {
                return Err(format!("{key:?} {name} {time} is {found:?}"));
            }
        }
    }
    Ok(())
}

pub fn count(records: &[Record], of: impl Fn(&LogEntry) -> bool) -> usize {
    records.iter().filter(|record| of(&record.what)).count()
}
