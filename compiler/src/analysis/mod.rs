//! What is proven of a program for all configurations and times: ranges of expressions, rows that never act.

pub(crate) mod idle_rows;
pub(crate) mod value_ranges;
