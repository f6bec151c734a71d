//! The Gantt chart as SVG: rows of robots and agents as in thesis Figs. 5.7 and 5.8.

use std::fmt::Write;

use mission::chart::{Bar, Chart, Entry, LabelPlace, Row, Style};

use crate::xml::escaped;

use super::axis::Axis;
use super::{STYLE, columns, px, shortened};

/// Appearance of a chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    /// The present (s): the time before it is shaded.
    pub now: Option<f64>,
    /// Minimum end of the axis (s), so that two charts are comparable; `None`: the end of the chart.
    pub until: Option<f64>,
    /// True to embed the style sheet; a page with [`STYLE`] does not need it.
    pub styled: bool,
}

impl Default for Look {
    fn default() -> Look {
        Look { now: None, until: None, styled: true }
    }
}

/// Number of distinct colours of groups.
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
/// Maximum number of characters of an entry of the legend that is not shortened.
const LONGEST_ENTRY: usize = 40;
/// Height of a line of the legend.
const LINE: f64 = 18.0;

/// Draws the chart as a standalone file.
pub fn svg(chart: &Chart) -> String {
    picture(chart, &Look::default())
}

/// Draws the chart with this appearance. Each activity is one `rect` with `data-phase`; for updates by a page, the
/// group `now` has `data-left` and `data-scale` (px, px/s) and `data-start` (s).
pub fn picture(chart: &Chart, look: &Look) -> String {
    let (first, last) = (chart.start().unwrap_or(0.0), chart.end().unwrap_or(0.0));
    let last = look.until.filter(|until| until.is_finite()).map_or(last, |until| last.max(until));
    let picture = Picture::new(chart, Axis::over(first, last, 8));
    let mut out = String::new();
    // Writing to a String never fails.
    let _ = picture.write(look, &mut out);
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

struct Picture<'c> {
    chart: &'c Chart,
    axis: Axis,
    left: f64,
    bottom: f64,
}

impl<'c> Picture<'c> {
    fn new(chart: &'c Chart, axis: Axis) -> Picture<'c> {
        let rows = &chart.rows;
        let longest = rows.iter().map(|row| columns(&row.name).min(LONGEST)).max().unwrap_or(0);
        Picture { chart, axis, left: 20.0 + CHARACTER * longest as f64, bottom: TOP + ROW * rows.len() as f64 }
    }

    fn x(&self, time: f64) -> f64 {
        self.left + self.axis.share(time).clamp(0.0, 1.0) * (WIDTH - RIGHT - self.left)
    }

    fn write(&self, look: &Look, out: &mut String) -> std::fmt::Result {
        let rows = &self.chart.rows;
        let lines = self.entries().last().map_or(0, |(_, _, line)| *line) as f64;
        head(WIDTH, self.bottom + 34.0 + LINE * lines, "plan: who does what, and when", look.styled, out)?;
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
            self.row(row, TOP + ROW * index as f64, out)?;
        }
        if let Some(now) = look.now.filter(|now| now.is_finite()) {
            self.now(now, out)?;
        }
        self.legend(out)?;
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

    fn row(&self, row: &Row, y: f64, out: &mut String) -> std::fmt::Result {
        for bar in &row.bars {
            self.bar(row, bar, y, out)?;
        }
        match row.labels {
            LabelPlace::Within => row.bars.iter().try_for_each(|bar| self.within(bar, y, out)),
            LabelPlace::Above => row.works().try_for_each(|work| self.above(work, y, out)),
        }
    }

    fn bar(&self, row: &Row, bar: &Bar, y: f64, out: &mut String) -> std::fmt::Result {
        let (x, height) = (self.x(bar.start), bar.style.height);
        let begun = if bar.begun { " begun" } else { "" };
        let name = bar.style.name;
        let class = class(bar.style, bar.group);
        write!(
            out,
            "<rect class=\"{class}{begun}\" x=\"{}\" y=\"{}\" width=\"{:.2}\" height=\"{}\"",
            px(x),
            px(y + MIDDLE - 0.5 * height),
            self.x(bar.end) - x,
            px(height)
        )?;
        if bar.style.activity {
            write!(out, " data-phase=\"{name}\"")?;
        }
        let speed = bar.speed.map(|speed| format!(", {speed:.3} m/s")).unwrap_or_default();
        let title = format!(
            "{}: {name} {}, {:.1} s to {:.1} s ({:.1} s{speed})",
            row.name,
            bar.title,
            bar.start,
            bar.end,
            bar.end - bar.start
        );
        writeln!(out, "><title>{}</title></rect>", escaped(&title))
    }

    /// Writes the label of a bar into it, if there is space.
    fn within(&self, bar: &Bar, y: f64, out: &mut String) -> std::fmt::Result {
        let Some(text) = &bar.label else { return Ok(()) };
        let (from, to) = (self.x(bar.start), self.x(bar.end));
        if to - from < CHARACTER * columns(text) as f64 + 4.0 {
            return Ok(());
        }
        writeln!(
            out,
            "<text class=\"on middle\" x=\"{}\" y=\"{}\">{}</text>",
            px(0.5 * (from + to)),
            px(y + MIDDLE + 4.0),
            escaped(text)
        )
    }

    /// Writes the label of a work above it, if there is space.
    fn above(&self, work: &[Bar], y: f64, out: &mut String) -> std::fmt::Result {
        let (Some(first), Some(last)) = (work.first(), work.last()) else { return Ok(()) };
        let Some(text) = &first.label else { return Ok(()) };
        let (from, to) = (self.x(first.start), self.x(last.end));
        if to - from < CHARACTER * columns(text) as f64 {
            return Ok(());
        }
        writeln!(out, "<text class=\"small\" x=\"{}\" y=\"{}\">{}</text>", px(from + 1.0), px(y + 13.0), escaped(text))
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

    /// The entries of the legend that occur in the chart, each with its left end and its line.
    fn entries(&self) -> Vec<(&Entry, f64, usize)> {
        let has = |entry: &&Entry| self.chart.bars().any(|bar| bar.style == entry.style && bar.group == entry.group);
        let (mut x, mut line) = (self.left, 0);
        let place = |entry: &'c Entry| {
            let width = 46.0 + CHARACTER * columns(&shortened(&entry.text, LONGEST_ENTRY)) as f64;
            if x > self.left && x + width > WIDTH {
                (x, line) = (self.left, line + 1);
            }
            let at = x;
            x += width;
            (entry, at, line)
        };
        self.chart.legend.iter().filter(has).map(place).collect()
    }

    fn legend(&self, out: &mut String) -> std::fmt::Result {
        for (entry, x, line) in self.entries() {
            let (y, height) = (self.bottom + 20.0 + LINE * line as f64, entry.style.height);
            writeln!(
                out,
                "<rect class=\"{}\" x=\"{}\" y=\"{}\" width=\"22\" height=\"{}\"/>",
                class(entry.style, entry.group),
                px(x),
                px(y - 0.5 * height),
                px(height)
            )?;
            writeln!(
                out,
                "<text class=\"small\" x=\"{}\" y=\"{}\">{}</text>",
                px(x + 27.0),
                px(y + 4.0),
                escaped(&shortened(&entry.text, LONGEST_ENTRY))
            )?;
        }
        Ok(())
    }
}

/// Returns the class of a bar; the colours of groups repeat after six.
fn class(style: &Style, group: Option<usize>) -> String {
    match group {
        Some(group) => format!("{} layer-{}", style.name, group % LAYERS),
        None => style.name.to_string(),
    }
}
