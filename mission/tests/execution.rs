//! Executed schedules: what happens never gives a plan that the validator refuses, everything that can be served is served
//! once, what has begun stays, and the same happens however time is cut.

#![allow(clippy::unwrap_used, reason = "a test that cannot unwrap fails")]

mod common;

use std::collections::BTreeMap;
use std::time::Duration;

use hierarq_mission::engine::Budget;
use hierarq_mission::execution::{
    Doing, Durations, Event, EventError, Execution, Happening, NoPlan, Obstacle, Potentials, Record, Refusal, Replan,
    Settings, Stage, Travel,
};
use hierarq_mission::plan::{Activity, Actor, Phase, Plan, Target};
use hierarq_mission::schedule::choose::{Formulation, Options};
use hierarq_mission::schedule::problem::{AgentKind, Begun, Problem, Range};
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
                Phase::Task => continue,
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

/// Records of a mission advanced in steps that end at these times, and what it came to.
fn in_steps(problem: &Problem, settings: &Settings, events: &[(f64, Event)], steps: &[f64]) -> (Vec<Record>, String) {
    let mut execution = Execution::new(problem.clone(), settings.clone()).unwrap();
    let mut steps = steps.iter().copied().peekable();
    for (time, event) in events.iter().copied().chain([(20_000.0, Event::Done { agent: usize::MAX })]) {
        while let Some(step) = steps.next_if(|step| *step < time) {
            execution.advance(step);
        }
        execution.advance(time);
        let _ = execution.tell(event);
    }
    let all: Vec<String> = (0..problem.robots.len()).map(|robot| format!("{:?}", execution.robot(robot))).collect();
    (execution.records().to_vec(), format!("{:?} {all:?}", execution.statistics()))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, ..ProptestConfig::default() })]

    #[test]
    fn small_steps_are_one_large_step(
        (problem, settings) in mission(),
        events in proptest::collection::vec((0.0_f64..1500.0, 0_usize..12, 0_usize..8, -1.0_f64..1.0, -1.0_f64..1.0), 0..6),
        mut steps in proptest::collection::vec(0.0_f64..5000.0, 0..60),
    ) {
        let (robots, people) = (problem.robots.len(), problem.agents.len());
        let told = events.into_iter().map(|(time, what, who, a, b)| (time, event(what, who, robots, people, a, b)));
        let mut told: Vec<(f64, Event)> = told.collect();
        told.sort_by(|a, b| a.0.total_cmp(&b.0));
        steps.sort_by(f64::total_cmp);
        let once = in_steps(&problem, &settings, &told, &[]);
        prop_assert_eq!(in_steps(&problem, &settings, &told, &steps), once.clone());
        let text = serde_json::to_string(&once.0).unwrap();
        prop_assert_eq!(serde_json::from_str::<Vec<Record>>(&text).unwrap(), once.0);
    }
}

/// Table 5.4 from executed runs: how often an operation ends within the time that it was planned to take.
#[test]
fn operations_end_in_time_as_often_as_wanted() {
    for confidence in [0.6, 0.7, 0.8, 0.9, 0.95, 0.99] {
        let (mut enough, mut count) = (0, 0);
        let mut problem = common::vineyard(3);
        problem.confidence = confidence;
        for (number, agent) in problem.agents.iter_mut().enumerate() {
            agent.duration.mean = 250.0 + 10.0 * (number + 1) as f64;
            agent.duration.sigma = 0.1 * agent.duration.mean;
        }
        let settings = Settings { replan: Replan::None, ..settings() };
        let plan = Execution::new(problem.clone(), settings.clone()).unwrap().plan().clone();
        for seed in 0..50 {
            let durations = Durations::Sampled { seed };
            let mut execution =
                Execution::with_plan(problem.clone(), plan.clone(), Settings { durations, ..settings.clone() })
                    .unwrap();
            run(&mut execution);
            assert!(execution.done());
            let late = |record: &&Record| matches!(record.what, Happening::OperationLate { .. });
            let times = happened(execution.records());
            for ((agent, _), times) in &times {
                let duration = problem.agents[*agent].duration;
                let planned = hierarq_mission::schedule::chance::quantile(duration, confidence);
                enough += usize::from(times["end"] - times["start"] <= planned);
                count += 1;
            }
            assert_eq!(
                execution.records().iter().any(|r| late(&r)),
                times.iter().any(|((agent, _), times)| {
                    let duration = problem.agents[*agent].duration;
                    times["end"] - times["start"]
                        > hierarq_mission::schedule::chance::quantile(duration, confidence) + 1e-9
                })
            );
        }
        near(enough as f64 / f64::from(count), confidence, 0.03);
    }
}

