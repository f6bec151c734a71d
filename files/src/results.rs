//! The folder of a run's results: one run at a time, and never a mix of the results of two runs.
//!
//! From its start on, a run owns the folder, and the results of the previous run are removed. Its own files are written
//! under temporary names and renamed at the end, the verdict on the run last. A run that is killed leaves at most the
//! files that grew with it; their names end in `.part`.

use std::fs::{File, TryLockError};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use crate::Draft;
use crate::output::{Kind, Target};

/// Suffix of the name of a growing file.
const PART: &str = ".part";

/// Results of a run in progress.
#[derive(Debug)]
pub struct Results {
    folder: PathBuf,
    /// Files in the order in which they are renamed.
    drafts: Vec<(String, Draft)>,
    /// Held until the results are complete. None if the system cannot lock folders.
    _lock: Option<File>,
}

impl Results {
    /// Claims a folder, which is created if it is missing, for files of these names and kinds. Removes the files of the
    /// previous run. None of `sources`, the input files, may be among them.
    ///
    /// # Errors
    /// Returns a message for the user if another run has claimed the folder, or if one of the names has a file of
    /// another kind.
    pub fn begin(folder: &Path, files: &[(&str, Kind)], sources: &[PathBuf]) -> Result<Results, String> {
        let shown = folder.display();
        std::fs::create_dir_all(folder).map_err(|e| format!("cannot create {shown}: {e}"))?;
        let lock = lock(folder)?;
        let mut former = Vec::new();
        for (name, kind) in files {
            for path in [folder.join(name), folder.join(format!("{name}{PART}"))] {
                if Target::new("--out", &path, *kind, sources)?.is_stream() {
                    return Err(format!("cannot write `{}`: it is a device or a pipe, and no file", path.display()));
                }
                former.push(path);
            }
        }
        // In reverse order, because the last file is the verdict: a run that is interrupted here leaves no verdict on
        // results that are partly removed.
        for path in former.iter().rev() {
            match std::fs::remove_file(path) {
                Err(e) if e.kind() != ErrorKind::NotFound => {
                    return Err(format!("cannot replace `{}`: {e}", path.display()));
                }
                _ => {}
            }
        }
        Ok(Results { folder: folder.into(), drafts: Vec::new(), _lock: lock })
    }

    /// Creates a file that grows with the run, to be passed to [`Results::add`] at the end. Until then its name ends in
    /// `.part`, and it stays if the run is killed.
    ///
    /// # Errors
    /// Returns a message for the user if it cannot be created.
    pub fn part(&self, name: &str) -> Result<Draft, String> {
        let path = self.folder.join(name);
        Draft::at(&self.folder.join(format!("{name}{PART}")), &path, false)
            .map_err(|e| format!("cannot write `{}`: {e}", path.display()))
    }

    /// Adds a file that was written.
    pub fn add(&mut self, name: &str, draft: Draft) {
        self.drafts.push((name.to_string(), draft));
    }

    /// Adds a file with this text.
    ///
    /// # Errors
    /// Returns a message for the user if it cannot be written.
    pub fn write(&mut self, name: &str, text: &str) -> Result<(), String> {
        let path = self.folder.join(name);
        let failed = |e: std::io::Error| format!("cannot write `{}`: {e}", path.display());
        let mut draft = Draft::new(&path).map_err(failed)?;
        draft.write_all(text.as_bytes()).map_err(failed)?;
        self.add(name, draft);
        Ok(())
    }

    /// Renames all files to their final names, in the order in which they were added.
    ///
    /// # Errors
    /// Returns a message for the user if one of them cannot be renamed, or if its name is taken; the remaining files
    /// are dropped.
    pub fn finish(self) -> Result<(), String> {
        for (name, draft) in self.drafts {
            let path = self.folder.join(name);
            // `begin` removed the files of these names, so that any that exists now belongs to another program.
            if path.symlink_metadata().is_ok() {
                return Err(format!("`{}` was written by somebody else in the meantime, and is kept", path.display()));
            }
            draft.keep().map_err(|e| format!("cannot write `{}`: {e}", path.display()))?;
        }
        Ok(())
    }
}

/// Opens and locks the folder.
fn lock(folder: &Path) -> Result<Option<File>, String> {
    // The lock is on the folder itself: a lock file would stay behind.
    let Ok(lock) = File::open(folder) else { return Ok(None) };
    match lock.try_lock() {
        Ok(()) => Ok(Some(lock)),
        Err(TryLockError::WouldBlock) => {
            let shown = folder.display();
            Err(format!("another run is writing into `{shown}`; wait for its end, or give another folder with --out"))
        }
        // Some systems and some network file systems cannot lock folders.
        Err(TryLockError::Error(_)) => Ok(None),
    }
}
