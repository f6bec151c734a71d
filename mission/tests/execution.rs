//! Executed schedules: events never lead to a plan that the validator rejects, everything that can be served is served
//! once, past activities stay unchanged, and the result is independent of the time steps.

use crate::common;

use std::collections::BTreeMap;

use common::execution::{happened, keeps, near, run, settings};
use hierarq_mission::execution::NoFeasiblePlan;
use hierarq_mission::execution::{Durations, Replan};
use hierarq_mission::kinds::schedule::duration_quantile::quantile;
use hierarq_mission::kinds::schedule::execution::{
    Doing, Event, LogEntry, Potentials, Record, ScheduleExecution, Settings, Stage, Travel,
};
use hierarq_mission::kinds::schedule::plan::{Actor, Phase};
use hierarq_mission::kinds::schedule::problem::{AgentKind, Distances, Problem};
use hierarq_mission::kinds::schedule::validate::validate;
use proptest::prelude::*;

/// Without events and with planned durations the execution equals the plan, to the last digit.
#[test]
fn a_quiet_day_is_the_plan() {
    let bases = Travel::Bases(Potentials::default());
    for (problem, travel) in [
        (common::vineyard(1), Travel::Planned),
        (common::vineyard(2), Travel::Planned),
        (common::fixed(3, 4, 2, 1), Travel::Planned),
        (common::random(5, 3, 2, 2), Travel::Planned),
        // No agent is near the paths of others.
        (common::random(3, 3, 1, 1), bases),
    ] {
        let mut execution = ScheduleExecution::new(problem, Settings { travel, ..settings() }).unwrap();
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
            };
            near(times[&key][name], activity.start, 1e-9);
        }
        near(execution.statistics().makespan, plan.end().unwrap(), 1e-9);
        assert_eq!((execution.statistics().reschedules, execution.statistics().reallocations), (0, 0));
        assert_eq!(execution.plan().activities, plan.activities);
    }
}

/// Returns a random event of a random agent or robot.
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
            let reporting = if told { vec![0] } else { Vec::new() };
            (problem, Settings { travel, durations, replan, reporting, ..settings() })
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
        let mut execution = ScheduleExecution::new(problem, settings.clone()).unwrap();
        let mut waited = vec![0.0; people];
        for (after, what, who, a, b) in events {
            execution.advance(execution.time() + after);
            possible(&execution, &settings.travel, &mut waited);
            let before = (execution.plan().clone(), execution.records().len());
            if execution.handle_event(event(what, who, robots, people, a, b)).is_err() {
                prop_assert_eq!((execution.plan().clone(), execution.records().len()), before);
            }
            possible(&execution, &settings.travel, &mut waited);
            if execution.stranded().is_none() && execution.problem().operations() > 0 {
                prop_assert_eq!(validate(execution.problem(), execution.plan()), Vec::new());
                keeps(execution.plan(), execution.records()).map_err(TestCaseError::fail)?;
            }
        }
        // Run and report ends of late operations, until there is no next event.
        for _ in 0..200 {
            run_told(&mut execution, &settings.travel, &mut waited);
            if execution.next().is_none() {
                break;
            }
        }
        prop_assert_eq!(execution.next(), None);
        prop_assert!(execution.done() || execution.stranded().is_some());
        let mut served = BTreeMap::new();
        for record in execution.records() {
            if let LogEntry::Served { agent, operation, .. } = record.what {
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
            prop_assert_eq!(gone, *why == NoFeasiblePlan::NobodyLeft { who: "every robot".into() }, "{}", why);
        } else if execution.problem().operations() > 0 {
            prop_assert_eq!(validate(execution.problem(), execution.plan()), Vec::new());
            keeps(execution.plan(), execution.records()).map_err(TestCaseError::fail)?;
        }
    }
}

