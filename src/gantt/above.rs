//! The map of a layered plan, seen from above: where agents stand, where objects lie, and where the plan brings them.

use std::fmt::Write;

use mission::kinds::layers::problem::{Body, Problem};
use mission::kinds::layers::steps::from_plan;
use mission::plan::Plan;

use crate::xml::escaped;

use super::frame::{Frame, Names};
use super::map::Standing;
use super::px;
use super::svg::{LAYERS, head};

/// Pixels of a metre at the most.
const MOST_SCALE: f64 = 1000.0;
/// The most objects whose names are written; of more they are told where the pointer stands.
const MOST_NAMES: usize = 24;

/// The map as SVG, x to the right and y upwards in one scale. What an agent carries is drawn from where it lies along its
/// path, in the colour of its layer, and a thin line goes from the agent to it. Objects that the plan leaves alone are
/// hollow. Hands that move are drawn as robots of schedules are, see [`super::map`].
pub fn layered_map(problem: &Problem, plan: &Plan, standing: &Standing) -> String {
    let flat = |p: &[f64; 3]| [p[0], p[1]];
    let agents = problem.agents.iter().map(|agent| flat(&agent.place));
    let objects = problem.objects.iter().map(|object| flat(&object.place));
    let paths = problem.tasks.iter().flat_map(|task| &task.path).map(flat);
    let frame = Frame::of(agents.chain(objects).chain(paths).chain(standing.robots.iter().copied()), MOST_SCALE);
    let mut out = String::new();
    // Writing to a String does not fail.
    let _ = write(problem, plan, standing, &frame, &mut out);
    out
}

fn write(problem: &Problem, plan: &Plan, standing: &Standing, frame: &Frame, out: &mut String) -> std::fmt::Result {
    head(frame.width, frame.height, "map: where objects lie, and where they are brought", standing.styled, out)?;
    let taken = ways(problem, plan, frame, out)?;
    let mut names = Names::new(frame);
    let at = |place: &[f64; 3]| frame.at([place[0], place[1]]);
    problem.agents.iter().for_each(|agent| names.keep_clear(at(&agent.place)));
    problem.objects.iter().for_each(|object| names.keep_clear(at(&object.place)));
    for (object, layer) in problem.objects.iter().zip(taken) {
        let [x, y] = at(&object.place);
        let class = layer.map_or("object".to_string(), |layer| format!("object layer-{}", layer % LAYERS));
        let title = escaped(problem.labels.member(&object.name));
        let (left, top) = (px(x - 4.5), px(y - 4.5));
        writeln!(
            out,
            "<rect class=\"{class}\" x=\"{left}\" y=\"{top}\" width=\"9\" height=\"9\"><title>{title}</title></rect>"
        )?;
    }
    for agent in &problem.agents {
        let [x, y] = at(&agent.place);
        let title = escaped(problem.labels.member(&agent.name));
        match agent.body {
            Body::Robot { .. } => writeln!(
                out,
                "<rect class=\"depot\" x=\"{}\" y=\"{}\" width=\"11\" height=\"11\"><title>{title}</title></rect>",
                px(x - 5.5),
                px(y - 5.5)
            )?,
            Body::Human { .. } => writeln!(
                out,
                "<circle class=\"human\" cx=\"{}\" cy=\"{}\" r=\"6\"><title>{title}</title></circle>",
                px(x),
                px(y)
            )?,
        }
        names.write([x, y], problem.labels.member(&agent.name), out)?;
    }
    if problem.objects.len() <= MOST_NAMES {
        for object in &problem.objects {
            names.write(at(&object.place), problem.labels.member(&object.name), out)?;
        }
    }
    let robots = problem.agents.iter().filter(|agent| matches!(agent.body, Body::Robot { .. }));
    frame.moving(robots.map(|agent| problem.labels.member(&agent.name)).zip(standing.robots.iter().copied()), out)?;
    words(frame, out)?;
    writeln!(out, "</svg>")
}

/// What is done in the plan, and for each object the layer of the task that takes it.
fn ways(
    problem: &Problem,
    plan: &Plan,
    frame: &Frame,
    out: &mut String,
) -> Result<Vec<Option<usize>>, std::fmt::Error> {
    let mut taken = vec![None; problem.objects.len()];
    for step in from_plan(problem, plan) {
        let (Some(task), Some(who)) = (problem.tasks.get(step.task), problem.agents.get(step.agent)) else { continue };
        let object = step.object.and_then(|object| problem.objects.get(object));
        if let Some(slot) = step.object.and_then(|object| taken.get_mut(object)) {
            *slot = Some(task.layer);
        }
        let stops: Vec<[f64; 2]> = object
            .map(|object| &object.place)
            .into_iter()
            .chain(&task.path)
            .map(|place| frame.at([place[0], place[1]]))
            .collect();
        let Some((first, rest)) = stops.split_first() else { continue };
        let with = object.map(|object| format!(" with {}", problem.labels.member(&object.name))).unwrap_or_default();
        let title = escaped(&format!(
            "{}: {} {}{with}",
            problem.labels.member(&who.name),
            task.action,
            problem.labels.task(&task.name)
        ));
        let [x, y] = frame.at([who.place[0], who.place[1]]);
        writeln!(out, "<path class=\"goes\" d=\"M{} {} L{} {}\"/>", px(x), px(y), px(first[0]), px(first[1]))?;
        let layer = task.layer % LAYERS;
        if let Some([x, y]) = rest.last() {
            let mut line = format!("M{} {}", px(first[0]), px(first[1]));
            rest.iter().try_for_each(|[x, y]| write!(line, " L{} {}", px(*x), px(*y)))?;
            writeln!(out, "<path class=\"carries line-{layer}\" d=\"{line}\"><title>{title}</title></path>")?;
            let (x, y) = (px(*x), px(*y));
            writeln!(
                out,
                "<circle class=\"end-of layer-{layer}\" cx=\"{x}\" cy=\"{y}\" r=\"4\"><title>{title}</title></circle>"
            )?;
        }
    }
    Ok(taken)
}

/// The bar of the scale, and what the signs mean.
fn words(frame: &Frame, out: &mut String) -> std::fmt::Result {
    frame.bar(out)?;
    let (y, mut x) = (frame.words(), frame.width - 290.0);
    writeln!(out, "<rect class=\"depot\" x=\"{}\" y=\"{}\" width=\"9\" height=\"9\"/>", px(x), px(y - 7.0))?;
    writeln!(out, "<text class=\"small\" x=\"{}\" y=\"{}\">robot</text>", px(x + 14.0), px(y + 2.0))?;
    x += 62.0;
    writeln!(out, "<circle class=\"human\" cx=\"{}\" cy=\"{}\" r=\"5\"/>", px(x), px(y - 2.5))?;
    writeln!(out, "<text class=\"small\" x=\"{}\" y=\"{}\">person</text>", px(x + 9.0), px(y + 2.0))?;
    x += 64.0;
    writeln!(out, "<rect class=\"object\" x=\"{}\" y=\"{}\" width=\"9\" height=\"9\"/>", px(x), px(y - 7.0))?;
    writeln!(out, "<text class=\"small\" x=\"{}\" y=\"{}\">object</text>", px(x + 14.0), px(y + 2.0))?;
    x += 64.0;
    writeln!(out, "<circle class=\"end-of layer-0\" cx=\"{}\" cy=\"{}\" r=\"4\"/>", px(x), px(y - 2.5))?;
    writeln!(out, "<text class=\"small\" x=\"{}\" y=\"{}\">brought to</text>", px(x + 9.0), px(y + 2.0))
}
