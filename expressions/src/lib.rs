//! Expressions as data: their operations, and functions of a few numbers that are made of them. The compiler writes them;
//! what evaluates them needs no text.

mod function;
mod op;

pub use function::{Function, MAX_OPERATIONS, Registers, check};
pub use op::{Op, ROUNDING};