/// Checks that no robot exceeds its maximum speed, and that no accumulated wait decreases. `waited` are the waits
/// before.
fn possible(execution: &ScheduleExecution, travel: &Travel, waited: &mut [f64]) {
    for (robot, machine) in execution.problem().robots.iter().enumerate() {
        let view = execution.robot(robot).unwrap();
        let speed = f64::hypot(view.velocity[0], view.velocity[1]);
        // The potentials of bases may exceed the maximum speed slightly; a table of lengths has no positions.
        let known = *travel == Travel::Planned && execution.problem().distances == Distances::Straight;
        let most = if known { machine.speed.high } else { f64::INFINITY };
        assert!(speed <= most * (1.0 + 1e-6), "{} {:?} {speed} {most}", machine.name, view.stage);
    }
    for (was, is) in waited.iter_mut().zip(execution.statistics().agents) {
        assert!(is.waited() >= *was - 1e-6, "{} {was} {}", is.name, is.waited());
        *was = is.waited();
    }
}

/// Runs a mission; reports an operation as done if it is late at an even step.
fn run_told(execution: &mut ScheduleExecution, travel: &Travel, waited: &mut [f64]) {
    let mut steps = 0;
    while let Some(next) = execution.next() {
        possible(execution, travel, waited);
        let late = execution.advance(next).iter().rev().find_map(|record| match record.what {
            LogEntry::OperationLate { agent, .. } => Some(agent),
            _ => None,
        });
        steps += 1;
        if let Some(agent) = late.filter(|_| steps % 2 == 0) {
            let _ = execution.handle_event(Event::Done { agent });
        }
        assert!(steps < 5_000, "the mission does not end");
    }
}

/// Runs a mission in steps that end at these times; returns its records and its final state.
fn in_steps(problem: &Problem, settings: &Settings, events: &[(f64, Event)], steps: &[f64]) -> (Vec<Record>, String) {
    let mut execution = ScheduleExecution::new(problem.clone(), settings.clone()).unwrap();
    let mut steps = steps.iter().copied().peekable();
    for (time, event) in events.iter().copied().chain([(20_000.0, Event::Done { agent: usize::MAX })]) {
        while let Some(step) = steps.next_if(|step| *step < time) {
            execution.advance(step);
        }
        execution.advance(time);
        let _ = execution.handle_event(event);
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

/// Table 5.4 from executed runs: fraction of operations that end within their planned duration.
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
        let plan = ScheduleExecution::new(problem.clone(), settings.clone()).unwrap().plan().clone();
        for seed in 0..50 {
            let durations = Durations::Sampled { seed };
            let mut execution =
                ScheduleExecution::with_plan(problem.clone(), plan.clone(), Settings { durations, ..settings.clone() })
                    .unwrap();
            run(&mut execution);
            assert!(execution.done());
            let late = |record: &&Record| matches!(record.what, LogEntry::OperationLate { .. });
            let times = happened(execution.records());
            for ((agent, _), times) in &times {
                let duration = problem.agents[*agent].duration;
                let planned = quantile(duration, confidence);
                enough += usize::from(times["end"] - times["start"] <= planned);
                count += 1;
            }
            assert_eq!(
                execution.records().iter().any(|r| late(&r)),
                times.iter().any(|((agent, _), times)| {
                    let duration = problem.agents[*agent].duration;
                    times["end"] - times["start"] > quantile(duration, confidence) + 1e-9
                })
            );
        }
        near(enough as f64 / f64::from(count), confidence, 0.03);
    }
}

/// A sampled duration depends only on its name: another plan, fewer agents or events do not change it.
#[test]
fn durations_depend_on_nothing_but_their_name() {
    let problem = common::vineyard(2);
    let settings = Settings { durations: Durations::Sampled { seed: 7 }, ..settings() };
    let lengths = |execution: &mut ScheduleExecution| {
        run(execution);
        let times = happened(execution.records());
        let names: Vec<_> = execution.problem().agents.iter().map(|who| who.name.clone()).collect();
        times.iter().map(|((a, o), t)| ((names[*a].clone(), *o), t["end"] - t["start"])).collect::<BTreeMap<_, _>>()
    };
    let mut all = ScheduleExecution::new(problem.clone(), settings.clone()).unwrap();
    let all = lengths(&mut all);
    let mut fewer = problem.clone();
    fewer.agents.remove(0);
    let mut fewer = ScheduleExecution::new(fewer, settings.clone()).unwrap();
    fewer.advance(100.0);
    fewer.handle_event(Event::Moved { agent: 0, place: [0.0, 0.0] }).unwrap();
    for (name, length) in lengths(&mut fewer) {
        near(all[&name], length, 1e-9);
    }
    let other = Settings { durations: Durations::Sampled { seed: 8 }, ..settings };
    let other = lengths(&mut ScheduleExecution::new(problem, other).unwrap());
    assert!(all.iter().all(|(name, length)| other[name] != *length));
}

