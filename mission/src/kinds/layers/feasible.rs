//! Feasibility of a layered problem: checks that all open tasks can be performed, and reports the tasks in conflict if
//! not. Agents perform one task after the other, so that only objects can run out.

use crate::check::{entry, of};

use super::ability::Abilities;
use super::check::{Item, Key, Mistake};
use super::matching::Matching;
use super::problem::Problem;
use super::reason::{Obstacle, ObstacleKind, Reason};

/// Returns the mistakes that make a plan impossible.
pub(super) fn mistakes(problem: &Problem) -> Vec<Mistake> {
    let abilities = Abilities::of(problem);
    let mut mistakes = Vec::new();
    let mut tasks = Vec::new();
    let mut candidates = Vec::new();
    let used = |object: &usize| problem.begun.iter().any(|begun| begun.object == Some(*object));
    for task in (0..problem.tasks.len()).filter(|task| problem.begun_of(*task).is_none()) {
        match usable(problem, &abilities, task) {
            Err(mistake) => mistakes.push(mistake),
            Ok(mut objects) if problem.tasks[task].needs_object() => {
                objects.retain(|object| !used(object));
                tasks.push(task);
                candidates.push(objects);
            }
            Ok(_) => {}
        }
    }
    for shortage in Matching::new(&candidates, problem.objects.len()).shortages(&candidates) {
        let of_all: Vec<usize> = shortage.rows.iter().filter_map(|row| tasks.get(*row)).copied().collect();
        let Some((&last, others)) = of_all.split_last() else { continue };
        let against = others.first().map(|task| of(Item::Task(*task), Key::Features));
        let reason = Reason::TooFewObjects { tasks: of_all.clone(), objects: shortage.columns };
        mistakes.push(Mistake { at: of(Item::Task(last), Key::Features), against, reason });
    }
    mistakes
}

/// Returns the objects that a task may use with some agent; empty for a task that needs none.
fn usable(problem: &Problem, abilities: &Abilities, task: usize) -> Result<Vec<usize>, Mistake> {
    let what = &problem.tasks[task];
    let agents = match what.agent {
        Some(agent) => agent..agent + 1,
        None => 0..problem.agents.len(),
    };
    let wrong = |key, against, reason| Err(Mistake { at: of(Item::Task(task), key), against, reason });
    let action = || what.action.clone();
    if problem.agents.iter().all(|who| who.skill(&what.action).is_none()) {
        return wrong(Key::Action, None, Reason::NobodyHasSkill { action: action() });
    }
    if !what.needs_object() {
        if agents.clone().any(|agent| problem.able(agent, task, None)) {
            return Ok(Vec::new());
        }
        let obstacle = |agent| Some(Obstacle { agent, object: None, kind: problem.obstacle(agent, task, None)? });
        return nobody(problem, task, agents.filter_map(obstacle).collect());
    }
    let named = |object: &usize| what.object.is_none_or(|named| named == *object);
    let suitable: Vec<usize> = abilities.objects[task].iter().copied().filter(named).collect();
    if suitable.is_empty() {
        if let Some(object) = what.object {
            let lacks = what.features.difference(&problem.objects[object].features).next();
            let reason = Reason::LacksFeature { object, feature: lacks.cloned().unwrap_or_default() };
            return wrong(Key::Object, Some(of(Item::Object(object), Key::Features)), reason);
        }
        let common = |object: &usize| problem.objects[*object].features.intersection(&what.features).count();
        let nearest = (0..problem.objects.len()).filter(|object| common(object) > 0).rev().max_by_key(common);
        let features = what.features.iter().cloned().collect();
        let against = nearest.map(|object| of(Item::Object(object), Key::Features));
        return wrong(Key::Features, against, Reason::NoObject { features, nearest });
    }
    let able = |object: &usize| {
        let mut takes_part = agents.clone().filter(|agent| !problem.agents[*agent].lost);
        takes_part.any(|agent| abilities.could(agent, task, Some(*object)))
    };
    let usable: Vec<usize> = suitable.iter().copied().filter(able).collect();
    if !usable.is_empty() {
        return Ok(usable);
    }
    let obstacle = |agent| {
        let without = problem.obstacle(agent, task, None).map(|kind| Obstacle { agent, object: None, kind });
        without.or_else(|| {
            let kinds = suitable.iter().filter_map(|object| {
                let kind = problem.obstacle(agent, task, Some(*object))?;
                Some(Obstacle { agent, object: Some(*object), kind })
            });
            kinds.min_by(|a, b| shortfall(&a.kind).total_cmp(&shortfall(&b.kind)))
        })
    };
    nobody(problem, task, agents.clone().filter_map(obstacle).collect())
}

/// Returns the missing amount: m or kg.
fn shortfall(kind: &ObstacleKind) -> f64 {
    match kind {
        ObstacleKind::Path { distance, reach } | ObstacleKind::Place { distance, reach } => distance - reach,
        ObstacleKind::Payload { mass, payload } => mass - payload,
        _ => f64::INFINITY,
    }
}

/// Returns the mistake of a task that no agent can perform; it refers to the agent with the smallest shortfall.
fn nobody(problem: &Problem, task: usize, obstacles: Vec<Obstacle>) -> Result<Vec<usize>, Mistake> {
    let closest = obstacles.iter().min_by(|a, b| shortfall(&a.kind).total_cmp(&shortfall(&b.kind)));
    let key = |kind: &ObstacleKind| match kind {
        ObstacleKind::Path { .. } | ObstacleKind::Place { .. } => Some(Key::Reach),
        ObstacleKind::Payload { .. } => Some(Key::Payload),
        ObstacleKind::Feature { .. } => Some(Key::Cannot),
        ObstacleKind::Skill { .. } => Some(Key::Skills),
        ObstacleKind::Lost | ObstacleKind::Another => None,
    };
    let against = closest.and_then(|closest| Some(of(Item::Agent(closest.agent), key(&closest.kind)?)));
    let named = problem.tasks[task].agent.is_some();
    let at = if named { of(Item::Task(task), Key::Agent) } else { entry(Item::Task(task)) };
    Err(Mistake { at, against, reason: Reason::Nobody { obstacles } })
}
