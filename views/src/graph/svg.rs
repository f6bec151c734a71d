//! Draws the machine as an SVG.

use std::fmt::Write;

use crate::xml::escaped;

use super::Chart;
use super::layout::{self, Lane, Layout, PAD, Place, TITLE, leads_to};

/// Colours of lanes, in turn; fault lanes have one of their own.
const COLOURS: [&str; 6] = ["#1f5f99", "#3b7d23", "#7a4ba0", "#00707a", "#8a5a00", "#4a4a8a"];
const FAULT: &str = "#b3261e";
/// Vertical offset of arriving fault lanes against other lanes (px).
const FAULT_BELOW: f64 = 8.0;

pub(super) fn draw(c: &Chart) -> String {
    let layout = layout::of(c);
    let mut out = String::new();
    // Writing to a `String` cannot fail.
    let _ = write(c, &layout, &mut out);
    out
}

fn write(c: &Chart, l: &Layout, out: &mut String) -> std::fmt::Result {
    let (w, h) = (l.width.ceil(), l.height.ceil());
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
         font-family=\"DejaVu Sans Mono, Menlo, Consolas, monospace\" font-size=\"12\">"
    )?;
    writeln!(out, "<title>machine {}</title>", escaped(c.short(0)))?;
    writeln!(out, "<rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>")?;
    // An outer state precedes its inner states, so its box is drawn below theirs.
    for (s, place) in l.places.iter().enumerate() {
        state(c, s, place, out)?;
    }
    for (i, lane) in l.lanes.iter().enumerate() {
        self::lane(c, l, lane, if lane.fault { FAULT } else { COLOURS[i % COLOURS.len()] }, out)?;
    }
    for s in 0..c.machine.states.len() {
        if let Some(initial) = c.initial(s) {
            begin(&l.places[initial], out)?;
        }
    }
    writeln!(out, "</svg>")
}

fn state(c: &Chart, s: usize, p: &Place, out: &mut String) -> std::fmt::Result {
    let state = &c.machine.states[s];
    writeln!(out, "<g class=\"state\">")?;
    let fill = match (s, c.holds_others(s)) {
        (0, _) => "#f4f4f2",
        (_, true) => "#fbfbf8",
        _ => "#ffffff",
    };
    let dashes = if c.is_region(s) { " stroke-dasharray=\"6 4\"" } else { "" };
    writeln!(
        out,
        "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" rx=\"7\" fill=\"{fill}\" stroke=\"#333333\"{dashes} \
         data-state=\"{}\"/>",
        p.x,
        p.y,
        p.width,
        p.height,
        escaped(&state.name)
    )?;
    if state.is_final {
        writeln!(
            out,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" rx=\"5\" fill=\"none\" stroke=\"#333333\"/>",
            p.x + 3.0,
            p.y + 3.0,
            p.width - 6.0,
            p.height - 6.0
        )?;
    }
    let title = if s == 0 { format!("machine {}", c.short(0)) } else { c.short(s).to_string() };
    text(p.x + PAD, p.y + TITLE / 2.0, " font-weight=\"bold\" font-size=\"13\"", &title, out)?;
    for row in &p.rows {
        let quiet = if row.edge.is_some() { "" } else { " fill=\"#666666\"" };
        text(p.x + PAD, row.y, quiet, &row.text, out)?;
        if let Some(e) = row.edge {
            text(p.right() - PAD, row.y, " text-anchor=\"end\" fill=\"#888888\"", &leads_to(c, c.edges[e].to), out)?;
        }
    }
    writeln!(out, "</g>")
}

fn text(x: f64, middle: f64, more: &str, said: &str, out: &mut String) -> std::fmt::Result {
    let y = middle + 4.0;
    writeln!(out, "<text x=\"{x:.1}\" y=\"{y:.1}\" xml:space=\"preserve\"{more}>{}</text>", escaped(said))
}

/// Draws the transitions to a state: from each row to the lane, along it, and to the state's box.
fn lane(c: &Chart, l: &Layout, lane: &Lane, colour: &str, out: &mut String) -> std::fmt::Result {
    let target = &l.places[lane.to];
    let (arrival, tip) = (target.arrival() + if lane.fault { FAULT_BELOW } else { 0.0 }, target.right());
    let dashes = if lane.fault { " stroke-dasharray=\"5 3\"" } else { "" };
    let to = escaped(&c.machine.states[lane.to].name);
    let farthest = |above: bool| {
        let rows = lane.rows.iter().map(|r| r.1).filter(|y| (*y < arrival) == above);
        rows.fold(arrival, |far, y| if (y - arrival).abs() > (far - arrival).abs() { y } else { far })
    };
    for &(e, y) in &lane.rows {
        let edge = &c.edges[e];
        let from = &l.places[edge.from];
        // Rounded corner where a transition joins its lane. The farthest rows, above and below, draw the lane itself.
        let down = if y < arrival { 1.0 } else { -1.0 };
        let bend = f64::min(5.0, (arrival - y).abs() / 2.0);
        let far = y == farthest(y < arrival);
        let (corner, end) = (lane.x - bend, y + down * bend);
        write!(
            out,
            "<path class=\"way\" d=\"M{:.1} {y:.1} H{corner:.1} Q{:.1} {y:.1} {:.1} {end:.1}",
            from.right(),
            lane.x,
            lane.x
        )?;
        if far {
            write!(out, " V{:.1} Q{:.1} {arrival:.1} {corner:.1} {arrival:.1}", arrival - down * bend, lane.x)?;
            write!(out, " H{:.1}", tip + 7.0)?;
        }
        writeln!(
            out,
            "\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.3\"{dashes} data-from=\"{}\" data-to=\"{to}\">\
             <title>{}: {}, to {to}</title></path>",
            escaped(&c.machine.states[edge.from].name),
            escaped(&c.machine.states[edge.from].name),
            escaped(edge.text)
        )?;
    }
    writeln!(out, "<path d=\"M{tip:.1} {arrival:.1} l8 -4 v8 z\" fill=\"{colour}\"/>",)
}

/// Draws the dot of the initial state of a machine, or of a state with inner states.
fn begin(p: &Place, out: &mut String) -> std::fmt::Result {
    let (x, y) = (p.x, p.arrival());
    writeln!(out, "<circle class=\"initial\" cx=\"{:.1}\" cy=\"{y:.1}\" r=\"5\" fill=\"#333333\"/>", x - 24.0)?;
    writeln!(out, "<path d=\"M{:.1} {y:.1} H{:.1}\" stroke=\"#333333\"/>", x - 19.0, x - 7.0)?;
    writeln!(out, "<path d=\"M{x:.1} {y:.1} l-8 -4 v8 z\" fill=\"#333333\"/>")
}
