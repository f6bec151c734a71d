//! `hierarq graph`: the three formats of one machine, and properties of the picture of any machine.

use crate::common;

use std::collections::BTreeSet;
use std::process::Command;

use hierarq::graph::{Format, draw};
use proptest::prelude::*;
use runtime::Program;
use runtime::program::Trigger;

const ARM: &str = "hierarq 1
robot arm { urdf \"robots/arm7.urdf\"  rate 100 Hz  home { all [0, 0.40, 0, 1.60, 0, 1.14, 0] rad } }
task reach = frame_position(tool) { position initial(position) + [0, 0.1, 0] m }
stack still { level limits hard { joint_position_limits  joint_velocity_limits } }
stack go from still { add motion { reach } }
";

const MACHINE: &str = "
signal start : event
signal load : number  timeout 0.1 s

machine pick {
  initial wait
  blend 0.3 s
  on fault(any) -> stopped

  state wait {
    stack still
    enter say \"Ready; \\\"a\\\" < b & c: go!\"
    on start -> work
    on start -> work.near
  }

  state work {
    stack go
    initial far
    do capture(camera)
    after 10 s -> wait
    on not_found -> near

    state far { on reached(reach, 5 mm) -> near }

    state near {
      when load > 3 and not (load > 30) for 200 ms -> done
      on fault(tracking) -> work
    }
  }

  final state done { stack still }
  final state stopped
}
";

fn small() -> Program {
    common::program_of(&format!("{ARM}{MACHINE}"))
}

#[test]
fn the_three_formats() {
    let program = small();
    for (name, format) in [("mermaid", Format::Mermaid), ("dot", Format::Dot), ("svg", Format::Svg)] {
        insta::assert_snapshot!(name, draw(&program, format).expect("a machine"));
    }
    insta::assert_snapshot!("text", runtime::text::text(&program).expect("it can be executed"));
}

#[test]
fn both_syntaxes_are_drawn_alike() {
    let text = format!("{ARM}{MACHINE}");
    let (tree, diagnostics) = dsl::parse(dsl::SourceId(0), &text, dsl::Syntax::Native);
    assert!(diagnostics.is_empty(), "{diagnostics:?}");
    let yaml = dsl::print(&tree, dsl::Syntax::Yaml);
    let folder = common::example("");
    let compiled = compiler::compile(&compiler::Input {
        name: "test.yaml",
        text: &yaml,
        syntax: dsl::Syntax::Yaml,
        folder: &folder,
        set: &[],
        package_paths: &[],
    });
    let program = compiled.program.expect("it compiles");
    for format in [Format::Mermaid, Format::Dot, Format::Svg] {
        assert_eq!(draw(&program, format), draw(&small(), format));
    }
}

/// A box of the picture.
#[derive(Clone, Debug)]
struct Rect {
    state: String,
    x: f64,
    y: f64,
    right: f64,
    bottom: f64,
}

impl Rect {
    fn apart(&self, other: &Rect) -> bool {
        self.right < other.x || other.right < self.x || self.bottom < other.y || other.bottom < self.y
    }

    fn holds(&self, other: &Rect) -> bool {
        self.x < other.x && self.y < other.y && other.right < self.right && other.bottom < self.bottom
    }
}

fn number(node: &roxmltree::Node, name: &str) -> f64 {
    node.attribute(name).and_then(|v| v.parse().ok()).unwrap_or_else(|| panic!("`{name}` of {node:?}"))
}

/// Checks all properties of the picture of a machine.
fn check(program: &Program) {
    let machine = program.machine.as_ref().expect("a machine");
    let svg = draw(program, Format::Svg).expect("a machine");
    let tree = roxmltree::Document::parse(&svg).unwrap_or_else(|e| panic!("{e}\n{svg}"));
    let (width, height) = (number(&tree.root_element(), "width"), number(&tree.root_element(), "height"));
    let rects: Vec<Rect> = tree
        .descendants()
        .filter_map(|n| {
            let (x, y) = n.attribute("data-state").map(|_| (number(&n, "x"), number(&n, "y")))?;
            let (right, bottom) = (x + number(&n, "width"), y + number(&n, "height"));
            Some(Rect { state: n.attribute("data-state")?.to_string(), x, y, right, bottom })
        })
        .collect();
    let names: Vec<&str> = machine.states.iter().map(|s| s.name.as_str()).collect();
    assert_eq!(rects.iter().map(|r| r.state.as_str()).collect::<Vec<_>>(), names, "every state once");
    for (i, a) in rects.iter().enumerate() {
        assert!(a.x >= 0.0 && a.y >= 0.0 && a.right <= width && a.bottom <= height, "{a:?} outside the picture");
        for (k, b) in rects.iter().enumerate().filter(|(k, _)| *k != i) {
            let inside = |s: usize, outer: usize| machine.path(s).any(|p| p == outer);
            match (inside(i, k), inside(k, i)) {
                (true, _) => assert!(b.holds(a), "{a:?} not inside {b:?}"),
                (_, true) => assert!(a.holds(b), "{b:?} not inside {a:?}"),
                _ => assert!(a.apart(b), "{a:?} overlaps {b:?}"),
            }
        }
    }
    // Every text fits its box, and no two texts overlap. A letter of the font is at most 0.61 of its size wide.
    let mut texts: Vec<(f64, f64, f64, String)> = Vec::new();
    for n in tree.descendants().filter(|n| n.has_tag_name("text")) {
        let said = n.text().unwrap_or("");
        let size = n.attribute("font-size").map_or(12.0, |s| s.parse().expect("a number"));
        let long = said.chars().count() as f64 * size * 0.61;
        let x = number(&n, "x");
        let (left, right) = if n.attribute("text-anchor") == Some("end") { (x - long, x) } else { (x, x + long) };
        let rect = n.parent().and_then(|g| g.children().find_map(|r| r.attribute("data-state"))).expect("in a state");
        let rect = rects.iter().find(|r| r.state == rect).expect("a box");
        assert!(rect.x < left && right < rect.right, "`{said}` leaves {rect:?}");
        for (l, r, y, other) in &texts {
            let near = (y - number(&n, "y")).abs() < 12.0;
            assert!(!near || right < *l || *r < left, "`{said}` runs into `{other}`");
        }
        texts.push((left, right, number(&n, "y"), said.to_string()));
    }
    // Every transition is a path that begins at its state's box and is labelled with its text.
    let ways: Vec<roxmltree::Node> = tree.descendants().filter(|n| n.attribute("class") == Some("way")).collect();
    let all: Vec<_> = machine.states.iter().flat_map(|s| s.transitions.iter().map(move |t| (s, t))).collect();
    assert_eq!(ways.len(), all.len());
    for (state, t) in all {
        let target = machine.states[t.target].name.as_str();
        let title = format!("{}: {}, to {target}", state.name, t.text);
        let way = ways.iter().find(|w| w.children().any(|c| c.text() == Some(title.as_str())));
        let way = way.unwrap_or_else(|| panic!("no way `{title}`"));
        assert_eq!((way.attribute("data-from"), way.attribute("data-to")), (Some(state.name.as_str()), Some(target)));
        assert_eq!(way.has_attribute("stroke-dasharray"), matches!(t.trigger, Trigger::Fault(_)), "{title}");
        let words: String = t.text.split_whitespace().collect();
        let plain = texts.iter().filter(|t| !t.3.starts_with('→'));
        let said: String = plain.flat_map(|t| t.3.split_whitespace()).collect();
        assert!(said.contains(&words), "`{}` is not written", t.text);
        let start: f64 = way.attribute("d").and_then(|d| d[1..].split(' ').next()?.parse().ok()).expect("a path");
        let from = rects.iter().find(|r| r.state == state.name).expect("a box");
        assert!((start - from.right).abs() < 0.11, "{title}");
    }
    let dots = tree.descendants().filter(|n| n.attribute("class") == Some("initial")).count();
    assert_eq!(dots, machine.states.iter().filter(|s| s.initial.is_some()).count());
    // The other formats name every state and every transition too.
    for format in [Format::Mermaid, Format::Dot] {
        let text = draw(program, format).expect("a machine");
        let arrow = if format == Format::Dot { "->" } else { "-->" };
        let lines: Vec<&str> = text.lines().filter(|l| l.split_whitespace().nth(1) == Some(arrow)).collect();
        let count: usize = machine.states.iter().map(|s| s.transitions.len()).sum();
        let ended = match format {
            Format::Mermaid => machine.states.iter().filter(|s| s.is_final).count(),
            _ => 0,
        };
        assert_eq!(lines.len(), count + dots + ended, "{text}");
        assert_eq!(text.matches(['{']).count(), text.matches(['}']).count(), "{text}");
        let ids: BTreeSet<&str> = text.split(|c: char| !c.is_ascii_alphanumeric()).collect();
        for i in 1..machine.states.len() {
            let id = format!("s{i}");
            assert!(ids.contains(id.as_str()) || text.contains(&format!("cluster_s{i} ")), "{id} in {text}");
        }
    }
}

#[test]
fn the_picture_of_the_small_machine() {
    check(&small());
}

/// A tree of states, each with some transitions.
#[derive(Clone, Debug)]
struct Tree {
    parents: Vec<usize>,
    ways: Vec<(usize, usize, u8)>,
    last: Vec<bool>,
}

fn trees() -> impl Strategy<Value = Tree> {
    (1..12_usize)
        .prop_flat_map(|n| {
            let parents: Vec<_> = (0..n).map(|i| 0..=i).collect();
            let way = (0..=n, 1..=n, 0..5_u8);
            (parents, prop::collection::vec(way, 0..20), prop::collection::vec(any::<bool>(), n))
        })
        .prop_map(|(parents, ways, last)| Tree { parents, ways, last })
}

impl Tree {
    fn path(&self, s: usize) -> String {
        match self.parents[s - 1] {
            0 => format!("s{s}"),
            p => format!("{}.s{s}", self.path(p)),
        }
    }

    fn write(&self, s: usize, out: &mut String) {
        let children: Vec<usize> = (1..=self.parents.len()).filter(|&k| self.parents[k - 1] == s).collect();
        if let Some(first) = children.first() {
            out.push_str(&format!("initial s{first}\n"));
        }
        for (_, to, kind) in self.ways.iter().filter(|w| w.0 == s) {
            let trigger = match kind {
                0 => "on go",
                1 => "after 3 s",
                2 => "on fault(tracking)",
                3 => "when load > 1 and load < 2 and load > 1.5 and load < 1.9 and load > 1.7 for 3 s",
                _ => "on fault(any)",
            };
            out.push_str(&format!("{trigger} -> {}\n", self.path(*to)));
        }
        for k in children {
            let word = if self.last[k - 1] { "final state" } else { "state" };
            out.push_str(&format!("{word} s{k} {{\nstack still\n"));
            self.write(k, out);
            out.push_str("}\n");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn pictures_of_any_machine(tree in trees()) {
        let mut text = format!("{ARM}signal go : event\nsignal load : number\nmachine m {{\n");
        tree.write(0, &mut text);
        text.push_str("}\n");
        check(&common::program_of(&text));
    }
}

fn hierarq(args: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hierarq"));
    let out =
        command.args(args).env("NO_COLOR", "1").current_dir(env!("CARGO_MANIFEST_DIR")).output().expect("it runs");
    let text = |b: &[u8]| String::from_utf8_lossy(b).into_owned();
    (out.status.code(), text(&out.stdout), text(&out.stderr))
}

#[test]
fn the_command() {
    let (code, out, _) = hierarq(&["graph", "editors/words.hq"]);
    assert_eq!(code, Some(0));
    assert!(out.contains("stateDiagram-v2"), "{out}");
    let file = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("words.svg");
    let (code, out, _) =
        hierarq(&["graph", "editors/words.hq", "--format", "svg", "--out", file.to_str().expect("UTF-8")]);
    assert_eq!((code, out.as_str()), (Some(0), ""));
    assert!(std::fs::read_to_string(&file).expect("written").starts_with("<svg"));
    let (code, _, err) = hierarq(&["graph", "examples/hello.hq"]);
    assert_eq!(code, Some(2));
    assert!(err.contains("has no machine to draw"), "{err}");
    assert_eq!(hierarq(&["graph", "examples/none.hq"]).0, Some(1));
    assert_eq!(hierarq(&["graph", "editors/words.hq", "--out", "/nowhere/at/all.svg"]).0, Some(2));
}
