//! The planner of searches: against exhaustive search, baselines, the validator, and dense samples of motions.

use std::time::Duration;

use hierarq_mission::engine::Budget;
use hierarq_mission::kinds::search::check::check;
use hierarq_mission::kinds::search::choose::{Formulation, Options, plan};
use hierarq_mission::kinds::search::geometry::{along, between, distance, length, segments};
use hierarq_mission::kinds::search::ground::{Body, Ground};
use hierarq_mission::kinds::search::plan::{Phase, Plan};
use hierarq_mission::kinds::search::problem::{Fall, Problem, Rate, Travel};
use hierarq_mission::kinds::search::reward::evaluate;
use hierarq_mission::kinds::search::team::{Act, State, Team};
use hierarq_mission::kinds::search::validate::validate;
use hierarq_mission::kinds::search::ways::{ActionSets, Way, rate};

use crate::searched::{agent, floor, hazard, light_and_panel, problem, random, source, square, wall};

fn options(problem: &Problem, formulation: Formulation) -> Options {
    Options { formulation, ..Options::of(problem) }
}

/// Random worlds that have no mistake.
fn worlds(agents: usize, sources: usize, count: usize) -> Vec<(u64, Problem)> {
    (0..).map(|seed| (seed, random(seed, agents, sources))).filter(|(_, p)| check(p).is_empty()).take(count).collect()
}

/// The best reward over every sequence of choices, by plain recursion.
fn best(team: &Team<'_>, state: &State, states: &mut u64) -> f64 {
    *states += 1;
    assert!(*states < 3_000_000, "the world is not tiny");
    if state.terminal {
        return state.reward;
    }
    let free: Vec<usize> = team.free(state).collect();
    let acts: Vec<Vec<Act>> = free
        .iter()
        .map(|agent| {
            let menu = team.menu(state, *agent).into_iter();
            menu.filter(|act| team.end_of(state, *agent, *act).is_some()).collect()
        })
        .collect();
    let count: usize = acts.iter().map(Vec::len).product();
    let mut most = f64::NEG_INFINITY;
    for number in 0..count {
        let mut rest = number;
        let mut chosen = Vec::new();
        for (agent, acts) in free.iter().zip(&acts) {
            chosen.push((*agent, acts[rest % acts.len()]));
            rest /= acts.len();
        }
        most = most.max(best(team, &team.next(state, &chosen), states));
    }
    most
}

/// In tiny worlds the tree search tries every sequence, and finds what plain recursion finds.
#[test]
fn tiny_worlds_are_searched_exhaustively() {
    let mut tried = 0;
    for (seed, mut p) in worlds(2, 2, 25) {
        p.horizon = p.horizon.min(8.0);
        p.planner =
            hierarq_mission::kinds::search::problem::Planner { goals: 64, states: 400_000, stay: 4.0, ..p.planner };
        let sets = ActionSets::new(&p, 2);
        let team = Team::new(&p, &sets);
        let mut states = 0;
        let most = best(&team, &team.root(), &mut states);
        let found = plan(&p, &options(&p, Formulation::TreeSearch)).expect("a plan");
        assert!(found.exhausted, "seed {seed}: {states} states are not exhausted");
        // The plans of agents on their own are compared too: their stays are not cut to shared pools.
        let alone = -plan(&p, &options(&p, Formulation::Independent)).expect("a plan").plan.cost;
        let (got, expected) = (-found.plan.cost, most.max(alone));
        assert!((got - expected).abs() < 1e-6 * expected.abs().max(1.0), "seed {seed}: {got} and {expected}");
        tried += usize::from(states > 20);
    }
    assert!(tried > 12, "only {tried} worlds had something to choose");
}

