//! The Gantt chart for a terminal: a row for each actor, a character for each interval.

use std::fmt::Write;

use mission::chart::{Bar, Chart, Row, Style};
use unicode_width::UnicodeWidthChar;

use super::axis::Axis;
use super::shortened;

/// Maximum number of columns of a name that is not shortened.
const LONGEST: usize = 16;
/// A cell that is covered by the wide character before it.
const COVERED: char = '\0';
/// Minimum number of columns between two marks of the axis.
const MARK: usize = 11;

/// Colours of groups, used in turn.
const GROUPS: [&str; 4] = ["34", "35", "36", "32"];

/// Appearance of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Look {
    style: &'static Style,
    group: Option<usize>,
}

impl Look {
    fn of(bar: &Bar) -> Look {
        Look { style: bar.style, group: bar.group }
    }

    fn sign(self) -> char {
        match self.group {
            Some(group) if group % 2 == 1 => '-',
            _ => self.style.sign,
        }
    }

    /// Returns the colour as a parameter of a terminal's `SGR` sequence.
    fn colour(self) -> &'static str {
        self.group.map_or(self.style.colour, |group| GROUPS[group % GROUPS.len()])
    }
}

/// Draws the chart in at most `columns` columns (40 to 400), optionally with terminal colours.
///
/// Each column shows the bar with the largest share of its time; bars of some styles show in at least one column.
pub fn text(chart: &Chart, columns: usize, colour: bool) -> String {
    let rows = &chart.rows;
    let (Some(first), Some(last)) = (chart.start(), chart.end()) else { return "Nothing is planned.\n".to_string() };
    let longest = rows.iter().map(|row| super::columns(&row.name)).max().unwrap_or(0).min(LONGEST);
    let width = columns.clamp(40, 400) - longest - 2;
    let axis = Axis::over(first, last, width / MARK);
    let mut out = String::new();
    scale(&axis, longest, width, &mut out);
    for row in rows {
        let (cells, line) = cells(row, &axis, width);
        let name: String = shown(&row.name, longest);
        let _ = write!(out, "{name}{:1$}  ", "", longest.saturating_sub(super::columns(&name)));
        paint(&cells, &line, colour, &mut out);
    }
    legend(chart, longest, colour, &mut out);
    out
}

/// Returns a name in at most this many columns, with control characters replaced.
fn shown(name: &str, most: usize) -> String {
    let plain = |c: char| if c.is_control() { '?' } else { c };
    shortened(&name.chars().map(plain).collect::<String>(), most)
}

/// Converts a text into cells of the chart: a wide character is followed by a [`COVERED`] cell.
fn in_cells(text: &str) -> Vec<char> {
    let mut cells = Vec::new();
    for c in text.chars() {
        match UnicodeWidthChar::width(c) {
            Some(2) => cells.extend([c, COVERED]),
            Some(1) => cells.push(c),
            // Combining characters have no cell of their own, and a cell holds one character.
            _ => {}
        }
    }
    cells
}

/// Draws the numbers and, below them, the marks of the axis.
fn scale(axis: &Axis, longest: usize, width: usize, out: &mut String) {
    let unit = axis.unit.name();
    let (mut numbers, mut ticks) = (vec![' '; width], vec!['-'; width]);
    let mut free = 0;
    for (time, number) in axis.marks() {
        let at = ((axis.share(time) * width as f64) as usize).min(width - 1);
        ticks[at] = '+';
        let number = if free == 0 { format!("{number} {unit}") } else { number };
        // A number begins at its mark, or ends at the right border.
        let from = at.min(width.saturating_sub(number.len()));
        if from >= free {
            numbers.iter_mut().skip(from).zip(number.chars()).for_each(|(cell, c)| *cell = c);
            free = from + number.len() + 1;
        }
    }
    let line = |cells: Vec<char>| cells.into_iter().collect::<String>();
    let _ = writeln!(out, "{:longest$}  {}", "", line(numbers).trim_end());
    let _ = writeln!(out, "{:longest$}  {}", "", line(ticks));
}

