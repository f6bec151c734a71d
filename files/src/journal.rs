//! A file that grows line by line, for one program at a time.

use std::fmt;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Error, ErrorKind};
use std::path::Path;

/// Removes a journal that is no longer needed.
///
/// # Errors
/// It cannot be removed.
pub fn remove(path: &Path) -> std::io::Result<()> {
    std::fs::remove_file(path)
}

/// Why a journal cannot be opened.
#[derive(Debug)]
pub enum Unopened {
    /// Another program has it.
    Locked,
    /// Anything else.
    Io(Error),
}

impl fmt::Display for Unopened {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Unopened::Locked => f.write_str("another program is writing it"),
            Unopened::Io(e) => e.fmt(f),
        }
    }
}

/// Opens a journal to be read and written, at its beginning, or makes an empty one; nobody else has it until it is closed.
///
/// # Errors
/// It is another's, a link, a folder, a device or a pipe, or cannot be written.
pub fn journal(path: &Path) -> Result<File, Unopened> {
    match path.symlink_metadata() {
        // What is written must be what was named: a link may lead into a file of somebody else.
        Ok(about) if about.is_symlink() => {
            return Err(Unopened::Io(Error::new(ErrorKind::InvalidInput, "it is a link, and is not followed")));
        }
        Ok(about) => crate::read::regular(&about).map_err(Unopened::Io)?,
        Err(_) => {}
    }
    let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
    let file = file.map_err(Unopened::Io)?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(Unopened::Locked),
        // Some network folders know no locks.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
    }
}
