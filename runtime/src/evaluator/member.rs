//! A task of a stack, and the ranges of its numbers.

use std::ops::Range;

use stdlib_tasks::dimension::Dimension;
use stdlib_tasks::task::{Measure, RowInfo, RowKind};

/// A task of the stack, and the ranges of its numbers.
#[derive(Clone, Debug)]
pub struct Member {
    /// Name of the task.
    pub name: String,
    /// Name of its type.
    pub kind: &'static str,
    /// Target or limit.
    pub row_kind: RowKind,
    /// Index of its level.
    pub level: usize,
    /// Its rows in that level.
    pub rows: Range<usize>,
    /// Descriptions of the rows.
    pub row_info: Vec<RowInfo>,
    /// Its range in [`Evaluator::margins`]; empty for targets.
    pub margins: Range<usize>,
    /// Its range in [`Evaluator::measures`]; empty for limits.
    pub measures: Range<usize>,
    /// Descriptions of the measures.
    pub measure_info: Vec<Measure>,
    /// Index of the task in the program.
    pub program_index: usize,
    /// True if the coefficients of the rows never change.
    pub constant: bool,
    /// Indices of its parameters in the table of values.
    pub slots: Vec<usize>,
    /// True for each row that was proven to be idle (without effect) while all joints are inside their limits; empty if
    /// none was.
    pub idle: Vec<bool>,
    /// Parts of the stack that contain it; its values are those of the first one.
    pub parts: Vec<usize>,
}

impl Member {
    /// Part of the stack whose values it reads.
    pub fn part(&self) -> usize {
        self.parts.first().copied().unwrap_or(0)
    }

    /// Dimension that all rows share, or `None` if they differ.
    pub fn dimension(&self) -> Option<Dimension> {
        let first = self.row_info.first()?.dimension;
        self.row_info.iter().all(|r| r.dimension == first).then_some(first)
    }
}
