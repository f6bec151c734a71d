//! An operation that ends early is served early, where its robot is on the way or waits already.
//!
//! Algorithm 3 lets every service keep its times where it can. At a confidence of 0.9 nine operations of ten end earlier
//! than planned, and a robot would stand and wait near a person who waits for it. So the approach begins when the operation
//! ends, at the planned speed, unless the plan lets the agent wait on purpose; what follows it for the robot and for the
//! agent's next operation is earlier by as much.

use crate::schedule::problem::ServiceTimes;

use super::Execution;
use super::view::Stage;

/// A plan that serves later than it must by more than this does so on purpose (s).
const ON_PURPOSE: f64 = 1e-6;

impl Execution {
    /// The operation of an agent has ended now, and was expected to end at `expected` (s).
    pub(super) fn serve_early(&mut self, agent: usize, expected: f64) {
        let operation = self.agents[agent].operation;
        let Some(robot) = self.robots.iter().position(|robot| robot.target == Some((agent, operation))) else { return };
        let Some(at) = self.service(agent, operation) else { return };
        let (was, state) = (at.times, &self.robots[robot]);
        let approach = was.serving - was.proximity;
        let possible = expected.max(was.waiting + approach);
        let serving = match state.stage {
            Stage::Going | Stage::Waiting if was.serving <= possible + ON_PURPOSE => {
                was.waiting.max(state.leg.until).max(self.time) + approach
            }
            Stage::Approaching => state.leg.until.max(self.time),
            _ => return,
        };
        if serving < was.serving {
            let approach = if state.stage == Stage::Approaching { was.proximity } else { serving - approach };
            self.shift(
                agent,
                operation,
                |times| ServiceTimes { proximity: approach, serving, ..times },
                serving - was.serving,
            );
        }
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
        for at in self.schedule.iter_mut().filter(|at| at.agent == agent) {
            if at.operation == operation {
                left = Some(at.times.depositing);
                let times = change(at.times);
                at.times = ServiceTimes { depositing: times.depositing + by, end: times.end + by, ..times };
            }
        }
        // The next operation begins with the end of the service, unless the plan lets the agent begin later.
        let next = self.schedule.iter_mut().find(|at| at.agent == agent && at.operation == operation + 1);
        if let (Some(left), Some(next)) = (left, next)
            && next.start <= left + ON_PURPOSE
        {
            next.start += by;
            next.end += by;
        }
    }
}
