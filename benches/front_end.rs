//! Times of reading and checking large texts: a plain spec of 5,000 lines, and a mebibyte of each of several kinds of
//! malformed text. `cargo bench --bench front_end`.

#[path = "../tests/common/large.rs"]
mod large;

use std::path::Path;

use divan::Bencher;
use dsl::{SourceId, Syntax, parse, print};

fn main() {
    divan::main();
}

fn check(text: &str, syntax: Syntax) -> usize {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let input = compiler::Input { name: "spec", text, syntax, folder: &folder, set: &[], package_paths: &[] };
    let compiled = compiler::compile(&input);
    compiled.report.render(compiler::Style::Plain, 100).len()
}

/// The honest spec in a syntax.
fn honest(name: &str) -> (String, Syntax) {
    let text = large::honest(5000);
    if name == "hq" {
        return (text, Syntax::Native);
    }
    let (spec, diagnostics) = parse(SourceId(0), &text, Syntax::Native);
    assert!(diagnostics.is_empty());
    (print(&spec, Syntax::Yaml), Syntax::Yaml)
}

/// Reading alone.
#[divan::bench(args = ["hq", "yaml"])]
fn read_5000_lines(bencher: Bencher, name: &str) {
    let (text, syntax) = honest(name);
    bencher.bench(|| parse(SourceId(0), &text, syntax));
}

/// Reading, compiling and all checks.
#[divan::bench(args = ["hq", "yaml"])]
fn check_5000_lines(bencher: Bencher, name: &str) {
    let (text, syntax) = honest(name);
    assert_eq!(check(&text, syntax), 0, "the honest spec is good");
    bencher.bench(|| check(&text, syntax));
}

/// The same for each nuisance, the report as text included.
#[divan::bench(args = large::nuisances().iter().map(|n| n.0).collect::<Vec<_>>(), sample_count = 1, sample_size = 1)]
fn check_nuisance(bencher: Bencher, name: &str) {
    let nuisances = large::nuisances();
    let Some((_, syntax, text)) = nuisances.iter().find(|n| n.0 == name) else { return };
    bencher.bench(|| check(text, *syntax));
}
