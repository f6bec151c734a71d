//! `hierarq check --coverage`: the table of limits, and the same as data.

use serde_json::Value;

use super::common::cli::{folder, hierarq, text};

fn data(spec: &str) -> Value {
    let out = hierarq(&["check", "--coverage", "--json", spec]);
    assert!(out.status.success(), "{}", text(&out.stderr));
    serde_json::from_slice(&out.stdout).expect("JSON")
}

#[test]
fn the_table_names_limits_and_what_lacks_them() {
    let out = hierarq(&["check", "--coverage", "examples/covered.hq"]);
    assert!(out.status.success());
    insta::assert_snapshot!(text(&out.stdout));
}

#[test]
fn both_spellings_have_the_same_coverage() {
    let [hq, yaml] = ["examples/covered.hq", "examples/covered.yaml"].map(data);
    assert_eq!(hq["coverage"], yaml["coverage"]);
    let stacks = hq["coverage"].as_array().expect("stacks");
    let names: Vec<&str> = stacks.iter().filter_map(|s| s["stack"].as_str()).collect();
    assert_eq!(names, ["waiting", "moving", "carrying"]);
    for stack in stacks {
        assert_eq!(stack["joints"].as_array().map(Vec::len), Some(7));
        assert!(stack["joints"].as_array().into_iter().flatten().all(|j| j["velocity"]["firmness"] == "hard"));
        assert_eq!(stack["unguarded_points"], Value::Array(Vec::new()));
    }
}

/// A limit that is taken out of one state is an error at the demand.
#[test]
fn a_dropped_limit_is_an_error() {
    let whole = std::fs::read_to_string("examples/covered.hq").expect("the example");
    let dropped = whole.replace("  replace motion { carry }\n", "  replace motion { carry }\n  remove guards\n");
    let dropped =
        dropped.replace("robots/arm7.urdf", concat!(env!("CARGO_MANIFEST_DIR"), "/examples/robots/arm7.urdf"));
    let spec = folder("coverage").join("dropped.hq");
    std::fs::write(&spec, dropped).expect("writable");
    let out = hierarq(&["check", "--json", spec.to_str().expect("UTF-8")]);
    assert!(!out.status.success());
    let report: Value = serde_json::from_slice(&out.stdout).expect("JSON");
    let all = report["diagnostics"].as_array().expect("diagnostics");
    let errors: Vec<&str> =
        all.iter().filter(|d| d["severity"] == "error").filter_map(|d| d["code"].as_str()).collect();
    assert_eq!(errors, ["HQ0572", "HQ0573"], "{report:#}");
    assert!(all.iter().any(|d| d["message"].as_str().is_some_and(|m| m.contains("stack `carrying`, state `carry`"))));
}
