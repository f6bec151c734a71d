//! Mistakes of form: what is said of them, in both syntaxes, and that one does not hide the next.

use crate::common;

use common::render;
use hierarq_dsl::{SourceId, Syntax, parse};

/// Diagnostics of every piece; pieces are separated by lines of `====`.
fn report(pieces: &str, header: &str, syntax: Syntax) -> String {
    let mut out = String::new();
    for piece in pieces.split("====\n") {
        let piece = piece.trim_start_matches('\n');
        let text = if piece.contains("hierarq") || piece.starts_with("!raw\n") {
            piece.trim_start_matches("!raw\n").to_owned()
        } else {
            format!("{header}{piece}")
        };
        let (_, diags) = parse(SourceId(0), &text, syntax);
        assert!(!diags.is_empty(), "no mistake found in\n{text}");
        out.push_str(&format!("{}\n", text.trim_end()));
        out.push_str("-----\n");
        out.push_str(&render(&text, &diags));
        out.push_str("==========\n");
    }
    out
}

#[test]
fn mistakes_in_hq() {
    insta::assert_snapshot!(report(include_str!("common/mistakes.hq"), "hierarq 1\n", Syntax::Native));
}

#[test]
fn mistakes_in_yaml() {
    insta::assert_snapshot!(report(include_str!("common/mistakes.yaml"), "hierarq: 1\n", Syntax::Yaml));
}

#[test]
fn mistakes_in_machines_in_hq() {
    insta::assert_snapshot!(report(include_str!("common/mistakes_machines.hq"), "hierarq 1\n", Syntax::Native));
}

#[test]
fn mistakes_in_machines_in_yaml() {
    insta::assert_snapshot!(report(include_str!("common/mistakes_machines.yaml"), "hierarq: 1\n", Syntax::Yaml));
}

#[test]
fn mistakes_in_missions_in_hq() {
    insta::assert_snapshot!(report(include_str!("common/mistakes_missions.hq"), "hierarq 1\n", Syntax::Native));
}

#[test]
fn mistakes_in_missions_in_yaml() {
    insta::assert_snapshot!(report(include_str!("common/mistakes_missions.yaml"), "hierarq: 1\n", Syntax::Yaml));
}

/// Every `«code|text»` plants a mistake: the code must be reported exactly at the text.
fn planted(marked: &str, syntax: Syntax) {
    let (mut text, mut expected) = (String::new(), Vec::new());
    let mut rest = marked;
    while let Some((before, after)) = rest.split_once('«') {
        let Some(((code, shown), after)) = after.split_once('»').and_then(|(i, a)| Some((i.split_once('|')?, a)))
        else {
            panic!("a plant is written «code|text»")
        };
        text.push_str(before);
        expected.push((code.to_owned(), text.len(), text.len() + shown.len()));
        text.push_str(shown);
        rest = after;
    }
    text.push_str(rest);
    let (_, diags) = parse(SourceId(0), &text, syntax);
    let found: Vec<_> =
        diags.iter().map(|d| (d.code.to_owned(), d.primary.span.start as usize, d.primary.span.end as usize)).collect();
    assert_eq!(found, expected, "{}", render(&text, &diags));
    assert!(expected.len() >= 6);
}

#[test]
fn six_slips_in_hq_give_six_diagnostics() {
    planted(
        r#"hierarq 1
param approach«HQ0104|» 0.15 m
robot canopies {
  urdf "canopies.urdf"
  base«HQ0108|:» unicycle
  home { torso_lift 0.15 «HQ0112|mtr»  arm [0, 1] rad }
}
«HQ0103|tsk» deck = virtual_wall {
  «HQ0107|d_min»
  gain 5 /s
}
stack safety {
  level limits «HQ0118|hrad» { position_limits }
  level motion { deck weight 2 «HQ0113|$» }
}
run { stack safety  title «HQ0109|'3.A'»  «HQ0115|stack» other }
"#,
        Syntax::Native,
    );
}

#[test]
fn six_slips_in_yaml_give_six_diagnostics() {
    planted(
        r#"hierarq: 1
params:
  approach: 0.15 «HQ0112|mtr»
«HQ0132|robot»:
  canopies:
    urdf: canopies.urdf
    home: { torso_lift: 0.15 m, arm: "[0, 1 «HQ0113|$»] rad" }
tasks:
  deck: { virtual_wall: { «HQ0107|d_min»: , gain: 5 /s } }
«HQ0130|	still: hold(left)»
stacks:
  safety:
    levels:
      - { name: limits, hard: «HQ0118|yes», tasks: [position_limits] }
      - { name: motion, tasks: [ deck, { task: still, wieght: 2 } ] }
run: { stack: safety, «HQ0115|stack»: other }
"#
        .replace("wieght", "«HQ0132|wieght»")
        .replace("«HQ0130|	still: hold(left)»", "«HQ0130|\t»still: hold(left)")
        .as_str(),
        Syntax::Yaml,
    );
}

#[test]
fn slips_in_a_mission_in_hq() {
    planted(
        r#"hierarq 1
mission «HQ0144|vineyard» {
  confidence 0.9 «HQ0112|mtr»
  «HQ0145|robt» m1 { depot [0, 0] m  speed«HQ0108|:» 0.2 m/s }
  human «HQ0115|h1» {}
  layer base {
    task left«HQ0104|» pick { to [0, 0, 0] m }
    task «HQ0107|right»
    «HQ0121|for» 3
  }
}
"#
        .replace("  human «HQ0115|h1» {}", "  human h1 {}\n  human «HQ0115|h1» {}")
        .as_str(),
        Syntax::Native,
    );
}

#[test]
fn slips_in_a_mission_in_yaml() {
    planted(
        r#"hierarq: 1
missions:
  «HQ0117|vines»:
  vineyard:
    schedule:
      confidence: 0.9 «HQ0112|mtr»
      «HQ0132|robot»: { m1: { depot: "[0, 0] m", «HQ0107|speed»: } }
      humans: { h1: {}, «HQ0115|h1»: {} }
      layers:
        base:
          tasks:
            left: { pick: { to: "[0, 0 «HQ0113|$»] m" } }
            «HQ0107|right»:
"#,
        Syntax::Yaml,
    );
}
