//! A build with all features compiles what it adds, and nothing anew: libraries of both builds have the same features in both.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

/// Features of the libraries of a build, by name and version.
fn libraries(more: &[&str]) -> BTreeMap<String, BTreeSet<String>> {
    let tree = Command::new(env!("CARGO"))
        .args(["tree", "--offline", "--package", "hierarq", "--edges", "normal,build"])
        .args(["--prefix", "none", "--no-dedupe", "--format", "{p}|{f}"])
        .args(more)
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .output()
        .expect("cargo");
    let text = String::from_utf8(tree.stdout).expect("text");
    assert!(tree.status.success(), "{}", String::from_utf8_lossy(&tree.stderr));
    let mut all: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (library, features) in text.lines().filter_map(|line| line.split_once('|')) {
        let library = library.replace(" (proc-macro)", "");
        let features = features.replace(" (*)", "");
        all.entry(library).or_default().extend(features.split(',').filter(|f| !f.is_empty()).map(str::to_string));
    }
    all
}

#[test]
fn features_add_libraries_and_change_none() {
    let (small, full) = (libraries(&[]), libraries(&["--features", "full"]));
    assert!(small.len() > 100 && full.len() > small.len(), "{} and {}", small.len(), full.len());
    for (library, features) in small.iter().filter(|(library, _)| !library.starts_with("hierarq")) {
        let more: Vec<&String> = full[library].difference(features).collect();
        assert!(
            more.is_empty(),
            "all features of `hierarq` switch on {more:?} of {library}: add them to unified/Cargo.toml"
        );
    }
}
