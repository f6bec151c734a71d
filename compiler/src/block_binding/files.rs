//! Files that keys name.

use std::path::Path;

use dsl::Sources;

/// Maximum size of a file, in bytes.
const MAX_BYTES: u64 = 4 << 20;

/// Reader of files.
pub(crate) struct TextFiles<'a> {
    /// Name of the spec.
    pub spec: &'a str,
    /// Folder that paths are relative to.
    pub folder: &'a Path,
    /// Sources, to which files are added.
    pub sources: &'a mut Sources,
    /// False if the contents of files of bytes are not needed.
    pub reads_bytes: bool,
}

/// A file that cannot be read.
pub(super) struct Unreadable {
    /// Reason.
    pub why: String,
    /// A way out; `None`: another path.
    pub help: Option<&'static str>,
}

impl TextFiles<'_> {
    /// Reads a file.
    pub(super) fn read(&self, path: &str) -> Result<String, Unreadable> {
        self.read_with(path, "save it as JSON")
    }

    /// Reads a file, with a way out for one that is no text.
    pub(super) fn read_with(&self, path: &str, if_no_text: &'static str) -> Result<String, Unreadable> {
        let bytes = self.read_bytes(&self.folder.join(path), MAX_BYTES, "split the mission into several")?;
        String::from_utf8(bytes)
            .map_err(|_| Unreadable { why: "it is no UTF-8 text".to_string(), help: Some(if_no_text) })
    }

    /// Reads a file of at most `most` bytes, with a way out for a larger one.
    pub(super) fn read_bytes(&self, on_disk: &Path, most: u64, if_larger: &'static str) -> Result<Vec<u8>, Unreadable> {
        files::read(on_disk, most).map_err(|e| match e.kind() {
            std::io::ErrorKind::FileTooLarge => {
                Unreadable { why: format!("it has more than {} MB", most >> 20), help: Some(if_larger) }
            }
            _ => Unreadable { why: files::reason(&e).to_string(), help: None },
        })
    }
}
