//! Every test file is built: each file in a folder `tests` is a module of that folder's `main.rs` or has its own
//! binary.

use std::path::Path;

#[test]
fn every_file_of_tests_belongs_to_a_binary() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = |path: &Path| std::fs::read_to_string(path).expect("a file of ours");
    let mut files = 0;
    for of in [".", "compiler", "context", "dsl", "mission", "solver"] {
        let (tests, manifest) = (root.join(of).join("tests"), text(&root.join(of).join("Cargo.toml")));
        let main = text(&tests.join("main.rs"));
        for entry in std::fs::read_dir(&tests).expect("a folder of ours") {
            let path = entry.expect("readable").path();
            let stem = path.file_stem().and_then(|s| s.to_str()).expect("a name");
            if path.extension().is_none_or(|e| e != "rs") || stem == "main" {
                continue;
            }
            files += 1;
            let declared = main.lines().any(|line| line == format!("mod {stem};"));
            assert!(declared || manifest.contains(&format!("name = \"{stem}\"")), "{} is in no binary", path.display());
        }
    }
    assert!(files > 80, "{files}");
}
