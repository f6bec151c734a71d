//! A file that a command was asked to write. It replaces an earlier one of its kind, and nothing else.

use std::fs::{File, OpenOptions};
use std::io::{ErrorKind, Result, Write};
use std::path::{Path, PathBuf};

use crate::{Draft, is_same, read_up_to, reason};

/// Bytes of a file that are looked at to know its kind.
const HEAD: u64 = 4096;

/// A kind of file, known by how it begins.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Its name in messages, with an article: "a picture".
    pub name: &'static str,
    /// Whether a file that begins with these bytes is one; at most 4096 of them are given, fewer of a shorter file.
    pub begins: fn(&[u8]) -> bool,
}

impl Kind {
    /// Whether the file at a path is of this kind, or empty. True of no file.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn is_at(&self, path: &Path) -> Result<bool> {
        match read_up_to(path, HEAD) {
            Ok(head) => Ok(head.is_empty() || (self.begins)(&head)),
            Err(e) if e.kind() == ErrorKind::NotFound => Ok(true),
            Err(e) => Err(e),
        }
    }
}

/// Where a file is to be written, found free or taken by a file of its kind.
#[derive(Clone, Debug)]
pub struct Target {
    path: PathBuf,
    kind: Kind,
    /// A device or a pipe, into which is written as it comes.
    stream: bool,
}

impl Target {
    /// Looks at where a file of this kind is to be written. `option` is what asks for it; none of `sources`, which were
    /// read, may be overwritten.
    ///
    /// # Errors
    /// What to say where it may not be written there: a folder, a source, a link, or a file that is not of its kind.
    pub fn new(option: &str, path: &Path, kind: Kind, sources: &[PathBuf]) -> std::result::Result<Target, String> {
        let shown = path.display();
        let cannot = |why: &str| Err(format!("cannot write `{shown}`: {why}"));
        if path.file_name().is_none() {
            return cannot("it is a folder");
        }
        if sources.iter().any(|source| is_same(path, source)) {
            return Err(format!("{option} `{shown}` would overwrite what it is made from; give another file"));
        }
        // Behind links: `/dev/stdout` is one, to a terminal or to a pipe.
        let stream = match std::fs::metadata(path) {
            Ok(about) if about.is_dir() => return cannot("it is a folder"),
            Ok(about) => !about.is_file(),
            Err(_) => false,
        };
        let target = Target { path: path.into(), kind, stream };
        target.check()?;
        Ok(target)
    }

    /// Whether this is a device or a pipe, into which is written as it comes.
    pub fn is_stream(&self) -> bool {
        self.stream
    }

    /// The path.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Refuses what may not be replaced.
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

    /// Begins the file.
    ///
    /// # Errors
    /// What to say where no file can be made there.
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
    /// What to say where it cannot be written; then all is as it was.
    pub fn write(self, text: &str) -> std::result::Result<(), String> {
        let mut output = self.begin()?;
        output.write_all(text.as_bytes()).map_err(|e| output.cannot(&e))?;
        output.finish()
    }
}

/// A file that is being written. Dropped before it is [finished](Output::finish), it leaves what was there.
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
    /// What to say of an error.
    pub fn cannot(&self, e: &std::io::Error) -> String {
        format!("cannot write `{}`: {e}", self.target.path.display())
    }

    /// The file itself, where it is no stream.
    pub fn file(&mut self) -> &mut File {
        match &mut self.to {
            To::Draft(draft) => draft.file(),
            To::Stream(file) => file,
        }
    }

    /// Brings the file to its place.
    ///
    /// # Errors
    /// What to say where it cannot be written to its end, or something else has come to its place.
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