/// Returns the appearance of each column, and the characters of the row with its labels.
fn cells(row: &Row, axis: &Axis, width: usize) -> (Vec<Option<Look>>, Vec<char>) {
    let mut most: Vec<(Option<Look>, f64)> = vec![(None, 0.0); width];
    let column = |time: f64| axis.share(time) * width as f64;
    for bar in &row.bars {
        let (from, to) = (column(bar.start).max(0.0), column(bar.end).min(width as f64));
        for (index, cell) in most.iter_mut().enumerate().take(to.ceil() as usize).skip(from as usize) {
            let share = (to.min(index as f64 + 1.0) - from.max(index as f64)).max(0.0);
            if share > cell.1 {
                *cell = (Some(Look::of(bar)), share);
            }
        }
    }
    let mut cells: Vec<Option<Look>> = most.into_iter().map(|cell| cell.0).collect();
    for bar in row.bars.iter().filter(|bar| bar.style.kept) {
        let middle = column(0.5 * (bar.start + bar.end)) as usize;
        cells[middle.min(width - 1)] = Some(Look::of(bar));
    }
    let mut line: Vec<char> = cells.iter().map(|cell| cell.map_or(' ', Look::sign)).collect();
    for bar in row.bars.iter().filter(|bar| bar.group.is_some()) {
        line[(column(bar.start) as usize).min(width - 1)] = '|';
    }
    for work in row.works() {
        write_label(work, &column, &cells, &mut line);
    }
    (cells, line)
}

/// Writes the label of a work into its longest bar; only if a column before and one after it still show the bar. Never
/// overwrites a bar that is shown in any case.
fn write_label(work: &[Bar], column: &impl Fn(f64) -> f64, cells: &[Option<Look>], line: &mut [char]) {
    let labelled = |bar: &&Bar| bar.label.is_some() && !bar.style.kept;
    let runs = work.iter().filter(labelled).map(|bar| {
        let shown = |cell: &usize| cells[*cell] == Some(Look::of(bar));
        let mut within = column(bar.start) as usize..(column(bar.end).ceil() as usize).min(cells.len());
        let first = within.find(shown).unwrap_or(cells.len());
        let count = within.take_while(shown).count() + 1;
        (count, std::cmp::Reverse(first), bar)
    });
    let Some((count, std::cmp::Reverse(first), bar)) = runs.max_by_key(|run| (run.0, run.1)) else { return };
    let text = shown(bar.label.as_deref().unwrap_or_default(), LONGEST + 4);
    let text = in_cells(&text);
    if text.len() + 2 <= count {
        line.iter_mut().skip(first + 1).zip(text).for_each(|(cell, c)| *cell = c);
    }
}

/// Draws a row of the chart, without trailing spaces.
fn paint(cells: &[Option<Look>], line: &[char], colour: bool, out: &mut String) {
    let end = line.iter().rposition(|c| *c != ' ').map_or(0, |last| last + 1);
    let mut at = 0;
    for stretch in cells[..end].chunk_by(|a, b| a == b) {
        let text: String = line[at..at + stretch.len()].iter().filter(|c| **c != COVERED).collect();
        at += stretch.len();
        match stretch[0] {
            Some(look) if colour => {
                let _ = write!(out, "\x1b[{}m{text}\x1b[0m", look.colour());
            }
            _ => out.push_str(&text),
        }
    }
    out.push('\n');
}

/// Draws the legend of the characters that occur in the chart.
fn legend(chart: &Chart, longest: usize, colour: bool, out: &mut String) {
    let has = |style: &Style| chart.bars().any(|bar| bar.style == style && bar.group.is_none());
    let single = chart.legend.iter().filter(|entry| entry.group.is_none() && has(entry.style));
    let entries = single.map(|entry| {
        let (c, sgr) = (entry.style.sign, entry.style.colour);
        let sign = if colour { format!("\x1b[{sgr}m{c}\x1b[0m") } else { c.to_string() };
        format!("{sign} {}", entry.text)
    });
    let grouped = chart.bars().find(|bar| bar.group.is_some());
    let groups = grouped.map(|bar| format!("|{} |- {}", bar.style.sign, chart.groups));
    let _ = writeln!(out, "{:longest$}  {}", "", entries.chain(groups).collect::<Vec<_>>().join("  "));
}
