//! Paths in a spec: helps for unreadable files, and conversion to another base folder.

use std::path::{Component, Path, PathBuf};

use dsl::Diagnostic;
use names::suggest;

/// Adds the way out of a missing file: a file of a similar name in the same folder, or the searched path.
pub(crate) fn instead_of(d: Diagnostic, written: &str, on_disk: &Path) -> Diagnostic {
    match meant(written, on_disk) {
        Some(near) => d.meant(near),
        None if on_disk.is_dir() => d.help("name a file inside it"),
        None => d.help(format!("looked for {}", on_disk.display())),
    }
}

/// The same for a file that a command makes.
pub(crate) fn made_by(d: Diagnostic, written: &str, on_disk: &Path, command: &str) -> Diagnostic {
    match meant(written, on_disk) {
        Some(near) => d.note(format!("`{command}` makes this file")).meant(near),
        None if on_disk.is_dir() => d.help("name a file inside it"),
        None => d.help(format!("make it: `{command}`")),
    }
}

/// The file that was probably meant, as it is written; none: there is none.
fn meant(written: &str, on_disk: &Path) -> Option<String> {
    let near = nearby(on_disk).filter(|_| !on_disk.is_dir())?;
    Some(format!("{}{near}", written.rfind('/').map_or("", |at| &written[..=at])))
}

/// A name in the folder of a path that is similar to its own.
fn nearby(path: &Path) -> Option<String> {
    let wanted = path.file_name()?.to_str()?.to_string();
    let mut names: Vec<String> = std::fs::read_dir(path.parent()?)
        .ok()?
        .take(1000)
        .filter_map(|e| e.ok()?.file_name().into_string().ok())
        .collect();
    names.sort();
    suggest(&wanted, names.iter().map(String::as_str)).map(str::to_string)
}

/// Removes folders that a path enters and leaves again: `common/../robots/arm.urdf` becomes `robots/arm.urdf`. Symbolic
/// links are kept, because their parent may be elsewhere. The path is relative to `folder`.
pub(crate) fn tidy(path: &Path, folder: &Path) -> PathBuf {
    let mut out = PathBuf::new();
    for part in path.components() {
        let entered = matches!(out.components().next_back(), Some(Component::Normal(_)));
        match part {
            Component::CurDir => {}
            Component::ParentDir if entered && !folder.join(&out).is_symlink() => {
                out.pop();
            }
            _ => out.push(part),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_that_are_left_again() {
        let tidied = |p: &str| tidy(Path::new(p), Path::new("/nowhere")).to_string_lossy().into_owned();
        assert_eq!(tidied("common/../robots/arm.urdf"), "robots/arm.urdf");
        assert_eq!(tidied("a/b/../../../c"), "../c");
        assert_eq!(tidied("./a/./b"), "a/b");
        assert_eq!(tidied("../a"), "../a");
        assert_eq!(tidied("/x/../y"), "/y");
    }
}
