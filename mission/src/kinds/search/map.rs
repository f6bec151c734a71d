//! The map of a search: the area with its walls, the boundaries of sources, and the ways of the agents.

use crate::map::{Line, Map, Region, Shape, Sign};
use crate::occupancy::Cell;

use super::belief::weights;
use super::geometry::Point;
use super::plan::{Activity, Phase};
use super::problem::{Boundary, Problem, Source, SourceKind};

/// Corners of a circle.
const CORNERS: usize = 32;
/// The most rectangles of the cells of a map, about 30 bytes each in a drawing.
const MOST_RECTANGLES: usize = 3_000;

/// The map of activities.
pub fn map(problem: &Problem, activities: &[Activity]) -> Map {
    let mut shapes = vec![Shape::Region { region: Region::Ground, corners: problem.area.clone(), title: None }];
    if let Some(map) = &problem.occupancy {
        for (cell, region) in [(Cell::Unknown, Region::Unknown), (Cell::Occupied, Region::Solid)] {
            let rectangles = map.rectangles(cell, MOST_RECTANGLES);
            if !rectangles.is_empty() {
                let title = Some(format!("{} in {}", cell.name(), map.image));
                shapes.push(Shape::Regions { region, rectangles, title });
            }
        }
    }
    belief(problem, &mut shapes);
    for wall in &problem.walls {
        let title = Some(problem.labels.member(&wall.name).to_string());
        shapes.push(match wall.solid {
            true => Shape::Region { region: Region::Solid, corners: wall.points.clone(), title },
            false => Shape::Line { line: Line::Wall, points: wall.points.clone(), title },
        });
    }
    let mut clear = Vec::new();
    let mut names = Vec::new();
    for (index, source) in problem.sources.iter().enumerate() {
        // Sources of actions have no place, and those of interactions move.
        if matches!(source.kind, SourceKind::Action | SourceKind::Interaction) {
            continue;
        }
        let label = problem.source_label(index).to_string();
        let at = draw(source, &label, &mut shapes);
        clear.push(at);
        names.push(Shape::Name { at, text: label });
    }
    for activity in activities.iter().filter(|activity| activity.phase == Phase::Going && activity.way.len() > 1) {
        let source = activity.source.map_or("a place", |source| problem.source_label(source));
        let title = Some(format!("{} to {source}", problem.agent_label(activity.agent)));
        shapes.push(Shape::Line { line: Line::Carry(activity.agent), points: activity.way.clone(), title });
    }
    for (index, agent) in problem.agents.iter().enumerate() {
        let sign = if agent.human { Sign::Person } else { Sign::Base };
        let label = problem.agent_label(index).to_string();
        shapes.push(Shape::sign(sign, agent.start, label.clone()));
        if let Some(told) = agent.told {
            shapes.push(Shape::sign(Sign::Target(index), told, format!("goal told for {label}")));
            clear.push(told);
        }
        clear.push(agent.start);
        names.push(Shape::Name { at: agent.start, text: label });
    }
    shapes.extend(names);
    Map {
        title: "map: sources of reward, and the ways of the agents",
        most_scale: 100.0,
        extent: problem.area.iter().chain(&clear).copied().collect(),
        clear,
        shapes,
        robots: (0..problem.agents.len()).map(|agent| problem.agent_label(agent).to_string()).collect(),
        legend: vec![(Sign::Base, "robot"), (Sign::Person, "person")],
    }
}

/// Draws the belief about hidden objects: cells in four shades, by their weight relative to the heaviest one.
fn belief(problem: &Problem, shapes: &mut Vec<Shape>) {
    if !problem.is_searching() {
        return;
    }
    let sight = problem.sight();
    let weights = weights(problem, &sight);
    let most = weights.iter().copied().fold(0.0, f64::max);
    let shades = [Region::Faint, Region::Light, Region::Medium, Region::Strong];
    for (level, region) in shades.into_iter().enumerate() {
        let (low, high) = (0.25 * level as f64, 0.25 * (level + 1) as f64);
        let is_in = |weight: f64| {
            let share = weight / most;
            // Cells in which next to nothing is left stay blank.
            share > low.max(0.02) && (share <= high || level == 3)
        };
        let cells = (0..sight.len()).filter(|cell| is_in(weights[*cell]));
        let rectangles: Vec<[Point; 4]> = cells.map(|cell| sight.corners(cell)).collect();
        if !rectangles.is_empty() {
            let title = format!("belief of {} to {} % of the highest", 25 * level, 25 * (level + 1));
            shapes.push(Shape::Regions { region, rectangles, title: Some(title) });
        }
    }
}

/// Draws a source; returns the place of its name.
fn draw(source: &Source, label: &str, shapes: &mut Vec<Shape>) -> Point {
    let region = if source.attracts() { Region::Attracts } else { Region::Repels };
    let title = Some(label.to_string());
    let corners = match &source.boundary {
        Boundary::Polygon(points) => points.clone(),
        Boundary::Circle { centre, radius } => circle(*centre, *radius),
        Boundary::Line(points) => {
            shapes.push(Shape::Line { line: Line::Near, points: points.clone(), title });
            return points.first().copied().unwrap_or_default();
        }
        Boundary::Points(points) => {
            let signs = points.iter().map(|at| Shape::sign(Sign::Stop, *at, label.to_string()));
            shapes.extend(signs);
            return points.first().copied().unwrap_or_default();
        }
        Boundary::Speed(_) => return Point::default(),
    };
    let at = super::geometry::middle(&corners);
    shapes.push(Shape::Region { region, corners, title });
    at
}

fn circle(centre: Point, radius: f64) -> Vec<Point> {
    let corner = |i: usize| {
        let (sin, cos) = (std::f64::consts::TAU * i as f64 / CORNERS as f64).sin_cos();
        [centre[0] + radius * cos, centre[1] + radius * sin]
    };
    (0..CORNERS).map(corner).collect()
}
