//! Scenarios of missions of layers: how one is executed, what is measured of it, and what may happen in it.

use std::time::Duration;

use mission::engine::Budget;
use mission::execution::Durations;
use mission::kinds::layers::choose::{Options, parts_of_a_second};
use mission::kinds::layers::execution::{Event, Settings};
use mission::numbers::MAX_NUMBER;
use serde::{Deserialize, Serialize};

use super::check::ensure;
use super::{LayersProgram, MissionMeasure, MissionScenarioProgram, Occurrence, ProgramError, error};

/// How long a plan may take, the first one and each that is made anew: far longer than the parts of the branch and bound
/// that end it at the same place in every run.
const LONGEST: Duration = Duration::from_secs(60);

/// What is measured of a mission of layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OfLayers {
    /// Every task is done.
    Done,
    /// There is no plan for everything any more.
    Stranded,
    /// From the start to the end of the last task so far, in s.
    Makespan,
    /// What the plan costs, as it stands.
    Cost,
    /// The energy of all robots so far, in J.
    Energy,
    /// The workload of all people so far, in kg s.
    Workload,
    /// How many layers are done.
    Layer,
    /// How many tasks are done.
    Tasks,
    /// How often a task failed, or was dropped by somebody who was lost.
    Dropped,
    /// How often times of the plan moved.
    Reschedules,
    /// How often was planned anew.
    Reallocations,
}

/// What is measured of an agent of a mission of layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OfTeammate {
    /// It is at work.
    Working,
    /// It takes no part any more.
    Lost,
    /// How many tasks it has done.
    Tasks,
    /// How long it was at work, the task under way with it, in s.
    Worked,
    /// Where it is, in m.
    X,
    /// See `X`.
    Y,
    /// See `X`.
    Z,
    /// Way that it has gone, in tasks that have ended, in m.
    Travelled,
    /// Of a robot: energy that these took, in J.
    Energy,
    /// Of a person: times of these tasks times the masses of their objects, in kg s.
    Workload,
}

impl MissionScenarioProgram {
    /// How its mission of layers is executed.
    pub fn layered_settings(&self, mission: &LayersProgram) -> Settings {
        let budget = Budget { time: LONGEST, nodes: parts_of_a_second(&mission.problem), gap: 1e-4 };
        Settings {
            durations: if self.sampled { Durations::Sampled { seed: self.seed } } else { Durations::Planned },
            replan: self.replan,
            reallocate_above: mission.reallocate_above,
            planning: Options { batch: mission.batch, budget, ..Options::default() },
            told: Vec::new(),
        }
    }

    /// Makes sure that it can be run on this mission; what the compiler gives always can.
    pub(super) fn check_layered(&self, of: &LayersProgram, place: &str) -> Result<(), ProgramError> {
        let problem = &of.problem;
        self.check_times(place)?;
        if let Some(mistake) = problem.check().first() {
            return Err(error(place, mistake.describe(problem).0));
        }
        let wrong = |e: mission::kinds::layers::execution::Refusal| error(place, e.to_string());
        self.layered_settings(of).check(problem).map_err(wrong)?;
        self.check_happens(place)?;
        let planned = !self.bases && self.replies.is_empty();
        ensure(planned, place, "nobody travels as bases or is served in a mission of layers")?;
        for happens in &self.happens {
            let good = match happens.what {
                Occurrence::Layered(event) => {
                    let usual = !matches!(event, Event::Late { by, .. } if by.is_nan() || by.abs() > MAX_NUMBER);
                    usual && event.agent().is_none_or(|agent| agent < problem.agents.len())
                }
                Occurrence::Event(_) | Occurrence::FailedBy { .. } | Occurrence::LateBy { .. } => false,
            };
            ensure(
                good,
                &format!("{place}.happens"),
                "something happens that cannot, or to an agent that does not exist",
            )?;
        }
        self.check_expectations(place, &|measure| match measure {
            MissionMeasure::Layers(_) => true,
            MissionMeasure::Teammate(agent, of) => problem.agents.get(*agent).is_some_and(|who| match of {
                OfTeammate::Energy => !who.is_human(),
                OfTeammate::Workload => who.is_human(),
                _ => true,
            }),
            MissionMeasure::Mission(_)
            | MissionMeasure::Agent(..)
            | MissionMeasure::Robot(..)
            | MissionMeasure::In(..) => false,
        })
    }
}
