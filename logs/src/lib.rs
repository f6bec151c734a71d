//! Logs of runs that other programs read: MCAP with ROS 2 messages, each with its definition.
//!
//! [`McapRecorder`] writes the log of a run; the messages are made by [`Messages`] from [`Snapshot`]s of ticks. [`Log`] reads
//! it, [`replay`](replay::replay) runs its program again, and [`csv`] has the same numbers as `log.csv`.

pub mod about;
pub mod cdr;
pub mod csv;
pub mod decode;
pub mod definitions;
mod description;
mod file;
mod markers;
mod messages;
mod queue;
mod read;
mod recorder;
pub mod replay;
mod scene;
mod snapshot;
pub mod topics;

pub use about::{About, Origin, SourceText};
pub use file::LogFile;
pub use messages::{Emit, Messages};
pub use queue::{NotSent, Queue, TickReceiver, TickSender, queue};
pub use read::{Log, LogError};
pub use recorder::{Finished, McapRecorder, Overflow, Written};
pub use snapshot::{Camera, LevelNumbers, Snapshot};
