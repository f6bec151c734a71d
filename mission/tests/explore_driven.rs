//! Explorations in which a controller drives the base of a robot, without the controller: bases that keep to the plan, lag behind it, and are
//! pushed about.

use hierarq_mission::kind::course::{Driven, GroundPose};
use hierarq_mission::kind::{Event, Execution, Mission, Run, WorkState};
use hierarq_mission::kinds::explore::Explore;
use hierarq_mission::kinds::explore::polygon::Point;
use hierarq_mission::kinds::explore::problem::Problem;

use crate::common::Random;
use crate::explore_execution::room;

const TICK: f64 = 0.05;
const TOLERANCE: f64 = 0.1;

fn execution(problem: &Problem, tolerance: f64) -> Result<Box<dyn Execution>, String> {
    let driven = vec![Driven { member: 0, tolerance }];
    let mission = Explore { problem: problem.clone() };
    let how = Run { driven, ..Run::default() };
    mission.check().unwrap();
    mission.check_run(&how).unwrap();
    mission.execute(&how)
}

/// The position after a tick of a base with this greatest speed (m/s), which follows the plan `lead` (s) ahead.
fn driven(run: &dyn Execution, at: Point, time: f64, lead: f64, most: f64) -> Point {
    let course = run.course(0).expect("somebody drives it");
    assert!(course.state != WorkState::Works || !course.is_reached(at, TOLERANCE, f64::INFINITY));
    let target = course.target(time, lead, 2.0).at;
    let gap = [target[0] - at[0], target[1] - at[1]];
    let step = (most * TICK / f64::hypot(gap[0], gap[1]).max(1e-9)).min(1.0);
    [0, 1].map(|i| at[i] + step * gap[i])
}

/// A base that is where the plan has it at each tick takes what the robot is sent to.
#[test]
fn a_base_on_the_plan_does_what_is_planned() {
    let problem = room();
    let mut run = execution(&problem, TOLERANCE).unwrap();
    let mut base = problem.robots[0].start;
    for tick in 0..200 {
        let time = f64::from(tick) * TICK;
        run.advance(time);
        run.drive(0, time, GroundPose { at: base, heading: 0.0 });
        assert_eq!(run.measure("position", Some(0))[..2], base);
        base = driven(&*run, base, time, TICK, 1e3);
    }
    let whole = |name: &str| run.measure(name, None)[0];
    assert!(run.done().is_some(), "{:#?}", run.log());
    assert_eq!((whole("by_robots"), whole("by_person")), (1.0, 1.0), "{:#?}", run.log());
    assert_eq!((whole("collisions"), whole("disconnections"), whole("without_plan")), (0.0, 0.0, 0.0));
    assert!(run.log().iter().all(|entry| !entry.text.contains("off its plan")), "{:#?}", run.log());
}

/// A base that is pushed aside is where it is and not where it was planned to be; the plans go on from there, and however time is cut the same happens.
#[test]
fn plans_go_on_from_where_a_base_is() {
    let problem = room();
    let mut off = 0;
    for seed in 0..8 {
        let played = |cut: bool| {
            let mut run = execution(&problem, TOLERANCE).unwrap();
            let (mut random, mut base, mut travelled) = (Random(seed + 3), problem.robots[0].start, 0.0);
            for tick in 0..160 {
                let time = f64::from(tick) * TICK;
                let part = random.within(0.0, TICK);
                if cut {
                    run.advance(time - part);
                }
                run.advance(time);
                if run.done().is_some() {
                    break;
                }
                run.drive(0, time, GroundPose { at: base, heading: 0.0 });
                assert!((run.measure("travelled", Some(0))[0] - travelled).abs() < 1e-9);
                match random.below(200) {
                    0 => drop(run.handle(&Event::of("lost", 0))),
                    1..8 => drop(run.handle(&Event::of("back", 0))),
                    _ => {}
                }
                let pushed = if random.below(30) == 0 { 0.3 } else { 0.0 };
                let next = driven(&*run, base, time, 0.1, 2.0);
                let next = [next[0], (next[1] + pushed).min(4.7)];
                travelled += f64::hypot(next[0] - base[0], next[1] - base[1]);
                base = next;
            }
            (format!("{:?} {:?}", run.row(), run.outcome()), run.log())
        };
        let (row, log) = played(false);
        off += log.iter().filter(|entry| entry.text.contains("off its plan")).count();
        let again = played(true);
        assert_eq!((again.0, again.1), (row, log), "seed {seed}");
    }
    assert!(off > 3, "{off}");
}

#[test]
fn tolerances_that_leave_nothing_of_a_target_are_refused() {
    let Err(why) = execution(&room(), 0.31) else { panic!("it runs") };
    assert!(why.contains("smaller than twice the `tolerance`"), "{why}");
}
