//! Mistakes about hidden objects: nobody who sees them, regions and places where none can be, parts of a region that stay unseen.

use blocks::{Help, Snippet};

use super::belief::prior;
use super::check::{Item, Mistake};
use super::geometry::{Point, area, crosses_itself};
use super::ground::{Body, Ground};
use super::problem::{MAX_OBJECTS, Problem};
use super::sight::{MAX_CELLS, raster_of};
use crate::numbers::MAX_NUMBER;

/// The most places of the raster of a belief, those in walls and outside the area included.
const MAX_RASTER: usize = 16 * MAX_CELLS;
/// Share of a region that may stay unseen without a warning: corners of rooms that no middle of a cell sees.
pub(super) const UNSEEN: f64 = 0.02;

/// A detection model, as an example.
fn sees() -> Snippet {
    Snippet::block("sees", [Snippet::entry("within", "6 m"), Snippet::entry("rate", "0.2 /s")])
}

/// Sizes, without which nothing else can be looked at.
pub(super) fn sizes(p: &Problem, found: &mut Vec<Mistake>) {
    if p.objects.len() > MAX_OBJECTS {
        let text =
            format!("{} groups of objects are more than the {MAX_OBJECTS} that a search may have", p.objects.len());
        found.push(Mistake::new("HQ0904", Item::Mission, &[], text, "split the mission into several"));
    }
    let small = |points: &[Point]| points.iter().flatten().all(|x| x.is_finite() && x.abs() <= MAX_NUMBER);
    for (i, object) in p.objects.iter().enumerate() {
        for (keys, points) in [(&["region"][..], &object.region), (&["positions"][..], &object.places)] {
            if !small(points) {
                let text = "this number is larger than 1e6".to_string();
                found.push(Mistake::new("HQ0904", Item::Object(i), keys, text, "check the unit after the number"));
            }
        }
    }
    let [columns, rows] = raster_of(&p.area, p.cell);
    if !p.objects.is_empty() && columns.saturating_mul(rows) > MAX_RASTER {
        too_fine(p, format!("{columns} by {rows} places"), found);
    }
}

fn too_fine(p: &Problem, cells: String, found: &mut Vec<Mistake>) {
    let [columns, rows] = raster_of(&p.area, p.cell).map(|count| count as f64);
    let larger = p.cell * (columns * rows / MAX_CELLS as f64).sqrt();
    let larger = format!("{} m", (10.0 * larger).ceil() / 10.0);
    let text = format!("cells of {} m cut the area into {cells}, and a belief has at most {MAX_CELLS} cells", p.cell);
    let help = Help::write_for_instance(Snippet::entry("cell", larger));
    found.push(Mistake::new("HQ0904", Item::Mission, &["cell"], text, help));
}

/// Regions, places, and those who look.
pub(super) fn objects(p: &Problem, found: &mut Vec<Mistake>) {
    let Some(first) = p.objects.first() else { return };
    if p.agents.iter().all(|agent| agent.sees.is_none()) {
        let text = format!("nobody can find `{}`: no agent of this search sees hidden objects", first.name);
        let help = Help::with("write for an agent how it detects them, {}", [sees()]);
        found.push(Mistake::new("HQ0946", Item::Object(0), &[], text, help));
    }
    let before = found.len();
    for (i, object) in p.objects.iter().enumerate() {
        let corners = &object.region;
        let why = match corners.len() {
            0 => None,
            1 | 2 => Some("has fewer than three corners"),
            _ if crosses_itself(corners) => Some("crosses itself"),
            _ if area(corners) <= 0.0 => Some("encloses nothing"),
            _ => None,
        };
        if let Some(why) = why {
            let help = "write its corners in order, from neighbour to neighbour";
            found.push(Mistake::new("HQ0947", Item::Object(i), &["region"], format!("this region {why}"), help));
        }
        if !object.places.is_empty() && object.places.len() != object.count {
            let (places, count) = (object.places.len(), object.count);
            let noun = if places == 1 { "position" } else { "positions" };
            let text = format!("`{}` has {places} {noun} and a `count` of {count}", object.name);
            let help =
                Help::with("write a position for each object, or {}", [Snippet::entry("count", places.to_string())]);
            let mistake = Mistake::new("HQ0948", Item::Object(i), &["positions"], text, help);
            let against = Some((Item::Object(i), &["count"][..], "the number of the objects"));
            found.push(Mistake { against, ..mistake });
        }
    }
    if found.len() > before {
        return;
    }
    let sight = p.sight();
    if sight.len() >= MAX_CELLS {
        return too_fine(p, format!("more than {MAX_CELLS} cells"), found);
    }
    for (i, object) in p.objects.iter().enumerate() {
        if prior(&sight, object).iter().all(|share| *share <= 0.0) {
            let text = format!("no cell in which `{}` could be has its middle on free ground", object.name);
            let help = Help::with(
                "move the region to free ground, or write smaller cells, {}",
                [Snippet::entry("cell", "0.5 m")],
            );
            found.push(Mistake::new("HQ0947", Item::Object(i), &["region"], text, help));
            continue;
        }
        for at in &object.places {
            if sight.seat(*at).is_none() {
                let text = format!("an object at ({}, {}) m is in a wall or outside the ground", at[0], at[1]);
                let help = "write a position on free ground";
                found.push(Mistake::new("HQ0948", Item::Object(i), &["positions"], text, help));
            } else if !object.region.is_empty() && !super::geometry::inside(*at, &object.region) {
                let text = format!(
                    "an object at ({}, {}) m is outside the region in which it is believed to be",
                    at[0], at[1]
                );
                let mistake = Mistake::new(
                    "HQ0948",
                    Item::Object(i),
                    &["positions"],
                    text,
                    "write a place in the region, or a larger region",
                );
                found.push(Mistake {
                    against: Some((Item::Object(i), &["region"], "the region")),
                    note: Some("the belief has no probability there: the plan would never look for it"),
                    ..mistake
                });
            }
        }
    }
}

/// The share of the region of a group of objects that no agent can ever see, if that is more than a little, and a place of it (m).
pub(super) fn unseen(p: &Problem, object: usize) -> Option<(f64, Point)> {
    let sight = p.sight();
    let mut seen = vec![false; sight.len()];
    for (index, agent) in p.agents.iter().enumerate() {
        let Some(sees) = p.looks(index) else { continue };
        let ground = Ground::new(p, &Body::of(agent));
        let raster = ground.raster();
        let reached = raster.reached(agent.start);
        for (cell, at) in sight.middles().iter().enumerate() {
            if ground.fits(*at) && reached.reaches(*at) {
                sight.seen(cell as u32, sees.within).iter().for_each(|(_, other)| seen[*other as usize] = true);
            }
        }
    }
    let prior = prior(&sight, p.objects.get(object)?);
    let hidden = || prior.iter().enumerate().filter(|(cell, share)| **share > 0.0 && !seen[*cell]);
    let share: f64 = hidden().map(|(_, share)| share).sum();
    let place = hidden().next().map(|(cell, _)| sight.middles()[cell])?;
    (share > UNSEEN).then_some((share, place))
}
