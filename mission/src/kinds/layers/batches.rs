//! Planning in batches, thesis Algorithm 6: for missions that are too large to be planned at once.
//!
//! Tasks are sorted within their layers by their shortest duration over all agents and objects, the longest first. One
//! batch after the other is planned and fixed with agent, object, speed and times. In the thesis a batch may take any
//! objects; here it leaves a suitable object for each later task, since otherwise a plan may not exist.

use std::time::Instant;

use crate::engine::Budget;
use crate::plan::Statistics;

use super::branch::branch;
use super::choose::Parts;
use super::instance::{Instance, Job};
use super::steps::Step;
use super::timeline;

/// Plans all tasks, `size` at a time; returns their steps, or `None` only if there is no plan at all.
pub(super) fn batches(whole: &Instance<'_>, size: usize, budget: &Budget) -> Option<Parts> {
    let begun = Instant::now();
    let mut order: Vec<(usize, f64, usize)> =
        whole.jobs.iter().map(|job| (whole.problem.tasks[job.task].layer, shortest(whole, job), job.task)).collect();
    order.sort_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1)).then(a.2.cmp(&b.2)));
    let tasks: Vec<usize> = order.into_iter().map(|(.., task)| task).collect();
    let mut steps: Vec<Step> = whole.fixed.clone();
    let mut statistics = Statistics::default();
    let mut stopped = None;
    let parts: Vec<&[usize]> = tasks.chunks(size.max(1)).collect();
    for (number, part) in parts.iter().enumerate() {
        let instance = whole.part(&steps, part);
        let left = u32::try_from(parts.len() - number).unwrap_or(u32::MAX);
        let time = budget.time.saturating_sub(begun.elapsed()) / left;
        let found = branch(&instance, &Budget { time, ..*budget })?;
        stopped = stopped.or(found.status.stopped());
        statistics = statistics.plus(found.statistics);
        steps = timeline::steps(&instance, &found.choices);
    }
    Some((steps, statistics, stopped))
}

/// Returns the shortest duration of a job (s).
fn shortest(instance: &Instance<'_>, job: &Job) -> f64 {
    let mut least = f64::INFINITY;
    for object in 0..job.objects.len() {
        for (agent, mover) in instance.movers.iter().enumerate() {
            if let Some(mode) = job.mode(object, agent) {
                least = least.min(mode.time + mover.moving(mode.way, 0.0));
            }
        }
    }
    least
}
