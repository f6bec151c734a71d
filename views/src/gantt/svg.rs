//! The Gantt chart as SVG: rows of robots and agents as in thesis Figs. 5.7 and 5.8.

use std::fmt::Write;

use mission::plan::{Actor, Phase, Plan};

use crate::xml::escaped;

use super::axis::Axis;
use super::rows::{Bar, Kind, Row, label, rows, span};
use super::{STYLE, columns, px, shortened};

/// Appearance of a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// The present (s): the time before it is shaded.
    pub now: Option<f64>,
    /// Minimum end of the axis (s), so that two charts are comparable; `None`: the end of the plan.
    pub until: Option<f64>,
    /// True to embed the style sheet; a page with [`STYLE`] does not need it.
    pub styled: bool,
}

impl Default for Look {
    fn default() -> Look {
        Look { now: None, until: None, styled: true }
    }
}

/// Number of distinct colours of layers.
pub(super) const LAYERS: usize = 6;

const WIDTH: f64 = 960.0;
const ROW: f64 = 40.0;
const TOP: f64 = 30.0;
const RIGHT: f64 = 16.0;
/// Vertical centre of the bars, from the top of a row; above them there is space for a label.
const MIDDLE: f64 = 25.0;
/// Width of a character (px), an upper estimate.
const CHARACTER: f64 = 6.9;
/// Maximum number of characters of a name that is not shortened.
const LONGEST: usize = 18;

/// Draws the chart as a standalone file.
pub fn svg(plan: &Plan) -> String {
    picture(plan, &Look::default())
}

/// Draws the chart with this appearance. Each activity is one `rect` with `data-phase`; for updates by a page, the
/// group `now` has `data-left` and `data-scale` (px, px/s) and `data-start` (s).
pub fn picture(plan: &Plan, look: &Look) -> String {
    let rows = rows(plan);
    let (first, last) = span(&rows).unwrap_or((0.0, 0.0));
    let last = look.until.filter(|until| until.is_finite()).map_or(last, |until| last.max(until));
    let chart = Chart::new(&rows, Axis::over(first, last, 8));
    let mut out = String::new();
    // Writing to a String never fails.
    let _ = chart.write(plan, &rows, look, &mut out);
    out
}

/// Writes the head of a picture: size, title, style sheet.
pub(super) fn head(width: f64, height: f64, title: &str, styled: bool, out: &mut String) -> std::fmt::Result {
    let (w, h) = (px(width), px(height));
    writeln!(
        out,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"plan\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
         role=\"img\">"
    )?;
    writeln!(out, "<title>{}</title>", escaped(title))?;
    if styled {
        writeln!(out, "<style>\n{STYLE}</style>")?;
    }
    writeln!(out, "<rect class=\"paper\" width=\"{w}\" height=\"{h}\"/>")
}

struct Chart {
    axis: Axis,
    left: f64,
    bottom: f64,
}

impl Chart {
    fn new(rows: &[Row], axis: Axis) -> Chart {
        let longest = rows.iter().map(|row| columns(&row.name).min(LONGEST)).max().unwrap_or(0);
        Chart { axis, left: 20.0 + CHARACTER * longest as f64, bottom: TOP + ROW * rows.len() as f64 }
    }

    fn x(&self, time: f64) -> f64 {
        self.left + self.axis.share(time).clamp(0.0, 1.0) * (WIDTH - RIGHT - self.left)
    }

    fn write(&self, plan: &Plan, rows: &[Row], look: &Look, out: &mut String) -> std::fmt::Result {
        head(WIDTH, self.bottom + 34.0, "plan: who does what, and when", look.styled, out)?;
        for (index, row) in rows.iter().enumerate() {
            let y = TOP + ROW * index as f64;
            if index % 2 == 0 {
                writeln!(out, "<rect class=\"band\" y=\"{}\" width=\"{}\" height=\"{}\"/>", px(y), px(WIDTH), px(ROW))?;
            }
            let name = escaped(&shortened(&row.name, LONGEST));
            writeln!(out, "<text class=\"name\" x=\"10\" y=\"{}\">{name}</text>", px(y + MIDDLE + 4.0))?;
        }
        self.grid(out)?;
        for (index, row) in rows.iter().enumerate() {
            self.row(plan, row, TOP + ROW * index as f64, out)?;
        }
        if let Some(now) = look.now.filter(|now| now.is_finite()) {
            self.now(now, out)?;
        }
        self.legend(plan, rows, out)?;
        writeln!(out, "</svg>")
    }

    fn grid(&self, out: &mut String) -> std::fmt::Result {
        for (index, (time, number)) in self.axis.marks().into_iter().enumerate() {
            let x = px(self.x(time));
            writeln!(out, "<path class=\"grid\" d=\"M{x} {} V{}\"/>", px(TOP - 6.0), px(self.bottom))?;
            let number = if index == 0 { format!("{number} {}", self.axis.unit.name()) } else { number };
            writeln!(out, "<text class=\"quiet small middle\" x=\"{x}\" y=\"{}\">{number}</text>", px(TOP - 11.0))?;
        }
        Ok(())
    }

    fn row(&self, plan: &Plan, row: &Row, y: f64, out: &mut String) -> std::fmt::Result {
        for bar in &row.bars {
            self.bar(plan, row, bar, y, out)?;
        }
        let layered = row.bars.iter().any(|bar| matches!(bar.kind, Kind::Task(_)));
        match row.actor {
            Actor::Agent(_) if !layered => row.bars.iter().try_for_each(|bar| self.number(bar, y, out)),
            _ => row.services().try_for_each(|service| self.whom(plan, service, y, out)),
        }
    }