/// The validator, which shares only data types, accepts every plan; the tree search is never worse than the baselines.
#[test]
fn plans_of_random_worlds_are_valid_and_no_worse_than_baselines() {
    let (mut sums, mut strictly) = ([0.0; 3], 0);
    for (seed, p) in worlds(3, 6, 40) {
        let rewards = Formulation::ALL.map(|formulation| {
            let found = plan(&p, &options(&p, formulation)).expect("a plan").plan;
            let violations = validate(&p, &found);
            assert!(violations.is_empty(), "seed {seed}, {}: {violations:?}", formulation.name());
            -found.cost
        });
        let [tree, greedy, independent] = rewards;
        assert!(tree >= greedy - 1e-9, "seed {seed}: {tree} below the greedy {greedy}");
        strictly += usize::from(tree > greedy + 1e-6 && tree > independent + 1e-6);
        sums.iter_mut().zip(rewards).for_each(|(sum, reward)| *sum += reward);
    }
    let [tree, greedy, independent] = sums;
    assert!(tree > greedy && tree > independent, "{sums:?}");
    assert!(strictly >= 20, "better than both in {strictly} of 40");
}

#[test]
fn a_plan_does_not_depend_on_threads() {
    for (seed, p) in worlds(3, 6, 4) {
        let of = |threads| {
            plan(&p, &Options { threads: Some(threads), ..options(&p, Formulation::TreeSearch) }).expect("a plan").plan
        };
        let one = of(1);
        for threads in [2, 3, 8] {
            assert_eq!(one, of(threads), "seed {seed}, {threads} threads");
        }
        let mut other = p.clone();
        other.planner.states = 8_000;
        let more = plan(&other, &options(&other, Formulation::TreeSearch)).expect("a plan").plan;
        assert!(more.cost <= one.cost + 1e-9, "seed {seed}: more states cost more");
    }
}

/// With a time limit there is a plan at any time.
#[test]
fn a_plan_is_there_at_once() {
    let mut p = floor(2, 8);
    // Not everything can be collected, so that no plan is proven.
    p.horizon = 40.0;
    let budget = Budget { time: Duration::ZERO, nodes: u64::MAX, gap: 1e-4 };
    let found = plan(&p, &Options { budget, ..options(&p, Formulation::TreeSearch) }).expect("a plan").plan;
    assert!(validate(&p, &found).is_empty() && found.cost < 0.0, "{found:?}");
    assert!(found.status.stopped().is_some());
}

/// Fig. 9: who expects the light to be opened goes straight to the panel; else the robot opens it first.
#[test]
fn the_light_is_opened_by_whom_it_is_expected_of() {
    let visits = |informed: bool| -> Vec<Option<usize>> {
        let p = light_and_panel(informed);
        let found = plan(&p, &options(&p, Formulation::TreeSearch)).expect("a plan").plan;
        let violations = validate(&p, &found);
        assert!(violations.is_empty(), "{violations:?} {:#?}", found.activities);
        assert!((found.cost + 15.0).abs() < 1e-6, "light and panel are consumed: {}", found.cost);
        let own = found.activities.iter().filter(|activity| activity.agent == 0 && activity.phase == Phase::Staying);
        own.map(|activity| activity.source).collect()
    };
    assert_eq!(visits(true), [Some(1)]);
    assert_eq!(visits(false), [Some(0), Some(1)]);
}

/// Fig. 12 d: hazards that affect one agent alone keep it away, and another one takes its goal.
#[test]
fn a_hazard_keeps_away_only_whom_it_affects() {
    let team = vec![agent("a", false, [1.0, 2.0], 1.0), agent("b", true, [1.0, 6.0], 1.0)];
    let goals = vec![source("low", [6.0, 2.0], 0.5, 4.0, 4.0, 2), source("high", [6.0, 6.0], 0.5, 4.0, 4.0, 2)];
    let mut p = problem(square(8.0), team, goals, 20.0);
    // Rewards by agent.
    let collected = |p: &Problem| {
        let found = plan(p, &options(p, Formulation::TreeSearch)).expect("a plan").plan;
        assert!(validate(p, &found).is_empty());
        evaluate(p, &found.activities).agents
    };
    assert_eq!(collected(&p), [4.0, 4.0]);
    p.sources.push(hazard("fire", [6.0, 2.0], 1.0, 10.0, vec![0]));
    let [first, second] = collected(&p)[..] else { panic!("two agents") };
    assert!(second > 7.999 && first > -0.01, "{first} and {second}");
}

