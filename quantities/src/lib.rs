//! Physical quantities: their dimensions, and numbers as text. Everything that declares a number with a unit builds on it.

pub mod dimension;
mod numbers;

pub use numbers::number;
