//! An operation that ends early is served early.
//!
//! Algorithm 3 lets every service keep its times where it can. At a confidence of 0.9 nine operations of ten end earlier
//! than planned: a robot would stand and wait near a person who waits for it, another would stand at its depot, and after
//! ten operations everybody would wait for what was saved. So the approach begins when the operation ends, if the robot is
//! there, and services that follow leave earlier, by the same robots in the same order at the planned speeds. A robot under
//! way that has time until the operation ends goes slowly: when it ends early, the robot goes as fast as the wait is worth.
//! A wait that the plan has on purpose stays.

use crate::kinds::schedule::assistance::Assistance;
use crate::kinds::schedule::cost::scaled;
use crate::kinds::schedule::instance::going;
use crate::kinds::schedule::problem::{Scales, ServiceTimes};

use super::ScheduleExecution;
use super::motion::distance;
use super::view::Stage;

/// A plan that serves later than it must by more than this does so on purpose (s).
const ON_PURPOSE: f64 = 1e-6;

impl ScheduleExecution {
    /// The operation of an agent ends at `end`, now or later, and was expected to end at `expected` (s).
    pub(super) fn serve_early(&mut self, agent: usize, expected: f64, end: f64) {
        let operation = self.world.agents[agent].operation;
        let Some(robot) = self.world.robots.iter().position(|robot| robot.target == Some((agent, operation))) else {
            return;
        };
        let Some(at) = self.service(agent, operation) else { return };
        let (was, state) = (at.times, &self.world.robots[robot]);
        let approach = was.serving - was.proximity;
        let possible = expected.max(was.waiting + approach);
        let (waiting, serving) = match state.stage {
            Stage::Going | Stage::Waiting if was.serving <= possible + ON_PURPOSE => {
                let waiting = if state.stage == Stage::Going {
                    self.sooner(robot, (agent, operation), &was).max(end - approach).min(was.waiting)
                } else {
                    was.waiting
                };
                (waiting, end.max(waiting.max(self.time) + approach))
            }
            Stage::Approaching => (was.waiting, end.max(state.leg.until).max(self.time)),
            _ => return,
        };
        if serving < was.serving {
            let proximity = if state.stage == Stage::Approaching { was.proximity } else { serving - approach };
            self.shift(
                agent,
                operation,
                |times| ServiceTimes { waiting, proximity, serving, ..times },
                serving - was.serving,
            );
        }
    }

    /// Arrival (s) of a robot under way to this operation at the waiting place, at the speed that is optimal while an
    /// agent waits; no later than planned.
    fn sooner(&self, robot: usize, (agent, operation): (usize, usize), was: &ServiceTimes) -> f64 {
        let (state, machine) = (&self.world.robots[robot], &self.problem.robots[robot]);
        if state.not_before > self.time {
            return was.waiting.max(state.leg.until);
        }
        let whole = was.waiting - was.going;
        let length = match whole > 0.0 {
            // If lengths come from a table, the rest of the way is as its time.
            true if !self.has_places() => {
                let left = ((was.waiting - self.time) / whole).clamp(0.0, 1.0);
                left * self.problem.lengths(agent, robot).going
            }
            _ => distance(self.position(robot, self.time), state.leg.to),
        };
        let scales = Scales::of(&self.problem);
        let price = scaled(self.problem.wait_weight(agent, operation), scales.wait);
        let way = going(&self.problem, &scales, robot, length);
        let worth = if price > 0.0 { way.shortest_at(price) } else { f64::INFINITY };
        let least = length / machine.speed.high;
        (self.time + worth.max(least)).min(was.waiting.max(state.leg.until))
    }

    /// The service of an operation is made to begin or end otherwise: `by` (s) is how much later the robot leaves the
    /// agent then, and so what follows for both.
    pub(super) fn shift(
        &mut self,
        agent: usize,
        operation: usize,
        change: impl Fn(ServiceTimes) -> ServiceTimes,
        by: f64,
    ) {
        let mut left = None;
        for at in self.world.schedule.iter_mut().filter(|at| at.agent == agent) {
            if at.operation == operation {
                left = Some(at.times.depositing);
                let times = change(at.times);
                at.times = ServiceTimes { depositing: times.depositing + by, end: times.end + by, ..times };
            }
        }
        // The next operation begins with the end of the service, unless the plan lets the agent begin later.
        let next = self.world.schedule.iter_mut().find(|at| at.agent == agent && at.operation == operation + 1);
        if let (Some(left), Some(next)) = (left, next)
            && next.start <= left + ON_PURPOSE
        {
            next.start += by;
            next.end += by;
        }
    }

    /// Services whose robot has not left, and operations that have not begun, come earlier where what they wait for does.
    /// `before` is the schedule as it was.
    pub(super) fn bring_forward(&mut self, before: &[Assistance]) {
        let mut order: Vec<usize> = (0..self.world.schedule.len().min(before.len())).collect();
        let serving = |index: &usize| before[*index].times.serving;
        order.sort_by(|a, b| serving(a).total_cmp(&serving(b)).then(before[*a].target().cmp(&before[*b].target())));
        // When each robot is at home, and each agent has been served: as it was, and as it is.
        let mut homes = vec![(self.begin, self.begin); self.world.robots.len()];
        let mut served: Vec<Option<(f64, f64)>> = vec![None; self.world.agents.len()];
        for index in order {
            let (was, mut is) = (before[index], self.world.schedule[index]);
            let state = &self.world.agents[was.agent];
            let done = was.operation < state.operation;
            let started = done || (was.operation == state.operation && state.started());
            if started && !done {
                is.end = state.expected;
            } else if !started && let Some((then, now)) = served[was.agent] {
                // It begins with the end of the service before, unless the plan lets the agent begin later.
                let by = if was.start <= then + ON_PURPOSE { (now - then).min(0.0) } else { 0.0 };
                (is.start, is.end) = (was.start + by, was.end + by);
            }
            let (was_home, is_home) = homes[was.robot];
            if !done && self.world.robots[was.robot].target != Some((was.agent, was.operation)) {
                let way = was.times.waiting - was.times.going + was.times.serving - was.times.proximity;
                let ready = is_home.max(self.time);
                let (planned, possible) = (was.end.max(was_home + way), is.end.max(ready + way));
                if was.times.serving <= planned + ON_PURPOSE && possible < was.times.serving {
                    let times = was.times.later(possible - was.times.serving);
                    let going = times.going.max(ready);
                    let waiting = times.waiting + (going - times.going);
                    is.times = ServiceTimes { going, waiting: waiting.min(times.proximity), ..times };
                }
            }
            homes[was.robot] = (was.times.end, is.times.end);
            served[was.agent] = Some((was.times.depositing, is.times.depositing));
            self.world.schedule[index] = is;
        }
    }
}
