//! Single events of an executed mission: their effects, and rejected ones.

use crate::common;

use common::execution::{count, happened, near, part, run, settings};
use hierarq_mission::execution::NoFeasiblePlan;
use hierarq_mission::execution::{Durations, Replan};
use hierarq_mission::kinds::schedule::execution::{
    Doing, Event, EventError, LogEntry, Obstacle, Potentials, Refusal, ScheduleExecution, Settings, Stage, Travel,
};
use hierarq_mission::kinds::schedule::plan::{Activity, Actor, Phase};
use hierarq_mission::kinds::schedule::problem::{AgentKind, Begun, Problem};
use hierarq_mission::kinds::schedule::validate::validate;
use hierarq_mission::numbers::Range;

/// 5.F: an operation that ends early is served early by a waiting robot; a late one delays the approach.
#[test]
fn a_robot_that_waits_approaches_when_the_operation_ends() {
    let mut problem = common::vineyard(1);
    for robot in &mut problem.robots {
        (robot.speed, robot.proximity) = (Range::point(0.2), Some(Range::point(0.2)));
    }
    let mut execution = ScheduleExecution::new(problem, Settings { replan: Replan::Reschedule, ..settings() }).unwrap();
    let robot_waits = |execution: &ScheduleExecution| {
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
    execution.handle_event(Event::Done { agent }).unwrap();
    let next = execution.agent(agent).unwrap().coming.unwrap();
    near(next.approaches, now, 1e-9);
    near(next.serves - next.approaches, coming.serves - coming.approaches, 1e-9);
    assert_eq!(
        execution.advance(now).last().unwrap().what,
        LogEntry::Approaches { robot: next.robot, agent, operation: 0 }
    );
    let mut late = execution.clone();
    run(&mut execution);
    assert!(execution.done());
    // Another agent reports that it needs longer.
    let other = (0..4).find(|a| late.agent(*a).unwrap().doing == Doing::Working).unwrap();
    let expected = late.agent(other).unwrap().until.unwrap();
    late.handle_event(Event::Late { agent: other, by: 200.0 }).unwrap();
    near(late.agent(other).unwrap().until.unwrap(), expected + 200.0, 1e-9);
    assert!(late.agent(other).unwrap().coming.unwrap().serves >= expected + 200.0 - 1e-9);
    run(&mut late);
    near(happened(late.records())[&(other, 0)]["end"], expected + 200.0, 1e-9);
}

/// A robot on its path moves slowly while there is time. If the operation ends early, or is reported to, the robot
/// moves as fast as the wait justifies, within its limits.
#[test]
fn a_robot_under_way_speeds_up_for_who_ends_early() {
    let mut agent = common::agent("h1", AgentKind::Human, [12.0, 0.0], 1, 200.0);
    agent.duration.sigma = 0.0;
    let problem = Problem::new(vec![common::robot("m1", [0.0, 0.0], 1.0)], vec![agent]);
    for (event, end) in [(Event::Done { agent: 0 }, 60.0), (Event::Late { agent: 0, by: -60.0 }, 140.0)] {
        for travel in [Travel::Planned, Travel::Bases(Potentials::default())] {
            let mut execution = ScheduleExecution::new(problem.clone(), Settings { travel, ..settings() }).unwrap();
            execution.advance(60.0);
            let planned = execution.agent(0).unwrap().coming.unwrap();
            let view = execution.robot(0).unwrap();
            assert!(view.stage == Stage::Going && f64::hypot(view.velocity[0], view.velocity[1]) < 0.08, "{view:?}");
            execution.handle_event(event).unwrap();
            let coming = execution.agent(0).unwrap().coming.unwrap();
            let approach = planned.serves - planned.approaches;
            near(coming.serves - coming.approaches, approach, 1e-9);
            // The rest of the path at 0.2 m/s, or the end of the operation if that is later.
            let there = 60.0 + (11.0 - view.position[0]) / 0.2;
            near(coming.serves, (there + approach).max(end), 1.0);
            assert!(coming.serves < planned.serves - 30.0, "{coming:?} {planned:?}");
            assert!(validate(execution.problem(), execution.plan()).is_empty());
            while !execution.done() && execution.time() < 2000.0 {
                execution.advance(execution.time() + 0.5);
                let [x, y] = execution.robot(0).unwrap().velocity;
                assert!(f64::hypot(x, y) <= 0.2 + 1e-9);
            }
            assert!(execution.done());
            assert!(execution.statistics().agents[0].waited() <= (coming.serves - end).max(0.0) + 3.0);
        }
    }
}

/// If operations end earlier than planned, no robot stays at its depot while its next agent waits.
#[test]
fn nobody_waits_for_a_robot_at_home() {
    for seed in 0..6 {
        let durations = Durations::Sampled { seed };
        let settings = Settings { durations, replan: Replan::Reschedule, ..settings() };
        let mut execution = ScheduleExecution::new(common::random(seed, 4, 2, 3), settings).unwrap();
        while let Some(next) = execution.next() {
            execution.advance(next);
            for robot in (0..2).filter(|m| execution.robot(*m).unwrap().stage == Stage::Home) {
                let Some(leaves) = execution.robot(robot).unwrap().until.filter(|at| *at > execution.time() + 1e-6)
                else {
                    continue;
                };
                let going =
                    |a: &&Activity| a.actor == Actor::Robot(robot) && a.phase == Phase::Going && a.start == leaves;
                let target = execution.plan().activities.iter().find(going).unwrap().target;
                let agent = execution.agent(target.agent).unwrap();
                let waits = agent.doing == Doing::Waiting && agent.operation == Some(target.operation);
                assert!(!waits, "{seed}: {target:?} at {}", execution.time());
            }
        }
        assert!(execution.done());
    }
}

/// A lost robot: its service is aborted, and the other robot takes over everything else; if that is lost too, the
/// mission stops and reports the reason; after it is back, the mission continues to its end.
#[test]
fn robots_that_are_lost_are_done_without() {
    let mut execution = ScheduleExecution::new(common::vineyard(2), settings()).unwrap();
    execution.advance(100.0);
    let lost = (0..2).find(|m| execution.robot(*m).unwrap().stage == Stage::Going).unwrap();
    execution.handle_event(Event::Lost { who: Actor::Robot(lost) }).unwrap();
    assert_eq!(count(execution.records(), |what| matches!(what, LogEntry::BrokenOff { .. })), 1);
    assert!(execution.handle_event(Event::Lost { who: Actor::Robot(lost) }).is_err());
    let new = execution.plan().activities.iter().filter(|a| !a.begun && a.phase == Phase::Going);
    assert!(new.clone().count() > 0 && new.into_iter().all(|a| a.actor == Actor::Robot(1 - lost)));
    assert!(validate(execution.problem(), execution.plan()).is_empty());
    execution.advance(700.0);
    execution.handle_event(Event::Lost { who: Actor::Robot(1 - lost) }).unwrap();
    assert_eq!(execution.stranded(), Some(&NoFeasiblePlan::NobodyLeft { who: "every robot".into() }));
    execution.advance(3000.0);
    assert_eq!(execution.next(), None);
    assert!(!execution.done());
    let doing: Vec<Doing> = (0..4).map(|agent| execution.agent(agent).unwrap().doing).collect();
    assert!(doing.contains(&Doing::Waiting), "{doing:?}");
    assert!(doing.iter().all(|doing| matches!(doing, Doing::Waiting | Doing::Finished)), "{doing:?}");
    execution.handle_event(Event::Back { who: Actor::Robot(lost) }).unwrap();
    assert_eq!(execution.stranded(), None);
    run(&mut execution);
    assert!(execution.done());
    assert!(execution.statistics().agents.iter().all(|agent| agent.served == 2));
    assert_eq!(execution.statistics().robots[1 - lost].served + execution.statistics().robots[lost].served, 8);
}

/// An agent that leaves is no longer served, and the robot on its path to it returns; after it is back, it repeats its
/// operation.
#[test]
fn agents_come_and_go() {
    let mut execution = ScheduleExecution::new(common::vineyard(2), settings()).unwrap();
    execution.advance(200.0);
    let (robot, target) = (0..2).find_map(|m| Some((m, execution.robot(m)?.target?))).unwrap();
    execution.handle_event(Event::Lost { who: Actor::Agent(target.agent) }).unwrap();
    assert_eq!(execution.robot(robot).unwrap().stage, Stage::Recalled);
    assert_eq!(execution.problem().operations(), 6);
    assert_eq!(execution.plan().of(Actor::Agent(target.agent)).count(), 0);
    let mut without = execution.clone();
    run(&mut without);
    assert!(without.done());
    assert_eq!(without.statistics().agents[target.agent].served, 0);
    execution.advance(900.0);
    execution.handle_event(Event::Back { who: Actor::Agent(target.agent) }).unwrap();
    run(&mut execution);
    assert!(execution.done());
    assert_eq!(execution.statistics().agents[target.agent].served, 2);
    assert_eq!(happened(execution.records())[&(target.agent, 0)]["start"], 900.0);
    // An agent may come back after the end too.
    without.handle_event(Event::Back { who: Actor::Agent(target.agent) }).unwrap();
    assert!(!without.done());
    run(&mut without);
    assert!(without.done());
    assert_eq!(without.statistics().agents[target.agent].served, 2);
}

/// A failed service is repeated; one that ends earlier is over; a moved agent is served at its new position.
#[test]
fn services_fail_end_early_and_move() {
    let mut execution = ScheduleExecution::new(common::vineyard(1), settings()).unwrap();
    let serving = |execution: &ScheduleExecution| (0..4).find(|a| execution.agent(*a).unwrap().doing == Doing::Served);
    while serving(&execution).is_none() {
        let next = execution.next().unwrap();
        execution.advance(next);
    }
    let agent = serving(&execution).unwrap();
    let since = execution.time();
    execution.advance(since + 4.0);
    execution.handle_event(Event::Failed { agent }).unwrap();
    near(execution.agent(agent).unwrap().until.unwrap(), since + 14.0, 1e-9);
    assert!(matches!(
        execution.handle_event(Event::Moved { agent, place: [0.0, 0.0] }),
        Err(EventError::RobotNear { .. })
    ));
    execution.advance(since + 5.0);
    execution.handle_event(Event::Served { agent }).unwrap();
    assert_eq!(execution.agent(agent).unwrap().doing, Doing::Finished);
    let other = (0..4).find(|a| execution.agent(*a).unwrap().doing == Doing::Working).unwrap();
    execution.handle_event(Event::Moved { agent: other, place: [5.0, 5.0] }).unwrap();
    run(&mut execution);
    assert!(execution.done());
    let at = part(execution.plan(), (other, 0), Phase::Serving).unwrap();
    assert_eq!(at.place, Some([5.0, 5.0]));
    assert!(matches!(execution.handle_event(Event::Done { agent }), Err(EventError::NotWorking { .. })));
    assert!(matches!(execution.handle_event(Event::Done { agent: 9 }), Err(EventError::NoAgent { agent: 9 })));
    let said = |wait| Event::Said { agent: 0, wait, approach: 0, distance: 0 };
    assert!(matches!(execution.handle_event(said(3)), Err(EventError::Step { step: 3 })));
}

/// A service that takes longer keeps its robot and its person for that time, and delays the following activities of
/// both; a shorter one ends earlier, but never in the past.
#[test]
fn services_take_longer_or_shorter() {
    for by in [25.0, 3.0, -2.0, -500.0] {
        let mut execution = ScheduleExecution::new(common::vineyard(2), settings()).unwrap();
        let serving =
            |execution: &ScheduleExecution| (0..4).find(|a| execution.agent(*a).unwrap().doing == Doing::Served);
        while serving(&execution).is_none() {
            let next = execution.next().unwrap();
            execution.advance(next);
        }
        let agent = serving(&execution).unwrap();
        let robot = (0..2).find(|m| execution.robot(*m).unwrap().stage == Stage::Serving).unwrap();
        let expected = execution.agent(agent).unwrap().until.unwrap();
        execution.advance(execution.time() + 4.0);
        let until = (expected + by).max(execution.time());
        execution.handle_event(Event::Late { agent, by }).unwrap();
        near(execution.agent(agent).unwrap().until.unwrap(), until, 1e-9);
        near(execution.robot(robot).unwrap().until.unwrap(), until, 1e-9);
        assert!(part(execution.plan(), (agent, 1), Phase::Operation).unwrap().start >= until - 1e-9, "{by}");
        execution.advance(until);
        assert_eq!(execution.robot(robot).unwrap().stage, Stage::Returning);
        assert!(matches!(execution.handle_event(Event::Late { agent: 9, by }), Err(EventError::NoAgent { agent: 9 })));
        run(&mut execution);
        assert!(execution.done());
        near(happened(execution.records())[&(agent, 0)]["depositing"], until, 1e-9);
        assert!(matches!(execution.handle_event(Event::Late { agent, by }), Err(EventError::NotBusy { .. })));
    }
}

/// Invalid settings are rejected before the start.
#[test]
fn wrong_settings_are_refused() {
    let refused = |change: &dyn Fn(&mut Problem, &mut Settings)| {
        let (mut problem, mut settings) = (common::vineyard(1), settings());
        change(&mut problem, &mut settings);
        ScheduleExecution::new(problem, settings).unwrap_err()
    };
    assert_eq!(refused(&|_, s| s.reporting = vec![7]), Refusal::Reporting(7));
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
    let two = [[0.0, 3.0], [2.5, 3.0]].map(|place| Obstacle { place, radius: 0.2 });
    assert!(matches!(bases(&|p| p.obstacles = two.to_vec()), Refusal::Narrow { .. }));
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

/// An operation with an end beyond the valid times leaves no plan; after it has ended, there is a plan again.
#[test]
fn a_mission_without_a_plan_finds_one_again() {
    let mut execution = ScheduleExecution::new(common::vineyard(1), settings()).unwrap();
    execution.advance(50.0);
    execution.handle_event(Event::Late { agent: 0, by: 1e6 }).unwrap();
    assert!(matches!(execution.stranded(), Some(NoFeasiblePlan::Broken { .. })), "{:?}", execution.stranded());
    execution.advance(400.0);
    assert!((0..2).all(|robot| execution.robot(robot).unwrap().stage == Stage::Home));
    execution.handle_event(Event::Done { agent: 0 }).unwrap();
    assert_eq!(execution.stranded(), None);
    assert!(validate(execution.problem(), execution.plan()).is_empty());
    run(&mut execution);
    assert!(execution.done());
}

/// A person who asks for longer waits gets waits longer by the step of the limit; weights alone would make them minutes
/// long.
#[test]
fn longer_waits_have_a_measure() {
    let waits = |limit: f64, said: i8| {
        let mut agent = common::agent("h1", AgentKind::Human, [4.0, 0.0], 5, 20.0);
        (agent.duration.sigma, agent.wait_limit) = (0.0, limit);
        let mut problem = Problem::new(vec![common::robot("m1", [0.0, 0.0], 1.0)], vec![agent]);
        problem.weights.makespan = 0.0;
        let mut execution = ScheduleExecution::new(problem, settings()).unwrap();
        while execution.statistics().agents[0].served < 1 {
            let next = execution.next().unwrap();
            execution.advance(next);
        }
        execution.handle_event(Event::Said { agent: 0, wait: said, approach: 0, distance: 0 }).unwrap();
        assert!(validate(execution.problem(), execution.plan()).is_empty());
        run(&mut execution);
        let waits = execution.statistics().agents[0].waits.clone();
        waits[1..4].iter().copied().fold(0.0, f64::max)
    };
    let before = waits(60.0, 0);
    assert!(before < 75.0, "{before}");
    // Half a step for half of the feedback, 30 s for all of it.
    near(waits(60.0, -1), 75.0, 0.5);
    near(waits(60.0, -2), 90.0, 0.5);
    near(waits(100.0, -2), 130.0, 0.5);
    assert!(waits(60.0, 2) <= before + 0.5);
    let without = waits(1e6, -2);
    assert!(without > 150.0, "{without}");
}

/// A person who asks for a slower robot gets one, and the index grows; without replanning, feedback is only recorded.
#[test]
fn feedback_changes_the_plan_only_where_it_may() {
    for (replan, changes) in [(Replan::None, false), (Replan::Reschedule, true), (Replan::Both, true)] {
        let mut execution = ScheduleExecution::new(common::vineyard(2), Settings { replan, ..settings() }).unwrap();
        let served = |execution: &ScheduleExecution| (0..3).find(|a| execution.statistics().agents[*a].served == 1);
        while served(&execution).is_none() {
            let next = execution.next().unwrap();
            execution.advance(next);
        }
        let agent = served(&execution).unwrap();
        let before = execution.problem().clone();
        let said = Event::Said { agent, wait: 2, approach: -2, distance: -1 };
        execution.handle_event(said).unwrap();
        assert_eq!(execution.problem().agents[agent] != before.agents[agent], changes, "{replan:?}");
        assert_eq!(execution.problem().wait_weight(agent, 1) > before.wait_weight(agent, 1), changes);
        assert_eq!(count(execution.records(), |what| *what == LogEntry::Handled { event: said }), 1);
        run(&mut execution);
        let outcome = execution.statistics();
        assert_eq!(outcome.agents[agent].speed_index > 1.0, changes, "{replan:?} {outcome:?}");
        assert!(outcome.waited() > 0.0 && outcome.energy() > 0.0);
        assert!(outcome.reallocations == 0 || replan == Replan::Both);
    }
}

/// A robot on its path to a moved agent keeps its remaining distance, whatever other events occur.
#[test]
fn a_robot_that_was_sent_elsewhere_is_there_no_sooner() {
    let mut problem = Problem::new(
        vec![common::robot("m1", [-10.0, 0.0], 1.0), common::robot("m2", [-10.0, -5.0], 1.0)],
        vec![
            common::agent("h1", AgentKind::Human, [0.0, 0.0], 1, 100.0),
            common::agent("h2", AgentKind::Human, [0.0, -5.0], 1, 60.0),
        ],
    );
    problem.robots.iter_mut().for_each(|robot| robot.speed = Range::point(0.25));
    problem.robots.iter_mut().for_each(|robot| robot.proximity = None);
    problem.agents.iter_mut().for_each(|agent| agent.duration.sigma = 0.0);
    let settings = Settings { replan: Replan::Reschedule, ..settings() };
    let mut execution = ScheduleExecution::new(problem, settings).unwrap();
    let comes = |execution: &ScheduleExecution, time: f64| {
        let service = |phase| part(execution.plan(), (0, 0), phase).unwrap().start;
        let view = (0..2).map(|robot| execution.robot(robot).unwrap());
        let speeds: Vec<f64> = view.map(|view| f64::hypot(view.velocity[0], view.velocity[1])).collect();
        assert!(speeds.iter().all(|speed| *speed <= 0.25 + 1e-9), "{speeds:?}");
        (service(Phase::Waiting) - time, service(Phase::Going))
    };
    // It has left; its path starts at its position.
    let leaves = comes(&execution, 0.0).1;
    let time = leaves + 20.0;
    execution.advance(time);
    execution.handle_event(Event::Moved { agent: 0, place: [-10.0, 20.0] }).unwrap();
    let way = f64::hypot(5.0, 19.0) / 0.25;
    near(comes(&execution, time).0, way, 1e-6);
    execution.advance(time + 5.0);
    execution.handle_event(Event::Late { agent: 1, by: 30.0 }).unwrap();
    near(comes(&execution, time).0, way, 1e-6);
    run(&mut execution);
    assert!(execution.done());
}

/// A robot without a waiting distance is asked to wait farther away: past phases stay unchanged.
#[test]
fn a_distance_that_was_nothing_may_grow() {
    let mut agent = common::agent("h1", AgentKind::Human, [10.0, 0.0], 3, 50.0);
    agent.wait_distance = 0.0;
    let problem = Problem::new(vec![common::robot("m1", [-6.0, 0.0], 1.0)], vec![agent]);
    for seed in 0..12 {
        let settings = Settings { durations: Durations::Sampled { seed }, ..settings() };
        let mut execution = ScheduleExecution::new(problem.clone(), settings).unwrap();
        while execution.statistics().agents[0].served < 1 {
            let next = execution.next().unwrap();
            execution.advance(next);
        }
        execution.handle_event(Event::Said { agent: 0, wait: 0, approach: 0, distance: 2 }).unwrap();
        near(execution.problem().approach(&execution.problem().agents[0], 0).1, 1.0, 1e-12);
        run(&mut execution);
        assert!(execution.done() && execution.stranded().is_none());
    }
}

/// Feedback that the robot came too slowly at its greatest speed widens the range of speeds, and the plan uses it.
#[test]
fn a_wider_range_of_speeds_is_used() {
    let mut problem = Problem::new(
        vec![common::robot("m1", [0.0, 0.0], 1.0)],
        vec![common::agent("h1", AgentKind::Human, [8.0, 0.0], 4, 2.0)],
    );
    problem.robots[0].speed = Range::new(0.05, 1.0);
    problem.robots[0].proximity = Some(Range::new(0.1, 0.4));
    problem.agents[0].wait_weights = vec![1000.0; 4];
    problem.agents[0].wait_distance = 4.0;
    let mut execution = ScheduleExecution::new(problem, settings()).unwrap();
    for served in 1..3 {
        while execution.statistics().agents[0].served < served {
            let next = execution.next().unwrap();
            execution.advance(next);
        }
        execution.handle_event(Event::Said { agent: 0, wait: 0, approach: 2, distance: 0 }).unwrap();
    }
    run(&mut execution);
    let speeds = execution.statistics().agents[0].speeds.clone();
    // Algorithm 2: 0.4 (1 + 1), then 0.8 (1 + 1), limited to the robot's maximum speed.
    for (speed, most) in speeds.iter().zip([0.4, 0.8, 1.0, 1.0]) {
        near(*speed, most, 1e-3);
    }
}

/// An aborted wait still counts.
#[test]
fn waits_in_vain_count() {
    let mut problem = Problem::new(
        vec![common::robot("m1", [-8.0, 0.0], 1.0)],
        vec![common::agent("h1", AgentKind::Human, [8.0, 0.0], 2, 20.0)],
    );
    problem.agents[0].duration.sigma = 0.0;
    let mut execution = ScheduleExecution::new(problem, settings()).unwrap();
    let waited = |execution: &ScheduleExecution| execution.statistics().agents[0].waited();
    execution.advance(45.0);
    near(waited(&execution), 25.0, 1e-9);
    execution.handle_event(Event::Lost { who: Actor::Agent(0) }).unwrap();
    execution.advance(100.0);
    near(waited(&execution), 25.0, 1e-9);
    execution.handle_event(Event::Back { who: Actor::Agent(0) }).unwrap();
    execution.advance(130.0);
    near(waited(&execution), 35.0, 1e-9);
    let before = waited(&execution);
    run(&mut execution);
    let end = execution.statistics().agents[0].clone();
    assert!(end.waited() > before && end.waiting == 0.0 && end.waits.len() == 2, "{end:?}");
}