/// A duration depends on its name alone: another plan, fewer agents or events change none.
#[test]
fn durations_depend_on_nothing_but_their_name() {
    let problem = common::vineyard(2);
    let settings = Settings { durations: Durations::Sampled { seed: 7 }, ..settings() };
    let lengths = |execution: &mut Execution| {
        run(execution);
        let times = happened(execution.records());
        let names = execution.plan().agents.clone();
        times.iter().map(|((a, o), t)| ((names[*a].clone(), *o), t["end"] - t["start"])).collect::<BTreeMap<_, _>>()
    };
    let mut all = Execution::new(problem.clone(), settings.clone()).unwrap();
    let all = lengths(&mut all);
    let mut fewer = problem.clone();
    fewer.agents.remove(0);
    let mut fewer = Execution::new(fewer, settings.clone()).unwrap();
    fewer.advance(100.0);
    fewer.tell(Event::Moved { agent: 0, place: [0.0, 0.0] }).unwrap();
    for (name, length) in lengths(&mut fewer) {
        near(all[&name], length, 1e-9);
    }
    let other = Settings { durations: Durations::Sampled { seed: 8 }, ..settings };
    let other = lengths(&mut Execution::new(problem, other).unwrap());
    assert!(all.iter().all(|(name, length)| other[name] != *length));
}

fn count(records: &[Record], of: impl Fn(&Happening) -> bool) -> usize {
    records.iter().filter(|record| of(&record.what)).count()
}

/// 5.F: an operation that ends early is served early by a robot that waits; one that is late is waited for.
#[test]
fn a_robot_that_waits_approaches_when_the_operation_ends() {
    let mut problem = common::vineyard(1);
    for robot in &mut problem.robots {
        (robot.speed, robot.proximity) = (Range::point(0.2), Some(Range::point(0.2)));
    }
    let mut execution = Execution::new(problem, Settings { replan: Replan::Reschedule, ..settings() }).unwrap();
    let robot_waits = |execution: &Execution| {
        (0..2).find_map(|m| Some(execution.robot(m)?).filter(|r| r.stage == Stage::Waiting)?.target)
    };
    while robot_waits(&execution).is_none() {
        let next = execution.next().unwrap();
        execution.advance(next);
    }
    let agent = robot_waits(&execution).unwrap().agent;
    let coming = execution.agent(agent).unwrap().coming.unwrap();
    assert!(execution.agent(agent).unwrap().doing == Doing::Working && coming.approaches > execution.time() + 1.0);
    execution.advance(execution.time() + 1.0);
    let now = execution.time();
    execution.tell(Event::Done { agent }).unwrap();
    let next = execution.agent(agent).unwrap().coming.unwrap();
    near(next.approaches, now, 1e-9);
    near(next.serves - next.approaches, coming.serves - coming.approaches, 1e-9);
    assert_eq!(
        execution.advance(now).last().unwrap().what,
        Happening::Approaches { robot: next.robot, agent, operation: 0 }
    );
    let mut late = execution.clone();
    run(&mut execution);
    assert!(execution.done());
    // Another one says that it needs longer.
    let other = (0..4).find(|a| late.agent(*a).unwrap().doing == Doing::Working).unwrap();
    let expected = late.agent(other).unwrap().until.unwrap();
    late.tell(Event::Late { agent: other, by: 200.0 }).unwrap();
    near(late.agent(other).unwrap().until.unwrap(), expected + 200.0, 1e-9);
    assert!(late.agent(other).unwrap().coming.unwrap().serves >= expected + 200.0 - 1e-9);
    run(&mut late);
    near(happened(late.records())[&(other, 0)]["end"], expected + 200.0, 1e-9);
}

