//! Labels on the command line: plans, charts, maps and reports display them; data contains names, with labels beside
//! them.

use crate::common::cli;

use std::path::Path;

use cli::{folder, hierarq, text};
use serde_json::Value;

const FIELD: &str = "hierarq 1
mission field : schedule {
  robot m1 { label \"Тележка\"  depot [0, 0] m  speed [0.1, 0.4] m/s  serve 20 s }
  human h1 { label \"Łukasz\"  place [8, 2] m  duration normal(100 s, 10 s) }
  human h2 { label \"Ann-Marie O'Neill <b>\"  place [8, 5] m  duration normal(100 s, 10 s) }
  worker w1 { label \"葡萄车\"  place [9, -3] m  duration 120 s }
}
scenario day { mission field  duration 900 s  expect eventually done }
";

const LETTER: &str = "hierarq 1
mission letter : layers {
  robot left { label \"Ramię\"  place [0, 0, 0] m  speed [0.1, 0.4] m/s  skills { pick 2 s } }
  human h1 { label \"Łukasz\"  place [1, 0, 0] m  speed 0.5 m/s  skills { pick 3 s } }
  object c1 { label \"Klocek\"  place [0.3, 0.1, 0] m  features [cube] }
  place shelf { label \"Półka\"  at [0.4, 0.2, 0] m }
  layer base { label \"Podstawa\"  task foot = pick { label \"Stopa\"  features [cube]  agent h1  to shelf } }
}
scenario day { mission letter  duration 100 s  expect eventually done }
";

fn spec(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("writable");
    path.to_str().expect("UTF-8").to_string()
}

fn good(args: &[&str]) -> String {
    let out = hierarq(args);
    assert_eq!(out.status.code(), Some(0), "{args:?}: {}", text(&out.stderr));
    text(&out.stdout)
}

#[test]
fn plans_charts_and_maps_show_labels_of_both_syntaxes() {
    for (name, source, labels, names) in [
        (
            "labels_field",
            FIELD,
            &["Łukasz", "Ann-Marie O'Neill <b>", "Тележка", "葡萄车"][..],
            &["h1", "h2", "m1", "w1"][..],
        ),
        ("labels_letter", LETTER, &["Łukasz", "Ramię", "Klocek", "Podstawa", "Stopa"], &["h1", "left", "c1", "foot"]),
    ] {
        let folder = folder(name);
        let file = spec(&folder, "spec.hq", source);
        let yaml = spec(&folder, "spec.yaml", &good(&["fmt", "--to", "yaml", &file]));
        assert_eq!(good(&["fmt", "--to", "hq", &yaml]), good(&["fmt", "--to", "hq", &file]));
        let compiled = spec(&folder, "spec.json", &good(&["compile", &file, "--format", "json"]));
        let drawn = ["chart.svg", "map.svg"].map(|f| folder.join(f).to_str().expect("UTF-8").to_string());
        for file in [&file, &yaml, &compiled] {
            let mut printed = good(&["plan", file, "--gantt", &drawn[0], "--map", &drawn[1]]);
            for label in labels {
                assert!(printed.contains(label), "{label}:\n{printed}");
            }
            printed.push_str(&drawn.clone().map(|f| std::fs::read_to_string(f).expect("drawn")).join(""));
            let words: Vec<&str> = printed.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
            for name in names {
                assert!(!words.contains(name), "{name}:\n{printed}");
            }
        }
        // Data uses names as identifiers.
        let data: Value = serde_json::from_str(&good(&["plan", &file, "--json"])).expect("JSON");
        let agents = data["agents"].as_array().expect("agents");
        let known = |name: &Value| agents.iter().any(|who| who["name"] == *name);
        assert!(agents.iter().any(|who| who["name"] == "h1" && who["label"] == "Łukasz"), "{data}");
        assert!(data["activities"].as_array().expect("activities").iter().all(|a| known(&a["agent"])));
        let out = folder.join("out").to_str().expect("UTF-8").to_string();
        let run = good(&["run", &file, "--scenario", "day", "--out", &out]);
        let report = std::fs::read_to_string(folder.join("out/report.html")).expect("a report");
        assert!(run.contains("Łukasz") && report.contains("Łukasz"), "{run}");
        assert!(!run.split_whitespace().any(|word| word == "h1"), "{run}");
    }
}

/// Columns stay aligned with characters of width two or zero.
#[test]
fn wide_and_joined_characters_keep_columns() {
    let file = spec(&folder("labels_wide"), "spec.hq", &FIELD.replace("Łukasz", "Jose\u{301}"));
    let printed = good(&["plan", &file]);
    let row = |label: &str| {
        printed.lines().find(|line| line.starts_with(label)).unwrap_or_else(|| panic!("{label}")).to_string()
    };
    let width = |text: &str| hierarq::gantt::columns(text);
    let bars: Vec<usize> = ["Jose\u{301}", "葡萄车"]
        .map(row)
        .iter()
        .map(|line| width(&line[..line.find('=').expect("an operation")]))
        .collect();
    assert_eq!(bars[0], bars[1], "{printed}");
}

#[test]
fn a_compiled_label_that_commands_is_refused() {
    let folder = folder("labels_compiled");
    let file = spec(&folder, "spec.hq", FIELD);
    let compiled = good(&["compile", &file, "--format", "json"]);
    for (bad, said) in [("a\\u001b[2J", "control character"), ("Тележка", "same label")] {
        let damaged = spec(&folder, "spec.json", &compiled.replace("Łukasz", bad));
        let out = hierarq(&["plan", &damaged]);
        assert_eq!(out.status.code(), Some(1));
        assert!(text(&out.stderr).contains(said), "{}", text(&out.stderr));
    }
}
