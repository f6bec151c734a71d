//! Properties of a program that hold for all configurations and times: ranges of expressions, rows that never act, and
//! conditions that exclude or imply each other.

pub(crate) mod conditions;
pub(crate) mod idle_rows;
pub(crate) mod value_ranges;
