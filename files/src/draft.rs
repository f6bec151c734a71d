//! A file on its way: written beside its place under a name of its own, and moved there once it is whole.

use std::fs::{File, OpenOptions, Permissions};
use std::hash::{BuildHasher, RandomState};
use std::io::{Error, ErrorKind, Result, Write};
use std::path::{Path, PathBuf};

/// Names that are tried; each has 64 random bits.
const TRIES: usize = 16;

/// A file that is not there yet. Dropped before it is [kept](Draft::keep), it leaves nothing.
#[derive(Debug)]
pub struct Draft {
    file: File,
    beside: PathBuf,
    target: PathBuf,
    kept: bool,
}

impl Draft {
    /// Begins a file that will stand at `target`, under a random name in the same folder.
    ///
    /// # Errors
    /// No file can be made in that folder.
    pub fn new(target: &Path) -> Result<Draft> {
        Draft::named(target, false)
    }

    /// Begins a file as [`new`](Draft::new) does that only its owner may read, from the first byte on.
    ///
    /// # Errors
    /// No file can be made in that folder.
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

    /// Begins a file that will stand at `target` and has the name `beside` until then, a name that nothing has yet.
    ///
    /// # Errors
    /// No file can be made there.
    pub(crate) fn at(beside: &Path, target: &Path, private: bool) -> Result<Draft> {
        // `create_new` follows no link, and overwrites nothing.
        let mut options = OpenOptions::new();
        options.read(true).write(true).create_new(true);
        #[cfg(unix)]
        if private {
            std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        }
        let file = options.open(beside)?;
        Ok(Draft { file, beside: beside.into(), target: target.into(), kept: false })
    }

    /// The file, to be written at any place of it.
    pub fn file(&mut self) -> &mut File {
        &mut self.file
    }

    /// Brings what was written to the disk, gives it the permissions of the file that it replaces, and moves it to its
    /// place in one step.
    ///
    /// # Errors
    /// It cannot be written to the end, or moved, or what it would replace may not be written; then all is as it was.
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

/// The permissions of the file that is replaced, if there is one.
fn replaced(target: &Path) -> Result<Option<Permissions>> {
    match target.symlink_metadata() {
        Ok(about) if about.is_file() => {
            // To rename over it would be allowed, and is not what whoever protected it wants.
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

/// Brings the name of a file to the disk, as far as the system can.
pub fn settle(path: &Path) {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // Not all systems open folders, and the file itself is there already.
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
}

/// Replaces the text of a file that was read: behind a link the file that it leads to. What somebody else has written
/// since then stays.
///
/// # Errors
/// It cannot be written, or is not as it was read.
pub fn replace(path: &Path, read: &str, text: &str) -> Result<()> {
    let target = path.canonicalize()?;
    let mut draft = Draft::new(&target)?;
    draft.write_all(text.as_bytes())?;
    if crate::read_up_to(&target, read.len() as u64 + 1)? != read.as_bytes() {
        return Err(Error::other("it was changed in the meantime"));
    }
    draft.keep()
}
