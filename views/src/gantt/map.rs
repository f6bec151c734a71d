//! Draws the map of a mission.

use std::fmt::Write;

use mission::map::{Line, Map, Region, Shade, Shape, Sign};

use crate::xml::escaped;

use super::frame::{Frame, Names};
use super::px;
use super::svg::{LAYERS, head};

/// Present positions of everybody who moves, and the style of the map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Standing {
    /// Position of each robot and person that moves on the map, or of its hand (m); empty: they are not drawn.
    pub moving: Vec<[f64; 2]>,
    /// With rules of style of its own; a page that has [`super::STYLE`] needs none.
    pub styled: bool,
}

/// Width of the legend (px).
const LEGEND: f64 = 290.0;

/// The map as SVG, x to the right and y upwards in one scale. The group `robots` carries what a page needs to move them:
/// `data-x`, `data-y` (px) of the origin and `data-scale` (px/m).
pub fn map(map: &Map, standing: &Standing) -> String {
    let frame = Frame::of(map.extent.iter().chain(&standing.moving).copied(), map.most_scale);
    let mut out = String::new();
    // Writing to a String does not fail.
    let _ = write(map, standing, &frame, &mut out);
    out
}

fn write(map: &Map, standing: &Standing, frame: &Frame, out: &mut String) -> std::fmt::Result {
    head(frame.width, frame.height, map.title, standing.styled, out)?;
    let mut names = Names::new(frame);
    map.clear.iter().for_each(|place| names.keep_clear(frame.at(*place)));
    for shape in &map.shapes {
        match shape {
            Shape::Sign { sign: form, at, title } => sign(*form, frame.at(*at), 1.0, title.as_deref(), out)?,
            Shape::Line { line: form, points, title } => line(*form, points, title.as_deref(), frame, out)?,
            Shape::Region { region: of, corners, title } => region(*of, corners, title.as_deref(), frame, out)?,
            Shape::Regions { region: of, rectangles, title } => regions(*of, rectangles, title.as_deref(), frame, out)?,
            Shape::Name { at, text } => names.write(frame.at(*at), text, out)?,
        }
    }
    frame.moving(map.moving.iter().zip(standing.moving.iter().copied()), out)?;
    frame.bar(out)?;
    legend(map, frame, out)?;
    writeln!(out, "</svg>")
}

/// The title of a shape and its end.
fn closed(element: &str, title: Option<&str>, out: &mut String) -> std::fmt::Result {
    let Some(title) = title else { return writeln!(out, "/>") };
    writeln!(out, "><title>{}</title></{element}>", escaped(title))
}

/// Draws a sign around a point (px); `size` is relative to that on the map.
fn sign(sign: Sign, [x, y]: [f64; 2], size: f64, title: Option<&str>, out: &mut String) -> std::fmt::Result {
    let square = |class: &str, side: f64, out: &mut String| {
        let (left, top) = (px(x - side / 2.0), px(y - side / 2.0));
        write!(out, "<rect class=\"{class}\" x=\"{left}\" y=\"{top}\" width=\"{side}\" height=\"{side}\"")?;
        closed("rect", title, out)
    };
    let circle = |class: &str, radius: f64, out: &mut String| {
        write!(out, "<circle class=\"{class}\" cx=\"{}\" cy=\"{}\" r=\"{radius}\"", px(x), px(y))?;
        closed("circle", title, out)
    };
    match sign {
        Sign::Base => square("depot", if size < 1.0 { 9.0 } else { 11.0 }, out),
        Sign::Person => circle("human", if size < 1.0 { 5.0 } else { 6.0 }, out),
        Sign::Worker => {
            let (up, side) = if size < 1.0 { (5.5, 6.0) } else { (7.0, 7.0) };
            let height = if size < 1.0 { 10.0 } else { 12.0 };
            let (x, y) = (px(x), px(y - up));
            write!(out, "<path class=\"worker\" d=\"M{x} {y} l{side} {height} h-{} z\"", 2.0 * side)?;
            closed("path", title, out)
        }
        Sign::Stop => circle("stop", 3.5, out),
        Sign::Object(None) => square("object", 9.0, out),
        Sign::Object(Some(group)) => square(&format!("object layer-{}", group % LAYERS), 9.0, out),
        Sign::Target(group) => circle(&format!("end-of layer-{}", group % LAYERS), 4.0, out),
    }
}

