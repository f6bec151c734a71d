//! The occupancy grid of a search: read from the map file that the spec names, and what is wrong with a place on it.

use blocks::{FileWith, Help, Located, Snippet};

use super::blocks::AREA;
use super::check::{Item, Mistake};
use super::ground::{Body, Ground};
use super::problem::{Problem, SourceKind};
use super::ways::goals;
use crate::declare::{DeclaredMission, Origins, Remark, Remarks};
use crate::occupancy::{Fault, Image, MapFile, OccupancyGrid};

/// Code of a map file or an image that cannot be read.
pub(super) const UNREADABLE: &str = "HQ0950";
/// Code of an image that is none of a map.
const IMAGE: &str = "HQ0951";
/// Code of a map file with a mistake.
const YAML: &str = "HQ0952";
/// Code of a place that is blocked.
const BLOCKED: &str = "HQ0953";

/// Mistakes of a map file that are reported at once.
const MOST: usize = 5;

/// Adds the grid of the map file, and the ground if the spec writes no area.
pub(super) fn add(
    declared: &DeclaredMission,
    file: Option<Located<FileWith>>,
    problem: &mut Problem,
    places: &mut Origins<Item>,
    remarks: &mut Remarks,
) {
    if declared.settings.is_wrong("map") {
        return;
    }
    let Some(file) = file else {
        if declared.settings.key_origin("area").is_none() && !declared.settings.is_wrong("area") {
            let pieces = [Snippet::entry("area", AREA), Snippet::entry("map", "\"lab.yaml\"")];
            let remark = Remark::error("HQ0206", declared.at, "a search needs `area` or `map`");
            remarks
                .push(remark.help(Help::with("write the corners of the ground, {}, or name a map of ROS, {}", pieces)));
            places.mark_wrong(Item::Mission, "area");
        }
        return;
    };
    match grid(&file.value) {
        Ok(grid) => {
            if declared.settings.key_origin("area").is_none() {
                problem.area = grid.corners().to_vec();
            }
            problem.occupancy = Some(grid);
        }
        Err(faults) => {
            for fault in faults.into_iter().take(MOST) {
                remarks.push(remark(fault, &file));
            }
            places.mark_wrong(Item::Mission, "map");
        }
    }
}

fn grid(file: &FileWith) -> Result<OccupancyGrid, Vec<Fault>> {
    let map = MapFile::read(&file.text)?;
    // A sound map file names an image, which was read with it.
    let image = Image::read(file.companion.as_deref().unwrap_or_default()).map_err(|fault| vec![fault])?;
    OccupancyGrid::read(&map, &image).map_err(|fault| vec![fault])
}

fn remark(fault: Fault, file: &Located<FileWith>) -> Remark {
    let FileWith { path, text, .. } = &file.value;
    if fault.in_image {
        let image = crate::occupancy::image_path(text).unwrap_or_default();
        let remark = Remark::error(IMAGE, file.at, format!("`{image}` cannot be read: {}", fault.text));
        return remark.note(format!("`{path}` names this image")).help(fault.help);
    }
    let remark = Remark::error(YAML, file.at, format!("`{path}`: {}", fault.text)).help(fault.help);
    match fault.line {
        Some(line) => {
            let written = text.lines().nth(line - 1).unwrap_or_default().trim();
            let short: String = written.chars().take(60).collect();
            remark.note(format!("line {line} of `{path}`: {short}"))
        }
        None => remark,
    }
}

/// An agent that begins in a blocked cell, outside the map, or too near to a blocked cell.
pub(super) fn start(p: &Problem, agent: usize) -> Option<Mistake> {
    let (map, who) = (p.occupancy.as_ref()?, &p.agents[agent]);
    let mistake = |code: &'static str, text: String, pixel: String, help: &'static str| Mistake {
        pixel: Some(pixel),
        ..Mistake::new(code, Item::Agent(agent), &["start"], text, help)
    };
    let index = map.index(who.start);
    if map.is_blocked(index) {
        let text = match map.cell(index) {
            Some(cell) => format!("`{}` starts in a cell that is {} on the map", who.name, cell.name()),
            None => format!("`{}` starts outside the map", who.name),
        };
        return Some(mistake(
            BLOCKED,
            text,
            map.describe(who.start),
            "write a free position, or check `origin` in the map file",
        ));
    }
    let near = map.too_near(who.start, who.start, who.radius)?;
    let pixel = match map.cell(near) {
        Some(cell) => format!("{} is {}", map.pixel(near), cell.name()),
        None => "what is outside the map is blocked".into(),
    };
    let text = format!("`{}` starts nearer to a blocked cell of the map than its radius", who.name);
    Some(mistake("HQ0942", text, pixel, "write a position with more room, or a smaller `radius`"))
}

/// A source none of whose places is free on the map.
pub(super) fn source(p: &Problem, source: usize) -> Option<Mistake> {
    let (map, of) = (p.occupancy.as_ref()?, &p.sources[source]);
    if !matches!(of.kind, SourceKind::Task | SourceKind::Environment) {
        return None;
    }
    let has_room = |agent: usize| {
        let ground = Ground::new(p, &Body::of(&p.agents[agent]));
        p.consumes(agent, source) && goals(p, agent, &ground, None).into_iter().any(|(_, goal)| goal == source)
    };
    let at = super::geometry::middle(&of.boundary.points());
    if !map.is_blocked(map.index(at)) || (0..p.agents.len()).any(has_room) {
        return None;
    }
    let text = format!("`{}` has no place that is free on the map", of.name);
    let help = "move it to free cells, or check `origin` in the map file";
    let keys: &[&str] = &["polygon", "line", "points", "at"];
    Some(Mistake { pixel: Some(map.describe(at)), ..Mistake::new(BLOCKED, Item::Source(source), keys, text, help) })
}
