//! Scenarios of missions of layers: expectations agree with the log, and rejected events are reported.

use crate::common::played;

use std::path::Path;

use mission::chart::{Bar, Chart};
use mission::kinds::layers::Layers;
use mission::kinds::layers::chart::chart;
use mission::kinds::layers::choose::plan;
use mission::kinds::layers::execution::Outcome;
use played::{cells, compiled, numbers, table};
use proptest::prelude::*;
use runtime::expect::Verdict;
use runtime::missions::{End, MissionRun, MissionSummary};
use runtime::program::{CompiledFile, MissionProgram, MissionScenarioProgram};

/// Two arms, and a person who is the only one with the skill `look`, six blocks, three layers: planned quickly.
const TEAM: &str = "hierarq 1
mission wall : layers {
  robot left { place [-0.4, -0.5, 0] m  speed [0.1, 0.3] m/s  skills { pick 2 s }  energy { standby 4  drag 100 }  spread 0.1 }
  robot right { place [0.4, -0.5, 0.2] m  speed [0.1, 0.3] m/s  skills { pick 2 s }  energy { standby 4  drag 100 }  spread 0.1 }
  human anna { place [0, 0.5, 0] m  speed 0.3 m/s  skills { pick 2 s  look 3 s }  slowing 2 /kg  spread 0.3 }
  for i in 1..6 { object block_${i} { place [-0.5 + 0.15*i, 0.05*i, 0.02] m  mass i * 50 g  features [block] } }
  layer one {
    task a = pick { features [block]  to [-0.2, 0, 0] m }
    task b = pick { features [block]  to [0.2, 0, 0] m }
  }
  layer two {
    task c = pick { features [block]  via [[0, 0, 0.3]] m  to [0, 0, 0.1] m }
    task d = pick { features [block]  to [0.1, 0, 0.1] m }
  }
  layer three { task check = look { to [0, 0.2, 0.2] m } }
}
";

/// Returns a scenario with this body, and its mission.
fn scenario(body: &str) -> (MissionProgram, MissionScenarioProgram) {
    played::scenario(&format!("{TEAM}scenario s {{ mission wall  duration 150 s  {body} }}\n"))
}

/// Runs a scenario; returns the run with its log.
fn logged(body: &str) -> (MissionRun, Vec<String>, Vec<Vec<String>>) {
    let (mission, scenario) = scenario(body);
    let (run, bytes) = played::logged(&mission, &scenario);
    let (header, rows) = table(bytes);
    (run, header, rows)
}

fn summary(body: &str) -> MissionSummary {
    logged(body).0.summary
}

/// Without disturbances the execution equals the plan, and the log equals the execution.
#[test]
fn without_disturbances_the_plan_is_what_is_done() {
    let body = "operations planned  step 100 ms  expect eventually done";
    let (run, header, rows) = logged(body);
    assert!(run.summary.ok, "{:?}", run.summary.expectations);
    let End::Done { at_s } = run.summary.end else { panic!("{:?}", run.summary.end) };
    let (planned, executed) = (run.planned.expect("a plan"), run.executed.expect("what was done"));
    let same = |a: &Bar, b: &Bar| (a.work, a.speed) == (b.work, b.speed) && (a.start - b.start).abs() < 1e-6;
    let all = |chart: &Chart| chart.bars().count();
    assert!(all(&planned) == 5 && all(&executed) == 5);
    assert!(planned.bars().zip(executed.bars()).all(|(a, b)| same(a, b)));
    assert!(planned.rows.iter().zip(&executed.rows).all(|(a, b)| a.bars.len() == b.bars.len()));
    assert!(planned.bars().all(|bar| !bar.begun) && executed.bars().all(|bar| bar.begun));
    assert!((at_s - planned.end().expect("an end")).abs() < 1e-6);
    let (mission, scenario) = scenario(body);
    let layers = mission.kind.downcast::<Layers>().expect("layers");
    let problem = &layers.problem;
    let plan = plan(problem, &layers.settings(&scenario.run(&mission)).planning).expect("a plan");
    assert_eq!(planned, chart(problem, &plan));
    for activity in &plan.activities {
        let who = &problem.agents[activity.agent].name;
        let tasks = cells(&header, &rows, &format!("{who}.task"));
        let objects = cells(&header, &rows, &format!("{who}.object"));
        let object = activity.object.map_or("", |object| &problem.objects[object].name);
        for (k, (task, with)) in tasks.iter().zip(objects).enumerate() {
            let time = 0.1 * k as f64;
            if time > activity.start + 1e-6 && time < activity.end - 1e-6 {
                assert_eq!((*task, with), (problem.tasks[activity.task].name.as_str(), object), "{who} at {time} s");
            }
        }
    }
}

