//! Atomic writing: a draft is written next to its target under a temporary name, and moved there when it is complete.

use std::fs::{File, OpenOptions, Permissions};
use std::hash::{BuildHasher, RandomState};
use std::io::{Error, ErrorKind, Result, Write};
use std::path::{Path, PathBuf};

/// Number of temporary names that are tried; each has 64 random bits.
const TRIES: usize = 16;

/// A file that has not reached its target yet. If it is dropped before it is [kept](Draft::keep), nothing remains.
#[derive(Debug)]
pub struct Draft {
    file: File,
    beside: PathBuf,
    target: PathBuf,
    kept: bool,
}

impl Draft {
    /// Creates a draft for `target`, under a random name in the same folder.
    ///
    /// # Errors
    /// If no file can be created in that folder.
    pub fn new(target: &Path) -> Result<Draft> {
        Draft::named(target, false)
    }

    /// Creates a draft like [`new`](Draft::new) that only its owner can read, from the first byte on.
    ///
    /// # Errors
    /// If no file can be created in that folder.
    pub fn private(target: &Path) -> Result<Draft> {
        Draft::named(target, true)
    }

    fn named(target: &Path, private: bool) -> Result<Draft> {
        for _ in 0..TRIES {
            let random = RandomState::new().hash_one(std::process::id());
            match Draft::at(&target.with_file_name(format!(".hierarq-{random:016x}.tmp")), target, private) {
                Err(e) if e.kind() == ErrorKind::AlreadyExists => {}
                draft => return draft,
            }
        }
        Err(ErrorKind::AlreadyExists.into())
    }

    /// Creates a draft for `target` at the temporary path `beside`, which must be free.
    ///
    /// # Errors
    /// If no file can be created there.
    pub(crate) fn at(beside: &Path, target: &Path, private: bool) -> Result<Draft> {
        // `create_new` follows no link and overwrites nothing.
        let mut options = OpenOptions::new();
        options.read(true).write(true).create_new(true);
        #[cfg(unix)]
        if private {
            std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        }
        let file = options.open(beside)?;
        Ok(Draft { file, beside: beside.into(), target: target.into(), kept: false })
    }

    /// Returns the underlying file, for writing at any position.
    pub fn file(&mut self) -> &mut File {
        &mut self.file
    }

    /// Flushes the draft to the disk, copies the permissions of the file that it replaces, and renames it to its target
    /// in one step.
    ///
    /// # Errors
    /// If it cannot be flushed or renamed, or if the target is write-protected; the target then stays unchanged.
    pub fn keep(mut self) -> Result<()> {
        self.file.sync_all()?;
        if let Some(permissions) = replaced(&self.target)? {
            std::fs::set_permissions(&self.beside, permissions)?;
        }
        std::fs::rename(&self.beside, &self.target)?;
        self.kept = true;
        settle(&self.target);
        Ok(())
    }
}

impl Write for Draft {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> Result<()> {
        self.file.flush()
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        if !self.kept {
            let _ = std::fs::remove_file(&self.beside);
        }
    }
}

/// Returns the permissions of the file that is replaced, if there is one.
fn replaced(target: &Path) -> Result<Option<Permissions>> {
    match target.symlink_metadata() {
        Ok(about) if about.is_file() => {
            // `rename` would ignore the write protection of the target.
            if about.permissions().readonly() {
                return Err(Error::new(ErrorKind::PermissionDenied, "it is protected against writing"));
            }
            Ok(Some(about.permissions()))
        }
        Ok(_) => Err(Error::new(ErrorKind::AlreadyExists, "there is something else by that name now")),
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(None),
        Err(e) => Err(e),
    }
}

/// Flushes the folder entry of a file to the disk, as far as the system supports it.
pub fn settle(path: &Path) {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Not all systems open folders, and the file itself is on the disk already.
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

/// Replaces the text of a file that was read before, and follows links. Changes that another program made since then
/// are kept: `read` must still be the content of the file.
///
/// # Errors
/// If the file cannot be written, or if its content is not `read`.
pub fn replace(path: &Path, read: &str, text: &str) -> Result<()> {
    let target = path.canonicalize()?;
    let mut draft = Draft::new(&target)?;
    draft.write_all(text.as_bytes())?;
    if crate::read_up_to(&target, read.len() as u64 + 1)? != read.as_bytes() {
        return Err(Error::other("it was changed in the meantime"));
    }
    draft.keep()
}
