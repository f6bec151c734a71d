//! Repair of the steps ahead: times move, and each agent keeps its tasks and objects.

use crate::kinds::layers::instance::{Instance, Job};
use crate::kinds::layers::problem::{Begun, Problem};
use crate::kinds::layers::scales::Scales;
use crate::kinds::layers::steps::Step;
use crate::kinds::layers::timeline;

/// By start; of the same start by task.
pub(super) fn sort(steps: &mut [Step]) {
    steps.sort_by(|a, b| a.start.total_cmp(&b.start).then(a.task.cmp(&b.task)));
}

/// The steps as early as what has begun of the problem and the order of the layers allow, as fast as they were. Of an agent
/// and a layer they stay in their order.
pub(super) fn moved(problem: &Problem, ahead: &[Step]) -> Vec<Step> {
    let layer = |task: usize| problem.tasks[task].layer;
    let mut free: Vec<f64> = vec![problem.start; problem.agents.len()];
    for begun in &problem.begun {
        free[begun.agent] = free[begun.agent].max(begun.end);
    }
    let mut ahead = ahead.to_vec();
    ahead.sort_by_key(|step| layer(step.task));
    let mut moved: Vec<Step> = Vec::with_capacity(ahead.len());
    for step in ahead {
        let earlier = |task: usize| layer(task) < layer(step.task);
        let begun = problem.begun.iter().filter(|begun| earlier(begun.task)).map(|begun| begun.end);
        let planned = moved.iter().filter(|other| earlier(other.task)).map(|other| other.end);
        let start = begun.chain(planned).fold(free[step.agent], f64::max);
        let end = start + (step.end - step.start);
        free[step.agent] = end;
        moved.push(Step { start, end, ..step });
    }
    sort(&mut moved);
    moved
}

/// The same with the best speeds; none if somebody is not able to do what is planned for them.
pub(super) fn best(problem: &Problem, scales: &Scales, ahead: &[Step]) -> Option<Vec<Step>> {
    let mut pinned = problem.clone();
    for step in ahead {
        let task = pinned.tasks.get_mut(step.task)?;
        (task.agent, task.object) = (Some(step.agent), step.object);
    }
    let instance = Instance::with_scales(&pinned, scales.clone());
    let choice = |task: usize| ahead.iter().find(|step| step.task == task).map(|step| (step.agent, 0));
    let choices: Option<Vec<(usize, usize)>> = instance.jobs.iter().map(|job| choice(job.task)).collect();
    let choices = choices?;
    let possible = |(job, (agent, _)): (&Job, &(usize, usize))| job.mode(0, *agent).is_some();
    if !instance.jobs.iter().zip(&choices).all(possible) {
        return None;
    }
    let mut steps = timeline::steps(&instance, &choices);
    steps.retain(|step| !step.begun);
    sort(&mut steps);
    Some(steps)
}

/// A begun step in the form of the problem.
pub(super) fn begun(step: &Step) -> Begun {
    let Step { task, agent, object, speed, start, end, .. } = *step;
    Begun { task, agent, object, speed, start, end }
}

/// Times or speeds of one differ from those of the other.
pub(super) fn differ(before: &[Step], after: &[Step], same: f64) -> bool {
    let off = |a: f64, b: f64| (a - b).abs() > same;
    before.len() != after.len()
        || before.iter().any(|a| {
            let found = after.iter().find(|b| b.task == a.task);
            found.is_none_or(|b| off(a.start, b.start) || off(a.end, b.end) || off(a.speed, b.speed))
        })
}
