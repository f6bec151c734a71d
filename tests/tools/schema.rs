//! The JSON Schema against valid and invalid specs of the compiler, by an external validator.

use std::path::Path;

use compiler::{Compiled, Input};
use dsl::{SourceId, Syntax};
use jsonschema::Validator;
use serde_json::{Value, json};

use super::{hierarq, text};

static EXAMPLES: &[&str] = &[
    "vineyard",
    "hello",
    "safety_tasks",
    "uncooperative_motion",
    "cooperative_motion",
    "swivel_angle",
    "both_arms",
    "tested",
];

fn printed() -> Value {
    let out = hierarq(&["schema"]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    serde_json::from_slice(&out.stdout).expect("JSON")
}

fn validator() -> Validator {
    let schema = hierarq::schema::schema();
    jsonschema::draft202012::meta::validate(&schema).expect("a schema by the rules of 2020-12");
    jsonschema::draft202012::new(&schema).expect("a schema")
}

/// Parses a text with an external YAML reader.
fn data(yaml: &str) -> Value {
    serde_yaml::from_str(yaml).expect("YAML")
}

fn mistakes(validator: &Validator, value: &Value) -> Vec<String> {
    validator.iter_errors(value).map(|e| format!("{}: {e}", e.instance_path())).collect()
}

fn example(name: &str) -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(format!("{name}.yaml"));
    data(&std::fs::read_to_string(path).expect("readable"))
}

fn compile(yaml: &str) -> Compiled {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let syntax = Syntax::Yaml;
    compiler::compile(&Input { name: "test.yaml", text: yaml, syntax, folder: &folder, set: &[], package_paths: &[] })
}

#[test]
fn the_command_prints_the_schema() {
    assert_eq!(printed(), hierarq::schema::schema());
}

#[test]
fn every_example_is_valid() {
    let validator = validator();
    for name in EXAMPLES {
        assert_eq!(mistakes(&validator, &example(name)), Vec::<String>::new(), "{name}");
    }
}

#[test]
fn every_yaml_spec_of_the_docs_is_valid() {
    let validator = validator();
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/src/language/yaml.md");
    let page = std::fs::read_to_string(page).expect("readable");
    let mut count = 0;
    for block in page.split("```yaml\n").skip(1).filter_map(|b| b.split("```").next()) {
        count += 1;
        assert_eq!(mistakes(&validator, &data(block)), Vec::<String>::new(), "{block}");
    }
    assert!(count > 0);
}

/// The robot page of the docs uses nearly every key; the catalogue's examples use every type.
#[test]
fn what_the_printer_writes_is_valid() {
    let validator = validator();
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/src/language/robot.md");
    let page = std::fs::read_to_string(page).expect("readable");
    let robot = page.split("```hq\n").nth(1).and_then(|b| b.split("```").next()).expect("a spec");
    let mut texts = vec![robot.to_string()];
    texts.extend(stdlib_tasks::KINDS.iter().map(|k| format!("hierarq 1\n{}\n", k.example)));
    texts.push(
        "hierarq 1\nstack s { lock [base]  level a damping 0.1 { x weight 2  hold(left, right) weight 3 } }\n\
         run { duration 2 min  solver clarabel  simulator { lag 30 ms  noise 0.0005 rad  seed 7 } }\n"
            .to_string(),
    );
    // Declarations that a spec takes from others.
    texts.push(
        "hierarq 1\nimport \"a.hq\" { b, c as d }\nlet wave = sin(t/(1 s))\nparam x = 1 m { min 0 m  max 2 m }\n\
         robot e from d { rate 50 Hz }\ntask f(side: arm = left) = hold(side)\nstack g(side: arm) { level a { f(side) } }\n\
         stack h from g(left) { add i hard { f(right) } before a  replace a { b }  remove i }\n\
         for i in 1..3 {\n  param y_${i} = 1 m\n  task j_${i} = hold(left)\n  for k in [left, right] {\n    stack l_${i}_${k} {\n\
               level a { for n in [1, 2] { hold(left)  joint_velocity { velocity { \"arm_${k}_*\" 0 rad/s } } } }\n    }\n  }\n}\n"
            .to_string(),
    );
    // Signals, machines, scenarios: those of the docs, and the file of all words.
    for page in ["docs/src/language/machines.md", "docs/src/language/missions.md", "docs/src/language/scenarios.md"] {
        let page = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(page)).expect("readable");
        let blocks = page.split("```hq\n").skip(1).filter_map(|b| b.split("```").next());
        texts.extend(blocks.map(|b| format!("hierarq 1\n{}", b.trim_start_matches("hierarq 1\n"))));
    }
    texts.push(include_str!("../../editors/words.hq").to_string());
    for text in texts {
        let (tree, diagnostics) = dsl::parse(SourceId(0), &text, Syntax::Native);
        assert!(diagnostics.is_empty(), "{text}\n{diagnostics:?}");
        let yaml = dsl::print(&tree, Syntax::Yaml);
        assert_eq!(mistakes(&validator, &data(&yaml)), Vec::<String>::new(), "{yaml}");
    }
}