/// A drone passes a wall that a person has to walk around, Fig. 10.
#[test]
fn walls_are_passed_by_those_who_can() {
    let mut drone = agent("drone", false, [1.0, 1.0], 1.0);
    drone.passes.push(0);
    let team = vec![drone, agent("anna", true, [1.0, 1.0], 1.0)];
    let mut p = problem(square(8.0), team, vec![source("goal", [1.0, 6.0], 0.4, 5.0, 5.0, 2)], 40.0);
    p.walls.push(wall("fence", &[[0.0, 3.5], [6.0, 3.5]]));
    let sets = ActionSets::new(&p, 2);
    let times = [0, 1].map(|agent| sets.of[agent].way(0, 1).expect("a way").duration);
    assert!((times[0] - 5.0).abs() < 1e-9, "{times:?}");
    // Around the end of the wall, which is kept at 0.2 m.
    let around = 2.0 * distance([1.0, 1.0], [6.0, 3.5]);
    assert!(times[1] > around && times[1] < 1.1 * around, "{times:?}, around {around}");
}

/// The ground agrees with dense samples; ways keep clear of all walls that are not passed.
#[test]
fn ways_keep_their_distance_from_walls() {
    let mut ways = 0;
    for (seed, p) in worlds(2, 4, 30) {
        let sets = ActionSets::new(&p, 2);
        for (index, set) in sets.of.iter().enumerate() {
            let (who, count) = (&p.agents[index], set.spots.len());
            let blocked = p.walls.iter().enumerate().filter(|(wall, _)| !who.passes.contains(wall));
            let blocked: Vec<_> = blocked.flat_map(|(_, wall)| wall.points.windows(2)).collect();
            for way in (0..count * count).filter_map(|i| set.way(i / count, i % count)) {
                ways += 1;
                let metres = length(&way.points);
                assert!((metres / who.speed - way.duration).abs() < 1e-9);
                for i in 0..=200 {
                    let at = along(&way.points, i as f64 / 200.0, 0.0).at;
                    let gap = blocked.iter().map(|w| segments(at, at, w[0], w[1])).fold(f64::INFINITY, f64::min);
                    assert!(gap >= who.radius - 1e-9, "seed {seed}: {gap}");
                }
            }
        }
        let body = Body::of(&p.agents[0]);
        let ground = Ground::new(&p, &body);
        let mut generator = crate::common::Random(seed + 5);
        for _ in 0..200 {
            let mut point = || [generator.within(0.0, 12.0), generator.within(0.0, 12.0)];
            let (a, b) = (point(), point());
            if ground.fits(a) && ground.fits(b) && ground.clear(a, b) {
                assert!((0..=50).all(|i| ground.fits(between(a, b, i as f64 / 50.0))), "seed {seed}: {a:?} {b:?}");
            }
        }
    }
    assert!(ways > 200, "{ways}");
}

/// The reward along a way is the integral of the rate, srs (2), and adds up over parts of it.
#[test]
fn rewards_of_a_way_are_integrals() {
    let mut p = problem(
        square(8.0),
        vec![agent("a", false, [1.0, 1.0], 0.7)],
        vec![source("s", [4.0, 4.0], 0.9, 2.0, 9.0, 1)],
        60.0,
    );
    p.sources[0].inside = Rate { peak: 3.0, fall: Fall::Rising, scale: 0.4, ..Rate::ZERO };
    p.sources[0].outside = Rate { peak: 1.5, fall: Fall::Gaussian, scale: 0.8, ..Rate::ZERO };
    let way = Way::new(&p, 0, vec![[1.0, 1.0], [4.0, 3.5], [7.0, 7.0]]);
    let (fine, moving) = (100_000, Travel { speed: 0.7, heading: 0.0 });
    let exact: f64 = (0..fine)
        .map(|i| rate(&p, 0, 0, along(&way.points, (f64::from(i) + 0.5) / f64::from(fine), 0.0).at, moving))
        .sum::<f64>()
        * way.duration
        / f64::from(fine);
    let total = |from: f64, to: f64| {
        let mut sums = vec![0.0];
        way.add(from, to, &mut sums);
        sums[0]
    };
    assert!((total(0.0, 1.0) - exact).abs() < 0.02 * exact, "{} and {exact}", total(0.0, 1.0));
    assert!((total(0.0, 0.37) + total(0.37, 0.81) + total(0.81, 1.0) - total(0.0, 1.0)).abs() < 1e-12);
}

