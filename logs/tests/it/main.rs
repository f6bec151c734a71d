//! Logs in MCAP, written, read again and refused.

mod python;
mod refusals;
mod replays;
mod round_trip;
mod runs;
mod waiting;
