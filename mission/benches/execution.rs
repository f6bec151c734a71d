//! Times executed missions: a day of ten agents with ten operations each and four robots; the first plan is not
//! included. The items are the events, including planning and repairing; in the last bench also replanning after small
//! changes of the cost.

#[path = "../tests/common/mod.rs"]
mod common;

use std::time::Duration;

use divan::{Bencher, counter::ItemsCount};
use hierarq_mission::engine::Budget;
use hierarq_mission::execution::{Durations, Replan};
use hierarq_mission::kinds::schedule::choose::{Formulation, Options};
use hierarq_mission::kinds::schedule::execution::{Potentials, ScheduleExecution, Settings, Travel};

/// One day (s).
const DAY: f64 = 86_400.0;

fn main() {
    divan::main();
}

fn day(bencher: Bencher, settings: Settings) {
    let budget = Budget { time: Duration::from_secs(3600), nodes: 20, ..Budget::default() };
    let planning = Options { formulation: Some(Formulation::Batches), batch: 2, budget, ..Options::default() };
    let durations = Durations::Sampled { seed: 1 };
    let settings = Settings { durations, planning, ..settings };
    let Ok(start) = ScheduleExecution::new(common::random(1, 10, 4, 10), settings) else { return };
    let mut once = start.clone();
    let events = once.advance(DAY).len();
    let bencher = bencher.counter(ItemsCount::new(events));
    bencher.with_inputs(|| start.clone()).bench_local_values(|mut execution| {
        execution.advance(DAY);
        execution
    });
}

#[divan::bench(sample_count = 5)]
fn repaired(bencher: Bencher) {
    day(bencher, Settings { replan: Replan::Reschedule, ..Settings::default() });
}

#[divan::bench(sample_count = 5)]
fn repaired_with_bases(bencher: Bencher) {
    let travel = Travel::Bases(Potentials::default());
    day(bencher, Settings { replan: Replan::Reschedule, travel, ..Settings::default() });
}

#[divan::bench(sample_count = 1, sample_size = 1)]
fn planned_anew(bencher: Bencher) {
    day(bencher, Settings { reallocate_above: 0.03, ..Settings::default() });
}
