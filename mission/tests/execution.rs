//! Executed schedules: what happens never gives a plan that the validator refuses, everything that can be served is served
//! once, what has begun stays, and the same happens however time is cut.

#![allow(clippy::unwrap_used, reason = "a test that cannot unwrap fails")]

mod common;

use std::collections::BTreeMap;
use std::time::Duration;

use hierarq_mission::engine::Budget;
use hierarq_mission::execution::{
    Doing, Durations, Event, Execution, Happening, NoPlan, Potentials, Record, Replan, Settings, Stage, Travel,
};
use hierarq_mission::plan::{Activity, Actor, Phase, Plan, Target};
use hierarq_mission::schedule::choose::{Formulation, Options};
use hierarq_mission::schedule::problem::Problem;
use hierarq_mission::schedule::validate::validate;
use proptest::prelude::*;

fn near(a: f64, b: f64, by: f64) {
    assert!((a - b).abs() <= by, "{a} is not {b}");
}

fn quick() -> Options {
    let budget = Budget { time: Duration::from_secs(60), nodes: 20, ..Budget::default() };
    Options { formulation: Some(Formulation::Batches), batch: 2, budget, ..Options::default() }
}

fn settings() -> Settings {
    Settings { planning: quick(), ..Settings::default() }
}

/// Lets a mission run to its end.
fn run(execution: &mut Execution) {
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

/// When the beginnings and ends of a plan are recorded to have happened, by operation.
type Times = BTreeMap<(usize, usize), BTreeMap<&'static str, f64>>;

fn happened(records: &[Record]) -> Times {
    let mut times = Times::new();
    for record in records {
        let (key, name) = match record.what {
            Happening::OperationBegan { agent, operation } => ((agent, operation), "start"),
            Happening::OperationEnded { agent, operation } => ((agent, operation), "end"),
            Happening::Left { agent, operation, .. } => ((agent, operation), "going"),
            Happening::Waits { agent, operation, .. } => ((agent, operation), "waiting"),
            Happening::Approaches { agent, operation, .. } => ((agent, operation), "proximity"),
            Happening::Serves { agent, operation, .. } => ((agent, operation), "serving"),
            Happening::Served { agent, operation, .. } => ((agent, operation), "depositing"),
            Happening::BrokenOff { agent, operation, .. } => {
                let of = times.entry((agent, operation)).or_default();
                of.retain(|name, _| matches!(*name, "start" | "end"));
                continue;
            }
            Happening::Told { event: Event::Lost { who: Actor::Agent(lost) } } => {
                // What it has not been served for is not begun any more.
                times.retain(|(agent, _), of| *agent != lost || of.contains_key("depositing"));
                continue;
            }
            _ => continue,
        };
        times.entry(key).or_default().insert(name, record.time);
    }
    times
}

fn part(plan: &Plan, (agent, operation): (usize, usize), phase: Phase) -> Option<&Activity> {
    plan.activities.iter().find(|a| a.target == Target { agent, operation } && a.phase == phase)
}

/// Everything that has happened is in the plan as it happened.
fn keeps(plan: &Plan, records: &[Record]) -> Result<(), TestCaseError> {
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
            prop_assert!(found.is_some_and(|t| (t - time).abs() < 1e-6), "{key:?} {name} {time} is {found:?}");
        }
    }
    Ok(())
}

/// Without anything that happens, with durations as planned: the plan, to the last digit.
#[test]
fn a_quiet_day_is_the_plan() {
    let bases = Travel::Bases(Potentials::default());
    for (problem, travel) in [
        (common::vineyard(1), Travel::Planned),
        (common::vineyard(2), Travel::Planned),
        (common::fixed(3, 4, 2, 1), Travel::Planned),
        (common::random(5, 3, 2, 2), Travel::Planned),
        (common::random(5, 3, 1, 1), bases),
    ] {
        let mut execution = Execution::new(problem, Settings { travel, ..settings() }).unwrap();
        let plan = execution.plan().clone();
        run(&mut execution);
        assert!(execution.done());
        let times = happened(execution.records());
        for activity in &plan.activities {
            let key = (activity.target.agent, activity.target.operation);
            let name = match activity.phase {
                Phase::Operation => "start",
                Phase::Going => "going",
                Phase::Waiting => "waiting",
                Phase::Proximity => "proximity",
                Phase::Serving => "serving",
                Phase::Depositing => "depositing",
                Phase::Task => unreachable!("a schedule has no tasks of layers"),
            };
            near(times[&key][name], activity.start, 1e-9);
        }
        near(execution.statistics().makespan, plan.end().unwrap(), 1e-9);
        assert_eq!((execution.statistics().reschedules, execution.statistics().reallocations), (0, 0));
        assert_eq!(execution.plan().activities, plan.activities);
    }
}