/// A robot that is lost: what it was doing is broken off, the other one does all the rest; lost too, the mission stands
/// still and says why; back again, it goes on to its end.
#[test]
fn robots_that_are_lost_are_done_without() {
    let mut execution = Execution::new(common::vineyard(2), settings()).unwrap();
    execution.advance(100.0);
    let lost = (0..2).find(|m| execution.robot(*m).unwrap().stage == Stage::Going).unwrap();
    execution.tell(Event::Lost { who: Actor::Robot(lost) }).unwrap();
    assert_eq!(count(execution.records(), |what| matches!(what, Happening::BrokenOff { .. })), 1);
    assert!(execution.tell(Event::Lost { who: Actor::Robot(lost) }).is_err());
    let new = execution.plan().activities.iter().filter(|a| !a.begun && a.phase == Phase::Going);
    assert!(new.clone().count() > 0 && new.into_iter().all(|a| a.actor == Actor::Robot(1 - lost)));
    assert!(validate(execution.problem(), execution.plan()).is_empty());
    execution.advance(700.0);
    execution.tell(Event::Lost { who: Actor::Robot(1 - lost) }).unwrap();
    assert_eq!(execution.stranded(), Some(&NoPlan::NoRobot));
    execution.advance(3000.0);
    assert_eq!(execution.next(), None);
    assert!(!execution.done());
    let doing: Vec<Doing> = (0..4).map(|agent| execution.agent(agent).unwrap().doing).collect();
    assert!(doing.contains(&Doing::Waiting), "{doing:?}");
    assert!(doing.iter().all(|doing| matches!(doing, Doing::Waiting | Doing::Finished)), "{doing:?}");
    execution.tell(Event::Back { who: Actor::Robot(lost) }).unwrap();
    assert_eq!(execution.stranded(), None);
    run(&mut execution);
    assert!(execution.done());
    assert!(execution.statistics().agents.iter().all(|agent| agent.served == 2));
    assert_eq!(execution.statistics().robots[1 - lost].served + execution.statistics().robots[lost].served, 8);
}

/// An agent who leaves is not served any more, the robot under way to it goes home; back, it does its operation again.
#[test]
fn agents_come_and_go() {
    let mut execution = Execution::new(common::vineyard(2), settings()).unwrap();
    execution.advance(200.0);
    let (robot, target) = (0..2).find_map(|m| Some((m, execution.robot(m)?.target?))).unwrap();
    execution.tell(Event::Lost { who: Actor::Agent(target.agent) }).unwrap();
    assert_eq!(execution.robot(robot).unwrap().stage, Stage::Recalled);
    assert_eq!(execution.problem().operations(), 6);
    assert_eq!(execution.plan().of(Actor::Agent(target.agent)).count(), 0);
    let mut without = execution.clone();
    run(&mut without);
    assert!(without.done());
    assert_eq!(without.statistics().agents[target.agent].served, 0);
    execution.advance(900.0);
    execution.tell(Event::Back { who: Actor::Agent(target.agent) }).unwrap();
    run(&mut execution);
    assert!(execution.done());
    assert_eq!(execution.statistics().agents[target.agent].served, 2);
    assert_eq!(happened(execution.records())[&(target.agent, 0)]["start"], 900.0);
    // After the end too.
    without.tell(Event::Back { who: Actor::Agent(target.agent) }).unwrap();
    assert!(!without.done());
    run(&mut without);
    assert!(without.done());
    assert_eq!(without.statistics().agents[target.agent].served, 2);
}

