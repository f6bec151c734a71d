//! Language server: values that a scenario sends to the controller, variables and sensors.

use super::common;
use super::document::Document;

const TOLD: &str = r#"hierarq 1

robot arm {
  urdf "robots/arm7.urdf"
  rate 100 Hz
  home { joint_2 0.4 rad  joint_4 1.6 rad  joint_6 1.1 rad }
}

signal fruit : point?  timeout 500 ms
signal ft : wrench { timeout 0.1 s  frame tool  low_pass 20 Hz }
signal go : event
variable tries : number = 0

stack still { level limits hard { joint_position_limits  joint_velocity_limits } }

machine pick {
  initial look
  stack still
  on fault(stale(ft)) -> stopped
  on fault(any) -> stopped
  state look { enter tare(ft)  do capture(camera)  on found -> there  when tries > 3 -> stopped  after 9 s -> look }
  state there {
    enter set(tries, tries + 1)
    on go -> look
    when present(fruit) and norm(ft.force) < 3 N -> look
  }
  final state stopped
}

scenario calm {
  duration 1 s
  signals { fruit { value [0.5, 0, 1] m }  ft { value { force [0, 0, 1] N } } }
  push { ft { from 0.5 s  force [5, 0, 0] N } }
  events { go 0.2 s }
  outcomes { camera { outcome found  sets { fruit [0.5, 0, 1] m } } }
  expect never in(stopped)
  expect never fault(deadline)
  expect eventually (tries > 0 and present(fruit))
}

run { machine pick  duration 1 s }
"#;

#[test]
fn names_in_scenarios_are_renamed_with_the_others() {
    let mut doc = Document::open("lsp_told.hq", TOLD);
    assert!(doc.diagnostics().iter().all(|d| d["severity"] != 1));
    for (place, old, new) in [
        ("signal |fruit", "fruit", "bunch"),
        ("  sets { fr|uit", "fruit", "bunch"),
        ("signal |ft", "ft", "wrist"),
        ("push { f|t", "ft", "wrist"),
        ("tare(f|t)", "ft", "wrist"),
        ("signal |go", "go", "begin"),
        ("events { g|o", "go", "begin"),
        ("variable |tries", "tries", "attempts"),
        ("set(|tries,", "tries", "attempts"),
        ("eventually (tr|ies", "tries", "attempts"),
    ] {
        let (renamed, _) = doc.renamed(place, old, new);
        let (before, after) = (common::program_of(TOLD), common::program_of(&renamed));
        assert_eq!(before.values, after.values);
        assert_eq!(before.scenarios[0].world, after.scenarios[0].world);
    }
}

#[test]
fn names_are_offered_where_a_scenario_or_an_action_takes_them() {
    let mut doc = Document::open("lsp_offered.hq", TOLD);
    doc.completions(&[
        ("never in(stopped)", "never in(|)", &["look", "there", "stopped"], &["fruit"]),
        ("never fault(deadline)", "never fault(|)", &["deadline", "stale"], &["fruit"]),
        ("fault(stale(ft))", "fault(stale(|))", &["fruit", "ft"], &["go"]),
        ("fault(stale(ft))", "fault(|)", &["stale", "any"], &["go"]),
        ("signals { fruit {", "signals { | {", &["fruit", "ft"], &["go", "look"]),
        ("events { go", "events { | ", &["go"], &["fruit"]),
        ("sets { fruit", "sets { | ", &["fruit"], &["go"]),
        ("push { ft {", "push { | {", &["ft"], &["go"]),
        ("enter tare(ft)", "enter tare(|)", &["ft"], &["go"]),
        ("enter set(tries, tries + 1)", "enter set(|, tries + 1)", &["tries"], &["go"]),
        ("enter set(tries, tries + 1)", "enter set(tries, |)", &["tries", "frame"], &["go"]),
        ("variable tries : number", "variable tries : |", &["number", "point"], &["event", "wrench"]),
        ("frame tool", "frame |", &["tool", "link_4"], &["joint_1"]),
        ("low_pass 20 Hz", "|", &["bias", "low_pass"], &["frame"]),
        ("enter tare(ft)", "enter |", &["tare", "set", "clear", "say"], &["fruit"]),
    ]);
}
