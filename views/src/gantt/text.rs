//! The Gantt chart for a terminal: a row for each actor, a character for each interval.

use std::fmt::Write;

use mission::plan::{Actor, Phase, Plan};
use unicode_width::UnicodeWidthChar;

use super::axis::Axis;
use super::rows::{Bar, Kind, Row, label, rows, span};
use super::shortened;

/// Maximum number of columns of a name that is not shortened.
const LONGEST: usize = 16;
/// A cell that is covered by the wide character before it.
const COVERED: char = '\0';
/// Minimum number of columns between two marks of the axis.
const MARK: usize = 11;

/// Colours of layers, used in turn.
const LAYERS: [&str; 4] = ["34", "35", "36", "32"];

/// Returns the character of a phase, and its colour as a parameter of a terminal's `SGR` sequence.
fn look(kind: Kind) -> (char, &'static str) {
    match kind {
        Kind::Phase(Phase::Operation | Phase::Task) => ('=', "1"),
        Kind::Task(layer) => (if layer % 2 == 0 { '=' } else { '-' }, LAYERS[layer % LAYERS.len()]),
        Kind::Phase(Phase::Going) => ('>', "34"),
        Kind::Phase(Phase::Waiting) | Kind::Waits => ('.', "33"),
        Kind::Phase(Phase::Proximity) => ('~', "36"),
        Kind::Phase(Phase::Serving) | Kind::Served => ('#', "32;1"),
        Kind::Phase(Phase::Depositing) => ('<', "35"),
    }
}

/// Draws the chart in at most `columns` columns (40 to 400), optionally with terminal colours.
///
/// Each column shows the phase with the largest share of its time; a service shows in at least one column. A robot's
/// row is labelled with the served agents, an agent's with the numbers of its operations.
pub fn text(plan: &Plan, columns: usize, colour: bool) -> String {
    let rows = rows(plan);
    let Some((first, last)) = span(&rows) else { return "Nothing is planned.\n".to_string() };
    let longest = rows.iter().map(|row| super::columns(&row.name)).max().unwrap_or(0).min(LONGEST);
    let width = columns.clamp(40, 400) - longest - 2;
    let axis = Axis::over(first, last, width / MARK);
    let mut out = String::new();
    scale(&axis, longest, width, &mut out);
    for row in &rows {
        let (cells, line) = cells(plan, row, &axis, width);
        let name: String = shown(&row.name, longest);
        let _ = write!(out, "{name}{:1$}  ", "", longest.saturating_sub(super::columns(&name)));
        paint(&cells, &line, colour, &mut out);
    }
    legend(&rows, longest, colour, &mut out);
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

/// Returns the phase of each column, and the characters of the row with its labels.
fn cells(plan: &Plan, row: &Row, axis: &Axis, width: usize) -> (Vec<Option<Kind>>, Vec<char>) {
    let mut most: Vec<(Option<Kind>, f64)> = vec![(None, 0.0); width];
    let column = |time: f64| axis.share(time) * width as f64;
    for bar in &row.bars {
        let (from, to) = (column(bar.start).max(0.0), column(bar.end).min(width as f64));
        for (index, cell) in most.iter_mut().enumerate().take(to.ceil() as usize).skip(from as usize) {
            let share = (to.min(index as f64 + 1.0) - from.max(index as f64)).max(0.0);
            if share > cell.1 {
                *cell = (Some(bar.kind), share);
            }
        }
    }
    let mut cells: Vec<Option<Kind>> = most.into_iter().map(|cell| cell.0).collect();
    let serves = |bar: &&Bar| matches!(bar.kind, Kind::Phase(Phase::Serving) | Kind::Served);
    for bar in row.bars.iter().filter(serves) {
        let middle = column(0.5 * (bar.start + bar.end)) as usize;
        cells[middle.min(width - 1)] = Some(bar.kind);
    }
    let mut line: Vec<char> = cells.iter().map(|cell| cell.map_or(' ', |kind| look(kind).0)).collect();
    for bar in row.bars.iter().filter(|bar| matches!(bar.kind, Kind::Task(_))) {
        line[(column(bar.start) as usize).min(width - 1)] = '|';
    }
    for service in row.services() {
        write_label(plan, row.actor, service, &column, &cells, &mut line);
    }
    (cells, line)
}

/// Writes the served agent into the longest phase of the service, and the number of an operation at its begin; only if
/// a column before and one after it still show the phase. Never overwrites the serving phase.
fn write_label(
    plan: &Plan,
    actor: Actor,
    service: &[Bar],
    column: &impl Fn(f64) -> f64,
    cells: &[Option<Kind>],
    line: &mut [char],
) {
    let kept = |bar: &&Bar| !matches!(bar.kind, Kind::Waits | Kind::Served | Kind::Phase(Phase::Serving));
    let runs = service.iter().filter(kept).map(|bar| {
        let shown = |cell: &usize| cells[*cell] == Some(bar.kind);
        let mut within = column(bar.start) as usize..(column(bar.end).ceil() as usize).min(cells.len());
        let first = within.find(shown).unwrap_or(cells.len());
        let count = within.take_while(shown).count() + 1;
        (count, std::cmp::Reverse(first), bar)
    });
    let Some((count, std::cmp::Reverse(first), bar)) = runs.max_by_key(|run| (run.0, run.1)) else { return };
    let text = match (actor, bar.kind) {
        (Actor::Robot(_), _) | (_, Kind::Task(_)) => label(plan, bar),
        (Actor::Agent(_), _) => (bar.target.operation + 1).to_string(),
    };
    let text = shown(&text, LONGEST + 4);
    let text = in_cells(&text);
    if text.len() + 2 <= count {
        line.iter_mut().skip(first + 1).zip(text).for_each(|(cell, c)| *cell = c);
    }
}

/// Draws a row of the chart, without trailing spaces.
fn paint(cells: &[Option<Kind>], line: &[char], colour: bool, out: &mut String) {
    let end = line.iter().rposition(|c| *c != ' ').map_or(0, |last| last + 1);
    let mut at = 0;
    for stretch in cells[..end].chunk_by(|a, b| a == b) {
        let text: String = line[at..at + stretch.len()].iter().filter(|c| **c != COVERED).collect();
        at += stretch.len();
        match stretch[0] {
            Some(kind) if colour => {
                let _ = write!(out, "\x1b[{}m{text}\x1b[0m", look(kind).1);
            }
            _ => out.push_str(&text),
        }
    }
    out.push('\n');
}

/// Draws the legend of the characters that occur in the chart.
fn legend(rows: &[Row], longest: usize, colour: bool, out: &mut String) {
    let has = |kind: Kind| rows.iter().flat_map(|row| &row.bars).any(|bar| bar.kind == kind);
    let entries = Phase::ALL.into_iter().filter(|phase| has(Kind::Phase(*phase))).map(|phase| {
        let (c, sgr) = look(Kind::Phase(phase));
        let sign = if colour { format!("\x1b[{sgr}m{c}\x1b[0m") } else { c.to_string() };
        format!("{sign} {}", phase.name())
    });
    let layered = rows.iter().flat_map(|row| &row.bars).any(|bar| matches!(bar.kind, Kind::Task(_)));
    let tasks = layered.then(|| "|= |- tasks, of one layer and of the next".to_string());
    let _ = writeln!(out, "{:longest$}  {}", "", entries.chain(tasks).collect::<Vec<_>>().join("  "));
}
