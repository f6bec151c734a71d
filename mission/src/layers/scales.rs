//! What makes the terms of the cost of a layered plan comparable: the denominators of (6.1), (6.2) and (6.6).

use serde::{Deserialize, Serialize};

use super::problem::{Body, Problem};

/// Denominators of the cost. Neither who is lost nor which agent or
/// object a task names changes them, so that costs before and after a loss, with and without an allocation, compare.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scales {
    /// `|T| (delta_max + d_max / v_min)` of (6.1) (s).
    pub makespan: f64,
    /// By agent: `omega_{h,max}` of (6.2) for a person (kg s), the denominator of (6.6) for a robot (J); 0 where nothing
    /// that the agent could do has any.
    pub of_agent: Vec<f64>,
}

impl Scales {
    /// The scales of a problem.
    pub fn of(problem: &Problem) -> Scales {
        let mut farthest = 0.0_f64;
        let mut workload = vec![0.0_f64; problem.agents.len()];
        for (agent, who) in problem.agents.iter().enumerate() {
            for (task, what) in problem.tasks.iter().enumerate() {
                let Some(skill) = who.skill(&what.action) else { continue };
                // An object that is named is no part of the scale where features say which would do as well.
                let would_do = |object: &usize| match what.object.filter(|_| what.features.is_empty()) {
                    Some(named) => named == *object,
                    None => what.needs_object() && what.features.is_subset(&problem.objects[*object].features),
                };
                let objects = (0..problem.objects.len()).filter(would_do).map(Some);
                for object in objects.chain((!what.needs_object()).then_some(None)) {
                    let begun = problem.begun_of(task);
                    let as_begun = begun.is_some_and(|begun| begun.agent == agent && begun.object == object);
                    if !as_begun && problem.incapacity(agent, task, object).is_some() {
                        continue;
                    }
                    let distance = problem.distance(agent, task, object);
                    farthest = farthest.max(distance);
                    if let (Some(pace), Some(mass)) =
                        (problem.pace(who, skill, problem.mass(object)), problem.mass(object))
                    {
                        workload[agent] = workload[agent].max((skill.duration + distance / pace) * mass);
                    }
                }
            }
        }
        let masses: Vec<f64> = problem.objects.iter().map(|thing| thing.mass).collect();
        let heaviest = masses.iter().copied().reduce(f64::max);
        let mut slowest = f64::INFINITY;
        let mut longest = 0.0_f64;
        for who in &problem.agents {
            for skill in &who.skills {
                longest = longest.max(skill.duration);
                // (6.15) falls with the mass, so that the heaviest object is the slowest.
                slowest = slowest.min(problem.pace(who, skill, heaviest).unwrap_or(f64::INFINITY));
            }
            if let Body::Robot { speed, .. } = who.body {
                slowest = slowest.min(speed.low);
            }
        }
        let energy = |agent: usize| match problem.agents[agent].body {
            Body::Robot { speed, energy } => {
                energy.standby * farthest / speed.low + energy.friction * farthest + energy.drag * speed.high * farthest
            }
            Body::Human { .. } => workload[agent],
        };
        Scales {
            makespan: problem.tasks.len() as f64 * (longest + if farthest > 0.0 { farthest / slowest } else { 0.0 }),
            of_agent: (0..problem.agents.len()).map(energy).collect(),
        }
    }
}
