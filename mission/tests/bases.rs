//! Motion of robots as mobile bases: they keep their distances, pass each other, arrive, and delays reach the plan.

use crate::common;

use common::execution::{count, keeps, settings};
use hierarq_mission::kinds::schedule::execution::{
    Event, LogEntry, Obstacle, Potentials, ScheduleExecution, Settings, Stage, Travel,
};
use hierarq_mission::kinds::schedule::plan::Actor;
use hierarq_mission::kinds::schedule::problem::{AgentKind, Problem};
use hierarq_mission::kinds::schedule::validate::validate;
use hierarq_mission::numbers::Range;
use proptest::prelude::*;

/// Runs a mission with bases, checked at every step; returns the minimum distance between two bases or to an obstacle,
/// and the final state.
fn watched(problem: &Problem, potentials: &Potentials, until: f64) -> (f64, ScheduleExecution) {
    watched_with(problem, potentials, until, &mut Vec::new())
}

/// Waiting place of a robot at its target.
fn waits(execution: &ScheduleExecution, robot: usize) -> Option<[f64; 2]> {
    let target = execution.robot(robot)?.target?;
    execution.problem().waiting_place(target.agent, robot)
}

/// As [`watched`] with events, the last one first; events that are invalid at their time are ignored.
fn watched_with(
    problem: &Problem,
    potentials: &Potentials,
    until: f64,
    events: &mut Vec<(f64, Event)>,
) -> (f64, ScheduleExecution) {
    let travel = Travel::Bases(potentials.clone());
    let mut execution = ScheduleExecution::new(problem.clone(), Settings { travel, ..settings() }).unwrap();
    let (mut closest, mut time) = (f64::INFINITY, 0.0);
    while (!execution.done() || !events.is_empty()) && time < until {
        time += potentials.step;
        while let Some((at, event)) = events.pop_if(|(at, _)| *at <= time) {
            execution.advance(at);
            let _ = execution.handle_event(event);
        }
        execution.advance(time);
        let robots: Vec<_> = (0..execution.problem().robots.len()).map(|m| execution.robot(m).unwrap()).collect();
        for (m, robot) in robots.iter().enumerate() {
            for other in &robots[..m] {
                let apart = f64::hypot(robot.position[0] - other.position[0], robot.position[1] - other.position[1]);
                closest = closest.min(apart);
            }
            for (agent, who) in execution.problem().agents.iter().enumerate() {
                // A base keeps away from agents that it does not serve, unless other places are too close to them.
                let alone = |other: [f64; 2]| f64::hypot(other[0] - who.place[0], other[1] - who.place[1]) > 0.8;
                let others = execution.problem().agents.iter().enumerate().filter(|(other, _)| *other != agent);
                let depots = execution.problem().robots.iter().map(|robot| robot.depot);
                if robot.target.is_some_and(|target| target.agent != agent)
                    && others.map(|(_, who)| who.place).chain(depots).chain(waits(&execution, m)).all(alone)
                {
                    let [x, y] = robot.position;
                    closest = closest.min(f64::hypot(x - who.place[0], y - who.place[1]));
                }
            }
            for thing in &potentials.obstacles {
                let [x, y] = robot.position;
                closest = closest.min(f64::hypot(x - thing.place[0], y - thing.place[1]) - thing.radius);
            }
        }
    }
    (closest, execution)
}

