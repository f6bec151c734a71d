//! Files of missions whose workers run controllers: compilation, serialization, and references.

use compiler::Input;
use dsl::Syntax;
use runtime::program::{CompiledFile, Job, MissionProgram, MissionScenarioProgram, Running};

use super::common::example;
use super::{OWN, PICKER, SHUTTLE, compiled_in, folder, team};

/// A modification of a file.
type Damage = fn(&mut Running, &mut MissionScenarioProgram);

fn set(running: &mut Running, go: usize, done: usize) {
    running.workers[0].job = Job::Operations { go, done };
}

#[test]
fn a_compiled_file_keeps_controllers_and_refuses_damage() {
    let text = format!("{}scenario s {{ mission day  duration 300 s  expect eventually in(w1.cut) }}\n", team(PICKER));
    let missions = compiled_in(&example(""), &text).missions;
    let json = CompiledFile::to_json("day", None, &missions).expect("a text");
    assert_eq!(CompiledFile::read(&json).expect("a file").missions, missions);
    let damaged: [(&str, Damage); 9] = [
        ("workers[0]", |s, _| s.workers[0].member = 0),
        ("workers[0]", |s, _| s.workers[0].controller = 1),
        ("workers[0].go", |s, _| set(s, 99, 1)),
        ("workers[0].done", |s, _| set(s, 0, 99)),
        ("workers[0].done", |s, _| set(s, 0, 0)),
        ("workers[0].world", |s, _| s.workers[0].world.start.clear()),
        ("controllers[0]", |s, _| s.controllers[0].program.machine = None),
        ("scenarios[0]", |_, s| s.duration = 9e5),
        ("scenarios[0]", |s, _| *s = Running::default()),
    ];
    for (place, change) in damaged {
        let mut other = missions.clone();
        let MissionProgram { running, scenarios, .. } = &mut other[0];
        change(running, &mut scenarios[0]);
        let found = other[0].check().expect_err("refused").place;
        assert!(found.contains(place), "{found}, not {place}");
    }
    let roles: Vec<&str> = missions[0].kind.members().iter().map(|member| member.role).collect();
    assert_eq!(roles, ["robot", "robot", "human", "worker"]);
}

/// The number of compiled specs is limited, for any number of named ones.
#[test]
fn specs_that_are_run_are_bounded() {
    let folder = folder("many", "no spec at all");
    let one = |i: usize| OWN.replace("w1", &format!("w{i}")).replace("own.hq", &format!("own_{i}.hq"));
    for i in 0..40 {
        std::fs::copy(folder.join("own.hq"), folder.join(format!("own_{i}.hq"))).expect("a file");
    }
    let workers: String = (0..40).map(one).collect();
    let report = compiled_in(&folder, &team(&workers)).report;
    assert_eq!(report.diagnostics.iter().filter(|d| d.code == "HQ0933").count(), 1, "{}", report.to_json());
    assert_eq!(report.sources.iter().filter(|(_, s)| s.name.starts_with("own_")).count(), 16);
}

/// The dependencies that `watch` and the editor use.
#[test]
fn a_spec_rests_on_those_that_its_workers_run() {
    let text = team(PICKER);
    let folder = example("");
    let input =
        Input { name: "day.hq", text: &text, syntax: Syntax::Native, folder: &folder, set: &[], package_paths: &[] };
    let files = compiler::files(&input);
    assert!(["picker.hq", "robots/arm7.urdf"].iter().all(|f| files.contains(&folder.join(f))), "{files:?}");
    let path = folder.join("picker.hq").canonicalize().expect("a file");
    let other = "hierarq 1\nsignal box_in_place : flag\n".to_string();
    let compiled = compiler::compile_among(&input, &[(path, other)].into_iter().collect());
    assert!(compiled.report.errors() > 0);
}

