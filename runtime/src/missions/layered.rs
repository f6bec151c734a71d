//! A scenario of a mission of layers: it is executed while what the scenario says happens, and judged at instants that are
//! one step apart.

use mission::kinds::layers::execution::{Doing, Event, Happening, LayeredExecution, Outcome};
use mission::plan::Plan;

use super::judge::MissionJudge;
use super::layered_words::of_event;
use super::summary::{End, MissionSummary, Untaken};
use super::{MissionError, MissionRecorder, MissionRun};
use crate::program::{
    LayersProgram, MissionMeasure, MissionProgram, MissionScenarioProgram, Occurrence, OfLayers, OfTeammate,
};

/// Runs a scenario of a mission of layers to its end, or until `go_on` says no at an instant.
pub(super) fn run(
    (mission, layers): (&MissionProgram, &LayersProgram),
    scenario: &MissionScenarioProgram,
    recorder: &mut dyn MissionRecorder,
    go_on: &mut dyn FnMut(u32) -> bool,
) -> Result<MissionRun, MissionError> {
    let mut judge = MissionJudge::new(scenario)?;
    let mut execution = match LayeredExecution::new(layers.problem.clone(), scenario.layered_settings(layers)) {
        Ok(execution) => execution,
        Err(why) => {
            let summary = MissionSummary::refused(mission, scenario, why.to_string(), judge.finish());
            return Ok(MissionRun { summary, problem: None, layers: None, planned: None, executed: None });
        }
    };
    let planned = execution.plan().clone();
    let mut untaken = Vec::new();
    let (mut happened, mut instants, mut interrupted) = (0, 0, false);
    for k in 0..scenario.instants() {
        if !go_on(k) {
            interrupted = true;
            break;
        }
        let time = f64::from(k) * scenario.step;
        while let Some(happens) = scenario.happens.get(happened).filter(|happens| happens.at <= time) {
            happened += 1;
            execution.advance(happens.at);
            if let Occurrence::Layered(event) = happens.what {
                tell(&mut execution, event, &mut untaken);
            }
        }
        execution.advance(time);
        let now = execution.statistics();
        judge.instant(time, &|measure| value(measure, &execution, &now)).map_err(std::io::Error::other)?;
        recorder.layered(time, &execution)?;
        instants = k + 1;
    }
    let outcomes = judge.finish();
    let end = if interrupted { End::Interrupted } else { End::of_layers(&execution) };
    let summary = MissionSummary::layered(mission, scenario, (&execution, end, instants), untaken, outcomes);
    let (executed, layers) = (Some(carried_out(&execution)), Some(execution.problem().clone()));
    Ok(MissionRun { summary, problem: None, layers, planned: Some(planned), executed })
}

/// The plan as it stands, with all that has begun by now marked so, and not only what had when it was planned last.
fn carried_out(execution: &LayeredExecution) -> Plan {
    let mut begun = vec![false; execution.problem().tasks.len()];
    for record in execution.records() {
        let (task, is) = match record.what {
            Happening::Began { task, .. } => (task, true),
            Happening::Dropped { task, .. } => (task, false),
            _ => continue,
        };
        if let Some(slot) = begun.get_mut(task) {
            *slot = is;
        }
    }
    let mut plan = execution.plan().clone();
    for activity in &mut plan.activities {
        activity.begun = activity.work.is_some_and(|work| begun.get(work.task) == Some(&true));
    }
    plan
}

fn tell(execution: &mut LayeredExecution, event: Event, untaken: &mut Vec<Untaken>) {
    if let Err(why) = execution.tell(event).map(|_| ()) {
        let event = of_event(&event, execution.problem());
        untaken.push(Untaken { at_s: execution.time(), event, why: why.to_string() });
    }
}

/// The number of a measure; NaN for one that is of no mission of layers.
fn value(measure: MissionMeasure, execution: &LayeredExecution, now: &Outcome) -> f64 {
    let truth = |holds: bool| if holds { 1.0 } else { -1.0 };
    match measure {
        MissionMeasure::Layers(of) => match of {
            OfLayers::Done => truth(execution.done()),
            OfLayers::Stranded => truth(execution.stranded().is_some()),
            OfLayers::Makespan => now.makespan,
            OfLayers::Cost => execution.plan().cost,
            OfLayers::Energy => now.agents.iter().map(|agent| agent.energy).sum(),
            OfLayers::Workload => now.agents.iter().map(|agent| agent.workload).sum(),
            OfLayers::Layer => now.layers as f64,
            OfLayers::Tasks => now.tasks as f64,
            OfLayers::Dropped => now.dropped as f64,
            OfLayers::Reschedules => now.reschedules as f64,
            OfLayers::Reallocations => now.reallocations as f64,
        },
        MissionMeasure::Teammate(index, of) => {
            let (Some(view), Some(so_far)) = (execution.agent(index), now.agents.get(index)) else { return f64::NAN };
            match of {
                OfTeammate::Working => truth(view.doing == Doing::Working),
                OfTeammate::Lost => truth(view.doing == Doing::Lost),
                OfTeammate::Tasks => so_far.tasks as f64,
                OfTeammate::Worked => so_far.worked + view.work.map_or(0.0, |work| execution.time() - work.start),
                OfTeammate::X => view.position[0],
                OfTeammate::Y => view.position[1],
                OfTeammate::Z => view.position[2],
                OfTeammate::Travelled => so_far.travelled,
                OfTeammate::Energy => so_far.energy,
                OfTeammate::Workload => so_far.workload,
            }
        }
        MissionMeasure::Mission(_) | MissionMeasure::Agent(..) | MissionMeasure::Robot(..) | MissionMeasure::In(..) => {
            f64::NAN
        }
    }
}
