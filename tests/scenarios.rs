//! Scenarios: their measures against an independent recorder, reproducible numbers, and `hierarq test`.

use crate::common;

use std::path::Path;
use std::process::{Command, Output};

use common::program_of as program;
use hierarq::scenario_runner::{self, ScenarioResult};
use runtime::expect::Verdict;
use runtime::program::{Measure, Program, ScenarioProgram};
use runtime::record::summary::Summary;
use runtime::{Recorder, Tick};

const ARM: &str = "hierarq 1
robot arm {
  urdf \"robots/arm7.urdf\"  rate 100 Hz
  points { elbow link_4 }
  home { all [0, 0.4, 0, 1.6, 0, 1.14, 0] rad }
}
task limits = joint_position_limits
task speeds = joint_velocity_limits
task gap = self_collision { between elbow  and base_link  d_min 0.1 m  gain 5 /s }
task reach = frame_position(tool) { position initial(position) + [0, 0.2, -0.1] m  gain 3 /s }
stack work { level limits hard { limits  speeds  gap }  level motion { reach } }
run { duration 3 s }
";

fn result_of(program: &Program) -> ScenarioResult {
    scenario_runner::run("spec.hq", program, &program.scenarios[0]).expect("a compiled program can be executed")
}

/// Records the quantities of the expectations, computed from the configuration alone.
#[derive(Default)]
struct Seen {
    lowest: f64,
    fastest: f64,
    positions: Vec<Vec<f64>>,
}

impl Recorder for Seen {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let model = tick.controller.evaluator().model();
        let mut data = robot::Data::new(model);
        model.forward(tick.q, &mut data);
        let tool = model.link("tool").expect("a link");
        self.lowest = self.lowest.min(data.pose(tool).translation.z);
        if let Some(before) = self.positions.last() {
            self.fastest = self.fastest.max((tick.q[1] - before[1]).abs() / 0.01);
        }
        self.positions.push(tick.q.to_vec());
        Ok(())
    }
}

/// Runs a scenario with all recorders.
fn run(program: &Program, scenario: &ScenarioProgram) -> (Summary, Vec<runtime::expect::Outcome>, Seen) {
    let mut seen = Seen { lowest: f64::INFINITY, ..Seen::default() };
    let (summary, outcomes) = common::judged(program, scenario, &mut seen);
    (summary, outcomes, seen)
}

#[test]
fn measures_are_what_others_see() {
    let text = format!(
        "{ARM}scenario s {{
  seed 3
  start {{ joint_1 10 deg }}
  simulator {{ lag 20 ms  noise 1 mrad }}
  expect always margin(gap) >= 0 m
  expect always error(reach) <= 1 m
  expect always frame(tool).position.z >= 0 m
  expect always speed(joint_2) < 10 rad/s
  expect always from 2 s : error(reach) < 50 mm
  expect eventually joint(joint_1) > 11 deg
}}\n"
    );
    let program = program(&text);
    let (summary, outcomes, seen) = run(&program, &program.scenarios[0]);
    let margins: Vec<f64> = outcomes.iter().map(|o| o.margin().expect("a margin")).collect();
    // The summary has tasks in their stack, measures have each by itself.
    let gap = summary.tasks["gap"].min_margin.expect("a limit");
    let reach = summary.tasks["reach"].max_error.expect("a target");
    assert!((margins[0] - gap).abs() < 1e-12, "{} {gap}", margins[0]);
    assert!((margins[1] - (1.0 - reach)).abs() < 1e-12);
    assert!((margins[2] - seen.lowest).abs() < 1e-12);
    assert!((margins[3] - (10.0 - seen.fastest)).abs() < 1e-9);
    assert_eq!(seen.positions[0][0], 10_f64.to_radians());
    let most = seen.positions.iter().map(|q| q[0]).fold(f64::NEG_INFINITY, f64::max);
    assert!((margins[5] - (most - 11_f64.to_radians())).abs() < 1e-12);
    assert!(outcomes.iter().all(|o| o.verdict == Verdict::Holds), "{outcomes:?}");
}