/// A spec with a mission whose worker runs this spec again: each only uses the other's controller.
#[test]
fn specs_that_run_each_other_end() {
    let folder =
        folder("circle", &format!("{SHUTTLE}{}", team(&OWN.replace("own.hq", "day.hq")).replace("hierarq 1", "")));
    let day = std::fs::read_to_string(folder.join("own.hq")).expect("a text").replace("day.hq", "own.hq");
    std::fs::write(folder.join("day.hq"), &day).expect("a file");
    let compiled = compiled_in(&folder, &day);
    assert!(compiled.report.errors() == 0, "{}", compiled.report.to_json());
    assert_eq!(compiled.missions.len(), 1);
}

/// The command line reports the controllers that run, and all outputs contain their results.
#[test]
fn the_command_line_says_what_workers_ran() {
    let folder = folder("command_line", SHUTTLE);
    let text = format!(
        "{}scenario s {{ mission day  duration 200 s }}\nscenario t {{ mission day  duration 200 s  happens [{{ at 9 s  lost m1 }}] }}\n",
        team(OWN)
    );
    std::fs::write(folder.join("day.hq"), text).expect("a file");
    let hierarq = |args: &[&str]| {
        let command =
            std::process::Command::new(env!("CARGO_BIN_EXE_hierarq")).args(args).current_dir(&folder).output();
        let output = command.expect("the command line");
        (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let (code, out) = hierarq(&["plan", "day.hq"]);
    assert!(
        code == Some(0) && out.contains("w1 runs own.hq at 50 Hz in scenarios: go is `go`, done is `idle`"),
        "{out}"
    );
    let (code, out) = hierarq(&["run", "day.hq", "--scenario", "s"]);
    assert!(code == Some(0) && out.contains("w1 ran own.hq; its operations took: "), "{out}");
    let read = |name: &str| std::fs::read_to_string(folder.join("out/day").join(name)).expect("a file");
    let summary: serde_json::Value = serde_json::from_str(&read("summary.json")).expect("JSON");
    assert_eq!(summary["workers"][0]["operations_s"].as_array().map(Vec::len), Some(3), "{summary}");
    assert!(read("report.html").contains("<h2>Controllers of workers</h2>"));
    assert!(read("log.csv").lines().next().is_some_and(|header| header.ends_with(",w1.state")));
    let (code, out) = hierarq(&["test", "day.hq", "--json"]);
    let data: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    let names = data["scenarios"].as_array().expect("a list").iter().map(|s| &s["mission"]["workers"][0]["name"]);
    assert!(code == Some(0) && names.clone().count() == 2 && names.into_iter().all(|name| name == "w1"), "{data}");
    let (code, out) = hierarq(&["run", "day.hq", "--scenario", "s", "--duration", "900000"]);
    assert!(code != Some(0), "{out}");
}

/// Paths are relative to the file that names them, also for an imported mission.
#[test]
fn a_mission_that_is_imported_brings_its_controllers() {
    let below = folder("imported/below", SHUTTLE);
    std::fs::write(below.join("day.hq"), team(OWN)).expect("a file");
    let above = below.parent().expect("a folder");
    let text = "hierarq 1\nimport \"below/day.hq\" { day }\n";
    let compiled = compiled_in(above, text);
    assert_eq!(compiled.report.errors(), 0, "{}", compiled.report.to_json());
    let running = &compiled.missions[0].running;
    assert_eq!(running.controllers[0].spec, "below/own.hq");
    // Mistakes in that file are shown there.
    let broken = std::fs::read_to_string(below.join("own.hq")).expect("a text").replace("-> away", "-> awy");
    std::fs::write(below.join("own.hq"), broken).expect("a file");
    let report = compiled_in(above, text).report;
    let names: Vec<&str> = report
        .diagnostics
        .iter()
        .filter(|d| d.code == "HQ0201")
        .filter_map(|d| Some(report.sources.get(d.primary.span.source)?.name.as_str()))
        .collect();
    assert_eq!(names, ["below/own.hq"], "{}", report.to_json());
}
