//! Language server: safety fields.

use super::common;
use super::document::Document;

const FIELDS: &str = r#"hierarq 1

robot arm {
  urdf "robots/arm7.urdf"
  rate 100 Hz
  home { joint_2 0.4 rad  joint_4 1.6 rad  joint_6 1.1 rad }
  arms { only { tip tool } }
}

human operator { points [chest, hand] }

// How far all of the arm is. 🤖
safety_field nearness {
  of [operator.chest, operator.hand]
  links only
  points minimum
}

task apart = keep(field(nearness)) { min 0.3 m }

stack work { level people { apart } }

scenario calm {
  stack work
  duration 1 s
  humans { operator { value [2, 0, 0] m  shape { chest [0, 0, 1.2] m  hand [0, 0, 0.9] m } } }
  expect always field(nearness) > 1 m
}

run { stack work  duration 1 s }
"#;

fn opened() -> Document {
    Document::open("lsp_field.hq", FIELDS)
}

#[test]
fn hover_and_definition() {
    let mut doc = opened();
    assert!(doc.diagnostics().is_empty());
    doc.hovers(&[
        ("saf|ety_field", "safety_field", "read as `field(NAME)`"),
        ("keep(field(near|ness", "nearness", "How far all of the arm is. 🤖"),
        ("keep(fie|ld(", "field", "value of a safety field"),
        ("  li|nks only", "links", "the whole robot"),
        ("links on|ly", "only", "arm"),
        ("of [oper|ator", "operator", "human"),
    ]);
    doc.definitions(&[
        ("expect always field(near|ness", "safety_field |nearness"),
        ("links on|ly", "arms { |only"),
        ("[operator.ch|est", "points [|chest"),
    ]);
}

#[test]
fn completion_offers_fields_words_and_links() {
    let mut doc = opened();
    doc.completions(&[
        ("keep(field(nearness))", "keep(field(|))", &["nearness"], &["operator"]),
        ("points minimum", "points |", &["mean", "minimum", "soft_minimum"], &["nearness"]),
        ("  links only\n", "  links |\n", &["only", "link_3"], &["joint_1"]),
        ("  links only\n", "  |\n", &["links", "distance"], &["of", "timeout"]),
    ]);
}

#[test]
fn references_and_rename() {
    let mut doc = opened();
    assert_eq!(doc.references("safety_field near|ness", true), 3);
    let (renamed, _) = doc.renamed("safety_field near|ness", "nearness", "room");
    assert!(!renamed.contains("nearness") && renamed.contains("field(room)"), "{renamed}");
    let (before, after) = (common::program_of(FIELDS), common::program_of(&renamed));
    assert_eq!((before.fields[0].points.clone(), before.values), (after.fields[0].points.clone(), after.values));
    // A human has that name.
    doc.refused(&[("safety_field near|ness", "operator")]);
}
