//! The visible state of an execution: present activity, position and next task of each agent.

use serde::{Deserialize, Serialize};

use super::{LayersExecution, way};

/// Activity of an agent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Doing {
    /// It is at its base, and does nothing.
    Idle,
    /// It is at work.
    Working,
    /// It takes no part any more.
    Lost,
}

/// A task that an agent performs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct UnderWay {
    /// Index of the task.
    pub task: usize,
    /// Index of the object; none: it needs none.
    pub object: Option<usize>,
    /// Start (s).
    pub start: f64,
    /// Expected end (s).
    pub expected: f64,
}

/// A task that is planned for an agent.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NextTask {
    /// Index of the task.
    pub task: usize,
    /// Index of the object; none: it needs none.
    pub object: Option<usize>,
    /// Planned start (s).
    pub start: f64,
    /// Planned end (s).
    pub end: f64,
    /// Its layer has begun: every task of the layers before is done.
    pub open: bool,
}

/// An agent now.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AgentView {
    /// Present activity.
    pub doing: Doing,
    /// Since when (s).
    pub since: f64,
    /// The task under way.
    pub work: Option<UnderWay>,
    /// The next task.
    pub next: Option<NextTask>,
    /// Position of its hand (m): on the way from its base to the object, along the path and back, or at the base. A
    /// lost agent keeps its last position.
    pub position: [f64; 3],
    /// Number of finished tasks.
    pub tasks: usize,
}

impl LayersExecution {
    /// State of this agent; none if there is no such agent.
    pub fn agent(&self, agent: usize) -> Option<AgentView> {
        let state = self.world.agents.get(agent)?;
        let work = state.task.as_ref().map(|running| UnderWay {
            task: running.step.task,
            object: running.step.object,
            start: running.step.start,
            expected: running.expected,
        });
        let next = self.world.ahead.iter().find(|step| step.agent == agent).map(|step| NextTask {
            task: step.task,
            object: step.object,
            start: step.start.max(self.time),
            end: step.end + (self.time - step.start).max(0.0),
            open: self.world.open == self.problem.tasks.get(step.task).map(|task| task.layer),
        });
        let position = self.position(agent)?;
        Some(AgentView { doing: state.doing, since: state.since, work, next, position, tasks: state.tasks })
    }

    /// Position of an agent (m); none if there is no such agent.
    pub fn position(&self, agent: usize) -> Option<[f64; 3]> {
        let state = self.world.agents.get(agent)?;
        Some(match &state.task {
            Some(running) => way::place(&self.problem, &running.step, running.share(self.time)),
            None => state.place,
        })
    }
}
