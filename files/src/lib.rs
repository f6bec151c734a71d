//! Access to the user's files: reads are bounded in size, writes are atomic.
//!
//! All other crates read and write files through this one. Inputs that may never end (devices, pipes) are rejected
//! unless the caller asks for a [`stream`]. No file is written in place: a [`Draft`] with a temporary name is written,
//! flushed and renamed, so that an interrupted program leaves either the old file or the new one. An [`Output`]
//! replaces only files of its own [`Kind`], and never follows a link. A run [claims](Results) the folder of its
//! results.

mod draft;
mod fresh;
mod identity;
mod journal;
mod output;
mod read;
mod results;
mod word;

pub use draft::{Draft, replace, settle};
pub use fresh::{begin, create};
pub use identity::is_same;
pub use journal::{Unopened, journal, remove};
pub use output::{Kind, Output, Target};
pub use read::{open, read, read_up_to, reason, stream};
pub use results::Results;
pub use word::quoted;
