//! The map of a schedule: depots, places, where robots wait, and the ways between them that a plan uses.

use std::collections::BTreeSet;
use std::fmt::Write;

use mission::kinds::schedule::problem::{AgentKind, Problem};
use mission::plan::{Actor, Phase, Plan};

use crate::xml::escaped;

use super::frame::{Frame, Names};
use super::px;
use super::svg::head;

/// Where robots, or hands, are now, and how the map is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Standing {
    /// Position of each robot, or of its hand (m), in the problem's order; empty: they are not drawn.
    pub robots: Vec<[f64; 2]>,
    /// With rules of style of its own; a page that has [`super::STYLE`] needs none.
    pub styled: bool,
}

/// Pixels of a metre at the most.
const MOST_SCALE: f64 = 200.0;

/// The map as SVG, x to the right and y upwards in one scale. Ways from a depot to the waiting place are thin, those near a
/// person thick; ways that the plan does not use are not drawn. The group `robots` carries what a page needs to move them:
/// `data-x`, `data-y` (px) of the origin and `data-scale` (px/m).
pub fn map(problem: &Problem, plan: &Plan, standing: &Standing) -> String {
    let places = problem.robots.iter().map(|robot| robot.depot).chain(problem.agents.iter().map(|agent| agent.place));
    let frame = Frame::of(places.chain(standing.robots.iter().copied()), MOST_SCALE);
    let mut out = String::new();
    // Writing to a String does not fail.
    let _ = write(problem, plan, standing, &frame, &mut out);
    out
}

fn write(problem: &Problem, plan: &Plan, standing: &Standing, frame: &Frame, out: &mut String) -> std::fmt::Result {
    head(frame.width, frame.height, "map: depots, places and ways", standing.styled, out)?;
    ways(problem, plan, frame, out)?;
    let mut names = Names::new(frame);
    for robot in &problem.robots {
        names.keep_clear(frame.at(robot.depot));
    }
    for agent in &problem.agents {
        names.keep_clear(frame.at(agent.place));
    }
    for robot in &problem.robots {
        let [x, y] = frame.at(robot.depot);
        let title = escaped(&format!("depot of {}", problem.labels.member(&robot.name)));
        writeln!(
            out,
            "<rect class=\"depot\" x=\"{}\" y=\"{}\" width=\"11\" height=\"11\"><title>{title}</title></rect>",
            px(x - 5.5),
            px(y - 5.5)
        )?;
        names.write([x, y], problem.labels.member(&robot.name), out)?;
    }
    for agent in &problem.agents {
        let [x, y] = frame.at(agent.place);
        let title = escaped(problem.labels.member(&agent.name));
        match agent.kind {
            AgentKind::Human => writeln!(
                out,
                "<circle class=\"human\" cx=\"{}\" cy=\"{}\" r=\"6\"><title>{title}</title></circle>",
                px(x),
                px(y)
            )?,
            AgentKind::Worker => writeln!(
                out,
                "<path class=\"worker\" d=\"M{} {} l7 12 h-14 z\"><title>{title}</title></path>",
                px(x),
                px(y - 7.0)
            )?,
        }
        names.write([x, y], problem.labels.member(&agent.name), out)?;
    }
    let robots = problem.robots.iter().map(|robot| problem.labels.member(&robot.name));
    frame.moving(robots.zip(standing.robots.iter().copied()), out)?;
    words(frame, out)?;
    writeln!(out, "</svg>")
}

/// The ways of the plan, each once, and where robots wait on them.
fn ways(problem: &Problem, plan: &Plan, frame: &Frame, out: &mut String) -> std::fmt::Result {
    let serving = plan.activities.iter().filter(|activity| activity.phase == Phase::Serving);
    let pairs: BTreeSet<(usize, usize)> = serving
        .filter_map(|activity| match activity.actor {
            Actor::Robot(robot) => Some((robot, activity.target.agent)),
            Actor::Agent(_) => None,
        })
        .collect();
    let mut stops = Vec::new();
    for (m, a) in pairs {
        let (Some(robot), Some(agent)) = (problem.robots.get(m), problem.agents.get(a)) else { continue };
        let (depot, place) = (frame.at(robot.depot), frame.at(agent.place));
        let stop = problem.waiting_place(a, m).map_or(place, |stop| frame.at(stop));
        let between =
            escaped(&format!("{} serves {}", problem.labels.member(&robot.name), problem.labels.member(&agent.name)));
        for (class, [ax, ay], [bx, by]) in [("way", depot, stop), ("near", stop, place)] {
            writeln!(
                out,
                "<path class=\"{class}\" d=\"M{} {} L{} {}\"><title>{between}</title></path>",
                px(ax),
                px(ay),
                px(bx),
                px(by)
            )?;
        }
        stops.push(stop);
    }
    for [x, y] in stops {
        writeln!(out, "<circle class=\"stop\" cx=\"{}\" cy=\"{}\" r=\"3.5\"/>", px(x), px(y))?;
    }
    Ok(())
}

/// The bar of the scale, and what the signs mean.
fn words(frame: &Frame, out: &mut String) -> std::fmt::Result {
    frame.bar(out)?;
    let y = frame.words();
    let mut x = frame.width - 290.0;
    writeln!(out, "<rect class=\"depot\" x=\"{}\" y=\"{}\" width=\"9\" height=\"9\"/>", px(x), px(y - 7.0))?;
    writeln!(out, "<text class=\"small\" x=\"{}\" y=\"{}\">depot</text>", px(x + 14.0), px(y + 2.0))?;
    x += 62.0;
    writeln!(out, "<circle class=\"human\" cx=\"{}\" cy=\"{}\" r=\"5\"/>", px(x), px(y - 2.5))?;
    writeln!(out, "<text class=\"small\" x=\"{}\" y=\"{}\">person</text>", px(x + 9.0), px(y + 2.0))?;
    x += 64.0;
    writeln!(out, "<path class=\"worker\" d=\"M{} {} l6 10 h-12 z\"/>", px(x), px(y - 8.0))?;
    writeln!(out, "<text class=\"small\" x=\"{}\" y=\"{}\">worker</text>", px(x + 10.0), px(y + 2.0))?;
    x += 64.0;
    writeln!(out, "<circle class=\"stop\" cx=\"{}\" cy=\"{}\" r=\"3.5\"/>", px(x), px(y - 2.5))?;
    writeln!(out, "<text class=\"small\" x=\"{}\" y=\"{}\">robot waits</text>", px(x + 8.0), px(y + 2.0))
}