/// A service that failed takes its time once more; one that ends earlier is over; a place that moved is gone to.
#[test]
fn services_fail_end_early_and_move() {
    let mut execution = Execution::new(common::vineyard(1), settings()).unwrap();
    let serving = |execution: &Execution| (0..4).find(|a| execution.agent(*a).unwrap().doing == Doing::Served);
    while serving(&execution).is_none() {
        let next = execution.next().unwrap();
        execution.advance(next);
    }
    let agent = serving(&execution).unwrap();
    let since = execution.time();
    execution.advance(since + 4.0);
    execution.tell(Event::Failed { agent }).unwrap();
    near(execution.agent(agent).unwrap().until.unwrap(), since + 14.0, 1e-9);
    assert!(matches!(execution.tell(Event::Moved { agent, place: [0.0, 0.0] }), Err(EventError::RobotNear { .. })));
    execution.advance(since + 5.0);
    execution.tell(Event::Served { agent }).unwrap();
    assert_eq!(execution.agent(agent).unwrap().doing, Doing::Finished);
    let other = (0..4).find(|a| execution.agent(*a).unwrap().doing == Doing::Working).unwrap();
    execution.tell(Event::Moved { agent: other, place: [5.0, 5.0] }).unwrap();
    run(&mut execution);
    assert!(execution.done());
    let at = part(execution.plan(), (other, 0), Phase::Serving).unwrap();
    assert_eq!(at.place, Some([5.0, 5.0]));
    assert!(matches!(execution.tell(Event::Done { agent }), Err(EventError::NotWorking { .. })));
    assert!(matches!(execution.tell(Event::Done { agent: 9 }), Err(EventError::NoAgent { agent: 9 })));
    let said = |wait| Event::Said { agent: 0, wait, approach: 0, distance: 0 };
    assert!(matches!(execution.tell(said(3)), Err(EventError::Step { step: 3 })));
}

/// What makes no sense is refused before it begins.
#[test]
fn wrong_settings_are_refused() {
    let refused = |change: &dyn Fn(&mut Problem, &mut Settings)| {
        let (mut problem, mut settings) = (common::vineyard(1), settings());
        change(&mut problem, &mut settings);
        Execution::new(problem, settings).unwrap_err()
    };
    assert_eq!(refused(&|_, s| s.told = vec![7]), Refusal::Told(7));
    assert!(matches!(refused(&|_, s| s.reallocate_above = f64::NAN), Refusal::Setting { .. }));
    let bases = |change: &dyn Fn(&mut Potentials)| {
        let mut potentials = Potentials::default();
        change(&mut potentials);
        refused(&|_, s| s.travel = Travel::Bases(potentials.clone()))
    };
    assert!(matches!(bases(&|p| p.step = 0.0), Refusal::Setting { .. }));
    assert!(matches!(bases(&|p| p.threshold = 0.1), Refusal::Setting { .. }));
    let rock = Obstacle { place: [1.0, -1.0], radius: 0.2 };
    assert!(matches!(bases(&|p| p.obstacles = vec![rock]), Refusal::Covered { .. }));
    let table = |p: &mut Problem, s: &mut Settings| {
        *p = common::fixed(1, 2, 2, 1);
        s.travel = Travel::Bases(Potentials::default());
    };
    assert_eq!(refused(&table), Refusal::NoPlaces);
    assert!(matches!(refused(&|p, _| p.robots.clear()), Refusal::Plan(_)));
    let begun = |p: &mut Problem, _: &mut Settings| {
        p.begun = vec![Begun { agent: 0, operation: 0, start: 0.0, end: 10.0, service: None }];
    };
    assert_eq!(refused(&begun), Refusal::Begun);
}

/// Bases of a mission watched at every step: the smallest distance between two that are not lost, and whether it ended.
fn watched(problem: &Problem, potentials: &Potentials, until: f64) -> (f64, Execution) {
    let travel = Travel::Bases(potentials.clone());
    let mut execution = Execution::new(problem.clone(), Settings { travel, ..settings() }).unwrap();
    let (mut closest, mut time) = (f64::INFINITY, 0.0);
    while !execution.done() && time < until {
        time += potentials.step;
        execution.advance(time);
        let robots: Vec<_> = (0..execution.plan().robots.len()).map(|m| execution.robot(m).unwrap()).collect();
        for (m, robot) in robots.iter().enumerate() {
            for other in robots[..m].iter().filter(|other| other.stage != Stage::Lost && robot.stage != Stage::Lost) {
                let apart = f64::hypot(robot.position[0] - other.position[0], robot.position[1] - other.position[1]);
                closest = closest.min(apart);
            }
            for thing in &potentials.obstacles {
                let [x, y] = robot.position;
                closest = closest.min(f64::hypot(x - thing.place[0], y - thing.place[1]) - thing.radius);
            }
        }
    }
    (closest, execution)
}

