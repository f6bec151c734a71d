//! The Gantt chart of a plan as data: a row for each member, a bar for each interval.

/// A chart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// A row for each member, also without bars.
    pub rows: Vec<Row>,
    /// Bars with their meanings, in order; those that do not occur in the chart are omitted.
    pub legend: Vec<Entry>,
    /// Meaning of bars in the colours of groups, where colours are few.
    pub groups: &'static str,
}

/// A row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Label of the member.
    pub name: String,
    /// Place of the labels of its bars.
    pub labels: LabelPlace,
    /// Its bars, by time.
    pub bars: Vec<Bar>,
}

/// Place of labels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LabelPlace {
    /// Above, once for consecutive bars with the same work.
    Above,
    /// Within each bar.
    Within,
}

/// An interval in a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// Appearance and name.
    pub style: &'static Style,
    /// Group whose colour it has, if any.
    pub group: Option<usize>,
    /// Number of the work to which it belongs.
    pub work: usize,
    /// Text for this work under the pointer.
    pub title: String,
    /// Label of this work.
    pub label: Option<String>,
    /// Start (s).
    pub start: f64,
    /// End (s).
    pub end: f64,
    /// Mean speed of a motion (m/s).
    pub speed: Option<f64>,
    /// True if it had begun when the plan was made.
    pub begun: bool,
}

/// Appearance of bars. Kinds of bars differ in height and character as well as in colour.
#[derive(Debug, PartialEq)]
pub struct Style {
    /// Name under the pointer and in the legend. It is also the class in a picture, and the style sheet has its colour
    /// unless bars have those of groups.
    pub name: &'static str,
    /// Height in a picture (px).
    pub height: f64,
    /// Character in a terminal. A group with an odd number has a hyphen.
    pub sign: char,
    /// Colour in a terminal, a parameter of the sequence `SGR`.
    pub colour: &'static str,
    /// True for an activity of the plan; false for an interval that follows from activities in other rows.
    pub activity: bool,
    /// True if a terminal shows it in at least one column, and no label covers it.
    pub kept: bool,
}

/// An entry of the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Appearance of the bars.
    pub style: &'static Style,
    /// Their group, if any.
    pub group: Option<usize>,
    /// Meaning.
    pub text: String,
}

impl Bar {
    /// True if its times can be drawn.
    pub fn is_drawable(&self) -> bool {
        self.start.is_finite() && self.end.is_finite() && self.start <= self.end
    }
}

impl Row {
    /// Creates a row from bars in any order; those whose times cannot be drawn are omitted.
    pub fn new(name: String, labels: LabelPlace, mut bars: Vec<Bar>) -> Row {
        bars.retain(Bar::is_drawable);
        bars.sort_by(|a, b| a.start.total_cmp(&b.start).then(a.end.total_cmp(&b.end)));
        Row { name, labels, bars }
    }

    /// Returns groups of consecutive bars with the same work.
    pub fn works(&self) -> impl Iterator<Item = &[Bar]> {
        self.bars.chunk_by(|a, b| a.work == b.work)
    }
}

impl Chart {
    /// Returns the start of the first bar (s); `None` without bars.
    pub fn start(&self) -> Option<f64> {
        self.bars().map(|bar| bar.start).reduce(f64::min)
    }

    /// Returns the end of the last bar (s); `None` without bars.
    pub fn end(&self) -> Option<f64> {
        self.bars().map(|bar| bar.end).reduce(f64::max)
    }

    /// Returns all bars.
    pub fn bars(&self) -> impl Iterator<Item = &Bar> {
        self.rows.iter().flat_map(|row| &row.bars)
    }
}