#[test]
fn a_limit_of_acceleration_is_measured_from_tick_to_tick() {
    let arm = ARM.replace("level motion {", "level smooth { calm }  level motion {");
    let text = format!(
        "{arm}task calm = joint_acceleration_limits {{ max 2 rad/s^2 }}
scenario s {{ simulator {{ lag 20 ms }}  expect always margin(calm) >= -9 rad/s^2 }}\n"
    );
    let program = program(&text);
    let (summary, outcomes, _) = run(&program, &program.scenarios[0]);
    let least = summary.tasks["calm"].min_margin.expect("a limit");
    assert!((outcomes[0].margin().expect("a margin") - (least + 9.0)).abs() < 1e-9, "{outcomes:?} {least}");
    assert!(least < 1.0, "it accelerates, and has {least} left");
}

#[test]
fn the_same_seed_gives_the_same_bits_and_another_one_others() {
    let text = |seed: u32| {
        format!("{ARM}scenario s {{ seed {seed}  simulator {{ noise 1 mrad }}  expect always margin(gap) >= 0 m }}\n")
    };
    let figures = |seed| {
        let program = program(&text(seed));
        let (_, outcomes, seen) = run(&program, &program.scenarios[0]);
        (outcomes[0].lower.to_bits(), seen.positions)
    };
    assert_eq!(figures(7), figures(7));
    assert_ne!(figures(7), figures(8));
}

#[test]
fn a_task_that_runs_nowhere_is_measured_all_the_same() {
    let text = format!(
        "{ARM}task wall = virtual_wall {{ points elbow  through [[0, 0, -1], [1, 0, -1], [0, 1, -1]] m  d_min 0.1 m  gain 5 /s }}
scenario s {{ expect always margin(wall) >= 0 m }}\n"
    );
    let program = program(&text);
    let (summary, outcomes, _) = run(&program, &program.scenarios[0]);
    assert!(!summary.tasks.contains_key("wall"));
    // The elbow stays more than a metre above the plane.
    assert!(outcomes[0].margin().is_some_and(|m| m > 0.9 && m < 2.0), "{outcomes:?}");
}

#[test]
fn a_late_tick_is_a_fault_at_its_time_and_the_robot_goes_on_until_then() {
    let text = format!("{ARM}scenario s {{ late {{ at 1 s  by 50 ms }}  expect always margin(gap) >= 0 m }}\n");
    let program = program(&text);
    let t = result_of(&program);
    assert!(t.halted && !t.ok);
    // Ticks at 1.00 to 1.04 s are omitted.
    assert_eq!((t.faults.len(), t.faults[0].kind.as_str()), (1, "deadline"));
    assert!((t.faults[0].time - 1.05).abs() < 1e-9);
    let (_, _, seen) = run(&program, &program.scenarios[0]);
    let step = |k: usize| (seen.positions[k + 1][0] - seen.positions[k][0]).abs();
    assert!(step(99) > 1e-6);
    // The command of 0.99 s is applied for six periods.
    assert!((100..105).all(|k| (step(k) - step(99)).abs() < 1e-12));
    assert_eq!(step(106), 0.0);
}

#[test]
fn who_speaks_of_faults_decides_on_them() {
    let lost = "lost { joint_3 { from 0.5 s  to 0.52 s } }";
    for (expect, ok) in [
        ("expect eventually fault(not_finite)", true),
        ("expect never fault", false),
        ("expect always margin(gap) >= 0 m", false),
        ("", false),
    ] {
        let t = result_of(&program(&format!("{ARM}scenario s {{ {lost}  {expect} }}\n")));
        assert_eq!((t.ok, t.halted, t.faults[0].time), (ok, true, 0.5), "{expect}");
    }
}

#[test]
fn a_hand_pulls_no_more_than_it_can_and_lets_go() {
    let text = format!(
        "{}signal touch : wrench  timeout 0.1 s
scenario s {{
  push {{ touch {{ from 1 s  to 2 s  link tool  towards [3, 0, 0] m  most 12 N }} }}
  expect always norm(touch.force) <= 12.000001 N
  expect always from 1 s to 1.9 s : norm(touch.force) >= 11.9 N
  expect always from 1 s to 1.9 s : touch.force.x > 9 N
  expect always from 2 s : norm(touch.force) <= 0 N
  expect to 0.9 s : always norm(touch.force) <= 0 N
}}\n",
        ARM
    );
    let t = result_of(&program(&text));
    assert!(t.ok, "{t:#?}");
}

