//! Messages between people and robots of a search: roles, goals that are told, and beliefs that differ from the truth.

use hierarq_mission::execution::Replan;
use hierarq_mission::kind::Run;
use hierarq_mission::kinds::search::Search;
use hierarq_mission::kinds::search::check::check;
use hierarq_mission::kinds::search::choose::{Formulation, Options, plan};
use hierarq_mission::kinds::search::execution::{Event, EventError, LogEntry, Role, SearchExecution};
use hierarq_mission::kinds::search::geometry::{Point, along, distance};
use hierarq_mission::kinds::search::ground::{Body, Ground};
use hierarq_mission::kinds::search::plan::Phase;
use hierarq_mission::kinds::search::problem::Problem;
use hierarq_mission::kinds::search::validate::validate;

use crate::common::Random;
use crate::searched::{grid, light_and_panel, on_grid, random, wall};

fn begun(problem: &Problem, replan: Replan) -> SearchExecution {
    let settings = Search { problem: problem.clone() }.settings(&Run { replan, ..Run::default() });
    SearchExecution::new(problem.clone(), settings).expect("an execution")
}

const ROBOT: usize = 0;
const ANNA: usize = 1;

/// Section 6 of the paper: who has told a goal decides the roles, until it is reached or withdrawn.
#[test]
fn roles_arise_from_messages() {
    let mine = Event::MyGoal { agent: ANNA, to: [4.0, 4.0] };
    let robots = Event::RobotGoal { agent: ROBOT, to: [2.0, 7.0] };
    let cases: [(&[Event], Role); 6] = [
        (&[], Role::LeaderFollower),
        (&[mine], Role::PeerToPeer),
        (&[robots], Role::LeaderLeader),
        (&[mine, robots], Role::MasterSlave),
        (&[robots, mine, Event::Free { agent: ROBOT }], Role::PeerToPeer),
        (&[mine, Event::MyPose { agent: ANNA, to: [6.0, 2.0] }, Event::Replan], Role::PeerToPeer),
    ];
    for (messages, role) in cases {
        let mut run = begun(&light_and_panel(true), Replan::Both);
        run.advance(0.5);
        for message in messages {
            run.handle_event(*message).expect("a possible message");
        }
        assert_eq!(run.role(), role, "{messages:?}");
        // The plan is one from here and now, unless nothing was said.
        assert!(messages.is_empty() || validate(&run.present(), run.plan()).is_empty(), "{messages:?}");
        run.advance(30.0);
        assert_eq!(run.role(), Role::LeaderFollower, "goals are reached: {messages:?}");
        let reached = run.records().iter().filter(|r| matches!(r.what, LogEntry::GoalReached { .. })).count();
        let told = messages.iter().filter(|m| matches!(m, Event::MyGoal { .. } | Event::RobotGoal { .. })).count();
        let freed = messages.iter().filter(|m| matches!(m, Event::Free { .. })).count();
        assert_eq!(reached, told - freed, "{messages:?}");
        assert!(run.rewards().pools.iter().all(|pool| *pool == 0.0), "all is collected afterwards: {messages:?}");
    }
}

/// A goal that is told comes first in every plan, under each setting, and the way to it is clear.
#[test]
fn told_goals_come_first() {
    let mut checked = 0;
    let worlds = (0..60).map(|seed| if seed % 2 == 0 { random(seed, 3, 5) } else { on_grid(grid(seed, 24, 18), seed) });
    for (seed, mut p) in (0..).zip(worlds).filter(|(_, p)| check(p).is_empty()) {
        let mut random = Random(seed + 31);
        random.unit();
        let [low, high] = p.bounds();
        let agent = random.below(p.agents.len());
        let ground = Ground::new(&p, &Body::of(&p.agents[agent]));
        let raster = ground.raster();
        let reached = raster.reached(p.agents[agent].start);
        let places = (0..200).map(|_| [random.within(low[0], high[0]), random.within(low[1], high[1])]);
        let places: Vec<Point> = places.collect();
        let Some(to) = places.into_iter().find(|to| ground.fits(*to) && reached.reaches(*to)) else { continue };
        // The planner and both baselines.
        p.planner.states = 400;
        let mut told = p.clone();
        told.agents[agent].told = Some(to);
        for formulation in Formulation::ALL {
            let found = plan(&told, &Options { formulation, ..Options::of(&told) }).expect("a plan").plan;
            let violations = validate(&told, &found);
            assert!(violations.is_empty(), "seed {seed}, {}: {violations:?}", formulation.name());
            if let Some(first) = found.activities.iter().find(|activity| activity.agent == agent) {
                let end = along(&first.way, 1.0, 0.0).at;
                assert!(first.phase == Phase::Going && distance(end, to) < 1e-9, "seed {seed}: {first:?}");
                checked += 1;
            }
        }
        // Executed: the message changes the plan at once, whatever the setting.
        let human = p.agents[agent].human;
        for replan in [Replan::None, Replan::Both] {
            let mut run = begun(&p, replan);
            run.advance(0.2);
            let event = if human { Event::MyGoal { agent, to } } else { Event::RobotGoal { agent, to } };
            if run.handle_event(event).is_ok() {
                let view = run.agent(agent).expect("an agent");
                assert!(run.told_goal(agent).is_none() || view.source.is_none(), "seed {seed}: {view:?}");
                run.advance(p.horizon + 200.0);
                assert!(run.done(), "seed {seed}");
            }
        }
    }
    assert!(checked > 60, "{checked}");
}

