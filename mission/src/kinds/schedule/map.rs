//! The map of a schedule: depots, places, waiting places, and the paths between them that a plan uses.

use std::collections::BTreeSet;

use super::plan::{Actor, Phase, Plan};
use crate::map::{Line, Map, Moving, Shape, Sign};

use super::problem::{AgentKind, Problem};

/// The map of a plan. Paths that the plan does not use are left out.
pub fn map(problem: &Problem, plan: &Plan) -> Map {
    let label = |name: &str| problem.labels.member(name).to_string();
    let depots = problem.robots.iter().map(|robot| robot.depot);
    let places: Vec<[f64; 2]> = depots.chain(problem.agents.iter().map(|agent| agent.place)).collect();
    let mut shapes = paths(problem, plan);
    for robot in &problem.robots {
        shapes.push(Shape::sign(Sign::Base, robot.depot, format!("depot of {}", label(&robot.name))));
        shapes.push(Shape::Name { at: robot.depot, text: label(&robot.name) });
    }
    for agent in &problem.agents {
        let sign = match agent.kind {
            AgentKind::Human => Sign::Person,
            AgentKind::Worker => Sign::Worker,
        };
        shapes.push(Shape::sign(sign, agent.place, label(&agent.name)));
        shapes.push(Shape::Name { at: agent.place, text: label(&agent.name) });
    }
    Map {
        title: "map: depots, places and ways",
        most_scale: 200.0,
        extent: places.clone(),
        clear: places,
        shapes,
        moving: problem.robots.iter().map(|robot| Moving::robot(label(&robot.name))).collect(),
        legend: vec![
            (Sign::Base, "depot"),
            (Sign::Person, "person"),
            (Sign::Worker, "worker"),
            (Sign::Stop, "robot waits"),
        ],
    }
}

/// The paths of the plan, each once, and the waiting places on them.
fn paths(problem: &Problem, plan: &Plan) -> Vec<Shape> {
    let serving = plan.activities.iter().filter(|activity| activity.phase == Phase::Serving);
    let pairs: BTreeSet<(usize, usize)> = serving
        .filter_map(|activity| match activity.actor {
            Actor::Robot(robot) => Some((robot, activity.target.agent)),
            Actor::Agent(_) => None,
        })
        .collect();
    let (mut shapes, mut stops) = (Vec::new(), Vec::new());
    for (m, a) in pairs {
        let (Some(robot), Some(agent)) = (problem.robots.get(m), problem.agents.get(a)) else { continue };
        let stop = problem.waiting_place(a, m).unwrap_or(agent.place);
        let title = format!("{} serves {}", problem.labels.member(&robot.name), problem.labels.member(&agent.name));
        for (line, from, to) in [(Line::Path, robot.depot, stop), (Line::Near, stop, agent.place)] {
            shapes.push(Shape::Line { line, points: vec![from, to], title: Some(title.clone()) });
        }
        stops.push(Shape::Sign { sign: Sign::Stop, at: stop, title: None });
    }
    shapes.extend(stops);
    shapes
}
