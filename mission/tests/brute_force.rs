//! Tiny problems against enumeration of all assignments and orders, and re-timing against a fine grid of speeds.
//!
//! The enumeration shares the data types and the cost of a schedule with the planners, but no algorithm: it tries every
//! sequence with every speed of a grid, and computes times by a pass through the sequence.

use crate::common;

use hierarq_mission::kinds::schedule::assistance::{Assistance, from_plan};
use hierarq_mission::kinds::schedule::choose::{Formulation, Options, plan};
use hierarq_mission::kinds::schedule::cost::cost;
use hierarq_mission::kinds::schedule::duration_quantile;
use hierarq_mission::kinds::schedule::problem::{AgentKind, Problem, ServiceTimes};
use hierarq_mission::kinds::schedule::validate::validate;
use hierarq_mission::numbers::Range;
use hierarq_mission::plan::Status;

/// Speeds of the three legs of a service, each from 0 (slowest) to 1 (fastest).
type Speeds = [f64; 3];

/// Returns the times of services `(agent, operation, robot)` in this order, each as early as possible; `None` if the
/// order contradicts an agent's order. Operations begin as early as possible.
fn timed(problem: &Problem, services: &[(usize, usize, usize)], speeds: &[Speeds]) -> Option<Vec<Assistance>> {
    let mut home = vec![problem.start; problem.robots.len()];
    let mut served: Vec<Vec<f64>> = vec![Vec::new(); problem.agents.len()];
    let mut schedule = Vec::new();
    for ((agent, operation, robot), speeds) in services.iter().copied().zip(speeds) {
        if served[agent].len() != operation {
            return None;
        }
        let machine = &problem.robots[robot];
        let lengths = problem.lengths(agent, robot);
        let (near, _) = problem.approach(&problem.agents[agent], robot);
        let time = |length: f64, range: Range, share: f64| {
            let (fast, slow) = (length / range.high, length / range.low);
            slow + share * (fast - slow)
        };
        let going = time(lengths.going, machine.speed, speeds[0]);
        let near = time(lengths.proximity, near, speeds[1]);
        let back = time(lengths.depositing, machine.speed, speeds[2]);
        let start = served[agent].last().copied().unwrap_or(problem.start);
        let end = start + duration_quantile::nominal(problem, agent);
        let serving = end.max(home[robot] + going + near);
        let times = ServiceTimes {
            going: home[robot],
            waiting: home[robot] + going,
            proximity: serving - near,
            serving,
            depositing: serving + machine.serve,
            end: serving + machine.serve + back + machine.deposit,
        };
        home[robot] = times.end;
        served[agent].push(times.depositing);
        schedule.push(Assistance { agent, operation, start, end, robot, times });
    }
    Some(schedule)
}

/// Enumerates every order of all services with every assignment.
fn sequences(problem: &Problem) -> Vec<Vec<(usize, usize, usize)>> {
    let all: Vec<(usize, usize)> =
        problem.agents.iter().enumerate().flat_map(|(a, who)| (0..who.operations).map(move |i| (a, i))).collect();
    let mut found = vec![Vec::new()];
    for _ in 0..all.len() {
        let mut longer = Vec::new();
        for sequence in &found {
            for &(a, i) in &all {
                let there = |j: usize| sequence.iter().any(|&(b, k, _): &(usize, usize, usize)| (b, k) == (a, j));
                if !there(i) && (i == 0 || there(i - 1)) {
                    for m in 0..problem.robots.len() {
                        let mut next = sequence.clone();
                        next.push((a, i, m));
                        longer.push(next);
                    }
                }
            }
        }
        found = longer;
    }
    found
}

/// Minimum cost over all sequences at fixed speeds.
fn least_fixed(problem: &Problem) -> f64 {
    let price = |sequence: &Vec<(usize, usize, usize)>| {
        timed(problem, sequence, &vec![[1.0; 3]; sequence.len()]).map(|schedule| cost(problem, &schedule).total())
    };
    sequences(problem).iter().filter_map(price).fold(f64::INFINITY, f64::min)
}

/// Minimum cost of a sequence over a grid of durations that is refined around the best point. The cost is convex, and
/// has kinks where sums of durations equal a time: steps of equal seconds in up to three durations follow these kinks.
fn least_on_grid(problem: &Problem, sequence: &[(usize, usize, usize)]) -> f64 {
    let count = 3 * sequence.len();
    // Difference (s) between the slowest and the fastest duration of each leg.
    let spans: Vec<f64> = sequence
        .iter()
        .flat_map(|(agent, _, robot)| {
            let (lengths, cruise) = (problem.lengths(*agent, *robot), problem.robots[*robot].speed);
            let (near, _) = problem.approach(&problem.agents[*agent], *robot);
            let span = |length: f64, range: Range| length / range.low - length / range.high;
            [span(lengths.going, cruise), span(lengths.proximity, near), span(lengths.depositing, cruise)]
        })
        .collect();
    let price = |at: &[f64]| {
        let speeds: Vec<Speeds> = at.chunks(3).map(|three| [three[0], three[1], three[2]]).collect();
        timed(problem, sequence, &speeds).map_or(f64::INFINITY, |schedule| cost(problem, &schedule).total())
    };
    let mut at = vec![0.5; count];
    let mut best = price(&at);
    let mut step = 64.0;
    while step > 1e-2 {
        let mut moved = false;
        let mut attempt = |moves: &[(usize, f64)]| {
            let mut next = at.clone();
            for (i, sign) in moves {
                next[*i] = (next[*i] + sign * step / spans[*i]).clamp(0.0, 1.0);
            }
            let cost = price(&next);
            if cost < best - 1e-13 {
                (best, at, moved) = (cost, next, true);
            }
        };
        let signs = [1.0, -1.0];
        for i in 0..count {
            for a in signs {
                attempt(&[(i, a)]);
                for j in i + 1..count {
                    for b in signs {
                        attempt(&[(i, a), (j, b)]);
                        for k in j + 1..count {
                            signs.iter().for_each(|c| attempt(&[(i, a), (j, b), (k, *c)]));
                        }
                    }
                }
            }
        }
        if !moved {
            step *= 0.5;
        }
    }
    best
}

