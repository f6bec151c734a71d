//! Files that never replace another one: recordings are kept.

use std::fs::File;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};

/// Maximum number of files with one base name.
const MOST: usize = 10_000;

/// Creates a file with this name, or with the first free number in it: `talk.jsonl`, `talk.2.jsonl`. Returns the file
/// and its name.
///
/// # Errors
///
/// Returns a message for the user if no such file can be created.
pub fn begin(path: &Path) -> Result<(File, PathBuf), String> {
    for number in 1..=MOST {
        let name = numbered(path, number);
        match File::create_new(&name) {
            Ok(file) => return Ok((file, name)),
            Err(e) if e.kind() == ErrorKind::AlreadyExists && !path.is_dir() => {}
            Err(e) => return Err(format!("cannot write `{}`: {e}", name.display())),
        }
    }
    Err(format!("there are {MOST} files like `{}` already", path.display()))
}

/// Writes a new file.
///
/// # Errors
/// If the file exists, or if it cannot be written completely; it is then removed.
pub fn create(path: &Path, text: &str) -> std::io::Result<()> {
    let mut file = File::create_new(path)?;
    let written = file.write_all(text.as_bytes()).and_then(|()| file.sync_all());
    if written.is_err() {
        let _ = std::fs::remove_file(path);
    }
    written
}

fn numbered(path: &Path, number: usize) -> PathBuf {
    if number == 1 {
        return path.into();
    }
    let mut name = path.file_stem().unwrap_or_default().to_os_string();
    name.push(format!(".{number}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}
