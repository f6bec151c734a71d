//! Reading: regular files alone, and never more of them than the caller has room for.

use std::fs::{File, Metadata};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// The bytes of a file that has at most `most` of them.
///
/// # Errors
/// It cannot be read, is a folder, a device or a pipe, or is larger; [`reason`] says which of it.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>> {
    let bytes = read_up_to(path, most.saturating_add(1))?;
    if bytes.len() as u64 > most {
        return Err(Error::new(ErrorKind::FileTooLarge, format!("it is larger than {}", size(most))));
    }
    Ok(bytes)
}

/// The first `most` bytes of a file, or all where it has fewer.
///
/// # Errors
/// It cannot be read, or is a folder, a device or a pipe.
pub fn read_up_to(path: &Path, most: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// A regular file, opened to be read.
///
/// # Errors
/// It cannot be opened, or is a folder, a device or a pipe.
pub fn open(path: &Path) -> Result<File> {
    // Looked at before it is opened: to open a pipe waits for whoever writes into it.
    regular(&std::fs::metadata(path)?)?;
    let file = File::open(path)?;
    regular(&file.metadata()?)?;
    Ok(file)
}

/// A file or a pipe, opened to be read as it comes; the caller bounds what it keeps.
///
/// # Errors
/// It cannot be opened, or is a folder or a device, which may never end.
pub fn stream(path: &Path) -> Result<File> {
    let about = std::fs::metadata(path)?;
    if is_pipe(&about) { File::open(path) } else { open(path) }
}

/// Refuses what is no regular file.
pub(crate) fn regular(about: &Metadata) -> Result<()> {
    if about.is_dir() {
        return Err(Error::new(ErrorKind::IsADirectory, "it is a folder"));
    }
    if !about.is_file() {
        return Err(Error::new(ErrorKind::Unsupported, "it is a device or a pipe, and no file"));
    }
    Ok(())
}

#[cfg(unix)]
fn is_pipe(about: &Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_fifo(&about.file_type())
}

#[cfg(not(unix))]
fn is_pipe(_: &Metadata) -> bool {
    false
}

/// Why a file cannot be read or written, in a few words that are the same on all systems.
pub fn reason(e: &Error) -> &'static str {
    match e.kind() {
        ErrorKind::NotFound => "there is no such file",
        ErrorKind::PermissionDenied => "permission denied",
        ErrorKind::IsADirectory => "it is a folder",
        ErrorKind::Unsupported => "it is a device or a pipe, and no file",
        ErrorKind::FileTooLarge => "it is too large",
        ErrorKind::StorageFull => "the disk is full",
        _ => "the system refuses",
    }
}

/// A number of bytes in words.
fn size(bytes: u64) -> String {
    match bytes >> 20 {
        0 => format!("{bytes} bytes"),
        mebibytes => format!("{mebibytes} MiB"),
    }
}