fn proven(problem: &Problem, formulation: Formulation) -> f64 {
    let options = Options { formulation: Some(formulation), ..Options::default() };
    let plan = plan(problem, &options).unwrap();
    assert_eq!(validate(problem, &plan), Vec::new(), "{formulation:?}");
    let Status::Proven { bound } = plan.status else { panic!("{formulation:?}: {:?}", plan.status) };
    assert!(bound <= plan.cost && plan.cost - bound <= 1.01e-4 * plan.cost, "{bound} {}", plan.cost);
    let schedule = from_plan(&plan).unwrap();
    assert!((cost(problem, &schedule).total() - plan.cost).abs() < 1e-12 * plan.cost);
    plan.cost
}

#[test]
fn every_engine_finds_the_least_cost_of_all_sequences() {
    for (seed, agents, robots) in
        [(0, 1, 1), (1, 2, 1), (2, 2, 2), (3, 3, 2), (4, 3, 2), (5, 2, 3), (6, 4, 2), (7, 4, 1)]
    {
        let problem = common::fixed(seed, agents, robots, 1);
        let least = least_fixed(&problem);
        for formulation in [Formulation::Subsets, Formulation::Constraint, Formulation::Position, Formulation::Orders] {
            let cost = proven(&problem, formulation);
            assert!((cost - least).abs() < 1e-4 * least, "{seed} {formulation:?}: {cost}, not {least}");
        }
    }
}

#[test]
fn engines_agree_where_agents_have_several_operations() {
    for (seed, agents, robots, operations) in [(0, 1, 2, 3), (1, 2, 1, 2), (2, 2, 2, 2), (3, 3, 2, 1), (4, 1, 1, 4)] {
        let mut problem = common::fixed(seed, agents, robots, operations);
        // With decreasing weights the optimal times are the earliest ones, as in the enumeration.
        for agent in &mut problem.agents {
            agent.wait_weights = (0..operations).map(|i| 2.0 / (1.0 + i as f64)).collect();
        }
        let least = least_fixed(&problem);
        for formulation in [Formulation::Constraint, Formulation::Position, Formulation::Orders] {
            let cost = proven(&problem, formulation);
            assert!((cost - least).abs() < 1e-4 * least, "{seed} {formulation:?}: {cost}, not {least}");
        }
    }
}

#[test]
fn speeds_are_the_best_of_a_fine_grid() {
    for (seed, agents, robots, operations) in [
        (0, 1, 1, 1),
        (1, 2, 1, 1),
        (2, 2, 2, 1),
        (3, 3, 2, 1),
        (8, 3, 1, 1),
        (9, 1, 2, 2),
        (10, 1, 1, 3),
        (11, 2, 1, 2),
        (12, 1, 2, 3),
    ] {
        let mut problem = common::random(seed, agents, robots, operations);
        // Several weights near the agents: each has its own duration in the program.
        for (a, agent) in problem.agents.iter_mut().enumerate() {
            agent.approach_weights = vec![0.5 + a as f64; operations];
            agent.wait_weights = (0..operations).map(|i| 2.0 / (1.0 + i as f64)).collect();
            // With short operations robots wait for each other.
            agent.duration.mean *= if operations > 1 { 0.3 } else { 1.0 };
        }
        let least = sequences(&problem).iter().map(|s| least_on_grid(&problem, s)).fold(f64::INFINITY, f64::min);
        let single = (operations == 1).then_some(Formulation::Subsets);
        for formulation in [Formulation::Position, Formulation::Orders].into_iter().chain(single) {
            let cost = proven(&problem, formulation);
            assert!((cost - least).abs() < 1e-4 * least, "{seed} {formulation:?}: {cost}, not {least}");
        }
    }
}

#[test]
fn an_operation_may_begin_late_where_the_wait_after_it_weighs_more() {
    // One robot, one person whose second wait has three times the weight of the first: the second operation begins
    // late.
    let mut problem = common::random(3, 1, 1, 2);
    problem.agents[0].kind = AgentKind::Human;
    problem.agents[0].duration.mean = 60.0;
    problem.agents[0].duration.sigma = 0.0;
    problem.agents[0].wait_weights = vec![1.0, 3.0];
    let plan = plan(&problem, &Options::default()).unwrap();
    assert_eq!(validate(&problem, &plan), Vec::new());
    let schedule = from_plan(&plan).unwrap();
    assert!(schedule[1].start > schedule[0].times.depositing + 1.0, "{schedule:?}");
    assert!((schedule[1].end - schedule[1].times.serving).abs() < 1e-6, "{schedule:?}");
}
