//! A task of a stack, and where its numbers stand.

use std::ops::Range;

use stdlib_tasks::dimension::Dimension;
use stdlib_tasks::task::{Measure, Nature, RowInfo};

/// A task of the stack, and where its numbers stand.
#[derive(Clone, Debug)]
pub struct Member {
    /// The task's name.
    pub name: String,
    /// Its type.
    pub kind: &'static str,
    /// Target or limit.
    pub nature: Nature,
    /// Index of its level.
    pub level: usize,
    /// Its rows in that level.
    pub rows: Range<usize>,
    /// What the rows are called.
    pub row_info: Vec<RowInfo>,
    /// Its place in [`Evaluator::margins`]; empty for targets.
    pub margins: Range<usize>,
    /// Its place in [`Evaluator::measures`]; empty for limits.
    pub measures: Range<usize>,
    /// What the measures are called.
    pub measure_info: Vec<Measure>,
    /// Index of the task in the program.
    pub program_index: usize,
    /// True where the coefficients of the rows never change.
    pub constant: bool,
    /// Places of its parameters in the table of values.
    pub slots: Vec<usize>,
    /// For each row, whether it was proven to have no say while joints stand inside their limits; empty where none was.
    pub idle: Vec<bool>,
}

impl Member {
    /// The dimension that all rows share, if they do.
    pub fn dimension(&self) -> Option<Dimension> {
        let first = self.row_info.first()?.dimension;
        self.row_info.iter().all(|r| r.dimension == first).then_some(first)
    }
}
