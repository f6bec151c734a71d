//! Executing explorations: what the person does is not what was expected.

use hierarq_mission::execution::Replan;
use hierarq_mission::kind::{Detail, Event, Execution, Mission, Run};
use hierarq_mission::kinds::explore::Explore;
use hierarq_mission::kinds::explore::execution::ExploreExecution;
use hierarq_mission::kinds::explore::polygon::Convex;
use hierarq_mission::kinds::explore::problem::{Fallback, Model, Problem};
use proptest::prelude::*;

use crate::explored::{rectangle, world};

/// A room that the built-in engine can plan in: one robot, one obstacle, two targets, and an exit that is near.
pub(crate) fn room() -> Problem {
    let mut problem = world();
    problem.area = rectangle([2.5, 2.5], [5.0, 5.0]);
    problem.exit = rectangle([4.5, 0.5], [1.0, 1.0]);
    problem.obstacles.truncate(1);
    problem.targets.truncate(2);
    problem.targets[0].shape = rectangle([0.5, 4.5], [0.6, 0.6]);
    problem.targets[1].shape = rectangle([1.5, 0.5], [0.6, 0.6]);
    problem.robots.truncate(1);
    problem.robots[0].start = [0.5, 3.5];
    problem.person.start = [0.5, 0.5];
    problem.connection = Convex::regular(8, 6.0).unwrap();
    problem.periods = 8;
    problem.planner.nodes = 100;
    problem.planner.time = 20.0;
    problem
}

fn start(problem: &Problem, how: &Run) -> Box<dyn Execution> {
    let mission = Explore { problem: problem.clone() };
    mission.check().unwrap();
    mission.execute(how).unwrap()
}

fn end(mut run: Box<dyn Execution>, limit: f64) -> Box<dyn Execution> {
    run.advance(limit);
    run
}

#[test]
fn robots_take_what_the_person_leaves() {
    let mut run = end(start(&room(), &Run::default()), 5.0);
    assert_eq!(run.done(), Some(5.0), "{:#?}", run.log());
    let (at, log) = (run.measure("position", Some(0)), run.log());
    run.advance(60.0);
    // Nobody moves after the end.
    assert_eq!((run.measure("position", Some(0))[..2].to_vec(), run.log()), (at[..2].to_vec(), log));
    let whole = |name: &str| run.measure(name, None)[0];
    assert_eq!((whole("targets"), whole("by_robots"), whole("by_person")), (2.0, 1.0, 1.0));
    assert_eq!((whole("collisions"), whole("disconnections"), whole("redundant")), (0.0, 0.0, 0.0));
    assert!(whole("closest") > 0.0 && whole("connected") > 0.0);
}

/// The person takes a target against the prediction: robots that plan anew leave it then, and those that keep their first plan
/// come to it in vain.
#[test]
fn planning_anew_follows_the_person() {
    let mut problem = room();
    problem.person.predicted = Model::GoalDirected { values: vec![0.0, 0.0] };
    problem.person.walks = Model::GoalDirected { values: vec![0.0, 1.0] };
    problem.person.speed = 0.5;
    problem.periods = 24;
    let closed = end(start(&problem, &Run::default()), 20.0);
    let open = end(start(&problem, &Run { replan: Replan::None, ..Run::default() }), 20.0);
    assert_eq!(closed.done(), open.done());
    let of = |run: &dyn Execution, name: &str| run.measure(name, None)[0];
    assert_eq!((of(&*closed, "targets"), of(&*closed, "redundant")), (2.0, 0.0), "{:#?}", closed.log());
    assert_eq!((of(&*open, "targets"), of(&*open, "redundant")), (2.0, 1.0), "{:#?}", open.log());
}

/// However time is cut into steps, the same happens.
#[test]
fn steps_of_the_clock_change_nothing() {
    let (once, mut often) = (end(start(&room(), &Run::default()), 8.0), start(&room(), &Run::default()));
    for step in 0..=800 {
        often.advance(f64::from(step) * 0.01);
    }
    assert_eq!(once.log(), often.log());
    assert_eq!(once.outcome(), often.outcome());
}