/// Collects the paths of all keys of a value.
fn keys(value: &Value, at: &str, out: &mut Vec<(String, String)>) {
    match value {
        Value::Object(map) => {
            for (key, inner) in map {
                out.push((at.to_string(), key.clone()));
                keys(inner, &format!("{at}/{}", key.replace('~', "~0").replace('/', "~1")), out);
            }
        }
        Value::Array(items) => {
            for (i, inner) in items.iter().enumerate() {
                keys(inner, &format!("{at}/{i}"), out);
            }
        }
        _ => {}
    }
}

/// Mistakes in a machine that are detectable without resolving names.
#[test]
fn machines_that_are_not_valid() {
    let validator = validator();
    let machine = |state: Value| json!({ "hierarq": 1, "machines": { "m": { "initial": "a", "states": { "a": { "states": { "b": state } } } } } });
    for good in [
        json!({}),
        json!({ "final": true, "stack": "reach(left, goal: x)", "enter": ["say \"a\"", "log(b)"], "do": "capture(c)" }),
        json!({ "transitions": [{ "on": "fault(any)", "to": "a.b" }, { "when": "x < 3 N", "for": "3 s", "to": "c" }] }),
        json!({ "transitions": [{ "after": "10 s", "to": "c", "blend": "1 s" }], "initial": "c", "blend": 0.5 }),
    ] {
        assert_eq!(mistakes(&validator, &machine(good)), Vec::<String>::new());
    }
    for bad in [
        json!({ "stak": "reach" }),
        json!({ "transitions": { "on": "found", "to": "b" } }),
        json!({ "transitions": [{ "on": "found" }] }),
        json!({ "transitions": [{ "to": "b" }] }),
        json!({ "transitions": [{ "on": "found", "when": "x < 3 N", "to": "b" }] }),
        json!({ "transitions": [{ "on": "found", "for": "3 s", "to": "b" }] }),
        json!({ "transitions": [{ "after": "10 m", "to": "b" }] }),
        json!({ "blend": "1 m" }),
        json!({ "final": "yes" }),
        json!({ "states": { "c": { "stak": "x" } } }),
    ] {
        assert!(!validator.is_valid(&machine(bad.clone())), "{bad}");
    }
    let signal = |signal: Value| json!({ "hierarq": 1, "signals": { "s": signal } });
    for good in [json!("point?"), json!("event"), json!({ "type": "wrench", "timeout": "100 ms" })] {
        assert!(validator.is_valid(&signal(good.clone())), "{good}");
    }
    for bad in [json!("pont"), json!({ "timeout": "1 s" }), json!({ "type": "point", "timeout": "1 m" }), json!(3)] {
        assert!(!validator.is_valid(&signal(bad.clone())), "{bad}");
    }
}

#[test]
fn missions_that_are_not_valid() {
    let validator = validator();
    let mission = |kind: Value| json!({ "hierarq": 1, "missions": { "m": kind } });
    let robots = json!({ "r": { "depot": "[0, 0] m", "speed": "[0.05, 0.2] m/s", "serve": "20 s" } });
    let human = json!({ "place": "[1, 1] m", "duration": "normal(200 s, 20 s)" });
    let repeat = json!({ "name": "i", "in": "1..2", "humans": { "h${i}": human } });
    for good in [
        json!({ "robots": robots, "humans": { "h": human } }),
        json!({ "robots": robots, "for": [repeat] }),
        json!({ "for": [{ "name": "i", "in": [1, 2], "robots": robots, "for": [repeat] }], "confidence": 0.9 }),
    ] {
        assert_eq!(mistakes(&validator, &mission(json!({ "schedule": good }))), Vec::<String>::new());
    }
    for bad in [
        json!({ "robot": robots }),
        json!({ "humans": { "h": human } }),
        json!({ "robots": robots, "confidence": "0.9 m" }),
        json!({ "robots": { "r": { "depot": "[0, 0] m", "speed": "0.2 m", "serve": "20 s" } } }),
        json!({ "robots": { "r": { "depot": "[0, 0] m" } } }),
        json!({ "robots": robots, "for": repeat }),
        json!({ "robots": robots, "for": [{ "name": "i", "humans": { "h${i}": human } }] }),
        json!({ "robots": robots, "for": [{ "name": "i", "in": "1..2", "confidence": 0.9 }] }),
    ] {
        assert!(!validator.is_valid(&mission(json!({ "schedule": bad.clone() }))), "{bad}");
    }
    for bad in [json!({}), json!({ "shedule": { "robots": robots } }), json!({ "robots": robots }), json!("schedule")] {
        assert!(!validator.is_valid(&mission(bad.clone())), "{bad}");
    }
    // Every section may be repeated.
    let repeated = json!({ "name": "i", "in": [1, 2], "signals": { "s": "point?" }, "missions": {} });
    assert_eq!(mistakes(&validator, &json!({ "hierarq": 1, "for": [repeated] })), Vec::<String>::new());
}

