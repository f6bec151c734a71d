//! The map of a schedule: depots, places, where robots wait, and the ways between them that a plan uses.

use std::collections::BTreeSet;
use std::fmt::Write;

use mission::plan::{Actor, Phase, Plan};
use mission::schedule::problem::{AgentKind, Problem};

use crate::xml::escaped;

use super::px;
use super::svg::{head, shortened};

/// Where robots are now, and how the map is drawn.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Standing {
    /// Position of each robot (m), in the problem's order; empty: they are not drawn.
    pub robots: Vec<[f64; 2]>,
    /// With rules of style of its own; a page that has [`super::STYLE`] needs none.
    pub styled: bool,
}

const SIDE: f64 = 560.0;
const MARGIN: f64 = 46.0;
const CHARACTER: f64 = 6.6;
const LONGEST: usize = 18;

/// The map as SVG, x to the right and y upwards in one scale. Ways from a depot to the waiting place are thin, those near a
/// person thick; ways that the plan does not use are not drawn. The group `robots` carries what a page needs to move them:
/// `data-x`, `data-y` (px) of the origin and `data-scale` (px/m).
pub fn map(problem: &Problem, plan: &Plan, standing: &Standing) -> String {
    let frame = Frame::of(problem, &standing.robots);
    let mut out = String::new();
    // Writing to a String does not fail.
    let _ = write(problem, plan, standing, &frame, &mut out);
    out
}

/// From metres to pixels.
struct Frame {
    left: f64,
    top: f64,
    scale: f64,
    width: f64,
    height: f64,
}

impl Frame {
    fn of(problem: &Problem, robots: &[[f64; 2]]) -> Frame {
        let depots = problem.robots.iter().map(|robot| robot.depot);
        let points = depots.chain(problem.agents.iter().map(|agent| agent.place)).chain(robots.iter().copied());
        let finite = points.filter(|p| p.iter().all(|x| x.abs() < 1e9));
        let none = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        let [x0, y0, x1, y1] = finite.fold(none, |b, [x, y]| [b[0].min(x), b[1].min(y), b[2].max(x), b[3].max(y)]);
        let [x0, y0, x1, y1] = if x0.is_finite() { [x0, y0, x1, y1] } else { [0.0, 0.0, 1.0, 1.0] };
        let scale = (SIDE / (x1 - x0).max(y1 - y0).max(1.0)).min(200.0);
        let (width, height) = (2.0 * MARGIN + scale * (x1 - x0), 2.0 * MARGIN + scale * (y1 - y0));
        // Room for the words below and for the longest name beside a point at the border.
        let wide = width.max(420.0);
        Frame {
            left: 0.5 * (wide - width) + MARGIN - scale * x0,
            top: MARGIN + scale * y1,
            scale,
            width: wide,
            height: height + 28.0,
        }
    }

    fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let clamp = |v: f64, most: f64| if v.is_finite() { v.clamp(0.0, most) } else { 0.0 };
        [clamp(self.left + self.scale * x, self.width), clamp(self.top - self.scale * y, self.height)]
    }
}

fn write(problem: &Problem, plan: &Plan, standing: &Standing, frame: &Frame, out: &mut String) -> std::fmt::Result {
    head(frame.width, frame.height, "map: depots, places and ways", standing.styled, out)?;
    ways(problem, plan, frame, out)?;
    let mut names = Names { taken: Vec::new(), frame };
    for robot in &problem.robots {
        names.keep_clear(frame.at(robot.depot));
    }
    for agent in &problem.agents {
        names.keep_clear(frame.at(agent.place));
    }
    for robot in &problem.robots {
        let [x, y] = frame.at(robot.depot);
        let title = escaped(&format!("depot of {}", robot.name));
        writeln!(
            out,
            "<rect class=\"depot\" x=\"{}\" y=\"{}\" width=\"11\" height=\"11\"><title>{title}</title></rect>",
            px(x - 5.5),
            px(y - 5.5)
        )?;
        names.write([x, y], &robot.name, out)?;
    }
    for agent in &problem.agents {
        let [x, y] = frame.at(agent.place);
        let title = escaped(&agent.name);
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
        names.write([x, y], &agent.name, out)?;
    }
    robots(problem, standing, frame, out)?;
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
        let between = escaped(&format!("{} serves {}", robot.name, agent.name));
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

fn robots(problem: &Problem, standing: &Standing, frame: &Frame, out: &mut String) -> std::fmt::Result {
    writeln!(
        out,
        "<g class=\"robots\" data-x=\"{}\" data-y=\"{}\" data-scale=\"{:.4}\">",
        px(frame.left),
        px(frame.top),
        frame.scale
    )?;
    for (robot, position) in problem.robots.iter().zip(&standing.robots) {
        let [x, y] = frame.at(*position);
        let name = escaped(&shortened(&robot.name, LONGEST));
        writeln!(
            out,
            "<g transform=\"translate({} {})\"><path class=\"robot\" d=\"M0 -8 L8 0 L0 8 L-8 0 z\"/>\
             <text class=\"small middle\" y=\"-11\">{name}</text></g>",
            px(x),
            px(y)
        )?;
    }
    writeln!(out, "</g>")
}

/// The bar of the scale, and what the signs mean.
fn words(frame: &Frame, out: &mut String) -> std::fmt::Result {
    let rough = 90.0 / frame.scale;
    let power = 10f64.powi(rough.log10().floor() as i32);
    let length = [5.0, 2.0, 1.0].into_iter().map(|of| of * power).find(|length| *length <= rough).unwrap_or(power);
    let (y, width) = (frame.height - 12.0, frame.scale * length);
    writeln!(out, "<path class=\"scale\" d=\"M10 {} v5 h{} v-5\"/>", px(y - 5.0), px(width))?;
    writeln!(out, "<text class=\"small\" x=\"{}\" y=\"{}\">{length} m</text>", px(16.0 + width), px(y + 2.0))?;
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

/// Names beside points, none over another where a free side is left.
struct Names<'f> {
    taken: Vec<[f64; 4]>,
    frame: &'f Frame,
}

impl Names<'_> {
    fn keep_clear(&mut self, [x, y]: [f64; 2]) {
        self.taken.push([x - 7.0, y - 7.0, x + 7.0, y + 7.0]);
    }

    fn write(&mut self, [x, y]: [f64; 2], name: &str, out: &mut String) -> std::fmt::Result {
        let name = shortened(name, LONGEST);
        let width = CHARACTER * name.chars().count() as f64;
        let boxed = |left: f64, base: f64| [left, base - 10.0, left + width, base + 3.0];
        let sides = [
            (x + 10.0, y + 4.0),
            (x - 10.0 - width, y + 4.0),
            (x - 0.5 * width, y - 12.0),
            (x - 0.5 * width, y + 21.0),
        ];
        let free = |b: &[f64; 4]| {
            let inside = b[0] >= 0.0 && b[2] <= self.frame.width && b[1] >= 0.0;
            let apart = |t: &[f64; 4]| b[2] <= t[0] || t[2] <= b[0] || b[3] <= t[1] || t[3] <= b[1];
            inside && self.taken.iter().all(apart)
        };
        let (left, base) = sides.into_iter().find(|(left, base)| free(&boxed(*left, *base))).unwrap_or(sides[0]);
        self.taken.push(boxed(left, base));
        writeln!(out, "<text class=\"small name\" x=\"{}\" y=\"{}\">{}</text>", px(left), px(base), escaped(&name))
    }
}
