//! Both syntaxes of the language: one file a subject.

mod common;
mod hostile;
mod machines;
mod meaning;
mod missions;
mod mistakes;
mod syntaxes;
mod tables;