/// Depots and places of agents on one line: robots that come meet robots that go back head-on, and a rock between them.
#[test]
fn bases_that_meet_head_on_pass() {
    for shift in [0.0, 0.01, -0.5] {
        let robots = vec![common::robot("m0", [0.0, 0.0], 1.0), common::robot("m1", [-4.0, shift], 1.0)];
        let agents = vec![
            common::agent("a0", AgentKind::Human, [9.0, 0.0], 3, 60.0),
            common::agent("a1", AgentKind::Human, [15.0, 0.0], 3, 60.0),
        ];
        let problem = common::problem(robots, agents);
        for obstacles in [vec![], vec![Obstacle { place: [4.5, 0.0], radius: 0.5 }]] {
            let (closest, execution) = watched(&problem, &Potentials { obstacles, ..Potentials::default() }, 6000.0);
            assert!(execution.done(), "{shift}: {:?} {:?}", execution.robot(0), execution.robot(1));
            assert!((0.8 - 1e-9..2.5).contains(&closest), "{shift}: {closest}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// Teams in a small place, depots and agents anywhere: nobody comes too near, everybody is served.
    #[test]
    fn bases_never_come_too_near(
        seed in 0_u64..100_000, robots in 2_usize..6, agents in 1_usize..6, rocks in 0_usize..3, crowded in any::<bool>(),
    ) {
        let mut problem = common::random(seed, agents, robots, 2);
        let mut random = common::Random(seed);
        random.unit();
        let size = if crowded { 5.0 } else { 12.0 };
        for (m, robot) in problem.robots.iter_mut().enumerate() {
            // In a row, far enough from each other to begin with.
            robot.depot = [1.5 * m as f64, -size];
        }
        for agent in &mut problem.agents {
            agent.place = [random.within(-size, size), random.within(-size, size) + 2.0];
            agent.duration.mean = random.within(30.0, 120.0);
            agent.duration.sigma = 0.0;
        }
        let mut obstacles = Vec::new();
        for _ in 0..rocks {
            let rock = Obstacle { place: [random.within(-size, size), random.within(-size, size)], radius: 0.4 };
            let places = problem.robots.iter().map(|r| r.depot).chain(problem.agents.iter().map(|a| a.place));
            let clear = |p: [f64; 2]| f64::hypot(p[0] - rock.place[0], p[1] - rock.place[1]) > 3.0;
            if places.into_iter().all(clear) {
                obstacles.push(rock);
            }
        }
        let (closest, execution) = watched(&problem, &Potentials { obstacles, ..Potentials::default() }, 20_000.0);
        prop_assert!(closest >= 0.8 - 1e-9, "{closest}");
        let robots: Vec<_> = (0..robots).map(|m| execution.robot(m)).collect();
        prop_assert!(execution.done(), "{robots:#?}");
    }
}

/// A base that is kept from its way arrives late, and the plan learns it.
#[test]
fn late_arrivals_reach_the_plan() {
    let mut late = 0;
    for seed in 0..6 {
        let mut problem = common::random(seed, 4, 3, 2);
        for (m, robot) in problem.robots.iter_mut().enumerate() {
            robot.depot = [2.0 * m as f64, 0.0];
            (robot.speed, robot.proximity) = (Range::point(0.2), None);
        }
        let (_, execution) = watched(&problem, &Potentials::default(), 20_000.0);
        assert!(execution.done());
        late += count(execution.records(), |what| matches!(what, Happening::RobotLate { .. }));
        assert!(validate(execution.problem(), execution.plan()).is_empty());
        keeps(execution.plan(), execution.records()).unwrap();
    }
    assert!(late > 0);
}