/// A person who strays is believed to follow the plan; nothing is collected where the person is not, until the person is seen.
#[test]
fn beliefs_differ_from_the_truth_until_somebody_is_seen() {
    for how in ["seen", "my pose", "never"] {
        let mut run = begun(&light_and_panel(true), Replan::Both);
        run.advance(1.0);
        run.handle_event(Event::Strays { agent: ANNA, to: [4.0, 7.0] }).expect("she goes away");
        let expected: Vec<Point> = [1.5, 2.5, 3.5].iter().map(|t| [7.0, 1.0 + t]).collect();
        for (time, at) in [1.5, 2.5, 3.5].into_iter().zip(expected) {
            run.advance(time);
            let view = run.agent(ANNA).expect("she is there");
            assert!(distance(view.believed.at, at) < 1e-6, "she is believed on her way: {view:?}");
        }
        run.advance(10.0);
        let view = run.agent(ANNA).expect("she is there");
        assert!(
            distance(view.pose.at, [4.0, 7.0]) < 1e-9 && distance(view.believed.at, view.pose.at) > 1.0,
            "{view:?}"
        );
        // From (7, 2) at 1 s to (4, 7), after 1 m of the plan.
        assert!((view.travelled - 1.0 - f64::hypot(3.0, 5.0)).abs() < 1e-6, "{view:?}");
        assert!(run.rewards().pools[0] > 4.9, "nobody has switched on the light");
        match how {
            "seen" => drop(run.handle_event(Event::Seen { agent: ANNA }).expect("she is seen")),
            "my pose" => drop(run.handle_event(Event::MyPose { agent: ANNA, to: [4.2, 6.9] }).expect("she says so")),
            _ => {}
        }
        run.advance(30.0);
        let found = how != "never";
        assert_eq!(run.rewards().pools[1] == 0.0, found, "{how}: {:?}", run.rewards());
        let view = run.agent(ANNA).expect("she is there");
        assert_eq!(view.pose == view.believed, found, "{how}");
    }
}

/// A pose that is told wrongly moves the belief alone.
#[test]
fn a_wrong_pose_is_believed() {
    let mut run = begun(&light_and_panel(true), Replan::Both);
    run.advance(1.0);
    run.handle_event(Event::Strays { agent: ANNA, to: [4.0, 7.0] }).expect("she goes away");
    run.advance(3.0);
    let truth = run.agent(ANNA).expect("she is there").pose.at;
    run.handle_event(Event::MyPose { agent: ANNA, to: [1.0, 2.0] }).expect("she errs");
    let view = run.agent(ANNA).expect("she is there");
    assert!(view.pose.at == truth && view.believed.at == [1.0, 2.0], "{view:?}");
    assert_eq!(run.messages().poses, 1);
}

/// Bad messages are refused with the reason, and change nothing.
#[test]
fn bad_messages_are_refused() {
    let mut p = light_and_panel(true);
    p.walls.push(wall("closet", &[[5.0, 8.0], [5.0, 7.0], [6.0, 7.0], [6.0, 8.0]]));
    let mut run = begun(&p, Replan::Both);
    run.advance(1.0);
    let goal = Event::MyGoal { agent: ANNA, to: [4.0, 4.0] };
    run.handle_event(goal).expect("a goal");
    let before = (run.records().len(), run.plan().clone(), run.messages());
    let (anna, robot) = (|| "anna".to_string(), || "robot".to_string());
    let inside = [5.5, 7.5];
    for (event, why) in [
        (Event::MyPose { agent: ANNA, to: [7.9, 2.0] }, EventError::NotFree { name: anna(), at: [7.9, 2.0] }),
        (Event::MyPose { agent: ANNA, to: [9.0, 2.0] }, EventError::NotFree { name: anna(), at: [9.0, 2.0] }),
        (Event::MyPose { agent: ROBOT, to: [4.0, 2.0] }, EventError::NoPerson { name: robot() }),
        (Event::MyGoal { agent: ANNA, to: inside }, EventError::NoWay { name: anna(), at: inside }),
        (goal, EventError::SameGoal { name: anna() }),
        (Event::RobotGoal { agent: ANNA, to: [4.0, 2.0] }, EventError::NoRobot { name: anna() }),
        (Event::RobotGoal { agent: ROBOT, to: inside }, EventError::NoWay { name: robot(), at: inside }),
        (Event::RobotPose { agent: ROBOT, to: [5.0, 7.5] }, EventError::NotFree { name: robot(), at: [5.0, 7.5] }),
        (Event::Free { agent: ROBOT }, EventError::NoGoal { name: robot() }),
        (Event::Strays { agent: ROBOT, to: [4.0, 2.0] }, EventError::NoPerson { name: robot() }),
        (Event::Seen { agent: 9 }, EventError::NoAgent { agent: 9 }),
    ] {
        assert_eq!(run.handle_event(event), Err(why), "{event:?}");
    }
    let not = Event::MyPose { agent: ANNA, to: [f64::NAN, 2.0] };
    assert!(matches!(run.handle_event(not), Err(EventError::NotFree { .. })));
    assert_eq!((run.records().len(), run.plan().clone(), run.messages()), before);
    // Behind the walls there is no way to the goal: it is dropped.
    run.handle_event(Event::Moved { agent: ANNA, to: inside }).expect("a free place");
    assert_eq!((run.told_goal(ANNA), run.role()), (None, Role::LeaderFollower));
}
