//! An output file of a command. It replaces an earlier file of its kind, and nothing else.

use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Result, Write};
use std::path::{Path, PathBuf};

use crate::{Draft, is_same, read_up_to, reason};

/// Number of bytes that are read to recognise the kind of a file.
const HEAD: u64 = 4096;

/// A kind of file, recognised by its first bytes.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Its name in messages, with an article: "a picture".
    pub name: &'static str,
    /// Returns true if a file that begins with these bytes is of this kind. It gets at most 4096 bytes, fewer of a
    /// shorter file.
    pub begins: fn(&[u8]) -> bool,
}

impl Kind {
    /// Returns true if the file at `path` is of this kind or empty, or if there is no file.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn is_at(&self, path: &Path) -> Result<bool> {
        match read_up_to(path, HEAD) {
            Ok(head) => Ok(head.is_empty() || (self.begins)(&head)),
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(true),
            Err(e) => Err(e),
        }
    }
}

/// A checked path for an output file: free, or taken by a file of its kind.
#[derive(Clone, Debug)]
pub struct Target {
    path: PathBuf,
    kind: Kind,
    /// The path leads to a device or a pipe, which is written directly.
    stream: bool,
}

impl Target {
    /// Checks a path for an output file of this kind. `option` is the command-line option that requests the file. None
    /// of `sources`, the input files, may be overwritten.
    ///
    /// # Errors
    /// Returns a message for the user if the path is a folder, a source, a link or write-protected, or if it has a file
    /// of another kind.
    pub fn new(option: &str, path: &Path, kind: Kind, sources: &[PathBuf]) -> std::result::Result<Target, String> {
        let shown = path.display();
        let cannot = |why: &str| Err(format!("cannot write `{shown}`: {why}"));
        if path.file_name().is_none() {
            return cannot("it is a folder");
        }
        if sources.iter().any(|source| is_same(path, source)) {
            return Err(format!("{option} `{shown}` would overwrite what it is made from; give another file"));
        }
        // `metadata` follows links: `/dev/stdout` is one, to a terminal or to a pipe.
        let stream = match std::fs::metadata(path) {
            Ok(about) if about.is_dir() => return cannot("it is a folder"),
            Ok(about) => !about.is_file(),
            Err(_) => false,
        };
        let target = Target { path: path.into(), kind, stream };
        target.check()?;
        Ok(target)
    }

    /// Returns true for a device or a pipe, which is written directly.
    pub fn is_stream(&self) -> bool {
        self.stream
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Rejects a link, a write-protected file and a file of another kind.
    fn check(&self) -> std::result::Result<(), String> {
        let shown = self.path.display();
        if self.stream {
            return Ok(());
        }
        if let Ok(behind) = self.path.read_link() {
            let behind = behind.display();
            return Err(format!("`{shown}` is a link to `{behind}`, and is not followed; name a file"));
        }
        if self.path.metadata().is_ok_and(|about| about.permissions().readonly()) {
            return Err(format!("cannot write `{shown}`: it is protected against writing"));
        }
        let known = self.kind.is_at(&self.path).map_err(|e| format!("cannot write `{shown}`: {}", reason(&e)))?;
        if known {
            return Ok(());
        }
        Err(format!(
            "`{shown}` is there already and is not {} that Hierarq wrote, so it is kept; give another file, or move it away",
            self.kind.name
        ))
    }

    /// Opens the file for writing.
    ///
    /// # Errors
    /// Returns a message for the user if the file cannot be created.
    pub fn begin(self) -> std::result::Result<Output, String> {
        let failed = |e: std::io::Error| format!("cannot write `{}`: {e}", self.path.display());
        let to = if self.stream {
            To::Stream(OpenOptions::new().write(true).open(&self.path).map_err(failed)?)
        } else {
            To::Draft(Draft::new(&self.path).map_err(failed)?)
        };
        Ok(Output { to, target: self })
    }

    /// Writes the whole file.
    ///
    /// # Errors
    /// Returns a message for the user if the file cannot be written; the old file then stays unchanged.
    pub fn write(self, text: &str) -> std::result::Result<(), String> {
        let mut output = self.begin()?;
        output.write_all(text.as_bytes()).map_err(|e| output.cannot(&e))?;
        output.finish()
    }
}

/// A file that is being written. If it is dropped before it is [finished](Output::finish), the old file stays.
#[derive(Debug)]
pub struct Output {
    to: To,
    target: Target,
}

#[derive(Debug)]
enum To {
    Draft(Draft),
    Stream(File),
}

impl Output {
    /// Formats the message for an I/O error.
    pub fn cannot(&self, e: &std::io::Error) -> String {
        format!("cannot write `{}`: {e}", self.target.path.display())
    }

    /// Returns the underlying file.
    pub fn file(&mut self) -> &mut File {
        match &mut self.to {
            To::Draft(draft) => draft.file(),
            To::Stream(file) => file,
        }
    }

    /// Moves the file to its path.
    ///
    /// # Errors
    /// Returns a message for the user if the file cannot be completed, or if a file of another kind has appeared at its
    /// path.
    pub fn finish(self) -> std::result::Result<(), String> {
        let failed = |e: std::io::Error| format!("cannot write `{}`: {e}", self.target.path.display());
        self.target.check()?;
        match self.to {
            To::Draft(draft) => draft.keep().map_err(failed),
            To::Stream(mut file) => file.flush().map_err(failed),
        }
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> Result<usize> {
        match &mut self.to {
            To::Draft(draft) => draft.write(bytes),
            To::Stream(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> Result<()> {
        match &mut self.to {
            To::Draft(draft) => draft.flush(),
            To::Stream(file) => file.flush(),
        }
    }
}
