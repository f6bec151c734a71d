//! A search as text, for people to review: the team, the map, the sources and their interdependence.

use std::fmt::Write;

use names::list;
use quantities::number;

use super::mission::Search;
use crate::occupancy::Cell;

use super::problem::{Boundary, Fall, Problem, Rate, Source};

/// The text of a mission with this name.
pub(super) fn text(name: &str, of: &Search) -> String {
    let mut out = String::new();
    // Writing to a String does not fail.
    let _ = write(name, &of.problem, &mut out);
    out
}

fn count(of: usize, what: &str) -> String {
    if of == 1 { format!("1 {what}") } else { format!("{of} {what}s") }
}

fn write(name: &str, p: &Problem, out: &mut String) -> std::fmt::Result {
    writeln!(out, "mission {name} : search")?;
    writeln!(
        out,
        "  {}, {}, {} on {} m2, {} s",
        count(p.agents.len(), "agent"),
        count(p.sources.len(), "source"),
        count(p.walls.len(), "wall"),
        number(super::geometry::area(&p.area)),
        number(p.horizon)
    )?;
    if let Some(map) = &p.occupancy {
        let percent = |of: Cell| number((1000.0 * map.share(of)).round() / 10.0);
        let (free, unknown) = (percent(Cell::Free), percent(Cell::Unknown));
        let cells = format!("{} by {} cells of {} m", map.columns, map.rows, number(map.resolution));
        writeln!(out, "  map {}: {cells}, {free} % free, {unknown} % unknown", map.image)?;
    }
    writeln!(out, "\n  {:<16} {:<6} {:>16} {:>10} {:>10}", "agent", "", "start, m", "speed, m/s", "radius, m")?;
    for agent in &p.agents {
        let role = if agent.human { "human" } else { "robot" };
        let [x, y] = agent.start;
        let start = format!("({}, {})", number(x), number(y));
        writeln!(
            out,
            "  {:<16} {role:<6} {start:>16} {:>10} {:>10}",
            agent.name,
            number(agent.speed),
            number(agent.radius)
        )?;
        names(
            out,
            "passes",
            agent.passes.iter().map(|wall| p.walls.get(*wall).map_or("?", |wall| wall.name.as_str())),
        )?;
        names(out, "does not know of", sources(p, &agent.unaware))?;
    }
    if !p.sources.is_empty() || p.objects.is_empty() {
        writeln!(out, "\n  {:<16} {:<12} {:>8}  boundary", "source", "set", "pool")?;
    }
    for source in &p.sources {
        let pool = source.pool.map_or("endless".into(), number);
        writeln!(out, "  {:<16} {:<12} {pool:>8}  {}", source.name, source.kind.name(), boundary(source))?;
        rate(out, "inside", &source.inside)?;
        rate(out, "outside", &source.outside)?;
        if source.targets.len() < p.agents.len() {
            let targets =
                source.targets.iter().map(|agent| p.agents.get(*agent).map_or("?", |agent| agent.name.as_str()));
            names(out, "for", targets)?;
        }
        names(out, "of", source.of.iter().map(|agent| p.agents.get(*agent).map_or("?", |agent| agent.name.as_str())))?;
        names(out, "after", sources(p, &source.after))?;
        names(out, "until", sources(p, &source.until))?;
    }
    for pair in &p.codependent {
        let [one, other] = pair.of.map(|source| p.sources.get(source).map_or("?", |source| source.name.as_str()));
        writeln!(out, "  {one} and {other} share {} of what is taken", number(pair.share))?;
    }
    objects(p, out)?;
    let planner = &p.planner;
    writeln!(
        out,
        "\n  planned with {} states, {} goals, w {}, gamma {}, seed {}",
        planner.states,
        planner.goals,
        number(planner.reduction),
        number(planner.discount),
        planner.seed
    )
}

/// Hidden objects, and those who look for them.
fn objects(p: &Problem, out: &mut String) -> std::fmt::Result {
    if p.objects.is_empty() {
        return Ok(());
    }
    writeln!(out, "\n  {:<16} {:>6} {:>8}  region", "hidden", "count", "worth")?;
    for object in &p.objects {
        let region = match object.region.len() {
            0 => "the whole ground".into(),
            corners => {
                let [x, y] = super::geometry::middle(&object.region);
                format!("polygon of {corners} corners around ({}, {}) m", number(x), number(y))
            }
        };
        writeln!(out, "  {:<16} {:>6} {:>8}  {region}", object.name, object.count, number(object.worth))?;
    }
    for agent in &p.agents {
        if let Some(sees) = agent.sees {
            writeln!(out, "    {} sees {} m far, with {} /s", agent.name, number(sees.within), number(sees.rate))?;
        }
    }
    writeln!(out, "    belief of {} cells of {} m", p.sight().len(), number(p.cell))?;
    match p.planner.window {
        Some(window) => {
            writeln!(out, "    plans look {} s ahead, from {} lookouts", number(window), p.planner.lookouts)
        }
        None => writeln!(out, "    plans look from {} lookouts", p.planner.lookouts),
    }
}

fn sources<'p>(p: &'p Problem, of: &'p [usize]) -> impl Iterator<Item = &'p str> + Clone {
    of.iter().map(|source| p.sources.get(*source).map_or("?", |source| source.name.as_str()))
}

fn names<'n>(out: &mut String, what: &str, of: impl Iterator<Item = &'n str> + Clone) -> std::fmt::Result {
    if of.clone().next().is_none() {
        return Ok(());
    }
    writeln!(out, "    {what} {}", list(of, 64))
}

fn boundary(source: &Source) -> String {
    let point = |p: &[f64; 2]| format!("({}, {})", number(p[0]), number(p[1]));
    match &source.boundary {
        Boundary::Polygon(points) => {
            format!("polygon of {} corners around {}", points.len(), point(&super::geometry::middle(points)))
        }
        Boundary::Circle { centre, radius } => {
            format!("circle around {} m, radius {} m", point(centre), number(*radius))
        }
        Boundary::Line(points) => {
            format!("line of {} points around {} m", points.len(), point(&super::geometry::middle(points)))
        }
        Boundary::Points(points) => match &points[..] {
            [only] => format!("{} m", point(only)),
            all => format!("{} points", all.len()),
        },
        Boundary::Speed([low, high]) => format!("speeds from {} to {} m/s", number(*low), number(*high)),
        Boundary::Heading([low, high]) => {
            format!("headings from {} to {} deg", number(low.to_degrees()), number(high.to_degrees()))
        }
    }
}

fn rate(out: &mut String, side: &str, of: &Rate) -> std::fmt::Result {
    if of.is_zero() {
        return Ok(());
    }
    match &of.function {
        None => write!(out, "    {side} {} /s", number(of.peak))?,
        Some(function) => write!(out, "    {side} {}", function.of.text)?,
    }
    match of.fall {
        Fall::Constant => writeln!(out),
        fall => writeln!(out, ", {} over {} m", fall.name(), number(of.scale)),
    }
}
