//! Results of an execution of layers.

use serde::{Deserialize, Serialize};

use super::LayersExecution;

/// Results of a mission so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// From the start of the mission to the end of the last task so far (s); 0 before the first.
    pub makespan: f64,
    /// Number of finished layers, with all layers before them.
    pub layers: usize,
    /// Number of finished tasks.
    pub tasks: usize,
    /// By agent.
    pub agents: Vec<AgentOutcome>,
    /// Number of tasks dropped after a failure or a loss.
    pub dropped: usize,
    /// Number of repairs that moved times.
    pub reschedules: usize,
    /// Number of new plans.
    pub reallocations: usize,
}

/// Results of an agent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AgentOutcome {
    /// Its name.
    pub name: String,
    /// It is a person.
    pub human: bool,
    /// Number of finished tasks.
    pub tasks: usize,
    /// Time at work in tasks that have ended or were dropped (s).
    pub worked: f64,
    /// Way that it has gone in these (m).
    pub travelled: f64,
    /// Energy that these took (J); 0 of a person.
    pub energy: f64,
    /// Of each task of these its time times the mass of its object, together (kg s), as (6.16); 0 of a robot.
    pub workload: f64,
}

impl LayersExecution {
    /// Results of the mission so far.
    pub fn statistics(&self) -> Outcome {
        let agents = self.problem.agents.iter().zip(&self.world.agents).map(|(who, state)| AgentOutcome {
            name: who.name.clone(),
            human: who.is_human(),
            tasks: state.tasks,
            worked: state.worked,
            travelled: state.travelled,
            energy: state.energy,
            workload: state.workload,
        });
        Outcome {
            makespan: self.world.ended.last().map_or(0.0, |step| step.end - self.begin),
            layers: self.world.open.unwrap_or(self.problem.layers.len()),
            tasks: self.world.ended.len(),
            agents: agents.collect(),
            dropped: self.world.dropped,
            reschedules: self.log.reschedules,
            reallocations: self.log.reallocations,
        }
    }
}
