//! The map of an exploration: the region with its obstacles, targets and the exit, and the ways of everybody.

use crate::map::{Line, Map, Region, Shape, Sign};

use super::chart::label;
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

/// The map with these ways; `taken` says who has taken or takes each target, and `places` where everybody is.
pub(super) fn map(problem: &Problem, ways: &[Way], taken: &[Option<usize>], places: &[Point]) -> Map {
    let corners = |of: &super::polygon::Convex| of.corners().to_vec();
    let region =
        |region: Region, corners: Vec<Point>, title: String| Shape::Region { region, corners, title: Some(title) };
    let mut shapes = vec![region(Region::Ground, corners(&problem.area), "area".into())];
    shapes.push(region(Region::Unknown, corners(&problem.exit), "exit".into()));
    for obstacle in &problem.obstacles {
        let title = problem.labels.member(&obstacle.name).to_string();
        shapes.push(region(Region::Solid, corners(&obstacle.shape), title));
    }
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
    for (member, at) in places.iter().enumerate() {
        let sign = if member < problem.robots.len() { Sign::Base } else { Sign::Person };
        shapes.push(Shape::sign(sign, *at, label(problem, member).to_string()));
        clear.push(*at);
        names.push(Shape::Name { at: *at, text: label(problem, member).to_string() });
    }
    shapes.extend(names);
    Map {
        title: "map: targets, and the ways of the robots and of the person",
        most_scale: 100.0,
        extent: problem.area.corners().iter().chain(&clear).copied().collect(),
        clear,
        shapes,
        robots: (0..=problem.robots.len()).map(|member| label(problem, member).to_string()).collect(),
        legend: vec![(Sign::Base, "robot"), (Sign::Person, "person")],
    }
}
