//! Results of an execution.

use serde::{Deserialize, Serialize};

use super::ScheduleExecution;
use super::indices::Indices;
use super::record::LogEntry;

/// Results of a mission so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// From the start of the mission to the end of the last service so far (s); 0 before the first.
    pub makespan: f64,
    /// By agent.
    pub agents: Vec<AgentOutcome>,
    /// By robot.
    pub robots: Vec<RobotOutcome>,
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
    /// Number of its served operations.
    pub served: usize,
    /// Wait after each operation, to the start of the next, or of the service of the last (s).
    pub waits: Vec<f64>,
    /// Of a wait that is not over: how long it has been so far (s). Of one who left: what it waited in vain.
    #[serde(default)]
    pub waiting: f64,
    /// Speed of the robot's approach for each service (m/s).
    pub speeds: Vec<f64>,
    /// Adaptation index of the waits, thesis Algorithm 5; 1 for an agent who asked for nothing.
    pub wait_index: f64,
    /// Adaptation index of the speeds.
    pub speed_index: f64,
}

impl AgentOutcome {
    /// All its waits together, with the one that is not over (s).
    pub fn waited(&self) -> f64 {
        self.waits.iter().sum::<f64>() + self.waiting
    }
}

/// Results of a robot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotOutcome {
    /// Its name.
    pub name: String,
    /// Number of operations that it has served.
    pub served: usize,
    /// Way that it has gone, in ways that have ended (m).
    pub travelled: f64,
    /// Energy that these took (J).
    pub energy: f64,
}

impl Outcome {
    /// All waits of all agents together, with those that are not over (s).
    pub fn waited(&self) -> f64 {
        self.agents.iter().map(AgentOutcome::waited).sum()
    }

    /// The energy of all robots (J).
    pub fn energy(&self) -> f64 {
        self.robots.iter().map(|robot| robot.energy).sum()
    }
}

impl ScheduleExecution {
    /// Results of the mission so far.
    pub fn statistics(&self) -> Outcome {
        let home = self.log.records.iter().rev().find(|record| matches!(record.what, LogEntry::Home { .. }));
        let agents = self.problem.agents.iter().zip(&self.world.agents).enumerate().map(|(index, (who, state))| {
            let Indices { wait: wait_index, speed: speed_index } = self.world.indices[index];
            AgentOutcome {
                name: who.name.clone(),
                served: state.operation,
                waits: state.waits.clone(),
                waiting: state.waiting(self.time),
                speeds: state.speeds.clone(),
                wait_index,
                speed_index,
            }
        });
        let robots = self.problem.robots.iter().zip(&self.world.robots).map(|(machine, state)| RobotOutcome {
            name: machine.name.clone(),
            served: state.served,
            travelled: state.travelled,
            energy: state.energy,
        });
        Outcome {
            makespan: home.map_or(0.0, |record| record.time - self.begin),
            agents: agents.collect(),
            robots: robots.collect(),
            reschedules: self.log.reschedules,
            reallocations: self.log.reallocations,
        }
    }
}
