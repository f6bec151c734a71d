//! Many independent mistakes in one file are all reported: each at its place, with its code, and without further ones.

use crate::common;

use common::{annotated, compile_text, examples};
use dsl::Syntax;

/// Checks a spec in which every `«CODE|text»` marks a mistake.
fn planted(marked: &str, syntax: Syntax) {
    let (mut text, mut expected) = (String::new(), Vec::new());
    let mut rest = marked;
    while let Some((before, after)) = rest.split_once('«') {
        let (inside, behind) = after.split_once('»').expect("a plant ends");
        let (code, shown) = inside.split_once('|').expect("a plant is written «CODE|text»");
        text.push_str(before);
        expected.push((code, text.len(), text.len() + shown.len()));
        text.push_str(shown);
        rest = behind;
    }
    text.push_str(rest);
    let compiled = compile_text(&text, syntax, &examples(), &[]);
    let found: Vec<(&str, usize, usize)> = compiled
        .report
        .diagnostics
        .iter()
        .map(|d| (d.code, d.primary.span.range().start, d.primary.span.range().end))
        .collect();
    assert!(expected.len() >= 10, "{} mistakes are too few", expected.len());
    assert_eq!(found, expected, "{}", annotated(&compiled));
}

/// Syntax, names, types, units, the robot, safety and hierarchy, in `*.hq`.
#[test]
fn in_hq() {
    planted(
        r#"hierarq 1

param approach = 0.15 «HQ0112|mtr»
param swing = sin(«HQ0306|3 s»)
param far = «HQ0302|2 m + 1 rad»

robot arm {
  urdf "robots/arm7.urdf"
  rate«HQ0108|:» 100 Hz
  «HQ0205|bsae» fixed
  points { elbow «HQ0201|link_44»  wrist link_6 }
  home { all «HQ0310|[0, 0.4, 0, 1.6, 0, 1.14] rad» }
}

«HQ0103|tsk» still = hold(«HQ0201|toool»)
task wall = virtual_wall(elbow, wrist) { through [[0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]] m  d_min «HQ0301|0.2 s» }
task turn = frame_orientation(tool) { orientation «HQ0310|rpy(0, 0)» }
task go = frame_position(tool) { position [approach, 0, 0]  gain «HQ0501|150 /s» }
task reach = «HQ0204|frame_psition»(tool)
task steep = frame_position(tool) { position [far, swing, 0] m  «HQ0107|gain» }

stack work {
  level limits «HQ0118|hrad» { wall  joint_velocity_limits }
  level motion { go weight «HQ0308|-1»  still  turn  reach  «HQ0201|gone»  steep }
}

run { stack «HQ0201|wrok»  duration «HQ0301|10 m» }
"#,
        Syntax::Native,
    );
}

/// The same kinds of mistakes in YAML.
#[test]
fn in_yaml() {
    planted(
        r#"hierarq: 1
params:
  approach: 0.15 «HQ0112|mtr»
  swing: "sin(«HQ0306|3 s»)"
  far: «HQ0302|2 m + 1 rad»
robots:
  arm:
    urdf: robots/arm7.urdf
    rate: 100 Hz
    «HQ0205|bsae»: fixed
    points: { elbow: «HQ0201|link_44», wrist: link_6 }
    home: { all: "«HQ0310|[0, 0.4, 0, 1.6, 0, 1.14] rad»" }
tasks:
  still: hold(«HQ0201|toool»)
  wall:
    virtual_wall:
      points: [elbow, wrist]
      through: "[[0, 0, 0.1], [1, 0, 0.1], [0, 1, 0.1]] m"
      d_min: «HQ0301|0.2 s»
  turn: { frame_orientation: { frame: tool, orientation: "«HQ0310|rpy(0, 0)»" } }
  go:
    frame_position:
      frame: tool
      position: [approach, 0, 0]
      gain: «HQ0501|150 /s»
«HQ0130|   »keep: hold(gripper)
  two:
    hold: { frames: gripper }
    «HQ0131|gain»: 2 /s
  reach: «HQ0204|frame_psition»(tool)
  steep: { frame_position: { frame: tool, position: "[far, swing, 0] m", «HQ0107|gain»: } }
stacks:
  work:
    levels:
      - { name: limits, hard: «HQ0118|yes», tasks: [wall, joint_velocity_limits] }
      - name: motion
        tasks:
          - { task: go, weight: «HQ0308|-1» }
          - { task: still, «HQ0132|wieght»: 2 }
          - turn
          - reach
          - keep
          - two
          - «HQ0201|gone»
          - steep
run: { stack: «HQ0201|wrok», duration: «HQ0301|10 m» }
"#,
        Syntax::Yaml,
    );
}
