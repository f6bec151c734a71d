//! Warnings about places of layers that do not fit each other: two objects in one place, and places that take far longer to reach
//! than any skill.

use quantities::number;

use super::check::{Item, Key};
use super::problem::{Body, Problem};
use crate::declare::{Origins, Remark, Remarks};

/// Distance (m) below which two places are one.
const SAME: f64 = 1e-6;

/// Number of times that a way may be as long as the longest skill.
const LONGER: f64 = 50.0;

/// Time (s) up to which a way is never reported.
const WAY: f64 = 900.0;

/// Adds the warnings.
pub(super) fn add(problem: &Problem, places: &Origins<Item>, remarks: &mut Remarks) {
    put_together(problem, places, remarks);
    begin_together(problem, places, remarks);
    far(problem, places, remarks);
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Warns of two tasks of a layer that bring objects to the same coordinates. A named place, such as a box, holds several.
fn put_together(problem: &Problem, places: &Origins<Item>, remarks: &mut Remarks) {
    let named = |to: &[f64; 3]| problem.places.values().any(|place| distance(place, to) < SAME);
    for (j, task) in problem.tasks.iter().enumerate() {
        let brings = |task: &super::problem::Task| task.object.is_some() || !task.features.is_empty();
        let Some(to) = task.path.last().filter(|to| brings(task) && !named(to)) else { continue };
        let same = |other: &super::problem::Task| {
            other.layer == task.layer
                && other.action == task.action
                && brings(other)
                && other.path.last().is_some_and(|end| distance(end, to) < SAME)
        };
        let Some(i) = problem.tasks[..j].iter().position(same) else { continue };
        let at = |task: usize| places.of(Item::Task(task), Key::Path.names());
        let text = format!("`{}` ends where `{}` does", task.name, problem.tasks[i].name);
        remarks.push(
            Remark::warning("HQ0920", at(j), text)
                .label(at(i), "the same place, in the same layer")
                .note("both objects would be in one place")
                .help("write another place, or a named one, `place box { at .. }`, if it holds several objects"),
        );
    }
}

/// Warns of two objects that begin at the same coordinates.
fn begin_together(problem: &Problem, places: &Origins<Item>, remarks: &mut Remarks) {
    let named = |at: &[f64; 3]| problem.places.values().any(|place| distance(place, at) < SAME);
    for (j, object) in problem.objects.iter().enumerate().filter(|(_, object)| !named(&object.place)) {
        let same = |other: &super::problem::Object| distance(&other.place, &object.place) < SAME;
        let Some(i) = problem.objects[..j].iter().position(same) else { continue };
        let at = |object: usize| places.of(Item::Object(object), Key::Place.names());
        let text = format!("`{}` is where `{}` is", object.name, problem.objects[i].name);
        remarks.push(
            Remark::warning("HQ0920", at(j), text)
                .label(at(i), "the same place")
                .help("write another place, or a named one, `place box { at .. }`, if it holds several objects"),
        );
    }
}

/// Warns of objects and ends of tasks that every agent needs far longer to reach than any skill takes.
fn far(problem: &Problem, places: &Origins<Item>, remarks: &mut Remarks) {
    let skills = problem.agents.iter().flat_map(|agent| &agent.skills);
    let Some(longest) = skills.map(|skill| skill.duration).reduce(f64::max) else { return };
    let way = |to: &[f64; 3]| {
        let of = problem.agents.iter().map(|agent| {
            let speed = match &agent.body {
                Body::Robot { speed, .. } => speed.high,
                Body::Human { speed, .. } => *speed,
            };
            distance(&agent.place, to) / speed
        });
        of.reduce(f64::min).unwrap_or(0.0)
    };
    let objects = problem.objects.iter().enumerate().map(|(i, o)| (Item::Object(i), Key::Place, &o.name, o.place));
    let tasks = problem.tasks.iter().enumerate().filter_map(|(i, t)| {
        let to = t.path.last()?;
        Some((Item::Task(i), Key::Path, &t.name, *to))
    });
    for (item, key, name, place) in objects.chain(tasks) {
        let way = way(&place);
        if !(way > WAY && way > LONGER * longest) {
            continue;
        }
        let (way, longest) = (number(way.round()), number(longest));
        let text = format!("the way to `{name}` takes {way} s, and the longest skill takes {longest} s");
        remarks.push(
            Remark::warning("HQ0917", places.of(item, key.names()), text)
                .note("this is the way of the agent that needs the least, at its full speed")
                .help("check the unit of the place, and the speeds of the agents"),
        );
    }
}