/// Depots and agents on one line, with an obstacle between them: arriving and returning robots meet head-on.
#[test]
fn bases_that_meet_head_on_pass() {
    for shift in [0.0, 0.01, -0.5] {
        let robots = vec![common::robot("m0", [0.0, 0.0], 1.0), common::robot("m1", [-4.0, shift], 1.0)];
        let agents = vec![
            common::agent("a0", AgentKind::Human, [9.0, 0.0], 3, 60.0),
            common::agent("a1", AgentKind::Human, [15.0, 0.0], 3, 60.0),
        ];
        let problem = Problem::new(robots, agents);
        for obstacles in [vec![], vec![Obstacle { place: [4.5, 0.0], radius: 0.5 }]] {
            let (closest, execution) = watched(&problem, &Potentials { obstacles, ..Potentials::default() }, 6000.0);
            assert!(execution.done(), "{shift}: {:?} {:?}", execution.robot(0), execution.robot(1));
            assert!((0.8 - 1e-9..2.5).contains(&closest), "{shift}: {closest}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    /// Teams in a small area, with depots and agents anywhere: distances are kept, and every agent is served.
    #[test]
    fn bases_never_come_too_near(
        seed in 0_u64..100_000, robots in 2_usize..6, agents in 1_usize..6, rocks in 0_usize..3, crowded in any::<bool>(),
    ) {
        let mut problem = common::random(seed, agents, robots, 2);
        let mut random = common::Random(seed);
        random.unit();
        let size = if crowded { 5.0 } else { 12.0 };
        for (m, robot) in problem.robots.iter_mut().enumerate() {
            // Depots in a row, far enough apart at the start.
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
            let clear = |p: [f64; 2]| f64::hypot(p[0] - rock.place[0], p[1] - rock.place[1]) > 3.5;
            if places.chain(obstacles.iter().map(|other: &Obstacle| other.place)).all(clear) {
                obstacles.push(rock);
            }
        }
        let (closest, execution) = watched(&problem, &Potentials { obstacles, ..Potentials::default() }, 20_000.0);
        prop_assert!(closest >= 0.8 - 1e-9, "{closest}");
        let robots: Vec<_> = (0..robots).map(|m| execution.robot(m)).collect();
        prop_assert!(execution.done(), "{robots:#?}");
    }
}

/// A base that is blocked on its path arrives late, and the delay reaches the plan.
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
        late += count(execution.records(), |what| matches!(what, LogEntry::RobotLate { .. }));
        assert!(validate(execution.problem(), execution.plan()).is_empty());
        keeps(execution.plan(), execution.records()).unwrap();
    }
    assert!(late > 0);
}

/// Robots that share a depot, and agents at one position: robots arrive there one after the other, and all return.
#[test]
fn bases_take_turns_where_they_share_a_place() {
    for robots in 2..5 {
        let mut problem = common::random(robots as u64, 3, robots, 2);
        problem.robots.iter_mut().for_each(|robot| robot.depot = [0.0, 0.0]);
        for agent in &mut problem.agents {
            (agent.place, agent.duration.mean, agent.wait_distance) = ([6.0, 1.0], 40.0, 0.5);
        }
        let (_, execution) = watched(&problem, &Potentials::default(), 20_000.0);
        let views: Vec<_> = (0..robots).map(|robot| execution.robot(robot)).collect();
        assert!(execution.done(), "{views:#?}");
        assert!(execution.statistics().agents.iter().all(|agent| agent.served == 2));
    }
}

/// A team in a small area with random parameters; agents are at least two metres apart and away from depots.
fn day(seed: u64, robots: usize, agents: usize, size: f64) -> (Problem, common::Random) {
    let mut problem = common::random(seed, agents, robots, 2);
    let mut random = common::Random(seed);
    random.unit();
    for (m, robot) in problem.robots.iter_mut().enumerate() {
        robot.depot = [2.0 * m as f64, -size];
    }
    let mut places: Vec<[f64; 2]> = problem.robots.iter().map(|robot| robot.depot).collect();
    for agent in &mut problem.agents {
        let clear = |p: [f64; 2]| places.iter().all(|q| f64::hypot(p[0] - q[0], p[1] - q[1]) > 2.0);
        let mut place = || [random.within(-size, size), random.within(-size, size) + 2.0];
        let place = std::iter::from_fn(|| Some(place())).find(|place| clear(*place)).unwrap();
        places.push(place);
        (agent.place, agent.duration.mean, agent.duration.sigma) = (place, random.within(30.0, 120.0), 0.0);
    }
    (problem, random)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    /// Robots break down anywhere and come back at any time: the others keep the usual distances to them, and blocked
    /// robots report it. After all are back, every agent is served.
    #[test]
    fn who_breaks_down_is_kept_away_from(
        seed in 0_u64..100_000, robots in 2_usize..6, agents in 1_usize..6, losses in 1_usize..4, crowded in any::<bool>(),
    ) {
        let (problem, mut random) = day(seed, robots, agents, if crowded { 5.0 } else { 12.0 });
        let mut events = Vec::new();
        for _ in 0..losses {
            let who = Actor::Robot(random.below(robots));
            let at = random.within(0.0, 500.0);
            events.push((at, Event::Lost { who }));
            events.push((at + random.within(1.0, 600.0), Event::Back { who }));
        }
        for m in 0..robots {
            events.push((4000.0, Event::Back { who: Actor::Robot(m) }));
        }
        events.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (closest, execution) = watched_with(&problem, &Potentials::default(), 20_000.0, &mut events);
        prop_assert!(closest >= 0.8 - 1e-9, "{closest}");
        let robots: Vec<_> = (0..robots).map(|m| execution.robot(m)).collect();
        prop_assert!(execution.done(), "{robots:#?}");
    }
}

/// A robot that breaks down while serving blocks the access to that agent: the other robot stops, reports the blocking
/// robot once, and serves after the path is free.
#[test]
fn who_is_held_up_stands_and_says_so() {
    let robots = vec![common::robot("m0", [0.0, 0.0], 1.0), common::robot("m1", [0.0, -3.0], 1.0)];
    let problem = Problem::new(robots, vec![common::agent("a0", AgentKind::Human, [6.0, 0.0], 2, 60.0)]);
    let travel = Travel::Bases(Potentials::default());
    let mut execution = ScheduleExecution::new(problem, Settings { travel, ..settings() }).unwrap();
    let serves = |execution: &ScheduleExecution| (0..2).find(|m| execution.robot(*m).unwrap().stage == Stage::Serving);
    while serves(&execution).is_none() {
        execution.advance(execution.time() + 0.05);
    }
    let lost = serves(&execution).unwrap();
    execution.handle_event(Event::Lost { who: Actor::Robot(lost) }).unwrap();
    let apart = |execution: &ScheduleExecution| {
        let [a, b] = [0, 1].map(|m| execution.robot(m).unwrap().position);
        f64::hypot(a[0] - b[0], a[1] - b[1])
    };
    let mut closest = f64::INFINITY;
    while execution.time() < 1500.0 {
        execution.advance(execution.time() + 0.05);
        closest = closest.min(apart(&execution));
    }
    assert!((0.8 - 1e-9..1.0).contains(&closest), "{closest}");
    let held = LogEntry::HeldUp { robot: 1 - lost, agent: Some(0), by: lost };
    assert_eq!(count(execution.records(), |what| *what == held), 1);
    assert_eq!(count(execution.records(), |what| matches!(what, LogEntry::Served { .. })), 0);
    assert!(execution.records().len() < 100, "{}", execution.records().len());
    execution.handle_event(Event::Back { who: Actor::Robot(lost) }).unwrap();
    while !execution.done() && execution.time() < 5000.0 {
        execution.advance(execution.time() + 0.05);
        closest = closest.min(apart(&execution));
    }
    assert!(execution.done() && closest >= 0.8 - 1e-9, "{closest}");
    assert_eq!(execution.statistics().agents[0].served, 2);
}
