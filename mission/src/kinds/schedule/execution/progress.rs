//! Progress of all services, the input of repairing and planning anew.

use crate::kinds::schedule::problem::{Begun, Problem};
use crate::kinds::schedule::reschedule::{Earliest, Progress};

use super::ScheduleExecution;
use super::motion::{distance, waiting_place};
use super::view::Stage;

/// A place that is nearer than this has not moved (m).
const SAME_PLACE: f64 = 1e-9;

impl ScheduleExecution {
    /// Begun operations and services under the parameters of `problem`.
    pub(super) fn progress(&self, problem: &Problem) -> Vec<Progress> {
        let mut all = Vec::new();
        for (agent, state) in self.world.agents.iter().enumerate() {
            let count = problem.agents[agent].operations;
            let passed = |operation: usize| self.passed(agent, operation);
            // If a robot has left for an operation, the operations before it are settled too.
            let settled = (0..count).rev().find(|operation| passed(*operation) > 0);
            for operation in 0..count {
                let started = operation < state.operation || (operation == state.operation && state.started());
                let service = self.service(agent, operation);
                let settled = settled.is_some_and(|last| operation <= last);
                let (start, end) = match service {
                    _ if started && operation == state.operation => (state.start, state.expected),
                    Some(at) if started || settled => (at.start, at.end),
                    _ => continue,
                };
                let begun = Begun {
                    agent,
                    operation,
                    start,
                    end,
                    service: service.filter(|_| settled).map(|at| (at.robot, at.times)),
                };
                all.push(Progress {
                    begun,
                    started,
                    passed: passed(operation),
                    earliest: self.earliest(problem, agent, operation),
                });
            }
        }
        all
    }

    /// Number of instants of a service that have passed.
    fn passed(&self, agent: usize, operation: usize) -> usize {
        let robot = self.world.robots.iter().find(|robot| robot.target == Some((agent, operation)));
        robot.map_or(if operation < self.world.agents[agent].operation { 6 } else { 0 }, |robot| robot.passed())
    }

    fn earliest(&self, problem: &Problem, agent: usize, operation: usize) -> Earliest {
        let Some(robot) = self.world.robots.iter().position(|robot| robot.target == Some((agent, operation))) else {
            return Earliest::NONE;
        };
        let state = &self.world.robots[robot];
        let place = waiting_place(problem, agent, robot);
        let elsewhere = self.has_places() && distance(place, state.leg.to) > SAME_PLACE;
        let reached = |there: f64| if elsewhere { self.reach(robot, place) } else { there };
        match state.stage {
            Stage::Going => Earliest { waiting: reached(state.not_before), ..Earliest::NONE },
            Stage::Waiting => Earliest { proximity: reached(state.leg.until), ..Earliest::NONE },
            Stage::Approaching => Earliest { serving: state.leg.until, ..Earliest::NONE },
            Stage::Returning => Earliest { end: state.not_before + problem.robots[robot].deposit, ..Earliest::NONE },
            _ => Earliest::NONE,
        }
    }
}
