//! Evaluation of the records of an executed mission of layers, and the rules that they satisfy.

use std::collections::BTreeMap;
use std::time::Duration;

use hierarq_mission::engine::Budget;
use hierarq_mission::kinds::layers::choose::Options;
use hierarq_mission::kinds::layers::execution::{Doing, LayersExecution, LogEntry, Record, Settings};
use hierarq_mission::kinds::layers::problem::Problem;
use hierarq_mission::kinds::layers::validate::validate;

/// Settings with fast planning.
pub fn settings() -> Settings {
    let budget = Budget { time: Duration::from_secs(60), nodes: 60, gap: 1e-4 };
    Settings { planning: Options { budget, ..Options::default() }, ..Settings::default() }
}

/// Runs a mission to its end, or until there is no next event.
pub fn run(execution: &mut LayersExecution) {
    let mut steps = 0;
    while let Some(next) = execution.next().filter(|_| !execution.done()) {
        execution.advance(next);
        steps += 1;
        assert!(steps < 20_000, "the mission does not end: {:?}", execution.records().last());
    }
}

/// A performed task according to the records.
#[derive(Clone, Copy, Debug)]
pub struct Performed {
    pub agent: usize,
    pub task: usize,
    pub object: Option<usize>,
    pub start: f64,
    pub end: f64,
    pub done: bool,
}

/// Returns the performed tasks, in the order of their ends.
pub fn performed(records: &[Record]) -> Vec<Performed> {
    let mut under_way: BTreeMap<usize, Performed> = BTreeMap::new();
    let mut all = Vec::new();
    for record in records {
        match record.what {
            LogEntry::Begun { agent, task, object } => {
                let (start, end) = (record.time, f64::INFINITY);
                let before = under_way.insert(agent, Performed { agent, task, object, start, end, done: false });
                assert!(before.is_none(), "agent {agent} does two things at a time");
            }
            LogEntry::Ended { agent, task } | LogEntry::Dropped { agent, task } => {
                let one = under_way.remove(&agent).expect("something under way");
                assert_eq!(one.task, task);
                let done = matches!(record.what, LogEntry::Ended { .. });
                all.push(Performed { end: record.time, done, ..one });
            }
            _ => {}
        }
    }
    all
}

/// Checks that each task is done at most once, in the order of layers, one at a time, with its own object, by an agent
/// with the abilities.
pub fn keeps_the_rules(problem: &Problem, records: &[Record]) {
    assert!(records.windows(2).all(|pair| pair[0].time <= pair[1].time));
    let all = performed(records);
    let layer = |one: &Performed| problem.tasks[one.task].layer;
    for (index, one) in all.iter().enumerate() {
        assert!(problem.able(one.agent, one.task, one.object));
        assert!(one.object.is_none_or(|object| problem.suits(one.task, object)));
        for other in &all[..index] {
            let both = one.end.min(other.end) - one.start.max(other.start);
            assert!(one.agent != other.agent || both <= 1e-9);
            // A dropped object or task is free again.
            let apart = one.start >= other.end - 1e-9 && !other.done;
            assert!(one.task != other.task || apart);
            assert!(one.object.is_none() || one.object != other.object || apart);
            let (early, late) = if layer(one) < layer(other) { (one, other) } else { (other, one) };
            assert!(layer(early) == layer(late) || late.start >= early.end - 1e-9 || !early.done);
        }
        // All earlier layers are completed at its start.
        let before = (0..problem.tasks.len()).filter(|task| problem.tasks[*task].layer < layer(one));
        for task in before {
            assert!(all.iter().any(|other| other.task == task && other.done && other.end <= one.start + 1e-9));
        }
    }
}

pub fn check(problem: &Problem, execution: &LayersExecution) {
    if execution.stranded().is_none() {
        assert_eq!(validate(execution.problem(), execution.plan()), vec![]);
    }
    let all = performed(execution.records());
    let numbers = execution.statistics();
    assert_eq!(numbers.tasks, all.iter().filter(|one| one.done).count());
    let whole = |layer: usize| {
        let tasks = (0..problem.tasks.len()).filter(|task| problem.tasks[*task].layer <= layer);
        tasks.into_iter().all(|task| all.iter().any(|one| one.task == task && one.done))
    };
    assert_eq!(numbers.layers, (0..problem.layers.len()).take_while(|layer| whole(*layer)).count());
    for (agent, of) in numbers.agents.iter().enumerate() {
        let own = || all.iter().filter(move |one| one.agent == agent);
        let worked: f64 = own().map(|one| one.end - one.start).sum();
        assert!((of.worked - worked).abs() < 1e-6);
        assert_eq!(of.tasks, own().filter(|one| one.done).count());
        let view = execution.agent(agent).unwrap();
        assert_eq!(view.work.is_some(), view.doing == Doing::Working);
        assert!(view.position.iter().all(|x| x.is_finite()));
    }
}
