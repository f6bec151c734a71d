//! The map of a layered plan, seen from above: bases of agents, objects, and the places to which the plan brings them.

use super::plan::Plan;
use crate::map::{Line, Map, Moving, Shape, Sign};

use super::problem::{Body, Problem};
use super::steps::from_plan;

/// The most objects whose names are written; of more they are shown under the pointer.
const MOST_NAMES: usize = 24;

fn flat(place: &[f64; 3]) -> [f64; 2] {
    [place[0], place[1]]
}

/// The map of a plan. A carried object is drawn from its place along its path, in the colour of its layer, with a thin line
/// from the agent to it. Objects that the plan leaves alone are hollow.
pub fn map(problem: &Problem, plan: &Plan) -> Map {
    let label = |name: &str| problem.labels.member(name).to_string();
    let agents = problem.agents.iter().map(|agent| flat(&agent.place));
    let objects = problem.objects.iter().map(|object| flat(&object.place));
    let clear: Vec<[f64; 2]> = agents.chain(objects).collect();
    let targets = problem.tasks.iter().flat_map(|task| &task.path).map(flat);
    let (mut shapes, taken) = paths(problem, plan);
    for (object, layer) in problem.objects.iter().zip(taken) {
        shapes.push(Shape::sign(Sign::Object(layer), flat(&object.place), label(&object.name)));
    }
    for agent in &problem.agents {
        let sign = match agent.body {
            Body::Robot { .. } => Sign::Base,
            Body::Human { .. } => Sign::Person,
        };
        shapes.push(Shape::sign(sign, flat(&agent.place), label(&agent.name)));
        shapes.push(Shape::Name { at: flat(&agent.place), text: label(&agent.name) });
    }
    if problem.objects.len() <= MOST_NAMES {
        let names = problem.objects.iter().map(|o| Shape::Name { at: flat(&o.place), text: label(&o.name) });
        shapes.extend(names);
    }
    let robots = problem.agents.iter().filter(|agent| !agent.is_human());
    Map {
        title: "map: where objects lie, and where they are brought",
        most_scale: 1000.0,
        extent: clear.iter().copied().chain(targets).collect(),
        clear,
        shapes,
        moving: robots.map(|agent| Moving::robot(label(&agent.name))).collect(),
        legend: vec![
            (Sign::Base, "robot"),
            (Sign::Person, "person"),
            (Sign::Object(None), "object"),
            (Sign::Target(0), "brought to"),
        ],
    }
}

/// The work of the plan, and for each object the layer of the task that takes it.
fn paths(problem: &Problem, plan: &Plan) -> (Vec<Shape>, Vec<Option<usize>>) {
    let (mut shapes, mut taken) = (Vec::new(), vec![None; problem.objects.len()]);
    for step in from_plan(plan) {
        let (Some(task), Some(who)) = (problem.tasks.get(step.task), problem.agents.get(step.agent)) else { continue };
        let object = step.object.and_then(|object| problem.objects.get(object));
        if let Some(slot) = step.object.and_then(|object| taken.get_mut(object)) {
            *slot = Some(task.layer);
        }
        let stops: Vec<[f64; 2]> = object.map(|object| &object.place).into_iter().chain(&task.path).map(flat).collect();
        let Some((first, rest)) = stops.split_first() else { continue };
        let with = object.map(|object| format!(" with {}", problem.labels.member(&object.name))).unwrap_or_default();
        let (who_label, task_label) = (problem.labels.member(&who.name), problem.labels.task(&task.name));
        let title = format!("{who_label}: {} {task_label}{with}", task.action);
        shapes.push(Shape::Line { line: Line::Fetch, points: vec![flat(&who.place), *first], title: None });
        if let Some(last) = rest.last() {
            let (points, at) = (stops.clone(), *last);
            shapes.push(Shape::Line { line: Line::Carry(task.layer), points, title: Some(title.clone()) });
            shapes.push(Shape::sign(Sign::Target(task.layer), at, title));
        }
    }
    (shapes, taken)
}