#[test]
fn a_scenario_that_was_damaged_in_its_file_is_refused() {
    let text = format!("{ARM}scenario s {{ expect always margin(gap) >= 0 m }}\n");
    let good = program(&text);
    let json = serde_json::to_string(&good).expect("data");
    assert_eq!(serde_json::from_str::<Program>(&json).expect("data"), good);
    assert_eq!(good.check(), Ok(()));
    let damage: [fn(&mut ScenarioProgram); 7] = [
        |s| s.measures[0] = Measure::Margin(99),
        |s| s.measures[0] = Measure::In(0),
        |s| s.measures.clear(),
        |s| s.start.clear(),
        |s| s.run.duration = f64::NAN,
        |s| s.expectations[0].formula.nodes.clear(),
        |s| s.world.events.push((0, vec![1.0])),
    ];
    for (i, damage) in damage.iter().enumerate() {
        let mut bad = good.clone();
        damage(&mut bad.scenarios[0]);
        assert!(bad.check().is_err(), "damage {i}");
    }
}

fn hierarq(arguments: &[&str]) -> Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    Command::new(env!("CARGO_BIN_EXE_hierarq")).args(arguments).current_dir(root).output().expect("it runs")
}

fn json(out: &Output) -> serde_json::Value {
    serde_json::from_slice(&out.stdout).expect("JSON")
}

#[test]
fn the_examples_do_what_is_expected_of_them() {
    // An example in YAML is the program of the one beside it (`examples::both_syntaxes_are_the_same_program`), and `.ci/run`
    // runs all of them with the release build.
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut specs = scenario_runner::specs(&[root.join("examples")]).expect("a folder");
    let tested = root.join("examples/tested.yaml");
    specs.retain(|path| {
        *path == tested || path.extension().is_none_or(|e| e == "hq") || !path.with_extension("hq").exists()
    });
    let specs: Vec<&str> = specs.iter().map(|path| path.to_str().expect("a path of letters")).collect();
    let out = hierarq(&[&["test", "--json"], &specs[..]].concat());
    let data = json(&out);
    assert_eq!((out.status.code(), &data["ok"]), (Some(0), &serde_json::Value::Bool(true)), "{data:#}");
    let all = data["scenarios"].as_array().expect("scenarios");
    let of = |ending: &str| {
        let name = format!("tested.{ending}");
        let mut mine: Vec<serde_json::Value> =
            all.iter().filter(|t| t["spec"].as_str().is_some_and(|s| s.ends_with(&name))).cloned().collect();
        mine.iter_mut().for_each(|t| t["spec"] = serde_json::Value::Null);
        mine
    };
    assert_eq!(of("hq").len(), 4);
    assert_eq!(of("hq"), of("yaml"));
}

/// Writes a spec into its own folder.
fn spec(name: &str, scenarios: &str) -> String {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    let robot = common::example("robots/arm7.urdf").display().to_string();
    let path = folder.join("spec.hq");
    std::fs::write(&path, format!("{}{scenarios}\n", ARM.replace("robots/arm7.urdf", &robot))).expect("a file");
    path.display().to_string()
}

