//! Conversion of choices to steps: computes the optimal lengths of the layers, the robots' speeds, and the starts of
//! tasks.

use super::dual::Choices;
use super::improve::Improver;
use super::instance::{Instance, Mover};
use super::speeds::timing;
use super::steps::Step;

/// Returns the steps of these choices, with the fixed steps. Agents begin with their layer and perform their tasks in
/// the problem's order without a pause.
pub(super) fn steps(instance: &Instance<'_>, choices: &Choices) -> Vec<Step> {
    let mut steps = instance.fixed.clone();
    let loads = Improver::new(instance, choices.clone()).into_loads();
    let mut begin = instance.begin;
    for (layer, loads) in instance.layers.iter().zip(&loads) {
        let length = timing(&instance.movers, layer, loads, instance.second).length;
        let mut end = begin + layer.floor;
        let mut free: Vec<f64> = layer.release.iter().map(|release| begin + release).collect();
        for &index in &layer.jobs {
            let job = &instance.jobs[index];
            let (agent, object) = choices[index];
            let Some(mode) = job.mode(object, agent) else { continue };
            let mover = &instance.movers[agent];
            let load = loads[agent];
            let left = length - layer.release[agent] - load.time;
            let speed = match mover {
                Mover::Robot { speed, .. } if load.way > 0.0 => {
                    (load.way / mover.moving(load.way, left)).clamp(speed.low, speed.high)
                }
                Mover::Robot { .. } => mover.speed_at(instance.second),
                Mover::Human => pace(instance, agent, job.task, job.objects[object]),
            };
            let time = mode.time + if mode.way > 0.0 { mode.way / speed } else { 0.0 };
            let start = free[agent];
            free[agent] = start + time;
            end = end.max(free[agent]);
            let object = job.objects[object];
            steps.push(Step { task: job.task, agent, object, speed, start, end: free[agent], begun: false });
        }
        begin = end;
    }
    steps.sort_by_key(|step| step.task);
    steps
}

fn pace(instance: &Instance<'_>, agent: usize, task: usize, object: Option<usize>) -> f64 {
    let problem = instance.problem;
    let who = &problem.agents[agent];
    let skill = who.skill(&problem.tasks[task].action);
    skill.and_then(|skill| problem.pace(who, skill, problem.mass(object))).unwrap_or(1.0)
}