/// Margins of expectations equal those computed from the log.
#[test]
fn what_is_judged_is_what_is_logged() {
    let body = "seed 2  step 500 ms  happens [{ at 4 s  late anna  by 7 s }, { at 9 s  failed left }]
        expect always distance(left, anna) > 0.01 m
        expect always norm(right.position - left.position) > 0 m
        expect always anna.tasks + left.tasks + right.tasks < 6
        expect always anna.position.y > -1 m
        expect always wall.dropped < 3
        expect eventually done";
    let (run, header, rows) = logged(body);
    assert_eq!(rows.len(), 301);
    let of = |name: &str| numbers(&header, &rows, name);
    let apart = |a: &str, b: &str| -> f64 {
        let all = ["x", "y", "z"].map(|axis| (of(&format!("{a}.{axis}")), of(&format!("{b}.{axis}"))));
        let at = |i: usize| all.iter().map(|(a, b)| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt();
        (0..rows.len()).map(at).fold(f64::INFINITY, f64::min)
    };
    let least = |all: Vec<f64>| all.into_iter().fold(f64::INFINITY, f64::min);
    let outcome: Outcome = serde_json::from_value(run.summary.outcome.expect("an outcome")).expect("of layers");
    let dropped = outcome.dropped as f64;
    let expected =
        [apart("left", "anna") - 0.01, apart("right", "left"), 6.0 - 5.0, least(of("anna.y")) + 1.0, 3.0 - dropped];
    for (record, expected) in run.summary.expectations.iter().zip(expected) {
        let margin = record.margin.expect("a margin");
        assert!((margin - expected).abs() < 1e-9, "{}: {margin}, and {expected} in the log", record.text);
    }
    assert_eq!((outcome.tasks, outcome.layers), (5, 3));
}

#[test]
fn the_same_seed_gives_the_same_records() {
    let of = |body: &str| serde_json::to_string(&summary(body)).expect("data");
    assert_eq!(of("seed 5"), of("seed 5"));
    assert_ne!(of("seed 5"), of("seed 6"));
    assert_ne!(of("seed 5"), of("seed 5  operations planned"));
}

/// Counts and Boolean quantities have the documented meaning.
#[test]
fn what_is_measured() {
    let body = "operations planned
        expect always (wall.layer >= 0 and wall.layer <= 3)
        expect eventually wall.layer > 2
        expect eventually (wall.tasks > 4 and done and not wall.stranded)
        expect always (anna.tasks < 1 implies anna.workload <= 0 kg s)
        expect always (wall.energy - left.energy - right.energy <= 1e-9 J)
        expect always (anna.working implies anna.worked >= 0 s)
        expect eventually anna.tasks > 0
        expect always (wall.reschedules < 1 and wall.reallocations < 1 and wall.cost > 0)
        expect always wall.workload - anna.workload <= 0 kg s
        expect always (not anna.lost and left.travelled >= 0 m)";
    let summary = summary(body);
    assert!(summary.ok, "{:#?}", summary.expectations);
}

/// Only one person can look: without her there is no complete plan, and the others continue as far as possible.
#[test]
fn a_mission_without_its_person_is_a_verdict_with_its_reason() {
    let lost = "operations planned  happens [{ at 1 s  lost anna }]";
    let bare = summary(lost);
    assert!(!bare.ok && matches!(bare.end, End::Stranded { .. }), "{:?}", bare.end);
    assert!(bare.trouble()[0].1.contains("no plan"), "{:?}", bare.trouble());
    let spoken = summary(&format!("{lost}  expect eventually wall.stranded  expect never done"));
    assert!(spoken.ok, "{:?}", spoken.expectations);
    let back = "operations planned  happens [{ at 1 s  lost anna }, { at 40 s  back anna }]
        expect eventually done  expect after wall.stranded : within 40 s : (not wall.stranded)";
    let good = summary(back);
    assert!(good.ok, "{:?} {:?}", good.end, good.expectations);
}

#[test]
fn what_cannot_happen_fails_the_scenario() {
    let early = summary("happens [{ at 2 s  back anna }, { at 140 s  done anna }]  expect eventually done");
    assert!(!early.ok && early.expectations.iter().all(|e| e.verdict == Verdict::Holds));
    let why: Vec<&str> = early.rejected_events.iter().map(|u| u.why.as_str()).collect();
    assert_eq!(why, ["anna is not lost", "anna is not at work"]);
}

#[test]
fn a_compiled_file_keeps_its_scenarios_and_refuses_damage() {
    let text = format!(
        "{TEAM}scenario s {{ mission wall  duration 90 s  happens [{{ at 9 s  lost left }}]
           expect always left.energy < 99 J }}\n"
    );
    let missions = compiled(&text).missions;
    let json = CompiledFile::to_json("wall", None, &missions).expect("a text");
    assert_eq!(CompiledFile::read(&json).expect("a file").missions, missions);
    for (from, to) in [
        ("\"duration\": 90.0", "\"duration\": -1.0"),
        ("\"reallocate_above\": 0.1", "\"reallocate_above\": -1.0"),
        ("\"spread\": 0.3", "\"spread\": -0.3"),
        ("\"bases\": false", "\"bases\": true"),
    ] {
        assert!(json.contains(from), "{from}\n{json}");
        assert!(CompiledFile::read(&json.replace(from, to)).is_err(), "{to}");
    }
    use runtime::program::MissionMeasure;
    let value = |name: &str, member, axis| MissionMeasure::Value { name: name.into(), member, axis };
    for measure in [
        value("position", Some(7), 0),
        value("position", Some(1), 3),
        value("energy", Some(2), 0),
        value("energy", Some(1), 1),
        value("served", Some(0), 0),
        value("waited", None, 0),
    ] {
        let mut other = missions.clone();
        other[0].scenarios[0].measures[0] = measure.clone();
        assert!(other[0].check().is_err(), "{measure:?}");
    }
}

