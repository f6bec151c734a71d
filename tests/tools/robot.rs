//! `hierarq robot`: groups, postures, and pairs of links that are not kept apart.

use super::{hierarq, text};

#[test]
fn the_srdf_of_an_example_is_shown() {
    let out = hierarq(&["robot", "examples/postures.hq"]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    insta::assert_snapshot!("robot_postures", text(&out.stdout));
    let out = hierarq(&["robot", "examples/postures.hq", "--json"]);
    let data: serde_json::Value = serde_json::from_slice(&out.stdout).expect("JSON");
    assert_eq!(data["postures"].as_array().map(Vec::len), Some(3));
    assert_eq!(data["groups"][0]["tip"], "tool");
    let compiled = text(&hierarq(&["compile", "examples/postures.hq"]).stdout);
    let rows = format!("apart: self_collision  {} inequalities", data["rows"]);
    assert!(compiled.contains(&rows), "the rows that `robot` counts are those of the task: {rows}\n{compiled}");
}

#[test]
fn a_robot_without_an_srdf_has_pairs_all_the_same() {
    let out = hierarq(&["robot", "examples/hello.hq"]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert!(text(&out.stdout).contains("(no srdf)"), "{}", text(&out.stdout));
    let missions = hierarq(&["robot", "examples/vineyard.hq"]);
    assert_eq!(missions.status.code(), Some(2), "{}", text(&missions.stdout));
}
