//! Language server: safety planners, with the protected task, the field, and the outputs.

use super::common;
use super::document::Document;

const SPEC: &str = r#"hierarq 1

robot arm {
  urdf "robots/arm7.urdf"
  rate 100 Hz
  home { joint_2 0.4 rad  joint_4 1.6 rad  joint_6 1.1 rad }
  points { tip tool }
}

human walker { points [chest] }

// How far away people are.
safety_field nearness { of walker }

// To and fro.
task reach = frame_position(tool) { position initial(position) + [0, 0.1, 0] m * sin(t/(1 s)) }
task separation = speed_separation(tip) { from walker.chest  reaction 0.1 s  deceleration 3 m/s^2  intrusion 0.1 m }
task guard = safety_planner(reach) {
  field nearness
  min 0.5 m
  deviate { position { speed 0.4 m/s  most 0.2 m } }
}

stack work { level limits hard { joint_position_limits  joint_velocity_limits }  level people { separation  joint_acceleration_limits }  level motion { reach }  level internal { guard } }

scenario calm {
  duration 1 s
  humans { walker { value [2, 0, 1] m } }
  expect always guard.scaling > 0.5
  expect always separation.room > 0 m
}
"#;

fn opened() -> Document {
    Document::open("lsp_planner.hq", SPEC)
}

#[test]
fn hover_and_definition() {
    let mut doc = opened();
    assert!(doc.diagnostics().is_empty());
    doc.hovers(&[
        ("safety_planner(rea|ch)", "reach", "To and fro."),
        ("  field near|ness", "nearness", "How far away people are."),
        ("mo|st 0.2 m", "most", "greatest deviation"),
        ("always gua|rd.scaling", "guard", "task"),
        ("guard.scal|ing > 0.5", "scaling", "the rate of the clock"),
        ("separation.ro|om >", "room", "must stop"),
    ]);
    doc.definitions(&[
        ("safety_planner(rea|ch)", "task |reach"),
        ("  field near|ness", "safety_field |nearness"),
        ("always gua|rd.scaling", "task |guard"),
        ("always separ|ation.room", "task |separation"),
    ]);
}

#[test]
fn rename() {
    let mut doc = opened();
    for (place, old, new) in [("task |reach", "reach", "move"), ("safety_field |nearness", "nearness", "room")] {
        let (renamed, _) = doc.renamed(place, old, new);
        assert!(!renamed.contains(old), "{place}:\n{renamed}");
        common::program_of(&renamed);
    }
}

#[test]
fn completion() {
    let mut doc = opened();
    doc.completions(&[
        ("safety_planner(reach)", "safety_planner(|)", &["reach"], &[]),
        ("  field nearness", "  field |", &["nearness"], &[]),
        ("  min 0.5 m\n", "  min 0.5 m\n  |\n", &["internal"], &[]),
        ("guard.scaling", "guard.|", &["deviation"], &[]),
        ("separation.room", "separation.|", &["speed_limit"], &[]),
        ("speed 0.4 m/s  most 0.2 m", "speed 0.4 m/s  |", &["return"], &[]),
    ]);
}
