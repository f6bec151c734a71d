//! Properties of a program that hold for all configurations and times: ranges of expressions, rows that never act,
//! conditions that exclude or imply each other, postures that meet targets, and what a machine can do.

pub(crate) mod conditions;
pub(crate) mod exploration;
pub(crate) mod idle_rows;
pub(crate) mod played;
pub(crate) mod postures;
pub(crate) mod regions;
pub(crate) mod stacks;
pub(crate) mod value_ranges;
pub(crate) mod wording;
