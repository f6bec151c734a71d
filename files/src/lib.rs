//! Files of a user: read within bounds, written whole or not at all.
//!
//! All other crates read and write files through this one. Nothing is read that may never end, a device or a pipe, and
//! nothing without a bound on its size. Nothing is written in place: a [`Draft`] with a name of its own is written,
//! brought to the disk and renamed, so that whatever ends the program leaves the old file or the new one. An
//! [`Output`] replaces what it knows as its own [`Kind`] of file, and nothing else; it never follows a link. A run
//! [claims](Results) the folder of its results for itself.

mod draft;
mod fresh;
mod identity;
mod journal;
mod output;
mod read;
mod results;

pub use draft::{Draft, replace, settle};
pub use fresh::{begin, create};
pub use identity::is_same;
pub use journal::{Unopened, journal, remove};
pub use output::{Kind, Output, Target};
pub use read::{open, read, read_up_to, reason, stream};
pub use results::Results;
