//! Expectations: a log judged as a whole and tick by tick, against the definitions, the laws of logic and rtamt.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod brute;
mod cases;
mod generate;
mod laws;
mod rtamt;
