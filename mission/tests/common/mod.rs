//! Problems for tests, benches and measurements: the vineyard of thesis 5.7.2, and random ones from a seed.
#![allow(dead_code, reason = "each binary uses a part")]

pub mod execution;

use hierarq_mission::kinds::schedule::problem::{AgentKind, Distances, Duration, Problem, Robot, WorkingAgent};
use hierarq_mission::numbers::{Energy, Range};

/// A small random number generator, so that the problems are the same on all platforms.
pub struct Random(pub u64);

impl Random {
    /// Returns a number between 0 and 1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        ((self.0 >> 33) as f64) / ((1_u64 << 31) as f64)
    }

    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Returns an integer less than `count`.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count - 1)
    }
}

pub fn robot(name: &str, depot: [f64; 2], factor: f64) -> Robot {
    Robot {
        name: name.into(),
        depot,
        speed: Range::new(0.05, 0.2),
        proximity: Some(Range::new(0.04, 0.15)),
        serve: 10.0,
        deposit: 20.0,
        factor,
        energy: Energy::of_factor(factor),
    }
}

pub fn agent(name: &str, kind: AgentKind, place: [f64; 2], operations: usize, mean: f64) -> WorkingAgent {
    // No limit of waits, as in the thesis.
    WorkingAgent {
        severity: 0.5,
        wait_limit: 1e6,
        ..WorkingAgent::new(name, kind, place, operations, Duration { mean, sigma: 0.1 * mean })
    }
}

/// Two service robots, three people and a working robot, with this number of operations each: thesis 5.7.2.
pub fn vineyard(operations: usize) -> Problem {
    let human = AgentKind::Human;
    let mut agents = vec![
        agent("h1", human, [1.0, -1.375], operations, 204.0),
        agent("h2", human, [2.3, -4.125], operations, 275.0),
        agent("h3", human, [1.0, -9.625], operations, 213.0),
        agent("w1", AgentKind::Worker, [2.3, -15.125], operations, 250.0),
    ];
    for (agent, severity) in agents.iter_mut().zip([0.5, 0.75, 1.0]) {
        agent.severity = severity;
    }
    Problem::new(vec![robot("m1", [-10.4, 7.0], 0.75), robot("m2", [-14.4, 7.0], 1.0)], agents)
}

/// Agents at random places near two or more depots, with ranges of speeds.
pub fn random(seed: u64, agents: usize, robots: usize, operations: usize) -> Problem {
    let mut random = Random(seed.wrapping_mul(7919).wrapping_add(17));
    random.unit();
    let robots = (0..robots)
        .map(|m| robot(&format!("m{m}"), [-10.0 - 4.0 * m as f64, 7.0], random.within(0.75, 1.25)))
        .collect();
    let agents = (0..agents)
        .map(|a| {
            let kind = if random.unit() < 0.7 { AgentKind::Human } else { AgentKind::Worker };
            let place = [random.within(-5.0, 10.0), random.within(-15.0, 5.0)];
            agent(&format!("a{a}"), kind, place, operations, random.within(150.0, 350.0))
        })
        .collect();
    Problem::new(robots, agents)
}

/// As [`random`] with fixed durations, integer seconds and one speed: the shape of thesis Table 5.5.
pub fn fixed(seed: u64, agents: usize, robots: usize, operations: usize) -> Problem {
    let mut problem = random(seed, agents, robots, operations);
    let mut random = Random(seed.wrapping_add(991));
    for robot in &mut problem.robots {
        robot.speed = Range::point(0.1);
        robot.proximity = Some(Range::point(0.1));
    }
    for agent in &mut problem.agents {
        agent.duration = Duration { mean: random.within(100.0, 300.0).round(), sigma: 0.0 };
    }
    let lengths = |random: &mut Random| (0..agents).map(|_| random.within(20.0, 150.0).round() / 10.0).collect();
    problem.distances = Distances::Table((0..robots).map(|_| lengths(&mut random)).collect());
    problem
}
