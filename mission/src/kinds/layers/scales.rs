//! Scales of the terms of the cost of a layered plan: the denominators of (6.1), (6.2) and (6.6).

use serde::{Deserialize, Serialize};

use super::ability::Abilities;
use super::problem::{Agent, Body, Problem, Skill};

/// Denominators of the cost. They are independent of lost agents, and of the agent or object that a task names, so that
/// costs before and after a loss, with and without an allocation, are comparable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scales {
    /// `|T| (delta_max + d_max / v_min)` of (6.1) (s).
    pub makespan: f64,
    /// By agent: `omega_{h,max}` of (6.2) for a person (kg s), the denominator of (6.6) for a robot (J); 0 if all tasks
    /// that the agent could perform have zero.
    pub of_agent: Vec<f64>,
}

impl Scales {
    /// Computes the scales of a problem.
    pub fn of(problem: &Problem) -> Scales {
        let least = problem.least_mass();
        let mut farthest = 0.0_f64;
        let mut workload = vec![0.0_f64; problem.agents.len()];
        let abilities = Abilities::of(problem);
        for (task, what) in problem.tasks.iter().enumerate() {
            let begun = problem.begun_of(task);
            // If the task has features, the scale covers all objects that have them, also if one is named.
            let objects: Vec<Option<usize>> = match what.needs_object() {
                true => abilities.objects[task].iter().copied().map(Some).collect(),
                false => vec![None],
            };
            for (agent, who) in problem.agents.iter().enumerate() {
                let Some(skill) = who.skill(&what.action) else { continue };
                for &object in &objects {
                    let as_begun = begun.is_some_and(|begun| begun.agent == agent && begun.object == object);
                    if !as_begun && !abilities.could(agent, task, object) {
                        continue;
                    }
                    let distance = problem.distance(agent, task, object);
                    farthest = farthest.max(distance);
                    if let (true, Some(mass)) = (who.is_human(), problem.mass(object)) {
                        let pace = pace(who, skill, mass - least);
                        workload[agent] = workload[agent].max((skill.duration + distance / pace) * mass);
                    }
                }
            }
        }
        let heaviest = problem.objects.iter().map(|thing| thing.mass).fold(least, f64::max);
        let mut slowest = f64::INFINITY;
        let mut longest = 0.0_f64;
        for who in &problem.agents {
            for skill in &who.skills {
                longest = longest.max(skill.duration);
                // The speed (6.15) decreases with the mass, so that the heaviest object is the slowest.
                slowest = slowest.min(pace(who, skill, heaviest - least));
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

/// Computes (6.15) for an object that is heavier than the lightest one by this mass (kg); infinite for a robot.
fn pace(agent: &Agent, skill: &Skill, heavier: f64) -> f64 {
    match agent.body {
        Body::Human { speed, slowing } => skill.pace * speed / (1.0 + slowing * heavier),
        Body::Robot { .. } => f64::INFINITY,
    }
}
