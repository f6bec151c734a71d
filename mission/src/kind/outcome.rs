//! Results of an execution: data for files, tables for people, and the work of members for the controllers that they run.

use crate::chart::Chart;

/// Results of an execution.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// Number of repairs that moved times of the plan.
    pub reschedules: usize,
    /// Number of times that the rest was planned anew.
    pub reallocations: usize,
    /// Everything, as the kind stores it in files.
    pub data: serde_json::Value,
    /// Everything, for people.
    pub tables: Vec<Table>,
}

/// A table for people.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Heads of the columns.
    pub columns: Vec<&'static str>,
    /// Rows, a cell a column.
    pub rows: Vec<Vec<Cell>>,
}

/// A part of a report beside the plan, the map and the log.
#[derive(Clone, Debug, PartialEq)]
pub enum ReportPart {
    /// A chart over time.
    Chart {
        /// Title.
        title: &'static str,
        /// The chart.
        chart: Chart,
    },
    /// A table.
    Table {
        /// Title.
        title: &'static str,
        /// The table.
        table: Table,
    },
}

/// A cell of a table or a log.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// A text.
    Text(String),
    /// A count.
    Count(usize),
    /// A number in SI with its unit; in a log without.
    Number(f64, &'static str),
}

/// The work of a member, as far as a controller that it runs needs to know it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Work {
    /// State.
    pub state: WorkState,
    /// Since when (s).
    pub since: f64,
}

/// State of a member's work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorkState {
    /// A piece of work is under way.
    Works,
    /// None is under way, and one is to come.
    Waits,
    /// None is to come any more.
    Over,
    /// The member is lost.
    Lost,
}