#[test]
fn what_fails_is_said_with_margin_and_instant() {
    let path = spec(
        "failing",
        "scenario bad { expect \"near\" always error(reach) < 1 mm  expect within 9 s : error(reach) < 1 um  expect never fault }
scenario \"good & <plain>\" { duration 1 s }",
    );
    let xml = Path::new(&path).with_file_name("result.xml").display().to_string();
    let out = hierarq(&["test", &path, "--json", "--junit", &xml]);
    assert_eq!(out.status.code(), Some(1));
    let data = json(&out);
    let near = &data["scenarios"][0]["expectations"][0];
    assert_eq!((near["verdict"].as_str(), near["worst_s"].as_f64()), (Some("fails"), Some(0.0)));
    // sqrt(0.2² + 0.1²) m away at the start, and 1 mm permitted.
    assert!((near["margin"].as_f64().expect("a number") - (0.001 - 0.05_f64.sqrt())).abs() < 1e-9, "{near}");
    // The run ends after 3 s: an expectation at 9 s is undecided.
    assert_eq!(data["scenarios"][0]["expectations"][1]["verdict"], "undecided");
    assert_eq!(data["scenarios"][0]["expectations"][2]["verdict"], "holds");
    assert_eq!(data["scenarios"][1]["ok"], true);
    let xml = std::fs::read_to_string(xml).expect("a file");
    assert!(xml.contains("good &amp; &lt;plain&gt;") && xml.matches("<failure").count() == 2, "{xml}");

    let out = hierarq(&["test", &path, "--scenario", "good & <plain>"]);
    let text = String::from_utf8_lossy(&out.stdout).to_string();
    assert_eq!(out.status.code(), Some(0));
    assert!(text.contains("no expectations; checked") && text.contains("1 scenario, 1 s simulated"), "{text}");

    let out = hierarq(&["test", &path, "--scenario", "godo"]);
    assert_eq!(out.status.code(), Some(2));
    let out = hierarq(&["test", "examples/robots"]);
    assert_eq!(out.status.code(), Some(2));
}

#[test]
fn one_scenario_runs_with_the_usual_report() {
    let path = spec("one", "scenario s { duration 1 s  expect always margin(gap) >= 10 m }");
    let folder = Path::new(&path).with_file_name("out").display().to_string();
    let out = hierarq(&["run", &path, "--scenario", "s", "--out", &folder, "--json"]);
    assert_eq!(out.status.code(), Some(1), "the expectation fails");
    let data = json(&out);
    assert_eq!((&data["ticks"], &data["expectations"][0]["verdict"]), (&100.into(), &"fails".into()));
    assert!(Path::new(&folder).join("report.html").is_file());
    let out = hierarq(&["run", &path, "--scenario", "t", "--out", &folder]);
    assert_eq!(out.status.code(), Some(2));
}

/// Returns the data of a report.
fn report(folder: &Path) -> serde_json::Value {
    let page = std::fs::read_to_string(folder.join("report.html")).expect("a report");
    let from = page.find("id=\"hierarq-data\"").expect("data") + 1;
    let begin = from + page[from..].find('{').expect("an object");
    let end = begin + page[begin..].find("</script>").expect("an end");
    serde_json::from_str(page[begin..end].trim()).expect("JSON")
}

#[test]
fn the_report_has_expectations_and_states() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report_of_states");
    let example = common::example("tested.hq").display().to_string();
    let run = |scenario: &str| {
        let out = folder.display().to_string();
        let summary = json(&hierarq(&["run", &example, "--scenario", scenario, "--out", &out, "--json"]));
        (summary, report(&folder))
    };
    let (summary, page) = run("taken by the hand");
    assert_eq!(page["verdict"]["ok"], true);
    assert!(
        page["verdict"]["text"].as_str().is_some_and(
            |t| t.starts_with("All 2 expectations hold. `reach` never") && t.contains("No limit was passed")
        )
    );
    let (told, known) = (page["states"].as_array().expect("states"), summary["states"].as_array().expect("states"));
    assert!(told.len() == known.len() && told.len() > 3);
    for (a, b) in told.iter().zip(known) {
        assert_eq!((&a["state"], &a["from"], &a["to"]), (&b["state"], &b["from_s"], &b["to_s"]));
    }
    let (told, known) =
        (page["expectations"].as_array().expect("some"), summary["expectations"].as_array().expect("some"));
    assert_eq!(told.len(), known.len());
    for (a, b) in told.iter().zip(known) {
        assert_eq!((&a["text"], &a["verdict"], &a["margin"]), (&b["text"], &b["verdict"], &b["margin"]));
        assert_eq!((&a["unit"], &a["at"]), (b.get("unit").unwrap_or(&serde_json::Value::Null), &b["worst_s"]));
    }
    assert!(page["plots"].as_array().is_some_and(|p| p.iter().all(|p| p["group"] != "Machine")));
    // An expected fault is no failure.
    let (summary, page) = run("the camera goes dark");
    assert_eq!((&page["verdict"]["ok"], summary["faults"].as_array().map(Vec::len)), (&true.into(), Some(1)));

    let path = spec("report_of_failure", "scenario s { duration 1 s  expect always margin(gap) >= 10 m }");
    hierarq(&["run", &path, "--scenario", "s", "--out", &folder.display().to_string()]);
    let page = report(&folder);
    assert_eq!((&page["verdict"]["ok"], &page["states"]), (&false.into(), &serde_json::json!([])));
    assert!(page["verdict"]["text"].as_str().is_some_and(|t| t.starts_with("Expectations that fail: 1 of 1. ")));
}

