//! Time to read and print a spec of 5,000 lines in both syntaxes.

use divan::{Bencher, black_box};
use hierarq_dsl::{SourceId, Syntax, parse, print};

fn main() {
    divan::main();
}

/// A spec of about 5,000 lines.
fn spec() -> String {
    let mut text = String::from("hierarq 1\n\nparam approach = 0.15 m\n\n");
    for i in 0..500 {
        text.push_str(&format!(
            "// Keeps the arms away from plane {i}.
task wall_{i} = virtual_wall {{
  points arms
  through [[0, 0, {i}.5], [1, 0, 0.5], [0, 1, 0.5]] m
  d_min 0.5 m + approach/2  // measured
  gain 5 /s
}}

task sine_{i} = joint_velocity {{
  joints [arm_left, arm_right]
  velocity 0.75*sin(2*pi*t/(25 s)) rad/s
}}
"
        ));
    }
    text
}

fn text(syntax: Syntax) -> String {
    let (spec, diags) = parse(SourceId(0), &spec(), Syntax::Native);
    assert!(diags.is_empty());
    print(&spec, syntax)
}

#[divan::bench(args = ["hq", "yaml"])]
fn read(bencher: Bencher, name: &str) {
    let syntax = if name == "hq" { Syntax::Native } else { Syntax::Yaml };
    let text = text(syntax);
    bencher.counter(divan::counter::BytesCount::of_str(&text)).bench(|| parse(SourceId(0), black_box(&text), syntax));
}

#[divan::bench(args = ["hq", "yaml"])]
fn write(bencher: Bencher, name: &str) {
    let syntax = if name == "hq" { Syntax::Native } else { Syntax::Yaml };
    let (spec, _) = parse(SourceId(0), &spec(), Syntax::Native);
    bencher.bench(|| print(black_box(&spec), syntax));
}
