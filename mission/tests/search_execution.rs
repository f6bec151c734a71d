//! Executions and pages of searches.

use hierarq_mission::execution::{PlanChange, Replan};
use hierarq_mission::kind::{Detail, Event, Execution, Mission, Run};
use hierarq_mission::kinds::search::Search;
use hierarq_mission::kinds::search::check::check;
use hierarq_mission::kinds::search::execution::{Event as Typed, EventError, LogEntry, SearchExecution};
use hierarq_mission::kinds::search::ground::{Body, Ground};
use hierarq_mission::kinds::search::problem::Problem;

use crate::common::Random;
use crate::searched::{light_and_panel, random};

fn execution(problem: &Problem, how: &Run) -> Box<dyn Execution> {
    Search { problem: problem.clone() }.execute(how).expect("an execution")
}

fn worlds(count: usize) -> Vec<(u64, Problem)> {
    let all = (0..).map(|seed| {
        let mut p = random(seed, 3, 5);
        p.planner.states = 400;
        (seed, p)
    });
    all.filter(|(_, p)| check(p).is_empty()).take(count).collect()
}

/// Executed as planned, a plan collects what it promises, whatever the steps of the clock are.
#[test]
fn what_is_promised_is_collected() {
    for (seed, p) in worlds(25) {
        let mut run = execution(&p, &Run::default());
        let promised = run.measure("promised", None)[0];
        let mut time = 0.0;
        while time < p.horizon {
            time += 0.37;
            run.advance(time);
        }
        let got = run.measure("reward", None)[0];
        assert!((got - promised).abs() < 1e-6 * promised.abs().max(1.0), "seed {seed}: {got} of {promised}");
        assert!(run.done().is_some());
        let agents: f64 = (0..3).map(|agent| run.measure("reward", Some(agent))[0]).sum();
        let sources: f64 = (0..p.sources.len()).map(|source| run.measure("reward", Some(3 + source))[0]).sum();
        assert!((agents - got).abs() < 1e-6 && (sources - got).abs() < 1e-6, "seed {seed}: {agents} {sources} {got}");
    }
}

/// Under random events no pool is negative or beyond its content, nobody leaves the free ground, and the end is reached.
#[test]
fn random_events_leave_everything_sound() {
    for (seed, mut p) in worlds(12) {
        p.agents.iter_mut().for_each(|agent| agent.spread = 0.2);
        let mut run = execution(&p, &Run { sampled: Some(seed), ..Run::default() });
        let mut random = Random(seed + 3);
        random.unit();
        let (mut time, mut handled) = (0.0, 0);
        for _ in 0..30 {
            time += random.within(0.05, 1.0);
            run.advance(time);
            let member = random.below(3);
            let place = Detail::Point([random.within(-1.0, 12.0), random.within(-1.0, 12.0)]);
            let messages = ["my_pose", "my_goal", "robot_goal", "robot_pose", "strays"];
            let event = match random.below(11) {
                5 => Event::of("seen", member),
                6 => Event::of("free", member),
                7.. => Event::of(messages[random.below(5)], member).and("to", place),
                0 => Event::of("late", member).and("by", Detail::Number(random.within(-1.0, 3.0))),
                1 => Event::of("moved", member)
                    .and("to", Detail::Point([random.within(-1.0, 12.0), random.within(-1.0, 12.0)])),
                2 => Event::of("lost", member),
                3 => Event::of("back", member),
                _ => Event::of_all("replan"),
            };
            let before = (run.log_len(), run.row());
            match run.handle(&event) {
                Ok(()) => handled += 1,
                Err(why) => assert!(!why.is_empty() && before == (run.log_len(), run.row()), "{event:?}"),
            }
            for (index, agent) in p.agents.iter().enumerate() {
                for name in ["position", "believed"] {
                    let [x, y, _] = run.measure(name, Some(index));
                    let body = Body { radius: agent.radius - 1e-6, ..Body::of(agent) };
                    assert!(Ground::new(&p, &body).fits([x, y]), "seed {seed}: {} at {x}, {y}", agent.name);
                }
            }
            for (index, source) in p.sources.iter().enumerate() {
                let [pool, given] = ["pool", "reward"].map(|name| run.measure(name, Some(3 + index))[0]);
                if let Some(content) = source.pool {
                    assert!((0.0..=content).contains(&pool) && given <= content - pool + 1e-6, "{}", source.name);
                }
            }
        }
        (0..3).for_each(|member| drop(run.handle(&Event::of("back", member))));
        run.advance(time + 200.0);
        assert!(run.done().is_some() && handled > 2, "seed {seed}: {handled} events");
        assert_eq!(run.columns().len(), run.row().len());
    }
}

/// A person who is lost leaves the light to the robot; without replanning nobody opens it.
#[test]
fn the_robot_opens_the_light_when_nobody_else_does() {
    let p = light_and_panel(true);
    for (replan, opened) in [(Default::default(), 1.0), (Replan::None, -1.0)] {
        let mut run = execution(&p, &Run { replan, ..Run::default() });
        run.advance(1.0);
        run.handle(&Event::of("lost", 1)).expect("she leaves");
        run.advance(30.0);
        assert_eq!(run.measure("consumed", Some(2))[0], opened, "{replan:?}");
        assert_eq!(run.measure("consumed", Some(3))[0], opened, "{replan:?}");
    }
}

