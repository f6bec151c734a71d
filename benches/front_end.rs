//! How long it takes to read and check large texts: an honest spec of 5,000 lines, and a mebibyte of each of several
//! kinds of nuisance. `cargo bench --bench front_end`.

#[path = "../tests/common/large.rs"]
mod large;

use std::path::Path;

use divan::Bencher;
use dsl::{SourceId, Spelling, parse, print};

fn main() {
    divan::main();
}

fn check(text: &str, spelling: Spelling) -> usize {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let input = compiler::Input { name: "spec", text, spelling, folder: &folder, set: &[], package_paths: &[] };
    let compiled = compiler::compile(&input);
    compiled.report.render(compiler::Style::Plain, 100).len()
}

/// The honest spec in a spelling.
fn honest(name: &str) -> (String, Spelling) {
    let text = large::honest(5000);
    if name == "hq" {
        return (text, Spelling::Hq);
    }
    let (spec, diagnostics) = parse(SourceId(0), &text, Spelling::Hq);
    assert!(diagnostics.is_empty());
    (print(&spec, Spelling::Yaml), Spelling::Yaml)
}

/// Reading alone.
#[divan::bench(args = ["hq", "yaml"])]
fn read_5000_lines(bencher: Bencher, name: &str) {
    let (text, spelling) = honest(name);
    bencher.bench(|| parse(SourceId(0), &text, spelling));
}

/// Reading, compiling and all checks.
#[divan::bench(args = ["hq", "yaml"])]
fn check_5000_lines(bencher: Bencher, name: &str) {
    let (text, spelling) = honest(name);
    assert_eq!(check(&text, spelling), 0, "the honest spec is good");
    bencher.bench(|| check(&text, spelling));
}

/// The same for each nuisance, the report as text included.
#[divan::bench(args = large::nuisances().iter().map(|n| n.0).collect::<Vec<_>>(), sample_count = 1, sample_size = 1)]
fn check_nuisance(bencher: Bencher, name: &str) {
    let nuisances = large::nuisances();
    let Some((_, spelling, text)) = nuisances.iter().find(|n| n.0 == name) else { return };
    bencher.bench(|| check(text, *spelling));
}
