//! Sweeps: one scenario over ranges of params and over seeds, one row for each run.
//!
//! A run is determined by its number alone. Its seed is that of the sweep plus the index of the run at its grid point;
//! its drawn values depend on that seed and the names of the params ([`axis::drawn`]). Therefore the results depend
//! neither on the number of threads, nor on earlier runs, nor on the distribution of a sweep to several machines:
//! merged parts are byte-identical to the whole.
//!
//! | module | idea |
//! |---|---|
//! | [`axis`] | parses `--vary`, and draws values |
//! | [`plan`] | a checked sweep: every run by its number |
//! | [`subject`] | the scenario, of a controller or of a mission, and its columns |
//! | [`head`] | metadata of a file, and the command lines of the sweep and of its runs |
//! | [`row`] | a run as a row; the columns |
//! | [`execute`] | parallel execution of runs |
//! | [`stored`] | a sweep in a file: continued, executed, written |
//! | [`journal`] | finished runs on the disk, until all are complete |
//! | [`table`] | the Parquet file |
//! | [`merge`] | merge of shards |
//! | [`digest`] | summary |

pub mod axis;
mod checksum;
pub mod digest;
pub mod execute;
pub mod head;
pub mod journal;
pub mod merge;
pub mod plan;
pub mod row;
pub mod stored;
mod subject;
pub mod table;

pub use digest::Digest;
pub use head::{Head, Shard};
pub use plan::{Plan, Refusal, Request};
pub use row::Row;