    fn bar(&self, plan: &Plan, row: &Row, bar: &Bar, y: f64, out: &mut String) -> std::fmt::Result {
        let (x, height) = (self.x(bar.start), height(bar.kind));
        let begun = if bar.begun { " begun" } else { "" };
        let name = bar.kind.name();
        let class = class(bar.kind);
        write!(
            out,
            "<rect class=\"{class}{begun}\" x=\"{}\" y=\"{}\" width=\"{:.2}\" height=\"{}\"",
            px(x),
            px(y + MIDDLE - 0.5 * height),
            self.x(bar.end) - x,
            px(height)
        )?;
        if let Kind::Phase(_) | Kind::Task(_) = bar.kind {
            write!(out, " data-phase=\"{name}\"")?;
        }
        let speed = bar.speed.map(|speed| format!(", {speed:.3} m/s")).unwrap_or_default();
        let title = format!(
            "{}: {name} {}, {:.1} s to {:.1} s ({:.1} s{speed})",
            row.name,
            label(plan, bar),
            bar.start,
            bar.end,
            bar.end - bar.start
        );
        writeln!(out, "><title>{}</title></rect>", escaped(&title))
    }

    /// Writes the number of an operation, if there is space.
    fn number(&self, bar: &Bar, y: f64, out: &mut String) -> std::fmt::Result {
        let text = (bar.target.operation + 1).to_string();
        let (from, to) = (self.x(bar.start), self.x(bar.end));
        if bar.kind != Kind::Phase(Phase::Operation) || to - from < CHARACTER * text.len() as f64 + 4.0 {
            return Ok(());
        }
        writeln!(
            out,
            "<text class=\"on middle\" x=\"{}\" y=\"{}\">{text}</text>",
            px(0.5 * (from + to)),
            px(y + MIDDLE + 4.0)
        )
    }

    /// Writes the served agent above the service, if there is space.
    fn whom(&self, plan: &Plan, service: &[Bar], y: f64, out: &mut String) -> std::fmt::Result {
        let (Some(first), Some(last)) = (service.first(), service.last()) else { return Ok(()) };
        let (from, to) = (self.x(first.start), self.x(last.end));
        let text = label(plan, first);
        if to - from < CHARACTER * columns(&text) as f64 {
            return Ok(());
        }
        writeln!(out, "<text class=\"small\" x=\"{}\" y=\"{}\">{}</text>", px(from + 1.0), px(y + 13.0), escaped(&text))
    }

    fn now(&self, now: f64, out: &mut String) -> std::fmt::Result {
        let (x, start) = (self.x(now), self.x(self.axis.start));
        let scale = (self.x(self.axis.end) - start) / self.axis.span();
        writeln!(
            out,
            "<g class=\"present\" data-left=\"{}\" data-scale=\"{scale:.6}\" data-start=\"{}\">",
            px(start),
            self.axis.start
        )?;
        writeln!(
            out,
            "<rect class=\"past\" x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/>",
            px(start),
            px(TOP),
            px(x - start),
            px(self.bottom - TOP)
        )?;
        writeln!(out, "<path class=\"now\" d=\"M{} {} V{}\"/>", px(x), px(TOP - 6.0), px(self.bottom + 2.0))?;
        writeln!(out, "</g>")
    }

    fn legend(&self, plan: &Plan, rows: &[Row], out: &mut String) -> std::fmt::Result {
        let has = |kind: &Kind| rows.iter().flat_map(|row| &row.bars).any(|bar| bar.kind == *kind);
        let phases = Phase::ALL.map(Kind::Phase).into_iter().map(|kind| (kind, kind.name().to_string()));
        let layers = plan.layered.iter().flat_map(|layered| &layered.layers).enumerate();
        let layers = layers.map(|(index, name)| (Kind::Task(index), shortened(plan.labels.layer(name), LONGEST)));
        let (mut x, y) = (self.left, self.bottom + 20.0);
        for (kind, text) in phases.chain(layers).filter(|(kind, _)| has(kind)) {
            let (height, end) = (height(kind), x + 46.0 + CHARACTER * columns(&text) as f64);
            if end > WIDTH {
                // A longer legend would exceed the picture; tooltips name the other kinds.
                return writeln!(out, "<text class=\"small\" x=\"{}\" y=\"{}\">…</text>", px(x), px(y + 4.0));
            }
            writeln!(
                out,
                "<rect class=\"{}\" x=\"{}\" y=\"{}\" width=\"22\" height=\"{}\"/>",
                class(kind),
                px(x),
                px(y - 0.5 * height),
                px(height)
            )?;
            writeln!(
                out,
                "<text class=\"small\" x=\"{}\" y=\"{}\">{}</text>",
                px(x + 27.0),
                px(y + 4.0),
                escaped(&text)
            )?;
            x = end;
        }
        Ok(())
    }
}

/// Returns the class of a bar; the colours of layers repeat after six.
fn class(kind: Kind) -> String {
    match kind {
        Kind::Task(layer) => format!("task layer-{}", layer % LAYERS),
        kind => kind.name().to_string(),
    }
}

/// Height of a bar (px).
fn height(kind: Kind) -> f64 {
    match kind {
        Kind::Phase(Phase::Operation | Phase::Task) => 18.0,
        Kind::Task(_) => 14.0,
        Kind::Phase(Phase::Going) => 14.0,
        Kind::Phase(Phase::Waiting) | Kind::Waits => 4.0,
        Kind::Phase(Phase::Proximity) => 10.0,
        Kind::Phase(Phase::Serving) | Kind::Served => 18.0,
        Kind::Phase(Phase::Depositing) => 7.0,
    }
}
