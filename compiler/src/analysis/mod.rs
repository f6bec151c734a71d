//! Properties of a program that hold for all configurations and times: ranges of expressions, and rows that never act.

pub(crate) mod idle_rows;
pub(crate) mod value_ranges;
