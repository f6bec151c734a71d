//! Physical quantities: their dimensions, and numbers as text. Everything that declares a number with a unit builds on it.

pub mod dimension;
mod numbers;
mod quantity;
pub mod usual;

pub use numbers::number;
pub use quantity::{Presence, Quantity};