#[test]
fn the_log_has_signals_variables_and_faults() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("log_of_signals");
    let example = common::example("harvesting.hq").display().to_string();
    let out = folder.display().to_string();
    hierarq(&["run", &example, "--scenario", "the gripper slips", "--out", &out]);
    let log = std::fs::read_to_string(folder.join("log.csv")).expect("a log");
    let mut rows = log.lines().map(|l| l.split(',').collect::<Vec<_>>());
    let header = rows.next().expect("a header");
    let place = |name: &str| header.iter().position(|h| *h == name).unwrap_or_else(|| panic!("{name}"));
    let (state, stem, force) = (place("state"), place("signal.stem.x"), place("signal.right_ft.force.z"));
    let (closed, fault) = (place("signal.closed"), place("fault"));
    let mut counts = Vec::new();
    for row in rows {
        assert_eq!(row.len(), header.len());
        // The camera finds the stem 1.5 s after the request; there is no touch and no fault.
        let seen: f64 = row[0].parse().expect("a time");
        assert_eq!(row[stem], if seen < 1.5 { "" } else { "0.6" }, "at {seen} s");
        assert_eq!((row[force], row[fault]), ("", ""));
        if row[state] == "autonomous.close" && counts.last() != Some(&row[closed].to_string()) {
            counts.push(row[closed].to_string());
        }
    }
    assert_eq!(counts, ["1", "2"], "counted on entering, at that very tick");
    let titles: Vec<String> = report(&folder)["plots"]
        .as_array()
        .expect("plots")
        .iter()
        .filter(|p| p["group"] == "Signals")
        .filter_map(|p| p["title"].as_str().map(str::to_string))
        .collect();
    assert_eq!(titles, ["stem", "right_ft", "right_ft", "closed"]);

    let example = common::example("tested.hq").display().to_string();
    hierarq(&["run", &example, "--scenario", "the camera goes dark", "--out", &out]);
    let log = std::fs::read_to_string(folder.join("log.csv")).expect("a log");
    let faults: Vec<&str> =
        log.lines().skip(1).filter_map(|l| l.rsplit(',').next()).filter(|f| !f.is_empty()).collect();
    assert_eq!(faults.first(), Some(&"stale"));
}

/// A fault whose transition leads to its own state is not answered, whether or not the machine leaves that state later.
#[test]
fn a_fault_that_leads_into_its_own_state_is_not_as_expected() {
    let lost = "scenario s { lost { joint_3 { from 0.5 s  to 0.52 s } }  expect always margin(gap) >= 0 m }";
    let states = |around: &str, ways: &str| {
        format!("machine m {{ initial a  {around}  state a {{ stack work  {ways} }}  final state b }}\n{lost}\n")
    };
    for (around, ways, ok, halted) in [
        ("on fault(any) -> b", "after 5 s -> b", true, false),
        ("", "on fault(any) -> a  after 5 s -> b", false, true),
        ("", "on fault(any) -> a  after 0.8 s -> b", false, false),
    ] {
        let t = result_of(&program(&format!("{ARM}{}", states(around, ways))));
        assert_eq!((t.ok, t.halted, t.faults[0].answered), (ok, halted, ok), "{around} {ways}");
    }
}

