//! Files that grow line by line, each locked by one program at a time.

use std::fmt;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Error, ErrorKind};
use std::path::Path;

/// Removes a file of Hierarq's own that is no longer needed.
///
/// # Errors
/// If it cannot be removed.
pub fn remove(path: &Path) -> std::io::Result<()> {
    std::fs::remove_file(path)
}

/// Reason why a journal cannot be opened.
#[derive(Debug)]
pub enum Unopened {
    /// Another program holds the lock.
    Locked,
    /// Any other error.
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

/// Opens a journal for reading and writing, positioned at its beginning; creates an empty one if there is none. The
/// lock is held until the file is closed.
///
/// # Errors
/// If another program holds the lock, if the path is a link, a folder, a device or a pipe, or if the file cannot be
/// written.
pub fn journal(path: &Path) -> Result<File, Unopened> {
    match path.symlink_metadata() {
        // A link may lead into a file of somebody else: only the named file itself is written.
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
        // Some network file systems have no locks.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
    }
}