/// Somebody who reports is waited for, and those who wait for the report go on then.
#[test]
fn a_wait_ends_with_the_activity_that_it_is_for() {
    let p = light_and_panel(true);
    let mut run = execution(&p, &Run { reporting: vec![1], ..Run::default() });
    run.advance(12.0);
    assert_eq!(run.measure("consumed", Some(3))[0], -1.0, "the panel is dark");
    run.handle(&Event::of("done", 1)).expect("she is at the light");
    run.advance(14.0);
    run.handle(&Event::of("done", 1)).expect("the light is on");
    run.advance(20.0);
    assert_eq!(run.measure("consumed", Some(3))[0], 1.0);
    assert!(run.handle(&Event::of("done", 1)).is_err(), "she has nothing to do");
}

/// A late activity moves times, and the repaired plan is valid: nothing is planned anew unless the reward changes.
#[test]
fn late_activities_are_repaired() {
    let mut moved = 0;
    for (seed, p) in worlds(25) {
        let settings = |replan| Search { problem: p.clone() }.settings(&Run { replan, ..Run::default() });
        let mut run = SearchExecution::new(p.clone(), settings(Replan::Reschedule)).expect("an execution");
        let mut random = Random(seed + 11);
        let mut promised = run.promised();
        for _ in 0..10 {
            run.advance(run.time() + random.within(0.1, 2.0));
            let late = Typed::Late { agent: random.below(3), by: random.within(-1.0, 3.0) };
            if run.handle_event(late).is_ok() && run.time() < p.horizon {
                promised = run.rewards().total - run.plan().cost;
            }
        }
        for record in run.records() {
            let LogEntry::Plan(change) = &record.what else { continue };
            assert!(matches!(change, PlanChange::Rescheduled { .. }), "seed {seed}: {record:?}");
            moved += 1;
        }
        // The last repair promises the reward that is collected after it, apart from the steps of the quadrature, which begin anew
        // where a way was cut: 0.1 s at the edge of a source.
        run.advance(run.time() + 300.0);
        let got = run.rewards().total;
        let step: f64 = p.sources.iter().map(|source| 0.1 * source.inside.peak.abs()).sum();
        assert!((got - promised).abs() < step, "seed {seed}: {got} of {promised}");
    }
    assert!(moved > 20, "{moved}");
}

/// A stay that ends early leaves something in its source: somebody goes on with it.
#[test]
fn what_a_stay_leaves_is_planned_for() {
    let p = light_and_panel(true);
    let mut run = execution(&p, &Run { reporting: vec![1], ..Run::default() });
    run.advance(4.0);
    run.handle(&Event::of("done", 1)).expect("she is at the light");
    run.advance(4.1);
    run.handle(&Event::of("done", 1)).expect("she looks away");
    assert_eq!(run.measure("consumed", Some(2))[0], -1.0);
    assert_eq!(run.outcome().reallocations, 1);
    run.advance(6.0);
    run.handle(&Event::of("lost", 1)).expect("she leaves");
    run.advance(40.0);
    assert_eq!(run.measure("consumed", Some(3))[0], 1.0, "the robot goes on");
}

/// An agent that was moved is planned for from where it is, under each setting.
#[test]
fn an_agent_that_was_moved_gets_a_new_plan() {
    let p = light_and_panel(true);
    for replan in [Replan::None, Replan::Reschedule, Replan::Both] {
        let mut run = execution(&p, &Run { replan, ..Run::default() });
        run.advance(1.0);
        let to = [4.0, 7.0];
        run.handle(&Event::of("moved", 0).and("to", Detail::Point(to))).expect("a free position");
        assert_eq!(run.measure("position", Some(0)), [to[0], to[1], 0.0]);
        assert_eq!(run.outcome().reallocations, 1);
        run.advance(30.0);
        assert_eq!(run.measure("consumed", Some(3))[0], 1.0, "{replan:?}");
    }
}

/// Events that are impossible change nothing, and say why.
#[test]
fn impossible_events_are_rejected() {
    let p = light_and_panel(true);
    let settings = Search { problem: p.clone() }.settings(&Run::default());
    let mut run = SearchExecution::new(p, settings).expect("an execution");
    run.advance(1.0);
    run.handle_event(Typed::Lost { agent: 1 }).expect("she leaves");
    let before = run.records().len();
    let name = || "anna".to_string();
    for (event, why) in [
        (Typed::Lost { agent: 1 }, EventError::IsLost { name: name() }),
        (Typed::Late { agent: 1, by: 1.0 }, EventError::IsLost { name: name() }),
        (Typed::Back { agent: 0 }, EventError::NotLost { name: "robot".into() }),
        (Typed::Back { agent: 9 }, EventError::NoAgent { agent: 9 }),
        (Typed::Done { agent: 9 }, EventError::NoAgent { agent: 9 }),
        (Typed::Late { agent: 0, by: 1e300 }, EventError::Time { value: 1e300 }),
        (Typed::Moved { agent: 0, to: [9.0, 1.0] }, EventError::NotFree { name: "robot".into(), at: [9.0, 1.0] }),
    ] {
        assert_eq!(run.handle_event(event), Err(why));
    }
    assert_eq!(run.records().len(), before);
    run.advance(100.0);
    assert_eq!(run.handle_event(Typed::Done { agent: 0 }), Err(EventError::NoActivity { name: "robot".into() }));
}

/// When everybody is lost the search has stopped, until somebody is back.
#[test]
fn a_search_goes_on_when_somebody_is_back() {
    let mut run = execution(&light_and_panel(true), &Run::default());
    run.advance(1.0);
    run.handle(&Event::of("lost", 0)).expect("it leaves");
    assert!(run.stranded().is_none());
    run.handle(&Event::of("lost", 1)).expect("she leaves");
    assert_eq!(run.stranded().as_deref(), Some("everybody is lost"));
    assert!(run.done().is_none());
    run.handle(&Event::of("back", 0)).expect("it is back");
    assert!(run.stranded().is_none());
    run.advance(40.0);
    assert_eq!(run.measure("consumed", Some(3))[0], 1.0);
}
