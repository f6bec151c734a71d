//! The folder of a run's results: one run at a time, and never the results of two runs side by side.
//!
//! From its begin on, a run has the folder for itself and the results of the run before are gone. Its own are written
//! aside and moved to their names at the end, the one that judges the run last. A run that is killed leaves no more than
//! the file that grew with it, under a name that says that it is a part.

use std::fs::{File, TryLockError};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

use crate::Draft;
use crate::output::{Kind, Target};

/// The end of the name of a file that grows.
const PART: &str = ".part";

/// The results of a run under way.
#[derive(Debug)]
pub struct Results {
    folder: PathBuf,
    /// Files in the order in which they come to their places.
    drafts: Vec<(String, Draft)>,
    /// Held until the results are there. Where the system locks no folders there is none.
    _lock: Option<File>,
}

impl Results {
    /// Claims a folder, which is made where there is none, for files of these names and kinds. Those of the run before
    /// are removed; none of `sources`, which were read, may be among them.
    ///
    /// # Errors
    /// What to say where another run has the folder, or a file of one of the names is not of its kind.
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
        // The last is the verdict: a run that ends in between leaves no verdict on what is half gone.
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

    /// A file that grows with the run; [`Results::add`] takes it back. Until the end `.part` stands behind its name, and
    /// it stays where the run is killed.
    ///
    /// # Errors
    /// What to say where it cannot be made.
    pub fn part(&self, name: &str) -> Result<Draft, String> {
        let path = self.folder.join(name);
        Draft::at(&self.folder.join(format!("{name}{PART}")), &path, false)
            .map_err(|e| format!("cannot write `{}`: {e}", path.display()))
    }

    /// Adds a file that is written.
    pub fn add(&mut self, name: &str, draft: Draft) {
        self.drafts.push((name.to_string(), draft));
    }

    /// Adds a file of this text.
    ///
    /// # Errors
    /// What to say where it cannot be written.
    pub fn write(&mut self, name: &str, text: &str) -> Result<(), String> {
        let path = self.folder.join(name);
        let failed = |e: std::io::Error| format!("cannot write `{}`: {e}", path.display());
        let mut draft = Draft::new(&path).map_err(failed)?;
        draft.write_all(text.as_bytes()).map_err(failed)?;
        self.add(name, draft);
        Ok(())
    }

    /// Moves all files to their names, in the order in which they were added.
    ///
    /// # Errors
    /// What to say where one cannot be moved, or something else has taken its name; the rest is left out.
    pub fn finish(self) -> Result<(), String> {
        for (name, draft) in self.drafts {
            let path = self.folder.join(name);
            // All of those names were free.
            if path.symlink_metadata().is_ok() {
                return Err(format!("`{}` was written by somebody else in the meantime, and is kept", path.display()));
            }
            draft.keep().map_err(|e| format!("cannot write `{}`: {e}", path.display()))?;
        }
        Ok(())
    }
}

/// The folder, locked.
fn lock(folder: &Path) -> Result<Option<File>, String> {
    // The folder itself: a file for it would stay behind.
    let Ok(lock) = File::open(folder) else { return Ok(None) };
    match lock.try_lock() {
        Ok(()) => Ok(Some(lock)),
        Err(TryLockError::WouldBlock) => {
            let shown = folder.display();
            Err(format!("another run is writing into `{shown}`; wait for its end, or give another folder with --out"))
        }
        // Some systems, and some network folders, lock no folders.
        Err(TryLockError::Error(_)) => Ok(None),
    }
}
