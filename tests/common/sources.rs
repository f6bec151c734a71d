//! Sources of the crates of the workspace, as files.

use std::path::{Path, PathBuf};

/// The sources of the program and of all crates whose folder is accepted.
pub fn of_crates(accepted: impl Fn(&str) -> bool) -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut all = Vec::new();
    below(&root.join("src"), &mut all);
    for entry in std::fs::read_dir(root).expect("the workspace") {
        let entry = entry.expect("an entry");
        let (sources, is_crate) = (entry.path().join("src"), entry.path().join("Cargo.toml").is_file());
        if is_crate && sources.is_dir() && entry.file_name().to_str().is_some_and(&accepted) {
            below(&sources, &mut all);
        }
    }
    all
}

/// The sources below a folder.
pub fn below(folder: &Path, all: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            below(&path, all);
        } else if path.extension().is_some_and(|e| e == "rs") {
            all.push(path);
        }
    }
}
