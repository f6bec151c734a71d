//! What an execution of layers comes to, in numbers.

use serde::{Deserialize, Serialize};

use super::LayeredExecution;

/// What a mission came to, so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// From the start of the mission to the end of the last task so far (s); 0 before the first.
    pub makespan: f64,
    /// How many layers are done, with those before them.
    pub layers: usize,
    /// How many tasks are done.
    pub tasks: usize,
    /// By agent.
    pub agents: Vec<AgentOutcome>,
    /// How often a task was dropped, because it failed or its agent was lost.
    pub dropped: usize,
    /// How often times of the plan moved.
    pub reschedules: usize,
    /// How often was planned anew.
    pub reallocations: usize,
}

/// What became of an agent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AgentOutcome {
    /// Its name.
    pub name: String,
    /// It is a person.
    pub human: bool,
    /// How many tasks it has done.
    pub tasks: usize,
    /// How long it was at work, in tasks that have ended or were dropped (s).
    pub worked: f64,
    /// Way that it has gone in these (m).
    pub travelled: f64,
    /// Energy that these took (J); 0 of a person.
    pub energy: f64,
    /// Of each task of these its time times the mass of its object, together (kg s), as (6.16); 0 of a robot.
    pub workload: f64,
}

impl LayeredExecution {
    /// What the mission has come to.
    pub fn statistics(&self) -> Outcome {
        let agents = self.problem.agents.iter().zip(&self.agents).map(|(who, state)| AgentOutcome {
            name: who.name.clone(),
            human: who.is_human(),
            tasks: state.tasks,
            worked: state.worked,
            travelled: state.travelled,
            energy: state.energy,
            workload: state.workload,
        });
        Outcome {
            makespan: self.ended.last().map_or(0.0, |step| step.end - self.begin),
            layers: self.open.unwrap_or(self.problem.layers.len()),
            tasks: self.ended.len(),
            agents: agents.collect(),
            dropped: self.dropped,
            reschedules: self.log.reschedules,
            reallocations: self.log.reallocations,
        }
    }
}
