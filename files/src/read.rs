//! Reading of regular files, up to a size that the caller chooses.

use std::fs::{File, Metadata};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Reads a file of at most `most` bytes.
///
/// # Errors
/// If it cannot be read, is a folder, a device or a pipe, or is larger; [`reason`] describes the cause.
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>> {
    let bytes = read_up_to(path, most.saturating_add(1))?;
    if bytes.len() as u64 > most {
        return Err(Error::new(ErrorKind::FileTooLarge, format!("it is larger than {}", size(most))));
    }
    Ok(bytes)
}

/// Reads the first `most` bytes of a file, or all of a shorter one.
///
/// # Errors
/// If it cannot be read, or is a folder, a device or a pipe.
pub fn read_up_to(path: &Path, most: u64) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    open(path)?.take(most).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Opens a regular file for reading.
///
/// # Errors
/// If it cannot be opened, or is a folder, a device or a pipe.
pub fn open(path: &Path) -> Result<File> {
    // Checked before it is opened, because opening a pipe blocks until somebody writes into it; and again after,
    // because the path may have changed in between.
    regular(&std::fs::metadata(path)?)?;
    let file = File::open(path)?;
    regular(&file.metadata()?)?;
    Ok(file)
}

/// Opens a file or a pipe for reading. The caller bounds the number of bytes that it keeps.
///
/// # Errors
/// If it cannot be opened, or is a folder or a device, which may never end.
pub fn stream(path: &Path) -> Result<File> {
    let about = std::fs::metadata(path)?;
    if is_pipe(&about) { File::open(path) } else { open(path) }
}

/// Rejects everything but regular files.
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

/// Describes an I/O error in a few words that are the same on all systems.
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

/// Formats a number of bytes.
fn size(bytes: u64) -> String {
    match bytes >> 20 {
        0 => format!("{bytes} bytes"),
        mebibytes => format!("{mebibytes} MiB"),
    }
}
