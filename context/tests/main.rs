//! Layered plans from a language model, played by a script: one file a subject.

#![allow(clippy::unwrap_used, reason = "a test that cannot unwrap fails")]

mod common;
mod layers;
mod server;
