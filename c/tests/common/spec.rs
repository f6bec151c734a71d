//! The spec of the example, compiled.

use std::path::{Path, PathBuf};

use runtime::program::CompiledFile;

/// Folder of the example.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/loop")
}

/// The text of the compiled program.
pub fn json() -> String {
    let path = folder().join("reach.hq");
    compiled(&std::fs::read_to_string(&path).expect("the spec is there"))
}

/// A text, compiled.
pub fn compiled(text: &str) -> String {
    let compiled = compiler::compile(&compiler::Input {
        name: "reach.hq",
        text,
        syntax: dsl::Syntax::Native,
        folder: &folder(),
        set: &[],
        package_paths: &[],
    });
    assert!(compiled.is_good(), "{}", compiled.report.render(compiler::Style::Plain, 100));
    CompiledFile::to_json("reach", compiled.program.as_ref(), &compiled.missions).expect("finite numbers")
}