fn line(line: Line, points: &[[f64; 2]], title: Option<&str>, frame: &Frame, out: &mut String) -> std::fmt::Result {
    let class = match line {
        Line::Path => "way".to_string(),
        Line::Near => "near".to_string(),
        Line::Fetch => "goes".to_string(),
        Line::Wall => "wall".to_string(),
        Line::Considered => "considered".to_string(),
        Line::Carry(group) => format!("carries line-{}", group % LAYERS),
    };
    write!(out, "<path class=\"{class}\" d=\"")?;
    path(points, frame, out)?;
    write!(out, "\"")?;
    closed("path", title, out)
}

/// The commands of a path through points.
fn path(points: &[[f64; 2]], frame: &Frame, out: &mut String) -> std::fmt::Result {
    for (number, point) in points.iter().enumerate() {
        let [x, y] = frame.at(*point);
        let (space, command) = if number == 0 { ("", 'M') } else { (" ", 'L') };
        write!(out, "{space}{command}{} {}", px(x), px(y))?;
    }
    Ok(())
}

fn class_of(region: Region) -> String {
    let shaded = |of: &str, shade: Shade| {
        let shade = match shade {
            Shade::Faint => "faint",
            Shade::Light => "light",
            Shade::Medium => "medium",
            Shade::Strong => "strong",
        };
        format!("{of} {shade}")
    };
    let plain = match region {
        Region::Belief(shade) => return shaded("belief", shade),
        Region::AttractsNear(shade) => return shaded("attracts-near", shade),
        Region::RepelsNear(shade) => return shaded("repels-near", shade),
        Region::Ground => "ground",
        Region::Solid => "solid",
        Region::Unknown => "unknown",
        Region::Attracts => "attracts",
        Region::Repels => "repels",
    };
    plain.to_string()
}

fn region(of: Region, corners: &[[f64; 2]], title: Option<&str>, frame: &Frame, out: &mut String) -> std::fmt::Result {
    write!(out, "<path class=\"{}\" d=\"", class_of(of))?;
    path(corners, frame, out)?;
    write!(out, " Z\"")?;
    closed("path", title, out)
}

/// Rectangles as one path. Without an outline, since those that touch are one area.
fn regions(
    of: Region,
    rectangles: &[[[f64; 2]; 4]],
    title: Option<&str>,
    frame: &Frame,
    out: &mut String,
) -> std::fmt::Result {
    write!(out, "<path class=\"{} cells\" d=\"", class_of(of))?;
    for corners in rectangles {
        let [a, b, c, d] = corners.map(|corner| frame.at(corner));
        if a[1] == b[1] && b[0] == c[0] {
            write!(out, "M{} {}H{}V{}H{}Z", px(a[0]), px(a[1]), px(b[0]), px(c[1]), px(d[0]))?;
        } else {
            write!(
                out,
                "M{} {}L{} {} {} {} {} {}Z",
                px(a[0]),
                px(a[1]),
                px(b[0]),
                px(b[1]),
                px(c[0]),
                px(c[1]),
                px(d[0]),
                px(d[1])
            )?;
        }
    }
    write!(out, "\"")?;
    closed("path", title, out)
}

/// The signs with their meanings, beside the bar of the scale.
fn legend(map: &Map, frame: &Frame, out: &mut String) -> std::fmt::Result {
    let (y, mut x) = (frame.words(), frame.width - LEGEND);
    for (form, text) in &map.legend {
        sign(*form, [x + 4.5, y - 2.5], 0.8, None, out)?;
        writeln!(out, "<text class=\"small\" x=\"{}\" y=\"{}\">{text}</text>", px(x + 14.0), px(y + 2.0))?;
        x += 30.0 + 6.0 * text.chars().count() as f64;
    }
    Ok(())
}