/// Every key of every example is misspelt in turn. If the compiler reports an unknown key or type, the schema rejects
/// it too.
#[test]
fn misspelt_keys_are_not_valid() {
    let validator = validator();
    let mut refused = 0;
    for name in ["hello", "cooperative_motion", "uncooperative_motion", "both_arms"] {
        let good = example(name);
        let mut all = Vec::new();
        keys(&good, "", &mut all);
        for (at, key) in all {
            let mut bad = good.clone();
            let parent = bad.pointer_mut(&at).and_then(Value::as_object_mut).expect("it was there");
            let value = parent.remove(&key).expect("it was there");
            let misspelt = match key.split_once('(') {
                Some((kind, rest)) => format!("{kind}x({rest}"),
                None => format!("{key}x"),
            };
            parent.insert(misspelt.clone(), value);
            let yaml = serde_yaml::to_string(&bad).expect("YAML");
            let compiled = compile(&yaml);
            let unknown = |d: &&dsl::Diagnostic| {
                matches!(d.code, "HQ0132" | "HQ0203" | "HQ0205")
                    && d.message.contains(&format!("`{}`", misspelt.split('(').next().unwrap_or("")))
            };
            if compiled.report.diagnostics.iter().find(unknown).is_some() {
                refused += 1;
                assert!(!validator.is_valid(&bad), "{name}: `{misspelt}` in {at} is taken for good");
            }
        }
    }
    assert!(refused > 60, "only {refused} misspelt keys were refused by the compiler");
}

/// Returns the keys that the compiler lists for an unknown one.
fn listed(yaml: &str) -> Vec<String> {
    let compiled = compile(yaml);
    let d = compiled.report.diagnostics.iter().find(|d| d.message.contains("`qqqqqq`"));
    let help = d.and_then(|d| d.help.clone()).unwrap_or_else(|| panic!("no list of keys:\n{yaml}"));
    let mut keys: Vec<String> = help.split('`').skip(1).step_by(2).map(str::to_string).collect();
    keys.sort();
    keys
}

/// Schema and compiler have the same keys: the schema repeats those of the sections, and this test compares them.
#[test]
fn the_sections_have_the_keys_of_the_compiler() {
    let schema = hierarq::schema::schema();
    let robot = "urdf: robots/arm7.urdf, rate: 100 Hz";
    let stacks = "stacks: { s: { levels: [{ name: a, tasks: [joint_velocity_limits] }] } }";
    let with = |inner: &str| format!("hierarq: 1\nrobots: {{ r: {{ {robot}, {inner} }} }}\n{stacks}\n");
    let bare = format!("hierarq: 1\nrobots: {{ r: {{ {robot} }} }}\n");
    let level = |inner: &str| {
        format!("{bare}stacks: {{ s: {{ levels: [{{ name: a, tasks: [joint_velocity_limits]{inner} }}] }} }}\n")
    };
    let r = "/properties/robots/additionalProperties/properties";
    let (none, from): (&[&str], &[&str]) = (&[], &["from"]);
    for (place, yaml, read_before) in [
        (r.to_string(), with("qqqqqq: 1"), from),
        (format!("{r}/arms/additionalProperties/properties"), with("arms: { a: { tip: tool, qqqqqq: 1 } }"), none),
        (format!("{r}/points/additionalProperties/properties"), with("points: { a: { link: tool, qqqqqq: 1 } }"), none),
        (
            format!("{r}/segments/additionalProperties/properties"),
            with("segments: { a: { link: tool, from: '[0, 0, 0] m', to: '[0, 0, 1] m', qqqqqq: 1 } }"),
            none,
        ),
        (format!("{r}/limits/additionalProperties/properties"), with("limits: { joint_1: { qqqqqq: 1 } }"), none),
        ("/properties/run/properties".to_string(), format!("{bare}{stacks}\nrun: {{ qqqqqq: 1 }}\n"), none),
        (
            "/properties/run/properties/simulator/properties".to_string(),
            format!("{bare}{stacks}\nrun: {{ simulator: {{ qqqqqq: 1 }} }}\n"),
            none,
        ),
        (
            "/properties/stacks/additionalProperties/properties".to_string(),
            format!(
                "{bare}stacks: {{ s: {{ qqqqqq: 1, levels: [{{ name: a, tasks: [joint_velocity_limits] }}] }} }}\n"
            ),
            &["levels", "from", "changes"],
        ),
        (
            "/properties/stacks/additionalProperties/properties/levels/items/properties".to_string(),
            level(", qqqqqq: 1"),
            &["hard", "name", "tasks"],
        ),
    ] {
        let mut expected = listed(&yaml);
        expected.extend(read_before.iter().map(|k| (*k).to_string()));
        // The key of every block, which no block declares.
        expected.push("allow".to_string());
        expected.sort();
        let object = schema.pointer(&place).and_then(Value::as_object).unwrap_or_else(|| panic!("{place}"));
        let mut keys: Vec<String> = object.keys().cloned().collect();
        keys.sort();
        assert_eq!(keys, expected, "{place}");
    }
}

