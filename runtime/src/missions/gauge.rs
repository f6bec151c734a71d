//! What is measured of a mission while it is executed.

use mission::kinds::schedule::execution::{Doing, Execution, Outcome, Stage};

use super::Workers;
use crate::program::{MissionMeasure, OfAgent, OfMission, OfRobot};

/// What a mission has come to.
pub(super) struct Gauge {
    /// Waits of each agent so far, in s.
    waited: Vec<f64>,
    now: Option<Outcome>,
}

impl Gauge {
    pub(super) fn new(agents: usize) -> Gauge {
        Gauge { waited: vec![0.0; agents], now: None }
    }

    /// Looks at an execution as it stands.
    pub(super) fn look(&mut self, execution: &Execution) {
        let now = execution.statistics();
        for (waited, agent) in self.waited.iter_mut().zip(&now.agents) {
            *waited = agent.waited();
        }
        self.now = Some(now);
    }

    /// Waits of the agents so far, in s, the ones under way with them.
    pub(super) fn waited(&self) -> &[f64] {
        &self.waited
    }

    /// The number of a measure at the instant that was looked at last; NaN for nobody's.
    pub(super) fn value(&self, measure: MissionMeasure, execution: &Execution, workers: &Workers) -> f64 {
        let truth = |holds: bool| if holds { 1.0 } else { -1.0 };
        let Some(now) = &self.now else { return f64::NAN };
        match measure {
            MissionMeasure::Mission(of) => match of {
                OfMission::Done => truth(execution.done()),
                OfMission::Stranded => truth(execution.stranded().is_some()),
                OfMission::Makespan => now.makespan,
                OfMission::Cost => execution.plan().cost,
                OfMission::Energy => now.energy(),
                OfMission::Reschedules => now.reschedules as f64,
                OfMission::Reallocations => now.reallocations as f64,
            },
            MissionMeasure::Agent(index, of) => {
                let (Some(view), Some(so_far)) = (execution.agent(index), now.agents.get(index)) else {
                    return f64::NAN;
                };
                match of {
                    OfAgent::Waited => self.waited.get(index).copied().unwrap_or(f64::NAN),
                    OfAgent::Served => so_far.served as f64,
                    OfAgent::Working => truth(view.doing == Doing::Working),
                    OfAgent::Lost => truth(view.doing == Doing::Lost),
                    OfAgent::Faulted => truth(workers.has_faulted(index)),
                    OfAgent::X => view.place[0],
                    OfAgent::Y => view.place[1],
                    OfAgent::Adaptation => so_far.wait_index,
                    OfAgent::SpeedAdaptation => so_far.speed_index,
                    OfAgent::WaitSatisfaction => execution.satisfaction(index).wait,
                    OfAgent::ApproachSatisfaction => execution.satisfaction(index).approach,
                }
            }
            // Where operations take as long as planned, no machine is in any state.
            MissionMeasure::In(index, state) => truth(workers.is_in(index, state).unwrap_or(false)),
            MissionMeasure::Robot(index, of) => {
                let (Some(view), Some(so_far)) = (execution.robot(index), now.robots.get(index)) else {
                    return f64::NAN;
                };
                match of {
                    OfRobot::X => view.position[0],
                    OfRobot::Y => view.position[1],
                    OfRobot::Speed => f64::hypot(view.velocity[0], view.velocity[1]),
                    OfRobot::Travelled => so_far.travelled,
                    OfRobot::Energy => so_far.energy,
                    OfRobot::Busy => truth(!matches!(view.stage, Stage::Home | Stage::Lost)),
                    OfRobot::Served => so_far.served as f64,
                    OfRobot::Lost => truth(view.stage == Stage::Lost),
                }
            }
            MissionMeasure::Layers(_) | MissionMeasure::Teammate(..) => f64::NAN,
        }
    }
}
