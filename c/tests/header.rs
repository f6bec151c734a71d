//! The header is that which cbindgen makes of the crate.

use std::path::Path;

/// The header without the sections on what a caller in Rust promises: the note at its top says that for C.
fn without_promises(header: &str) -> String {
    let mut kept: Vec<&str> = Vec::new();
    let mut left_out = false;
    for line in header.lines() {
        match line.trim() {
            "# Safety" => {
                left_out = true;
                kept.truncate(kept.len() - usize::from(kept.last().is_some_and(|last| last.trim().is_empty())));
            }
            "*/" => left_out = false,
            _ => {}
        }
        if !left_out {
            kept.push(line);
        }
    }
    kept.join("\n") + "\n"
}

#[test]
fn the_header_is_that_of_the_functions() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = cbindgen::Config::from_file(root.join("cbindgen.toml")).expect("a configuration");
    let bindings =
        cbindgen::Builder::new().with_config(config).with_src(root.join("src/lib.rs")).generate().expect("a header");
    let mut made = Vec::new();
    bindings.write(&mut made);
    let made = without_promises(&String::from_utf8(made).expect("text"));
    let path = root.join("include/hierarq.h");
    if std::env::var_os("HIERARQ_UPDATE_DOCS").is_some() {
        std::fs::write(&path, &made).expect("the header is written");
    }
    let kept = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(kept == made, "include/hierarq.h is not that of the functions: HIERARQ_UPDATE_DOCS=1 writes it anew");
}