/// What may be told, of somebody.
fn event(what: usize, who: usize, robots: usize, agents: usize, a: f64, b: f64) -> Event {
    let (agent, robot) = (who % agents, who % robots);
    let step = |x: f64| (x * 2.5) as i8;
    match what {
        0 => Event::Done { agent },
        1 => Event::Late { agent, by: 300.0 * a },
        2 => Event::Served { agent },
        3 => Event::Failed { agent },
        4 => Event::Moved { agent, place: [10.0 * a, 10.0 * b] },
        5 | 6 => Event::Said { agent, wait: step(a), approach: step(b), distance: step(a * b) },
        7 => Event::Lost { who: Actor::Robot(robot) },
        8 => Event::Lost { who: Actor::Agent(agent) },
        9 => Event::Back { who: Actor::Robot(robot) },
        10 => Event::Back { who: Actor::Agent(agent) },
        _ => Event::Begun { agent },
    }
}

fn mission() -> impl Strategy<Value = (Problem, Settings)> {
    let travel = prop_oneof![2 => Just(Travel::Planned), 1 => Just(Travel::Bases(Potentials::default()))];
    let durations = prop_oneof![Just(Durations::Planned), (0_u64..1000).prop_map(|seed| Durations::Sampled { seed })];
    let replan = prop_oneof![Just(Replan::None), Just(Replan::Reschedule), Just(Replan::Both), Just(Replan::Both)];
    let size = (0_u64..100_000, 1_usize..4, 1_usize..4, 1_usize..3, any::<bool>());
    (size, travel, durations, replan, prop::bool::weighted(0.2)).prop_map(
        |((seed, agents, robots, operations, fixed), travel, durations, replan, told)| {
            let fixed = fixed && travel == Travel::Planned;
            let problem = if fixed {
                common::fixed(seed, agents, robots, operations)
            } else {
                common::random(seed, agents, robots, operations)
            };
            let told = if told { vec![0] } else { Vec::new() };
            (problem, Settings { travel, durations, replan, told, ..settings() })
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn whatever_happens_the_plan_is_one(
        (problem, settings) in mission(),
        events in proptest::collection::vec((0.0_f64..400.0, 0_usize..12, 0_usize..8, -1.0_f64..1.0, -1.0_f64..1.0), 0..14),
    ) {
        let (robots, people) = (problem.robots.len(), problem.agents.len());
        let mut execution = Execution::new(problem, settings.clone()).unwrap();
        for (after, what, who, a, b) in events {
            execution.advance(execution.time() + after);
            let before = (execution.plan().clone(), execution.records().len());
            if execution.tell(event(what, who, robots, people, a, b)).is_err() {
                prop_assert_eq!((execution.plan().clone(), execution.records().len()), before);
            }
            if execution.stranded().is_none() && execution.problem().operations() > 0 {
                prop_assert_eq!(validate(execution.problem(), execution.plan()), Vec::new());
                keeps(execution.plan(), execution.records())?;
            }
        }
        // What waits to be told is told, until nothing happens any more.
        for _ in 0..200 {
            run_told(&mut execution);
            if execution.next().is_none() {
                break;
            }
        }
        prop_assert_eq!(execution.next(), None);
        prop_assert!(execution.done() || execution.stranded().is_some());
        let mut served = BTreeMap::new();
        for record in execution.records() {
            if let Happening::Served { agent, operation, .. } = record.what {
                *served.entry((agent, operation)).or_insert(0) += 1;
            }
        }
        prop_assert!(served.values().all(|count| *count == 1), "{served:?}");
        prop_assert!(execution.records().windows(2).all(|pair| pair[0].time <= pair[1].time));
        for agent in 0..people {
            let view = execution.agent(agent).unwrap();
            let here = served.keys().filter(|(who, _)| *who == agent).count();
            prop_assert_eq!(here, execution.statistics().agents[agent].served);
            if execution.stranded().is_none() && view.doing != Doing::Lost {
                prop_assert_eq!(view.doing, Doing::Finished);
                prop_assert_eq!(here, execution.problem().agents[agent].operations);
                prop_assert_eq!(view.waits.len(), here);
            }
        }
        if let Some(why) = execution.stranded() {
            let gone = (0..robots).all(|robot| execution.robot(robot).unwrap().stage == Stage::Lost);
            prop_assert_eq!(gone, *why == NoPlan::NoRobot, "{}", why);
        } else if execution.problem().operations() > 0 {
            prop_assert_eq!(validate(execution.problem(), execution.plan()), Vec::new());
            keeps(execution.plan(), execution.records())?;
        }
    }
}

/// Lets a mission run; an operation that ends when it is told is told to have ended when it is late for the second time.
fn run_told(execution: &mut Execution) {
    let mut steps = 0;
    while let Some(next) = execution.next() {
        let late = execution.advance(next).iter().rev().find_map(|record| match record.what {
            Happening::OperationLate { agent, .. } => Some(agent),
            _ => None,
        });
        steps += 1;
        if let Some(agent) = late.filter(|_| steps % 2 == 0) {
            let _ = execution.tell(Event::Done { agent });
        }
        assert!(steps < 5_000, "the mission does not end");
    }
}