fn judged(program: &Program) -> scenario_runner::Judged {
    scenario_runner::judged(program, &program.scenarios[0], &mut |_| true).expect("a compiled program can be executed")
}

/// Least distance of the tool from its target, from the configuration alone.
struct Nearest {
    goal: nalgebra::Vector3<f64>,
    least: f64,
}

impl Recorder for Nearest {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        let model = tick.controller.evaluator().model();
        let mut data = robot::Data::new(model);
        model.forward(tick.q, &mut data);
        let at = data.pose(model.link("tool").expect("a link")).translation.vector;
        if tick.index == 0 {
            self.goal += at;
        }
        self.least = self.least.min((at - self.goal).norm());
        Ok(())
    }
}

#[test]
fn a_target_that_is_never_reached_is_named() {
    for (max, named) in [("0.02 rad/s", true), ("1 rad/s", false)] {
        let text = ARM.replace("joint_velocity_limits", &format!("joint_velocity_limits {{ max {max} }}"));
        let program = program(&format!("{text}scenario s {{ expect always margin(gap) >= 0 m }}\n"));
        let mut nearest = Nearest { goal: nalgebra::Vector3::new(0.0, 0.2, -0.1), least: f64::INFINITY };
        common::record(&program, &program.scenarios[0], &mut nearest);
        let remarks = judged(&program).summary.remarks;
        let distance = runtime::quantity::quantity(nearest.least, "m");
        let wanted = format!("`reach` never came closer than {distance} to its target");
        assert_eq!(remarks, if named { vec![wanted] } else { Vec::new() }, "{max}");
    }
}

#[test]
fn a_machine_that_flips_and_one_that_handles_many_faults_are_named() {
    let flips = "machine m { initial a  stack work  on fault(any) -> c
      state a { after 10 ms -> b }  state b { after 10 ms -> a }  final state c }";
    let slower = flips.replace("10 ms", "100 ms");
    let faults = "task slow = joint_velocity_limits { max 0.02 rad/s }
      task rising = keep(frame(tool).position.z) { min 2 m/s * t  gain 10 /s }
      stack rise { level limits hard { limits  slow  rising } }
      stack rest { level limits hard { limits  slow } }
      machine m { initial b  blend 0 s  on fault(any) -> b  state a { stack rise  after 9 s -> b }
        state b { stack rest  after 20 ms -> a } }";
    let remarks = |machine: &str| {
        let judged =
            judged(&program(&format!("{ARM}{machine}\nscenario s {{ duration 8 s  expect never fault(deadline) }}\n")));
        (judged.summary.remarks, judged.summary.faults.len(), judged.summary.entries)
    };
    let (said, _, entries) = remarks(flips);
    assert_eq!(said.len(), 1, "{said:?}");
    // The first entry is the start; every other one is a change.
    let changes = entries["a"] + entries["b"] - 1;
    assert_eq!(said[0], format!("The machine changed its state {changes} times in {changes} ticks, from 0.01 s"));
    assert_eq!(remarks(&slower).0, Vec::<String>::new());
    let (said, number, _) = remarks(faults);
    assert!(number >= 10 && said.len() == 1, "{number} {said:?}");
    assert!(said[0].starts_with(&format!("The machine handled {number} faults, the first at ")), "{said:?}");
}

#[test]
fn an_expectation_whose_condition_is_never_true_is_not_put_to_the_test() {
    for (expect, untested) in [
        ("always (speed(joint_1) > 50 rad/s implies margin(gap) >= 9 m)", true),
        ("always (speed(joint_1) < 50 rad/s implies margin(gap) >= 0 m)", false),
        ("always margin(gap) >= 0 m", false),
        ("after fault(stale) : within 1 s : margin(gap) >= 9 m", true),
    ] {
        let t = result_of(&program(&format!("{ARM}scenario s {{ expect {expect} }}\n")));
        let e = &t.expectations[0];
        assert_eq!((t.ok, e.verdict, e.untested), (true, Verdict::Holds, untested), "{expect}");
    }
}
