//! Searches in which a controller drives the base of a robot, without the controller: bases that keep to the plan, lag behind it,
//! and are pushed about.

use hierarq_mission::kind::course::{Driven, GroundPose};
use hierarq_mission::kind::{Event, Execution, Mission, Run, WorkState};
use hierarq_mission::kinds::search::Search;
use hierarq_mission::kinds::search::check::check;
use hierarq_mission::kinds::search::ground::{Body, Ground};
use hierarq_mission::kinds::search::problem::Problem;

use crate::common::Random;
use crate::searched::random;

const TICK: f64 = 0.05;
const TOLERANCE: f64 = 0.1;

fn worlds(count: usize) -> Vec<(u64, Problem)> {
    let all = (0..).map(|seed| {
        let mut p = random(seed, 3, 5);
        p.agents[0].human = false;
        p.planner.states = 300;
        (seed, p)
    });
    all.filter(|(_, p)| check(p).is_empty()).take(count).collect()
}

fn execution(p: &Problem) -> Box<dyn Execution> {
    let driven = vec![Driven { member: 0, tolerance: TOLERANCE }];
    Search { problem: p.clone() }.execute(&Run { driven, ..Run::default() }).expect("an execution")
}

/// A base that moves towards its target with at most this speed (m/s); `pushed` is added to its position at each tick.
fn tick(run: &mut dyn Execution, base: &mut [f64; 2], time: f64, most: f64, pushed: [f64; 2]) -> bool {
    let Some(course) = run.course(0) else { panic!("nobody drives it") };
    let arrived = course.state == WorkState::Works && course.is_reached(*base, TOLERANCE, 0.6);
    let target = course.target(time, 0.0, 0.5).at;
    let gap = [target[0] - base[0], target[1] - base[1]];
    let step = (most * TICK / f64::hypot(gap[0], gap[1]).max(1e-9)).min(1.0);
    *base = [0, 1].map(|i| base[i] + step * gap[i] + pushed[i]);
    if arrived {
        run.handle(&Event::of("done", 0)).expect("it has arrived");
    }
    arrived
}

#[test]
fn a_base_on_the_plan_collects_what_is_promised() {
    let mut ways = 0;
    for (seed, p) in worlds(20) {
        let played = |cut: bool| {
            let mut run = execution(&p);
            let (mut base, mut random, mut ways) = (p.agents[0].start, Random(seed + 5), 0);
            for i in 0..=(p.horizon / TICK) as usize {
                let time = i as f64 * TICK;
                if cut {
                    run.advance(time - random.within(0.0, TICK));
                }
                run.advance(time);
                run.drive(0, time, GroundPose { at: base, heading: 0.0 });
                ways += usize::from(tick(&mut *run, &mut base, time, 1e3, [0.0; 2]));
            }
            let row = format!("{:?} {:?}", run.row(), run.log());
            (run.measure("promised", None)[0], run.measure("reward", None)[0], row, ways)
        };
        let (promised, got, row, arrived) = played(false);
        ways += arrived;
        // A sample is a tenth of a second, and a way ends within the tolerance.
        let most: f64 = p.sources.iter().map(|source| source.inside.peak.abs()).sum();
        assert!(got > promised - 0.3 * most - 0.02 * promised.abs(), "seed {seed}: {got} of {promised}");
        assert_eq!(played(true).2, row, "seed {seed}: other steps of the clock");
    }
    assert!(ways > 20, "{ways} ways");
}

/// A base that is slow, and pushed about: it is late, pools stay sound, everybody plans from free places, and it has travelled
/// what it has moved.
#[test]
fn bases_that_lag_and_are_pushed_leave_everything_sound() {
    let (mut late, mut arrived) = (0, 0);
    for (seed, p) in worlds(12) {
        let mut run = execution(&p);
        let mut random = Random(seed + 17);
        let (mut base, mut travelled) = (p.agents[0].start, 0.0);
        let most = p.agents[0].speed * random.within(0.3, 0.9);
        let body = Body { radius: p.agents[0].radius - 1e-6, ..Body::of(&p.agents[0]) };
        let ground = Ground::new(&p, &body);
        for i in 0..(1.5 * p.horizon / TICK) as usize {
            let time = i as f64 * TICK;
            run.advance(time);
            run.drive(0, time, GroundPose { at: base, heading: 0.0 });
            match random.below(400) {
                0 => drop(run.handle(&Event::of("lost", 0))),
                1..8 => drop(run.handle(&Event::of("back", 0))),
                8 => drop(run.handle(&Event::of_all("replan"))),
                _ => {}
            }
            let before = base;
            let pushed = [random.within(-0.02, 0.02), random.within(-0.02, 0.02)];
            arrived += usize::from(tick(&mut *run, &mut base, time, most, pushed));
            let [x, y, _] = run.measure("believed", Some(0));
            assert!(ground.fits([x, y]), "seed {seed}: it is believed to be at {x}, {y}");
            assert_eq!(run.measure("position", Some(0))[..2], before);
            assert!((run.measure("travelled", Some(0))[0] - travelled).abs() < 1e-9);
            travelled += f64::hypot(base[0] - before[0], base[1] - before[1]);
            for (index, source) in p.sources.iter().enumerate() {
                let [pool, given] = ["pool", "reward"].map(|name| run.measure(name, Some(3 + index))[0]);
                if let Some(content) = source.pool {
                    assert!((0.0..=content).contains(&pool) && given <= content - pool + 1e-6, "{}", source.name);
                }
            }
        }
        late += run.log().iter().filter(|entry| entry.text.contains("is late by")).count();
    }
    assert!(late > 10 && arrived > 5, "{late} late, {arrived} arrived");
}
