//! Descriptions of mistakes with the names of the problem: the problem, and the fix.

use super::check::{Item, Mistake};
use super::problem::Problem;
use super::reason::{Obstacle, Reason};

/// Maximum number of names in a sentence.
const LISTED: usize = 8;

impl Mistake {
    /// Returns the description of the mistake and a suggested fix, each a phrase without a full stop, with the names of
    /// agents, objects and tasks.
    pub fn describe(&self, problem: &Problem) -> (String, String) {
        let task = |index: usize| problem.tasks.get(index).map_or("?", |task| task.name.as_str());
        let object = |index: usize| problem.objects.get(index).map_or("?", |thing| thing.name.as_str());
        match &self.reason {
            Reason::NobodyHasSkill { action } => {
                let mut known: Vec<&str> =
                    problem.agents.iter().flat_map(|who| &who.skills).map(|skill| skill.action.as_str()).collect();
                known.sort_unstable();
                known.dedup();
                (format!("no agent has the skill `{action}`"), format!("use one of {}", list(&known)))
            }
            Reason::Nobody { obstacles } => {
                let each: Vec<String> = obstacles.iter().map(|obstacle| told(problem, obstacle)).collect();
                let who = if each.is_empty() { String::new() } else { format!(": {}", each.join("; ")) };
                let fix = "choose another object or place, or an agent that is able to";
                (format!("no agent is able to perform it{who}"), fix.into())
            }
            Reason::NoObject { features, nearest } => {
                let wanted: Vec<&str> = features.iter().map(String::as_str).collect();
                let fix = nearest.map_or("add such an object".into(), |nearest| {
                    let has: Vec<&str> = problem.objects[nearest].features.iter().map(String::as_str).collect();
                    format!("require fewer features; the nearest, `{}`, is {}", object(nearest), list(&has))
                });
                (format!("no object has all features {}", list(&wanted)), fix)
            }
            Reason::LacksFeature { object: index, feature } => {
                (format!("the named object `{}` is not {feature}", object(*index)), "name another object".into())
            }
            Reason::TooFewObjects { tasks, objects } => {
                let tasks_named: Vec<&str> = tasks.iter().map(|index| task(*index)).collect();
                let named: Vec<&str> = objects.iter().map(|index| object(*index)).collect();
                let what = format!(
                    "the tasks {} need {} objects, and only {} would do: {}",
                    list(&tasks_named),
                    tasks.len(),
                    objects.len(),
                    list(&named)
                );
                (what, "require other features in some of them, or remove tasks".into())
            }
            Reason::EmptyLayer => ("the layer has no task".into(), "remove it, or give it tasks".into()),
            Reason::NoTask => ("there is no task".into(), "give at least one".into()),
            Reason::NoSkill { agent, action } => {
                let who = problem.agents.get(*agent).map_or("?", |who| who.name.as_str());
                (format!("`{who}` lacks the skill `{action}`"), "name another agent".into())
            }
            Reason::LayerBefore { task: index } => {
                (format!("it begins before `{}` of a layer before is done", task(*index)), "begin later".into())
            }
            other => {
                let fix = match self.at.item {
                    Item::Mission => "change the mission",
                    Item::Agent(_) => "change the agent",
                    Item::Object(_) => "change the object",
                    Item::Layer(_) | Item::Task(_) => "change the task",
                    Item::Begun(_) => "change what has begun",
                };
                (other.to_string(), fix.into())
            }
        }
    }
}

fn told(problem: &Problem, obstacle: &Obstacle) -> String {
    let who = problem.agents.get(obstacle.agent).map_or("?", |who| who.name.as_str());
    match obstacle.object.and_then(|index| problem.objects.get(index)) {
        Some(thing) => format!("`{who}` with `{}`: {}", thing.name, obstacle.kind),
        None => format!("`{who}`: {}", obstacle.kind),
    }
}

fn list(names: &[&str]) -> String {
    let shown: Vec<String> = names.iter().take(LISTED).map(|name| format!("`{name}`")).collect();
    let more = names.len().saturating_sub(LISTED);
    if more > 0 { format!("{} and {more} more", shown.join(", ")) } else { shown.join(", ") }
}
