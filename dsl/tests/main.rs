//! Both spellings of the language: one file a subject.

mod common;
mod hostile;
mod machines;
mod meaning;
mod missions;
mod mistakes;
mod spellings;
mod tables;
