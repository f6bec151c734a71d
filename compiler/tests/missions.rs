//! Missions with repeated or imported members are equal to missions without repetitions and imports, in both syntaxes.

use crate::common;

use common::examples;
use dsl::{SourceId, Syntax};
use hierarq_compiler::{Input, Style, compile};
use proptest::prelude::*;
use std::path::{Path, PathBuf};

/// Missions of a spec without mistakes, as JSON.
fn missions_in(text: &str, syntax: Syntax, folder: &Path) -> serde_json::Value {
    let c = compile(&Input { name: "spec", text, syntax, folder, set: &[], package_paths: &[] });
    assert!(c.report.diagnostics.is_empty(), "{text}\n{}", c.report.render(Style::Plain, 100));
    serde_json::to_value(c.missions).expect("data")
}

fn missions(text: &str) -> serde_json::Value {
    let hq = missions_in(text, Syntax::Native, &examples());
    let (tree, _) = dsl::parse(SourceId(0), text, Syntax::Native);
    let yaml = dsl::print(&tree, Syntax::Yaml);
    assert_eq!(missions_in(&yaml, Syntax::Yaml, &examples()), hq, "{yaml}");
    hq
}

const CARRIER: &str = "robot carrier { depot [0, 0] m  speed [0.05, 0.2] m/s  serve 20 s }";

/// A mission with these members in addition to the carrier.
fn mission(name: &str, members: &str) -> String {
    format!("mission {name} : schedule {{\n  {CARRIER}\n  {members}\n}}\n")
}

#[test]
fn members_of_a_repetition_are_those_written_out() {
    let repeated = mission(
        "rows",
        "human first { place [1, 1] m  duration 100 s }
         for i in 1..2 { for side in [left, right] { human ${side}_${i + 1} { place [i, ${2*i}] m  duration 200 s } } }
         for i in [3, 5] { worker w${i} { place [-2 m, i * 3 m]  operations i  duration 90 s } }",
    );
    let written = mission(
        "rows",
        "human first { place [1, 1] m  duration 100 s }
         human left_2 { place [1, 2] m  duration 200 s }   human right_2 { place [1, 2] m  duration 200 s }
         human left_3 { place [2, 4] m  duration 200 s }   human right_3 { place [2, 4] m  duration 200 s }
         worker w3 { place [-2 m, 3 * 3 m]  operations 3  duration 90 s }
         worker w5 { place [-2 m, 5 * 3 m]  operations 5  duration 90 s }",
    );
    assert_eq!(missions(&format!("hierarq 1\n{repeated}")), missions(&format!("hierarq 1\n{written}")));
}

#[test]
fn missions_of_a_repetition_are_those_written_out() {
    let member = |k: &str| format!("for i in 1..2 {{ human h${{i}} {{ place [i, {k}] m  duration 200 s }} }}");
    // On one line, because `mission` at the beginning of a line would end the repetition.
    let inner = mission("field_${k}", &member("k"));
    let repeated = format!("hierarq 1\nfor k in 1..2 {{ {inner} }}\n");
    let written = format!("hierarq 1\n{}{}", mission("field_1", &member("1")), mission("field_2", &member("2")));
    assert_eq!(missions(&repeated), missions(&written));
}

#[test]
fn a_mission_that_is_imported_brings_its_params() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("missions");
    std::fs::create_dir_all(&folder).expect("a folder");
    let own = format!("param reach = 8 m\n{}", mission("rows", "human anna { place [reach, 2 m]  duration 200 s }"));
    std::fs::write(folder.join("rows.hq"), format!("hierarq 1\n{own}")).expect("a file");
    let imports = "hierarq 1\nimport \"rows.hq\" { rows }\n";
    let there = missions_in(imports, Syntax::Native, &folder);
    assert_eq!(there, missions_in(&format!("hierarq 1\n{own}"), Syntax::Native, &folder));
    let renamed = missions_in("hierarq 1\nimport \"rows.hq\" { rows as field }\n", Syntax::Native, &folder);
    assert_eq!(renamed[0]["name"], "field");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Both syntaxes agree on the order of members, for any mixture of roles and repetitions.
    #[test]
    fn the_order_of_roles_does_not_matter(order in Just((0..5usize).collect::<Vec<_>>()).prop_shuffle()) {
        let pieces = [
            "robot second { depot [1, 0] m  speed 0.1 m/s  serve 20 s }",
            "human anna { place [1, 1] m  duration 100 s }",
            "worker w { place [2, 1] m  duration 120 s }",
            "for i in 1..2 { human h${i} { place [i, 3] m  duration 200 s } }",
            "for i in 1..2 { worker w${i} { place [i, 5] m  duration 200 s } }",
        ];
        // Plain members precede repetitions.
        let mut order = order;
        order.sort_by_key(|i| *i > 2);
        let body: Vec<&str> = order.iter().map(|i| pieces[*i]).collect();
        let spec = format!("hierarq 1\n{}", mission("rows", &body.join("\n  ")));
        missions(&spec);
    }
}