/// The text of a random event.
fn event() -> impl Strategy<Value = String> {
    let who = prop::sample::select(vec!["left", "right", "anna"]);
    let at = 0..60_u32;
    prop_oneof![
        (at.clone(), who.clone(), -20..40_i32).prop_map(|(t, a, by)| format!("{{ at {t} s  late {a}  by {by} s }}")),
        (at.clone(), who.clone()).prop_map(|(t, a)| format!("{{ at {t} s  lost {a} }}")),
        (at.clone(), who.clone()).prop_map(|(t, a)| format!("{{ at {t} s  back {a} }}")),
        (at.clone(), who.clone()).prop_map(|(t, a)| format!("{{ at {t} s  failed {a} }}")),
        (at, who).prop_map(|(t, a)| format!("{{ at {t} s  done {a} }}")),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, ..ProptestConfig::default() })]
    /// For any events, a run ends with a verdict; each of its events is a record or has a reason for its rejection.
    #[test]
    fn random_days_end_with_a_verdict(events in prop::collection::vec(event(), 1..7), seed in 0..100_u64) {
        let body = format!("seed {seed}  step 5 s  happens [{}]  expect always wall.makespan >= 0 s", events.join(", "));
        let MissionRun { summary, executed, .. } = logged(&body).0;
        // Activities drawn as done have been done: all of them at the end, and never future ones.
        let done = matches!(summary.end, End::Done { .. });
        for activity in executed.iter().flat_map(Chart::bars) {
            prop_assert!(activity.begun || !done);
            prop_assert!(!activity.begun || activity.start <= summary.duration_s);
        }
        let told = played::events(&summary.log, &["left", "right", "anna"]);
        prop_assert_eq!(told + summary.rejected_events.len(), events.len());
        prop_assert!(summary.expectations.iter().all(|e| e.verdict == Verdict::Holds));
        let is_whole = !matches!(summary.end, End::Refused { .. } | End::Interrupted);
        prop_assert!(is_whole);
    }
}

#[test]
fn the_command_line_runs_and_tests_layers() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("layers_scenarios");
    std::fs::create_dir_all(&folder).expect("a folder");
    let text = format!(
        "{TEAM}scenario good {{ mission wall  duration 90 s  expect eventually done }}
         scenario bad {{ mission wall  duration 90 s  happens [{{ at 2 s  lost anna }}] }}\n"
    );
    std::fs::write(folder.join("wall.hq"), text).expect("a file");
    let hierarq = |args: &[&str]| {
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_hierarq"))
            .args(args)
            .current_dir(&folder)
            .output()
            .expect("the command line");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    let (code, out, err) = hierarq(&["run", "wall.hq", "--scenario", "good", "--seed", "4"]);
    assert_eq!(code, Some(0), "{out}{err}");
    assert!(out.contains("done after") && out.contains("kg s") && out.contains("check"), "{out}");
    let read = |name: &str| std::fs::read_to_string(folder.join("out/wall").join(name)).expect("a file");
    let summary: serde_json::Value = serde_json::from_str(&read("summary.json")).expect("JSON");
    assert_eq!((&summary["ok"], &summary["seed"], &summary["outcome"]["tasks"]), (&true.into(), &4.into(), &5.into()));
    assert_eq!(read("log.csv").lines().count(), 92);
    let report = read("report.html");
    assert_eq!(report.matches("<svg").count(), 3);
    assert!(report.find("Planned") < report.find("Executed") && report.contains("layer three is done"), "a page");

    let (code, out, _) = hierarq(&["test", "wall.hq", "--json"]);
    let data: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!((code, &data["ok"]), (Some(1), &false.into()));
    let [good, bad] = [&data["scenarios"][0], &data["scenarios"][1]];
    assert_eq!(good["mission"]["outcome"]["layers"], 3);
    assert_eq!((&bad["ok"], &bad["mission"]["end"]["how"]), (&false.into(), &"stranded".into()));
}
