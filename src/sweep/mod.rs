//! Sweeps: one scenario over ranges of params and over seeds, one row for each run.
//!
//! A run is known from its number alone. Its seed is that of the sweep plus its place at its point of the grid; its drawn
//! values come from that seed and the names of the params ([`axis::drawn`]). So neither the number of threads nor the
//! runs before it, nor how a sweep is shared out among machines, has a say in what it gives: parts of a sweep are put
//! together to the very bytes of the whole.
//!
//! | module | idea |
//! |---|---|
//! | [`axis`] | what `--vary` says, and how values are drawn |
//! | [`plan`] | a sweep that was checked: every run by its number |
//! | [`head`] | what a file says of itself, and the command lines that lead to it and to its runs |
//! | [`row`] | a run as a row; the columns |
//! | [`execute`] | runs on all processors |
//! | [`journal`] | finished runs on the disk, until all are there |
//! | [`table`] | the Parquet file |
//! | [`merge`] | shards put together |
//! | [`digest`] | what came of it all |

pub mod axis;
mod checksum;
pub mod digest;
pub mod execute;
pub mod head;
pub mod journal;
pub mod merge;
pub mod plan;
pub mod row;
pub mod table;

pub use digest::Digest;
pub use head::{Head, Shard};
pub use plan::{Plan, Refusal, Request};
pub use row::Row;
