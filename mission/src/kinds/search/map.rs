//! The map of a search: the area with its walls, the boundaries of sources, and the ways of the agents.

use crate::map::{Line, Map, Moving, Region, Shade, Shape, Sign};
use crate::occupancy::Cell;
use crate::parallel;

use super::belief::weights;
use super::geometry::{Point, bounds, inside};
use super::plan::{Activity, Phase};
use super::problem::{Agent, Boundary, Problem, Source, SourceKind};
use super::ways::ActionSets;

/// Corners of a circle.
const CORNERS: usize = 32;
/// The most rectangles of the cells of a map, about 30 bytes each in a drawing.
const MOST_RECTANGLES: usize = 3_000;

/// Cells of the reward field along the longer side of the ground.
const FIELD_CELLS: f64 = 60.0;
/// The most ways that were considered and are drawn.
const MOST_CONSIDERED: usize = 400;

/// The map of a plan: that of its activities, and the ways from the starts that its action sets have, branches of the trees.
pub fn map_of_plan(problem: &Problem, activities: &[Activity]) -> Map {
    let mut map = map(problem, activities);
    let sets = ActionSets::new(problem, parallel::threads());
    let ways = sets.of.iter().flat_map(|set| (1..set.spots.len()).filter_map(|spot| set.way(0, spot)));
    let lines = ways.take(MOST_CONSIDERED).map(|way| Shape::Line {
        line: Line::Considered,
        points: way.points.clone(),
        title: None,
    });
    // Below the ways of the plan.
    let first = map.shapes.iter().position(|shape| matches!(shape, Shape::Line { line: Line::Carry(_), .. }));
    let first = first.unwrap_or(map.shapes.len());
    map.shapes.splice(first..first, lines);
    map
}

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
    field(problem, &mut shapes);
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
    let moving = |(index, agent): (usize, &Agent)| Moving {
        label: problem.agent_label(index).to_string(),
        is_person: agent.human,
    };
    Map {
        title: "map: sources of reward, and the ways of the agents",
        most_scale: 100.0,
        extent: problem.area.iter().chain(&clear).copied().collect(),
        clear,
        shapes,
        moving: problem.agents.iter().enumerate().map(moving).collect(),
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
    for shade in Shade::ALL {
        let cells = (0..sight.len()).filter(|cell| Shade::of(weights[*cell] / most) == Some(shade));
        let rectangles: Vec<[Point; 4]> = cells.map(|cell| sight.corners(cell)).collect();
        if !rectangles.is_empty() {
            let high = shade.percent();
            let title = format!("belief of {} to {high} % of the highest", high - 25);
            shapes.push(Shape::Regions { region: Region::Belief(shade), rectangles, title: Some(title) });
        }
    }
}

/// Draws the reward field around sources: in each cell the sum of the rates of those outside of whose boundaries it is.
fn field(problem: &Problem, shapes: &mut Vec<Shape>) {
    let reaches = |source: &&Source| {
        matches!(source.kind, SourceKind::Environment | SourceKind::Task) && !source.outside.is_zero()
    };
    let sources: Vec<&Source> = problem.sources.iter().filter(reaches).collect();
    let [low, high] = bounds(problem.area.iter().copied());
    let width = (high[0] - low[0]).max(high[1] - low[1]) / FIELD_CELLS;
    if sources.is_empty() || !width.is_finite() || width <= 0.0 {
        return;
    }
    let [columns, rows] = [0, 1].map(|axis| ((high[axis] - low[axis]) / width).ceil() as usize);
    let mut cells: Vec<(f64, [Point; 4])> = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let at = |i: f64, j: f64| [low[0] + (column as f64 + i) * width, low[1] + (row as f64 + j) * width];
            let middle = at(0.5, 0.5);
            if inside(middle, &problem.area) {
                let outside = sources.iter().filter(|source| !source.boundary.side(middle).inside);
                let rate = outside.map(|source| source.rate(middle)).sum();
                cells.push((rate, [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)]));
            }
        }
    }
    let most = cells.iter().map(|(rate, _)| rate.abs()).fold(0.0, f64::max);
    for (sign, name) in [(1.0, "attracts"), (-1.0, "repels")] {
        for shade in Shade::ALL {
            let own = cells.iter().filter(|(rate, _)| Shade::of(sign * rate / most) == Some(shade));
            let rectangles: Vec<[Point; 4]> = own.map(|(_, corners)| *corners).collect();
            if !rectangles.is_empty() {
                let region = if sign > 0.0 { Region::AttractsNear(shade) } else { Region::RepelsNear(shade) };
                let high = 0.01 * shade.percent() as f64 * most;
                let title = format!("{name} with up to {high:.2} /s");
                shapes.push(Shape::Regions { region, rectangles, title: Some(title) });
            }
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
        Boundary::Speed(_) | Boundary::Heading(_) => return Point::default(),
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
