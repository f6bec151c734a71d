//! Layout of the SVG: positions of boxes, rows and lines.
//!
//! States are stacked vertically, inner states within the box of their parent. Each transition is a row of its state's
//! box with its trigger; from the end of the row, a line leads right to a lane beside all boxes, and along it to the
//! box of the target. Only the boxes around a state are between it and the lanes, so no line crosses a text. All
//! transitions to a state share its lane; fault transitions have a lane of their own.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use super::Chart;

/// Width of a character (px).
pub(super) const LETTER: f64 = 7.3;
/// Height of a row (px).
pub(super) const ROW: f64 = 18.0;
/// Height of a title (px).
pub(super) const TITLE: f64 = 26.0;
/// Distance between a border and the contents (px).
pub(super) const PAD: f64 = 12.0;
/// Distance left of inner states, for the dot of the initial state (px).
const LEFT: f64 = 34.0;
/// Distance between states, and around the picture (px).
const GAP: f64 = 14.0;
/// Distance between lanes (px).
const LANE: f64 = 16.0;
/// Maximum number of characters in a row before it is wrapped.
const MOST: usize = 76;

/// A line of text in a box.
pub(super) struct Row {
    /// Text of the row.
    pub text: String,
    /// Vertical centre (px).
    pub y: f64,
    /// Transition of the row; only in the first of several rows of a transition.
    pub edge: Option<usize>,
}

/// Box of a state.
#[derive(Default)]
pub(super) struct Place {
    pub x: f64,
    pub y: f64,
    pub width: f64,
    pub height: f64,
    pub rows: Vec<Row>,
}

impl Place {
    /// Height at which lines arrive.
    pub fn arrival(&self) -> f64 {
        self.y + TITLE / 2.0
    }

    pub fn right(&self) -> f64 {
        self.x + self.width
    }
}

/// Transitions to a state, either ordinary ones or faults.
pub(super) struct Lane {
    pub to: usize,
    pub fault: bool,
    pub x: f64,
    /// Transitions, each with the height of its row.
    pub rows: Vec<(usize, f64)>,
}

/// Layout of the whole picture.
pub(super) struct Layout {
    pub places: Vec<Place>,
    pub lanes: Vec<Lane>,
    pub width: f64,
    pub height: f64,
}

/// Label at the end of a row: the target of the transition.
pub(super) fn leads_to(c: &Chart, to: usize) -> String {
    format!("→ {}", c.machine.states[to].name)
}

pub(super) fn of(c: &Chart) -> Layout {
    let n = c.machine.states.len();
    let mut ways = vec![Vec::new(); n];
    for (i, e) in c.edges.iter().enumerate() {
        ways[e.from].push(i);
    }
    let mut places: Vec<Place> = (0..n).map(|s| Place { rows: rows(c, s, &ways[s]), ..Place::default() }).collect();
    // Sizes from the inside out, in reverse order: a state precedes its inner states.
    for s in (0..n).rev() {
        let own = places[s].rows.iter().map(|r| letters(c, r)).max().unwrap_or(0).max(c.short(s).chars().count() + 10);
        let inner = c.children[s].iter().map(|&k| places[k].width + LEFT + PAD).fold(0.0, f64::max);
        let below: f64 = c.children[s].iter().map(|&k| places[k].height + GAP).sum();
        let height = TITLE + ROW * places[s].rows.len() as f64;
        places[s].width = inner.max(own as f64 * LETTER + 2.0 * PAD);
        places[s].height = if below > 0.0 { height + GAP + below } else { height + PAD / 2.0 };
    }
    if let Some(root) = places.first_mut() {
        (root.x, root.y) = (GAP, GAP);
    }
    for s in 0..n {
        let (x, mut y, width) = (places[s].x, places[s].y + TITLE, places[s].width);
        for row in &mut places[s].rows {
            row.y = y + ROW / 2.0;
            y += ROW;
        }
        y += GAP;
        for &k in &c.children[s] {
            (places[k].x, places[k].y, places[k].width) = (x + LEFT, y, width - LEFT - PAD);
            y += places[k].height + GAP;
        }
    }
    let mut lanes = lanes(c, &places);
    let right = places.first().map_or(0.0, Place::right);
    let count = assign(&mut lanes, &places, right);
    let height = places.first().map_or(0.0, |p| p.height) + 2.0 * GAP;
    Layout { places, lanes, width: right + LANE * (count + 1) as f64 + GAP, height }
}

/// Length of a row with its label (characters).
fn letters(c: &Chart, row: &Row) -> usize {
    let end = row.edge.map_or(0, |e| leads_to(c, c.edges[e].to).chars().count() + 3);
    row.text.chars().count() + end
}

fn rows(c: &Chart, s: usize, ways: &[usize]) -> Vec<Row> {
    let about = c.about(s).into_iter().map(|text| (text, None));
    let ways = ways.iter().map(|&e| (c.edges[e].text.to_string(), Some(e)));
    let mut out = Vec::new();
    for (text, edge) in about.chain(ways) {
        for (i, text) in broken(&text).into_iter().enumerate() {
            out.push(Row { text, y: 0.0, edge: edge.filter(|_| i == 0) });
        }
    }
    out
}

/// Wraps a text to lines of limited length.
fn broken(text: &str) -> Vec<String> {
    let mut out = vec![String::new()];
    for word in text.split_whitespace() {
        let letters: Vec<char> = word.chars().collect();
        for (i, piece) in letters.chunks(MOST).enumerate() {
            let long = out.last().map_or(0, |l| l.chars().count());
            if long > 0 && (i > 0 || long + piece.len() + 1 > MOST) {
                out.push("  ".to_string());
            }
            if let Some(line) = out.last_mut() {
                if !line.trim().is_empty() {
                    line.push(' ');
                }
                line.extend(piece);
            }
        }
    }
    out
}

fn lanes(c: &Chart, places: &[Place]) -> Vec<Lane> {
    let mut all: BTreeMap<(usize, bool), Vec<(usize, f64)>> = BTreeMap::new();
    for row in places.iter().flat_map(|p| &p.rows) {
        if let Some(e) = row.edge {
            all.entry((c.edges[e].to, c.edges[e].fault)).or_default().push((e, row.y));
        }
    }
    all.into_iter().map(|((to, fault), rows)| Lane { to, fault, x: 0.0, rows }).collect()
}

/// Assigns each lane the innermost column that is free along it; returns the number of columns.
fn assign(lanes: &mut [Lane], places: &[Place], right: f64) -> usize {
    let ends = |l: &Lane| {
        let at = places[l.to].arrival();
        l.rows.iter().fold((at, at), |(low, high), r| (f64::min(low, r.1), f64::max(high, r.1)))
    };
    lanes.sort_by(|a, b| ends(a).0.total_cmp(&ends(b).0));
    // Integers, because `BinaryHeap` needs a total order.
    let whole = |y: f64| (y * 16.0) as i64;
    let mut busy: BinaryHeap<Reverse<(i64, usize)>> = BinaryHeap::new();
    let mut free: BinaryHeap<Reverse<usize>> = BinaryHeap::new();
    let mut count = 0;
    for lane in lanes.iter_mut() {
        let (top, bottom) = ends(lane);
        while let Some(Reverse((_, place))) = busy.peek().copied().filter(|b| b.0.0 < whole(top)) {
            busy.pop();
            free.push(Reverse(place));
        }
        let place = free.pop().map_or_else(
            || {
                count += 1;
                count - 1
            },
            |f| f.0,
        );
        busy.push(Reverse((whole(bottom), place)));
        lane.x = right + LANE * (place + 1) as f64;
    }
    count
}