/// 5.B: people give random feedback on waits and speeds. The mean adaptation index is more than 1 if the plan follows
/// it, and exactly 1 if it does not. The complete experiment is `examples/adaptation.rs`.
#[test]
fn plans_follow_what_people_ask_for() {
    for (replan, follows) in [(Replan::None, false), (Replan::Both, true)] {
        let (mut waits, mut speeds) = (Vec::new(), Vec::new());
        for seed in 0..24 {
            let durations = Durations::Sampled { seed };
            let mut problem = common::random(seed, 3, 2, 3);
            problem.agents.iter_mut().for_each(|who| who.kind = AgentKind::Human);
            let mut execution = ScheduleExecution::new(problem, Settings { durations, replan, ..settings() }).unwrap();
            let mut random = common::Random(seed);
            random.unit();
            while let Some(next) = execution.next() {
                let served: Vec<usize> = execution
                    .advance(next)
                    .iter()
                    .filter_map(|record| match record.what {
                        LogEntry::Served { agent, .. } => Some(agent),
                        _ => None,
                    })
                    .collect();
                for agent in served {
                    let (wait, approach) = (random.below(5) as i8 - 2, random.below(5) as i8 - 2);
                    execution.handle_event(Event::Said { agent, wait, approach, distance: 0 }).unwrap();
                }
            }
            let outcome = execution.statistics();
            waits.extend(outcome.agents.iter().map(|agent| agent.wait_index));
            speeds.extend(outcome.agents.iter().map(|agent| agent.speed_index));
        }
        for indices in [waits, speeds] {
            let mean = indices.iter().sum::<f64>() / indices.len() as f64;
            assert!(
                if follows { mean > 1.05 } else { indices.iter().all(|index| *index == 1.0) },
                "{mean} {indices:?}"
            );
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    /// Numbers from tiny to the maximum: every mission ends, or stops with a reason.
    #[test]
    fn extreme_missions_come_to_an_end(
        powers in proptest::collection::vec(-6.0_f64..5.0, 12), zeros in any::<u16>(), bases in any::<bool>(), seed in 0_u64..100,
    ) {
        let mut problem = common::random(1, 2, 2, 2);
        let numbers = powers.iter().enumerate().map(|(k, power)| if zeros >> k & 1 == 1 { 0.0 } else { 10_f64.powf(*power) });
        let mut next = numbers.cycle();
        let mut take = || next.next().unwrap();
        for robot in &mut problem.robots {
            (robot.serve, robot.deposit) = (take(), take());
            robot.depot = [take().min(100.0), -take().min(100.0)];
        }
        for agent in &mut problem.agents {
            agent.duration.mean = take().max(1e-9);
            agent.duration.sigma = take().min(0.5 * agent.duration.mean);
            agent.wait_distance = take().min(10.0);
        }
        let travel = if bases { Travel::Bases(Potentials::default()) } else { Travel::Planned };
        let durations = Durations::Sampled { seed };
        let Ok(mut execution) = ScheduleExecution::new(problem, Settings { travel, durations, ..settings() }) else { return Ok(()) };
        let mut steps = 0;
        while let Some(time) = execution.next() {
            execution.advance(time);
            steps += 1;
            prop_assert!(steps < 20_000, "{:?}", execution.records().last());
        }
        prop_assert!(execution.done() || execution.stranded().is_some());
    }
}
