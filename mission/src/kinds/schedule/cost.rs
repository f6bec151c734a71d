//! Cost of a schedule, thesis (5.1) to (5.5), term by term.
//!
//! `C = sum alpha w (people) + beta sum w (workers) + gamma/3 sum (e^g + zeta e^p + e^d) + kappa Delta`. A wait is
//! measured from the nominal end of its operation to the start of the next one; after an agent's last operation, for
//! which the thesis defines none, to the start of its service. The time beyond the limit of an agent's waits keeps at
//! least its weight before any feedback: `alpha w` becomes `alpha w + max(0, alpha_0 - alpha) max(0, w - w_limit)`.

use serde::{Deserialize, Serialize};

use super::assistance::Assistance;
use super::problem::{AgentKind, Problem, Scales};
use crate::numbers::Energy;

/// Cost of a schedule by terms, each weighted and dimensionless.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cost {
    /// Waits of people, weighted by `alpha`.
    pub human_wait: f64,
    /// Waits of working robots, weighted by `beta`.
    pub worker_wait: f64,
    /// Energy of going, times `gamma / 3`.
    pub going: f64,
    /// Energy near the agents, weighted by `zeta`, times `gamma / 3`.
    pub proximity: f64,
    /// Energy of the return to the depot, times `gamma / 3`.
    pub depositing: f64,
    /// The makespan, weighted by `kappa`.
    pub makespan: f64,
}

impl Cost {
    /// Returns the sum of all terms: `C` of (5.5).
    pub fn total(&self) -> f64 {
        self.human_wait + self.worker_wait + self.going + self.proximity + self.depositing + self.makespan
    }
}

impl Energy {
    /// Computes the energy (J) of a leg of `length` (m) in `time` (s), thesis (5.3): `rho_1 D + rho_2 l + rho_3 l^2 /
    /// D`. Zero for a leg of length zero; infinite for a longer leg in no time.
    pub fn of_way(&self, length: f64, time: f64) -> f64 {
        if length == 0.0 {
            return 0.0;
        }
        if time <= 0.0 {
            return f64::INFINITY;
        }
        self.standby * time + self.friction * length + self.drag * length * length / time
    }
}

impl Scales {
    /// Returns the scales of a problem: the given ones, or else those of the thesis.
    pub fn of(problem: &Problem) -> Scales {
        if let Some(scales) = problem.scales {
            return scales;
        }
        let (mut going, mut proximity, mut depositing) = (0.0_f64, 0.0_f64, 0.0_f64);
        for robot in 0..problem.robots.len() {
            for agent in 0..problem.agents.len() {
                let lengths = problem.lengths(agent, robot);
                going = going.max(lengths.going);
                proximity = proximity.max(lengths.proximity);
                depositing = depositing.max(lengths.depositing);
            }
        }
        let robots = &problem.robots;
        let slowest = robots.iter().map(|m| m.speed.low).fold(f64::INFINITY, f64::min);
        let fastest = robots.iter().map(|m| m.speed.high).fold(0.0, f64::max);
        let serve = robots.iter().map(|m| m.serve).fold(0.0, f64::max);
        let deposit = robots.iter().map(|m| m.deposit).fold(0.0, f64::max);
        let count = problem.operations() as f64;
        let energy = |length: f64| {
            let most = |e: Energy| e.standby * length / slowest + e.friction * length + e.drag * fastest * length;
            robots.iter().map(|m| most(m.energy)).fold(0.0, f64::max)
        };
        Scales {
            makespan: count * (depositing + going + proximity) / slowest + count * (serve + deposit),
            wait: (going + proximity) / slowest,
            energy: [energy(going), energy(proximity), energy(depositing)],
        }
    }
}

/// Returns `value / scale`, or 0 if the scale is 0: then the value is 0 too.
pub(crate) fn scaled(value: f64, scale: f64) -> f64 {
    if scale > 0.0 { value / scale } else { 0.0 }
}

/// Computes the cost of a schedule. The order of the assistances is arbitrary; the makespan counts from 0, as in the
/// thesis.
pub fn cost(problem: &Problem, schedule: &[Assistance]) -> Cost {
    cost_where(problem, schedule, |_| true)
}

/// Computes the cost of the operations and services for which `counts` returns true; the makespan is that of the whole
/// schedule.
pub fn cost_where(problem: &Problem, schedule: &[Assistance], counts: impl Fn(&Assistance) -> bool) -> Cost {
    let scales = Scales::of(problem);
    let mut cost = Cost::default();
    let third = problem.weights.energy / 3.0;
    for assistance in schedule.iter().filter(|assistance| counts(assistance)) {
        let Assistance { agent, operation, robot, times, .. } = *assistance;
        let (Some(who), Some(machine)) = (problem.agents.get(agent), problem.robots.get(robot)) else { continue };
        let wait = wait(schedule, assistance);
        let beyond = problem.limit_weight(agent, operation) * scaled((wait - who.wait_limit).max(0.0), scales.wait);
        let wait = problem.wait_weight(agent, operation) * scaled(wait, scales.wait) + beyond;
        match who.kind {
            AgentKind::Human => cost.human_wait += wait,
            AgentKind::Worker => cost.worker_wait += wait,
        }
        let lengths = problem.lengths(agent, robot);
        let zeta = problem.approach_weight(agent, operation);
        // A leg that took no time before the plan was made had length zero then.
        let gone = problem.begun.iter().any(|begun| begun.service.is_some_and(|(m, t)| m == robot && t == times));
        let energy = |length: f64, time: f64, scale: f64| match () {
            () if gone && time <= 0.0 => 0.0,
            () => third * scaled(machine.energy.of_way(length, time), scale),
        };
        cost.going += energy(lengths.going, times.waiting - times.going, scales.energy[0]);
        cost.proximity += zeta * energy(lengths.proximity, times.serving - times.proximity, scales.energy[1]);
        let back = times.end - times.depositing - machine.deposit;
        cost.depositing += energy(lengths.depositing, back, scales.energy[2]);
    }
    let end = schedule.iter().map(|assistance| assistance.times.end).reduce(f64::max).unwrap_or(0.0);
    cost.makespan = problem.weights.makespan * scaled(end, scales.makespan);
    cost
}

/// Computes the wait of an agent after an operation (s).
pub fn wait(schedule: &[Assistance], of: &Assistance) -> f64 {
    let next = schedule.iter().find(|next| next.agent == of.agent && next.operation == of.operation + 1);
    next.map_or(of.times.serving, |next| next.start) - of.end
}