#[test]
fn units_ranges_and_what_is_required_are_checked() {
    let validator = validator();
    let task = |kind: &str, params: Value| {
        let mut task = serde_json::Map::new();
        task.insert(kind.to_string(), params);
        json!({ "hierarq": 1, "tasks": { "a": task } })
    };
    let through = json!("[[0, 0, 0], [1, 0, 0], [0, 1, 0]] m");
    let wall = |d_min: Value| task("virtual_wall", json!({ "points": "arms", "through": through, "d_min": d_min }));
    for good in [
        json!("0.3 m"),
        json!("30 cm"),
        json!(0.3),
        json!("gap"),
        json!("2*gap + 3 cm"),
        json!("1 m/s * 2 s"),
        json!("3"),
    ] {
        assert!(validator.is_valid(&wall(good.clone())), "{good}");
    }
    for bad in [json!("0.3 s"), json!("30 deg"), json!("2 /s"), json!("5 mtr"), json!(-1), json!(true), json!(["1 m"])]
    {
        assert!(!validator.is_valid(&wall(bad.clone())), "{bad}");
    }
    let reach = |kind: &str, position: Value| task(kind, json!({ "position": position }));
    assert!(validator.is_valid(&reach("frame_position(tool)", json!("[0, 0, 1] m"))));
    assert!(validator.is_valid(&reach("frame_position(tool)", json!(["10 cm", 0, 1]))));
    assert!(!validator.is_valid(&reach("frame_position(tool)", json!("[0, 0, 1] rad"))));
    assert!(!validator.is_valid(&reach("frame_position(tool)", json!([0, 1]))));
    assert!(!validator.is_valid(&reach("frame_position", json!("[0, 0, 1] m"))), "no frame");
    assert!(!validator.is_valid(&json!({ "tasks": {} })), "no version");
    let gain = |gain: Value| task("hold(left)", json!({ "gain": gain }));
    assert!(validator.is_valid(&gain(json!("5 /s"))));
    assert!(validator.is_valid(&gain(json!("5 rad/s"))), "the language takes it too");
    assert!(validator.is_valid(&gain(json!({ "linear": "5 /s", "angular": 2 }))));
    assert!(!validator.is_valid(&gain(json!({ "linear": "5 /s" }))));
    assert!(!validator.is_valid(&gain(json!("5 m/s"))));
}

/// Plain quantities with every unit, alone and divided by another: valid if and only if the compiler accepts the
/// dimension.
#[test]
fn units_fit_where_the_compiler_says_so() {
    let validator = validator();
    let units: Vec<&str> = compiler::units::symbols().collect();
    let mut written: Vec<String> = units.iter().flat_map(|u| [format!("2 {u}"), format!("2 /{u}")]).collect();
    written.extend(units.iter().flat_map(|a| ["s", "m", "deg"].iter().map(move |b| format!("2 {a}/{b}"))));
    let (mut fit, mut misfit) = (0, 0);
    for value in written {
        for (key, kind) in [("gain", "hold(tool)"), ("d_min", "virtual_wall(tool)")] {
            let through = if key == "gain" { "" } else { ", through: '[[0, 0, 0], [1, 0, 0], [0, 1, 0]] m'" };
            let yaml = format!(
                "hierarq: 1\nrobots: {{ r: {{ urdf: robots/arm7.urdf, rate: 100 Hz }} }}\n\
                 tasks: {{ a: {{ '{kind}': {{ {key}: {value}{through} }} }} }}\n\
                 stacks: {{ s: {{ levels: [{{ name: a, tasks: [a] }}] }} }}\n"
            );
            let wrong = compile(&yaml).report.diagnostics.iter().any(|d| d.code == "HQ0301");
            assert_eq!(validator.is_valid(&data(&yaml)), !wrong, "{key}: {value}");
            *(if wrong { &mut misfit } else { &mut fit }) += 1;
        }
    }
    assert!(fit > 10 && misfit > 100, "{fit} fit, {misfit} do not");
}