#[test]
fn events_that_are_impossible_change_nothing() {
    let mut run = start(&room(), &Run::default());
    run.advance(1.0);
    let before = run.log();
    for (event, why) in [
        (Event::of("back", 0), "is there"),
        (Event::of("back", 1), "in sight already"),
        (Event::of("my_pose", 1).and("to", Detail::Point([0.5, 0.5])), "simulated"),
        (Event::of("strays", 1).and("to", Detail::Point([2.5, 2.5])), "blocked"),
        (Event::of("strays", 1).and("to", Detail::Point([9.0, 2.5])), "outside"),
        (Event::of("strays", 1), "needs `to`"),
        (Event::of("done", 1), "by walking"),
        (Event::of("late", 0), "no event"),
        (Event::of("lost", 7), "does not exist"),
    ] {
        let caught = run.handle(&event).unwrap_err();
        assert!(caught.contains(why), "{caught}");
    }
    assert_eq!(run.log(), before);
}

/// While nobody knows where the person is there is no plan, and afterwards there is one again.
#[test]
fn an_unseen_person_stops_the_plans() {
    let mut run = start(&room(), &Run::default());
    run.advance(1.2);
    run.handle(&Event::of("lost", 1)).unwrap();
    run.advance(2.5);
    assert!(run.measure("planned", None)[0] < 0.0);
    run.handle(&Event::of("back", 1)).unwrap();
    run.advance(3.0);
    assert!(run.measure("planned", None)[0] > 0.0, "{:#?}", run.log());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, max_shrink_iters: 20, ..ProptestConfig::default() })]

    /// The person walks back, stands, leaves early, goes where robots are, gets lost: robots stay within their limits, no
    /// target is taken twice, and the same happens again.
    #[test]
    fn robots_keep_their_limits_whatever_the_person_does(
        events in prop::collection::vec((0..3_usize, 0.3..6.0_f64, 0..25_usize, 0.0..3.0_f64), 1..4),
        stop in any::<bool>(),
    ) {
        let mut problem = room();
        problem.planner.nodes = 20;
        problem.planner.fallback = if stop { Fallback::Stop } else { Fallback::Barrier };
        let mut events = events;
        events.sort_by(|a, b| a.1.total_cmp(&b.1));
        let play = || {
            let mut run = start(&problem, &Run::default());
            let mut events = events.iter().peekable();
            for tick in 0..=160 {
                let time = f64::from(tick) * 0.05;
                while let Some((kind, _, cell, by)) = events.next_if(|(_, at, ..)| *at <= time) {
                    let to = [0.5 + (cell % 5) as f64, 0.5 + (cell / 5) as f64];
                    let event = match kind {
                        0 => Event::of("strays", 1).and("to", Detail::Point(to)),
                        1 => Event::of("late", 1).and("by", Detail::Number(*by)),
                        _ => Event::of(if cell % 2 == 0 { "lost" } else { "back" }, 1),
                    };
                    // Places in the obstacle, and who is in sight already, are refused.
                    let _ = run.handle(&event);
                }
                run.advance(time);
                let [x, y, _] = run.measure("position", Some(0));
                let body = problem.robots[0].body.moved([x, y]);
                assert!(body.corners().iter().all(|corner| problem.area.contains(*corner, 1e-6)), "{x} {y}");
                assert!(body.gap(&problem.obstacles[0].shape) > -1e-6, "{x} {y} at {time}: {:#?}", run.log());
            }
            run
        };
        let (run, again) = (play(), play());
        prop_assert_eq!(run.log(), again.log());
        prop_assert_eq!(run.outcome(), again.outcome());
        let taken = run.measure("targets", None)[0];
        prop_assert!(taken <= 2.0 && taken == run.measure("by_robots", None)[0] + run.measure("by_person", None)[0]);
        if !stop && run.measure("without_plan", None)[0] == 0.0 {
            // With a plan in each period nothing touches and nothing is lost, wherever the person walks.
            prop_assert_eq!(run.measure("collisions", None)[0], 0.0);
            prop_assert_eq!(run.measure("disconnections", None)[0], 0.0);
        }
    }
}

/// The type behind the interface is public, for programs that look closer.
#[test]
fn executions_show_their_records() {
    let execution = ExploreExecution::new(room(), Default::default()).unwrap();
    assert!(execution.records().is_empty() && execution.is_connected() && !execution.nobody_is_left());
}
