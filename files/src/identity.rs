//! Whether two paths lead to one file, whatever they are called.

use std::path::Path;

/// Whether two paths lead to the same file: by its device and number where the system has them, so that links of both
/// sorts are seen through, by the resolved paths elsewhere. False where one of them leads nowhere.
pub fn is_same(one: &Path, other: &Path) -> bool {
    same(one, other).unwrap_or(false)
}

#[cfg(unix)]
fn same(one: &Path, other: &Path) -> std::io::Result<bool> {
    use std::os::unix::fs::MetadataExt;
    let (one, other) = (std::fs::metadata(one)?, std::fs::metadata(other)?);
    Ok((one.dev(), one.ino()) == (other.dev(), other.ino()))
}

#[cfg(not(unix))]
fn same(one: &Path, other: &Path) -> std::io::Result<bool> {
    Ok(one.canonicalize()? == other.canonicalize()?)
}
