//! Position of an agent during a task: from its base to the object, along the path, and back.
//!
//! It moves at one speed. What performing takes besides moving `delta_{a,s}` it spends standing: half with the object and
//! half where the path ends, or all of it at the one of the two that there is; where neither is, at its base.

use crate::kinds::layers::problem::{Problem, between};
use crate::kinds::layers::steps::Step;

/// Position of the agent of a step (m) after this share of its time, 0 to 1.
pub(super) fn place(problem: &Problem, step: &Step, share: f64) -> [f64; 3] {
    let (Some(who), Some(task)) = (problem.agents.get(step.agent), problem.tasks.get(step.task)) else {
        return [0.0; 3];
    };
    let stands = who.skill(&task.action).map_or(0.0, |skill| skill.duration);
    let object = step.object.and_then(|object| problem.objects.get(object)).map(|thing| thing.place);
    // Each place with how long it is stood there.
    let mut stops: Vec<([f64; 3], f64)> = vec![(who.place, 0.0)];
    stops.extend(object.map(|place| (place, if task.path.is_empty() { stands } else { stands / 2.0 })));
    let last = task.path.len().saturating_sub(1);
    let there = if object.is_some() { stands / 2.0 } else { stands };
    stops.extend(task.path.iter().enumerate().map(|(i, place)| (*place, if i == last { there } else { 0.0 })));
    if stops.len() == 1 {
        stops[0].1 = stands;
    }
    if problem.returns {
        stops.push((who.place, 0.0));
    }
    along(&stops, step.speed, share)
}

fn along(stops: &[([f64; 3], f64)], speed: f64, share: f64) -> [f64; 3] {
    let Some((end, _)) = stops.last() else { return [0.0; 3] };
    let moving = |pair: &[([f64; 3], f64)]| between(&pair[0].0, &pair[1].0) / speed;
    let whole: f64 = stops.iter().map(|stop| stop.1).sum::<f64>() + stops.windows(2).map(moving).sum::<f64>();
    let mut left = share * whole;
    if share >= 1.0 {
        return *end;
    }
    for pair in stops.windows(2) {
        let [(from, stands), (to, _)] = [pair[0], pair[1]];
        if left <= stands {
            return from;
        }
        left -= stands;
        let time = moving(pair);
        if left < time {
            let part = left / time;
            return [0, 1, 2].map(|axis| from[axis] + part * (to[axis] - from[axis]));
        }
        left -= time;
    }
    *end
}
