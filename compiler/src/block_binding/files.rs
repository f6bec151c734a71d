//! Text files that keys name.

use std::path::Path;

use dsl::Sources;

/// Maximum size of a file, in bytes.
const MAX_BYTES: u64 = 4 << 20;

/// Reader of text files.
pub(crate) struct TextFiles<'a> {
    /// Folder that paths are relative to.
    pub folder: &'a Path,
    /// Sources, to which files are added.
    pub sources: &'a mut Sources,
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
        let on_disk = self.folder.join(path);
        let bytes = files::read(&on_disk, MAX_BYTES).map_err(|e| match e.kind() {
            std::io::ErrorKind::FileTooLarge => Unreadable {
                why: format!("it has more than {} MB", MAX_BYTES >> 20),
                help: Some("split the mission into several"),
            },
            _ => Unreadable { why: files::reason(&e).to_string(), help: None },
        })?;
        String::from_utf8(bytes)
            .map_err(|_| Unreadable { why: "it is no UTF-8 text".to_string(), help: Some("save it as JSON") })
    }
}
