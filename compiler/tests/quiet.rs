//! The examples are specs as they should be: none has a warning, so that a new check shows its false alarms.

use std::path::{Path, PathBuf};

use dsl::Syntax;
use hierarq_compiler::{Input, compile};

/// All specs below a folder.
fn specs(folder: &Path, out: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            specs(&path, out);
        } else if Syntax::of_path(&path).is_some() {
            out.push(path);
        }
    }
}

#[test]
fn examples_have_no_warnings() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples");
    let mut all = Vec::new();
    specs(&root, &mut all);
    // Maps are described in YAML too, and common parts are no specs by themselves.
    all.retain(|p| !["maps", "common", "robots"].iter().any(|f| p.parent().is_some_and(|at| at.ends_with(f))));
    all.sort();
    assert!(all.len() > 60, "{}", all.len());
    let mut found = Vec::new();
    for path in all {
        let text = std::fs::read_to_string(&path).expect("a spec");
        let (name, syntax) = (path.display().to_string(), Syntax::of_path(&path).expect("a spec"));
        let folder = path.parent().expect("a folder");
        let input = Input { name: &name, text: &text, syntax, folder, set: &[], package_paths: &[] };
        found.extend(compile(&input).report.diagnostics.iter().map(|d| {
            let line = text.get(..d.primary.span.range().start).map_or(0, |t| t.lines().count());
            format!("{name}:{line}: {} {}", d.code, d.message)
        }));
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}
