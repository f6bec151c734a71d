//! Missions on the command line: plans, output, drawings; and messages if nothing can be planned or run.

use crate::common::cli;

use std::path::Path;
use std::process::Output;

use cli::{folder, hierarq, text};
use serde_json::Value;

/// Two robots and three services: few enough for a fast proof.
const SMALL: &str = "hierarq 1
param pace = 0.4 m/s
mission harvest : schedule {
  robot carrier { depot [0, 0] m  speed [0.1 m/s, pace]  serve 20 s }
  robot lorry { depot [1, 0] m  speed [0.1, 0.3] m/s  serve 10 s  deposit 5 s  factor 2 }
  human anna { place [8, 2] m  operations 2  duration normal(100 s, 10 s)  severity 0.5 }
  worker picker { place [9, -3] m  duration 120 s }
}
";

const OTHER: &str = "mission other : schedule {
  robot carrier { depot [0, 0] m  speed 0.2 m/s  serve 20 s }
  human anna { place [8, 2] m  duration 100 s }
}
";

/// Writes a spec; returns its path.
fn spec(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("writable");
    path.to_str().expect("UTF-8").to_string()
}

fn json(out: &Output) -> Value {
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    serde_json::from_slice(&out.stdout).expect("JSON")
}

#[test]
fn a_plan_says_who_does_what_and_how_sure_it_is() {
    let file = spec(&folder("plan_text"), "small.hq", SMALL);
    let out = hierarq(&["plan", &file]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let printed = text(&out.stdout);
    for part in
        ["mission harvest: 3 services", "planned by orders", "optimal", "validated", "anna.2", "picker.1", "cost"]
    {
        assert!(printed.contains(part), "`{part}` is missing:\n{printed}");
    }
    assert!(printed.lines().all(|l| l.chars().count() <= 130), "{printed}");
    assert_eq!(text(&hierarq(&["plan", &file]).stdout), printed, "the same plan each time");
}

#[test]
fn a_plan_as_data_adds_up() {
    let file = spec(&folder("plan_json"), "small.hq", SMALL);
    let data = json(&hierarq(&["plan", &file, "harvest", "--json"]));
    assert_eq!(data["ok"], true);
    let number = |v: &Value| v.as_f64().expect("a number");
    let parts = data["cost"]["parts"].as_array().expect("parts");
    let sum: f64 = parts.iter().map(|part| number(&part["cost"])).sum();
    assert!((sum - number(&data["cost"]["total"])).abs() < 1e-9);
    let services = data["services"].as_array().expect("services");
    assert_eq!(services.len(), 3);
    for s in services {
        // The planned duration of each operation of anna is its mean plus 1.2816 standard deviations: nine of ten end
        // in time.
        if s["operation"] == serde_json::json!({ "of": "anna", "number": 1 }) {
            assert!((number(&s["operation_ends"]) - 112.8155).abs() < 1e-3, "{s}");
        }
        assert!(number(&s["serves"]) >= number(&s["operation_ends"]) - 1e-6, "{s}");
        let most = if s["robot"] == "carrier" { 0.4 } else { 0.3 };
        for key in ["going_speed", "approach_speed", "return_speed"] {
            let v = number(&s[key]);
            assert!(v <= most + 1e-9 && v >= 0.08, "{s}");
        }
    }
}

#[test]
fn a_compiled_mission_gives_the_plan_of_its_source() {
    let folder = folder("plan_compiled");
    let file = spec(&folder, "small.hq", SMALL);
    let yaml = text(&hierarq(&["fmt", "--to", "yaml", &file]).stdout);
    let yaml = spec(&folder, "small.yaml", &yaml);
    let compiled = hierarq(&["compile", &file, "--format", "json"]);
    assert_eq!(compiled.status.code(), Some(0), "{}", text(&compiled.stderr));
    let compiled = spec(&folder, "small.json", &text(&compiled.stdout));
    let plan = |file: &str| {
        let data = json(&hierarq(&["plan", file, "--json"]));
        (data["activities"].clone(), data["cost"].clone())
    };
    assert_eq!(plan(&compiled), plan(&file));
    assert_eq!(plan(&yaml), plan(&file));
    let slower = json(&hierarq(&["plan", &file, "--json", "--set", "pace=0.2 m/s"]));
    assert_ne!(slower["cost"], plan(&file).1);
}

#[test]
fn a_compiled_mission_that_was_damaged_is_refused() {
    let folder = folder("plan_damaged");
    let file = spec(&folder, "small.hq", SMALL);
    let good = text(&hierarq(&["compile", &file, "--format", "json"]).stdout);
    for (from, to, why) in [
        ("\"high\": 0.4", "\"high\": 0.01", "carrier"),
        ("\"batch\": 4", "\"batch\": 0", "batch"),
        ("\"missions\"", "\"mission\"", "program"),
        ("\"format\": ", "\"format\": 9", "version"),
        ("\"confidence\": 0.9", "\"confidence\": \"much\"", "confidence"),
    ] {
        assert!(good.contains(from), "{from}");
        let bad = spec(&folder, "bad.json", &good.replacen(from, to, 1));
        let out = hierarq(&["plan", &bad]);
        assert_eq!(out.status.code(), Some(1), "{to}: {}", text(&out.stdout));
        let said = text(&out.stderr);
        assert!(said.contains("HQ0607") && (said.contains(why) || why == "confidence"), "{to}: {said}");
    }
}

#[test]
fn what_cannot_be_planned_is_underlined() {
    let file = spec(&folder("plan_refused"), "bad.hq", &SMALL.replace("[0.1, 0.3] m/s", "[0.3, 0.1] m/s"));
    let out = hierarq(&["plan", &file]);
    assert_eq!(out.status.code(), Some(1));
    assert!(text(&out.stderr).contains("HQ0903"), "{}", text(&out.stderr));
    let out = hierarq(&["plan", &file, "--json"]);
    assert_eq!(out.status.code(), Some(1));
    let data: Value = serde_json::from_slice(&out.stdout).expect("JSON");
    assert_eq!(data["diagnostics"][0]["place"]["line"], 5);
}

#[test]
fn usage_is_told_with_what_to_do() {
    let folder = folder("plan_usage");
    let file = spec(&folder, "small.hq", SMALL);
    let two = spec(&folder, "two.hq", &format!("{SMALL}{OTHER}"));
    let robot = "examples/hello.hq";
    for (args, said) in [
        (vec![file.as_str(), "--engine", "highs"], "python3 -m pip install highsbox"),
        (vec![file.as_str(), "--formulation", "constraint"], "carrier"),
        (vec![file.as_str(), "harvst"], "did you mean `harvest`?"),
        (vec![file.as_str(), "--budget", "0"], "--budget"),
        (vec![file.as_str(), "--budget", "1e300"], "--budget"),
        (vec![two.as_str()], "`harvest` and `other`"),
        (vec![robot], "declares no mission"),
        (vec![file.as_str(), "--gantt", "/nowhere/chart.svg"], "cannot write"),
        (vec![file.as_str(), "--batch", "0"], "--batch"),
        (vec![file.as_str(), "--engine", "cplex"], "built-in"),
    ] {
        let args: Vec<&str> = ["plan"].into_iter().chain(args).collect();
        let out = hierarq(&args);
        assert_eq!(out.status.code(), Some(2), "{args:?}: {}", text(&out.stdout));
        assert!(text(&out.stderr).contains(said), "{args:?}: {}", text(&out.stderr));
    }
    let other = json(&hierarq(&["plan", &two, "other", "--json"]));
    assert_eq!(other["mission"], "other");
}

#[test]
fn formulations_agree_where_they_fit() {
    let file = spec(&folder("plan_formulations"), "other.hq", &format!("hierarq 1\n{OTHER}"));
    let cost = |formulation: &str| {
        let data = json(&hierarq(&["plan", &file, "--json", "--formulation", formulation]));
        assert_eq!(data["formulation"], formulation);
        data["cost"]["total"].as_f64().expect("a number")
    };
    let costs = ["subsets", "constraint", "orders", "position", "batches"].map(cost);
    for c in costs {
        assert!((c - costs[0]).abs() < 1e-3 * costs[0], "{costs:?}");
    }
}

#[test]
fn a_plan_is_drawn() {
    let folder = folder("plan_drawn");
    let file = spec(&folder, "small.hq", SMALL);
    let (chart, map) = (folder.join("chart.svg"), folder.join("map.svg"));
    let path = |p: &Path| p.to_str().expect("UTF-8").to_string();
    let out = hierarq(&["plan", &file, "--gantt", &path(&chart), "--map", &path(&map)]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    for picture in [chart, map] {
        let svg = std::fs::read_to_string(picture).expect("written");
        let tree = roxmltree::Document::parse(&svg).expect("XML");
        assert_eq!(tree.root_element().tag_name().name(), "svg");
        assert!(svg.contains("anna") && svg.contains("lorry"));
    }
}

/// A team of two that places three cubes in two layers.
const LETTER: &str = "hierarq 1
mission letter : layers {
  weights { workload 4  energy 1  makespan 10 }
  robot left { place [0, 0, 0] m  speed [0.1, 0.4] m/s  skills { pick_and_place 2 s }  reach 1 m }
  human anna { place [1, 0, 0] m  speed 0.5 m/s  skills { pick_and_place 3 s } }
  for i in 1..3 { object cube_${i} { place [0.3 m, i * 0.1 m, 0 m]  mass 0.2 kg  features [cube] } }
  layer base {
    task left_foot = pick_and_place { features [cube]  to [0.4, 0.2, 0] m }
    task right_foot = pick_and_place { features [cube]  to [0.6, 0.2, 0] m }
  }
  layer top { task head = pick_and_place { object cube_3  agent anna  to [0.5, 0.2, 0.1] m } }
}
";

#[test]
fn layers_are_planned_one_after_the_other() {
    let folder = folder("plan_layers");
    let file = spec(&folder, "letter.hq", LETTER);
    let yaml = spec(&folder, "letter.yaml", &text(&hierarq(&["fmt", "--to", "yaml", &file]).stdout));
    let compiled = spec(&folder, "letter.json", &text(&hierarq(&["compile", &file, "--format", "json"]).stdout));
    let data = json(&hierarq(&["plan", &file, "--json"]));
    assert_eq!(data["kind"], "layers");
    let activities = data["activities"].as_array().expect("activities");
    assert_eq!(activities.len(), 3);
    let of = |a: &Value, key: &str| a[key].as_f64().expect("a number");
    let head = activities.iter().find(|a| a["task"] == "head").expect("the head");
    assert_eq!((&head["object"], &head["agent"]), (&"cube_3".into(), &"anna".into()), "{head}");
    for foot in activities.iter().filter(|a| a["task"] != "head") {
        assert!(of(foot, "end") <= of(head, "start") + 1e-6);
    }
    for other in [&yaml, &compiled] {
        assert_eq!(json(&hierarq(&["plan", other, "--json"]))["activities"], data["activities"]);
    }
    let printed = text(&hierarq(&["plan", &file]).stdout);
    for part in ["3 tasks", "planned by branch", "optimal", "validated", "right_foot", "cube_3", "cost"] {
        assert!(printed.contains(part), "`{part}` is missing:\n{printed}");
    }
    let shown = text(&hierarq(&["compile", &file]).stdout);
    assert!(shown.starts_with("mission letter : layers\n  3 tasks in 2 layers, 3 objects"), "{shown}");
    let wrong = hierarq(&["plan", &file, "--formulation", "subsets"]);
    assert_eq!(wrong.status.code(), Some(2));
    assert!(text(&wrong.stderr).contains("`branch`, `mixed` and `batches`"), "{}", text(&wrong.stderr));
    let map = hierarq(&["plan", &file, "--map", "/nowhere/map.svg"]);
    assert_eq!(map.status.code(), Some(2));
}

/// The map of layers: a path for each carried cube, from its position to its target, with one scale.
#[test]
fn layers_are_drawn_from_above() {
    let folder = folder("plan_layers_drawn");
    let file = spec(&folder, "letter.hq", LETTER);
    let map = folder.join("map.svg");
    let out = hierarq(&["plan", &file, "--map", map.to_str().expect("UTF-8")]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let svg = std::fs::read_to_string(map).expect("written");
    let tree = roxmltree::Document::parse(&svg).expect("XML");
    let of = |class: &str| {
        let has =
            |node: &roxmltree::Node<'_, '_>| node.attribute("class").is_some_and(|c| c.split(' ').any(|c| c == class));
        tree.descendants().filter(has).collect::<Vec<_>>()
    };
    let carried = of("carries");
    assert_eq!(carried.len(), 3);
    let number = |text: &str| text.parse::<f64>().expect("a number");
    let ends = |node: &roxmltree::Node<'_, '_>| {
        let line = node.attribute("d").expect("a way").replace(['M', 'L'], "");
        let at: Vec<f64> = line.split_whitespace().map(number).collect();
        [at[at.len() - 2] - at[0], at[at.len() - 1] - at[1]]
    };
    let head = carried.iter().find(|n| n.attribute("class") == Some("carries line-1")).expect("the head");
    // Cube 3 moves 0.2 m to the right and 0.1 m down.
    let scale = number(of("robots")[0].attribute("data-scale").expect("a scale"));
    let [dx, dy] = ends(head);
    assert!((dx / scale - 0.2).abs() < 1e-3 && (dy / scale - 0.1).abs() < 1e-3, "{dx} {dy} {scale}");
    // Every cube is used, in the colour of its layer; one is in the legend.
    assert_eq!((of("object").len(), of("layer-1").len()), (4, 2));
    for name in ["left", "anna", "cube_1"] {
        assert!(svg.contains(&format!(">{name}</text>")), "{name}");
    }
}

/// A spec with missions only can be checked, compiled and formatted; commands that need a robot suggest an alternative.
#[test]
fn missions_alone_are_a_spec() {
    let folder = folder("missions_alone");
    let file = spec(&folder, "small.hq", SMALL);
    assert_eq!(text(&hierarq(&["check", &file]).stdout), format!("{file}: good\n"));
    let compiled = text(&hierarq(&["compile", &file]).stdout);
    assert!(compiled.starts_with("mission harvest : schedule\n"), "{compiled}");
    assert_eq!(hierarq(&["fmt", &file]).status.code(), Some(0));
    assert_eq!(hierarq(&["fmt", "--check", &file]).status.code(), Some(0));
    for command in ["run", "graph", "bench"] {
        let out = hierarq(&[command, &file]);
        assert_eq!(out.status.code(), Some(2), "{command}: {}", text(&out.stderr));
        assert!(text(&out.stderr).contains(&format!("hierarq plan {file}")), "{command}: {}", text(&out.stderr));
    }
    for args in [&["test", &file][..], &["sweep", &file, "--vary", "pace=0.2..0.3"]] {
        let out = hierarq(args);
        assert_eq!(out.status.code(), Some(2));
        assert!(text(&out.stderr).contains("no scenario"), "{}", text(&out.stderr));
    }
}

/// A robot and missions in one file: the robot runs, the missions are planned, and a compiled file contains both.
#[test]
fn a_robot_and_missions_share_a_file() {
    let folder = folder("missions_and_robot");
    let hello = std::fs::read_to_string("examples/hello.hq").expect("readable");
    let urdf = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/robots/arm7.urdf");
    let hello = hello.replace("robots/arm7.urdf", urdf.to_str().expect("UTF-8"));
    let file = spec(&folder, "both.hq", &format!("{hello}\n{OTHER}"));
    let compiled = hierarq(&["compile", &file, "--format", "json"]);
    assert_eq!(compiled.status.code(), Some(0), "{}", text(&compiled.stderr));
    let compiled = spec(&folder, "both.json", &text(&compiled.stdout));
    let out = folder.join("out");
    let run = |file: &str| {
        let out = out.to_str().expect("UTF-8");
        let run = hierarq(&["run", file, "--duration", "0.1s", "--out", out]);
        assert_eq!(run.status.code(), Some(0), "{}", text(&run.stderr));
        std::fs::read_to_string(Path::new(out).join("log.csv")).expect("written")
    };
    assert_eq!(run(&compiled), run(&file));
    let plan = |file: &str| json(&hierarq(&["plan", file, "--json"]))["activities"].clone();
    assert_eq!(plan(&compiled), plan(&file));
}