/// Every corruption of a plan is found.
#[test]
fn the_validator_rejects_corrupted_plans() {
    let p = light_and_panel(true);
    let good = plan(&p, &options(&p, Formulation::TreeSearch)).expect("a plan").plan;
    assert!(validate(&p, &good).is_empty());
    let going = good.activities.iter().position(|a| a.phase == Phase::Going).expect("a way");
    let waiting = good.activities.iter().position(|a| a.phase == Phase::Waiting).expect("a wait");
    let staying = good.activities.iter().position(|a| a.phase == Phase::Staying).expect("a stay");
    type Corrupt<'c> = (&'static str, &'c dyn Fn(&mut Plan));
    let corruptions: [Corrupt<'_>; 9] = [
        ("faster", &|plan| plan.activities[going].end -= 0.5),
        ("through the edge", &|plan| plan.activities[going].way.insert(1, [-1.0, 4.0])),
        ("a jump", &|plan| plan.activities[staying].way[0][0] += 0.1),
        ("begun later", &|plan| plan.activities[staying].begun = true),
        ("a gap", &|plan| plan.activities[staying].start += 0.2),
        ("another cost", &|plan| plan.cost -= 1.0),
        ("nobody", &|plan| plan.activities[going].agent = 9),
        ("waits for nobody", &|plan| plan.activities[waiting].end += 0.3),
        ("behind the horizon", &|plan| {
            plan.activities.iter_mut().for_each(|a| (a.start, a.end) = (a.start + 30.0, a.end + 30.0))
        }),
    ];
    for (what, corrupt) in corruptions {
        let mut bad = good.clone();
        corrupt(&mut bad);
        assert!(!validate(&p, &bad).is_empty(), "{what}");
    }
    // A wall across a way.
    let mut walled = p.clone();
    walled.walls.push(wall("new", &[[0.0, 3.0], [8.0, 3.0]]));
    assert!(!validate(&walled, &good).is_empty());
    // An agent that may not consume a source does not get its reward.
    let mut deaf = p.clone();
    deaf.sources[1].targets.clear();
    assert!(!validate(&deaf, &good).is_empty());
}

/// A shared pool gives its content once, and a codependent one loses its share.
#[test]
fn pools_are_consumed_once() {
    let team = vec![agent("a", false, [1.0, 1.0], 1.0), agent("b", true, [7.0, 7.0], 1.0)];
    let tills = vec![source("one", [1.0, 4.0], 0.5, 5.0, 6.0, 2), source("two", [7.0, 4.0], 0.5, 5.0, 6.0, 2)];
    let mut p = problem(square(8.0), team, tills, 20.0);
    let reward = |p: &Problem| -plan(p, &options(p, Formulation::TreeSearch)).expect("a plan").plan.cost;
    assert!((reward(&p) - 12.0).abs() < 1e-9);
    p.codependent.push(hierarq_mission::kinds::search::problem::Codependence { of: [0, 1], share: 1.0 });
    assert!((reward(&p) - 6.0).abs() < 1e-9, "{}", reward(&p));
    let found = plan(&p, &options(&p, Formulation::Independent)).expect("a plan").plan;
    assert_eq!(evaluate(&p, &found.activities).pools, [0.0, 0.0]);
    p.codependent[0].share = 0.5;
    assert!((reward(&p) - 9.0).abs() < 1e-9, "{}", reward(&p));
}
