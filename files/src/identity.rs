//! Comparison of the files behind two paths.

use std::path::Path;

/// Returns true if two paths lead to the same file. On Unix it compares device and inode numbers, which identifies
/// symbolic and hard links; elsewhere it compares the canonical paths. Returns false if one of the paths leads nowhere.
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
