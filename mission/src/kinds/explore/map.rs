//! The map of an exploration: the region with its obstacles, targets and the exit, and the ways of everybody.

use crate::map::{Line, Map, Moving, Region, Shade, Shape, Sign};

use super::chart::label;
use super::foresight::{Covariance, Foresight};
use super::polygon::Point;
use super::problem::Problem;

/// A way to be drawn.
pub(super) struct Way {
    /// Robots, and then the person.
    pub member: usize,
    /// Its points (m).
    pub points: Vec<Point>,
    /// It is expected, and not walked yet.
    pub expected: bool,
}

/// Corners of the ellipses of standard deviations.
const CORNERS: usize = 24;
/// Standard deviations (m) along the shorter axis below which an ellipse is not seen; it gets this axis then.
const LEAST: f64 = 0.02;

/// The ellipse of one standard deviation about a position (m); none: there is hardly a doubt.
fn ellipse(at: Point, [[xx, xy], [_, yy]]: Covariance) -> Option<Vec<Point>> {
    // Eigenvalues and the direction of the first one.
    let (middle, half) = (0.5 * (xx + yy), 0.5 * (xx - yy).hypot(2.0 * xy));
    let long = (middle + half).max(0.0).sqrt();
    if !long.is_finite() || long < 2.0 * LEAST {
        return None;
    }
    let short = (middle - half).max(0.0).sqrt().max(LEAST);
    let (sin, cos) = (0.5 * (2.0 * xy).atan2(xx - yy)).sin_cos();
    let corner = |index: usize| {
        let (y, x) = (std::f64::consts::TAU * index as f64 / CORNERS as f64).sin_cos();
        let (along, across) = (long * x, short * y);
        [at[0] + cos * along - sin * across, at[1] + sin * along + cos * across]
    };
    Some((0..CORNERS).map(corner).collect())
}

/// Ellipses of the doubt about where the person will be.
pub(super) fn doubts(foresight: &Foresight, from: usize) -> Vec<Shape> {
    let all = foresight.positions.iter().zip(&foresight.spread).enumerate().skip(from);
    let of = |(step, (at, covariance)): (usize, (&Point, &Covariance))| {
        let title = format!("standard deviation of the expected position, {} periods ahead", step - from);
        let corners = ellipse(*at, *covariance)?;
        Some(Shape::Region { region: Region::Belief(Shade::Faint), corners, title: Some(title) })
    };
    all.filter_map(of).collect()
}

/// The map with these ways; `taken` says who has taken or takes each target. `places` says where everybody is on a map of one moment; without
/// them the members are those that move on it.
pub(super) fn map(
    problem: &Problem,
    ways: &[Way],
    doubts: Vec<Shape>,
    taken: &[Option<usize>],
    places: Option<&[Point]>,
) -> Map {
    let corners = |of: &super::polygon::Convex| of.corners().to_vec();
    let region =
        |region: Region, corners: Vec<Point>, title: String| Shape::Region { region, corners, title: Some(title) };
    let mut shapes = vec![region(Region::Ground, corners(&problem.area), "area".into())];
    shapes.push(region(Region::Unknown, corners(&problem.exit), "exit".into()));
    for obstacle in &problem.obstacles {
        let title = problem.labels.member(&obstacle.name).to_string();
        shapes.push(region(Region::Solid, corners(&obstacle.shape), title));
    }
    shapes.extend(doubts);
    let (mut names, mut clear) = (Vec::new(), Vec::new());
    for (index, target) in problem.targets.iter().enumerate() {
        let name = problem.target_label(index);
        let (title, by) = match taken.get(index).copied().flatten() {
            Some(member) => {
                (format!("{name}, type {}, by {}", problem.types[target.of], label(problem, member)), Some(member))
            }
            None => (format!("{name}, type {}, left", problem.types[target.of]), None),
        };
        shapes.push(region(Region::Attracts, corners(&target.shape), title.clone()));
        shapes.push(Shape::sign(Sign::Object(by), target.shape.middle(), title));
        clear.push(target.shape.middle());
        names.push(Shape::Name { at: target.shape.middle(), text: name.to_string() });
    }
    for way in ways.iter().filter(|way| way.points.len() > 1) {
        let title = match way.expected {
            true => format!("{}, as planned", label(problem, way.member)),
            false => format!("{} so far", label(problem, way.member)),
        };
        let line = if way.expected { Line::Considered } else { Line::Carry(way.member) };
        shapes.push(Shape::Line { line, points: way.points.clone(), title: Some(title) });
    }
    for (member, at) in places.into_iter().flatten().enumerate() {
        let sign = if member < problem.robots.len() { Sign::Base } else { Sign::Person };
        shapes.push(Shape::sign(sign, *at, label(problem, member).to_string()));
        clear.push(*at);
        names.push(Shape::Name { at: *at, text: label(problem, member).to_string() });
    }
    shapes.extend(names);
    let moving =
        |member: usize| Moving { label: label(problem, member).to_string(), is_person: member == problem.robots.len() };
    Map {
        title: "map: targets, and the ways of the robots and of the person",
        most_scale: 100.0,
        extent: problem.area.corners().iter().chain(&clear).copied().collect(),
        clear,
        shapes,
        moving: if places.is_some() { Vec::new() } else { (0..=problem.robots.len()).map(moving).collect() },
        legend: vec![(Sign::Base, "robot"), (Sign::Person, "person")],
    }
}
