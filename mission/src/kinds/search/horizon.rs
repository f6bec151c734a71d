//! Warning about a search whose horizon ends before anything can be reached.

use quantities::number;

use super::check::Item;
use super::geometry::Point;
use super::problem::{Boundary, Problem, Source, SourceKind};
use crate::declare::{Origins, Remark, Remarks};

/// Warns of a horizon that is shorter than the straight way of every agent to every source that it may consume.
pub(super) fn add(problem: &Problem, places: &Origins<Item>, remarks: &mut Remarks) {
    let attracting: Vec<usize> = (0..problem.sources.len()).filter(|&s| problem.sources[s].attracts()).collect();
    // An agent may look for hidden objects anywhere.
    if attracting.is_empty() || !problem.objects.is_empty() {
        return;
    }
    let mut nearest: Option<(f64, usize, usize)> = None;
    for &s in &attracting {
        for (a, agent) in problem.agents.iter().enumerate().filter(|(a, _)| problem.consumes(*a, s)) {
            let time = least_distance(&problem.sources[s], agent.start) / agent.speed;
            if nearest.is_none_or(|n| time < n.0) {
                nearest = Some((time, s, a));
            }
        }
    }
    let Some((time, s, a)) = nearest.filter(|n| n.0 > problem.horizon) else { return };
    let (source, agent) = (&problem.sources[s], &problem.agents[a]);
    let text = format!("no source is reached within {} s", number(problem.horizon));
    remarks.push(
        Remark::warning("HQ0957", places.of(Item::Mission, &["horizon"]), text)
            .label(places.of(Item::Source(s), &["at", "polygon"]), "this is the nearest one")
            .note(format!(
                "the straight way of `{}` to `{}` takes {} s, so a plan within the horizon collects nothing",
                agent.name,
                source.name,
                number((10.0 * time).round() / 10.0)
            ))
            .help("write a longer `horizon`, or check the places and speeds"),
    );
}

/// Lower bound of the distance (m) from a point to where a source is rewarding; zero where none is known.
fn least_distance(source: &Source, from: Point) -> f64 {
    if source.outside.range()[1] > 0.0 || matches!(source.kind, SourceKind::Action | SourceKind::Interaction) {
        return 0.0;
    }
    match &source.boundary {
        Boundary::Circle { centre, radius } => (f64::hypot(centre[0] - from[0], centre[1] - from[1]) - radius).max(0.0),
        Boundary::Polygon(corners) => {
            let beyond = |axis: usize| {
                let all = || corners.iter().map(|c| c[axis]);
                let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
                (low - from[axis]).max(from[axis] - high).max(0.0)
            };
            f64::hypot(beyond(0), beyond(1))
        }
        _ => 0.0,
    }
}
