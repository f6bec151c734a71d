//! Scenarios of missions: expectations agree with the log, and rejected events are reported.

use crate::common::played;

use mission::chart::Chart;
use mission::kinds::schedule::execution::Outcome;
use played::{compiled, numbers, table};
use proptest::prelude::*;
use runtime::expect::Verdict;
use runtime::missions::{End, MissionRun, MissionSummary};
use runtime::program::{CompiledFile, MissionProgram, MissionScenarioProgram};
use std::path::Path;

/// Two robots with one speed, two people and a working robot: planned quickly.
const TEAM: &str = "hierarq 1
mission day : schedule {
  reallocate_above 0.05
  robot m1 { depot [0, 0] m  speed 0.2 m/s  proximity_speed 0.2 m/s  serve 20 s  deposit 10 s }
  robot m2 { depot [0, 6] m  speed 0.2 m/s  proximity_speed 0.2 m/s  serve 20 s  deposit 10 s }
  human h1 { place [12, 1] m  operations 2  duration normal(120 s, 12 s)  severity 0.5 }
  human h2 { place [14, 5] m  operations 1  duration normal(150 s, 15 s) }
  worker w1 { place [10, 3] m  duration 100 s }
}
";

/// Returns a scenario with this body, and its mission.
fn scenario(body: &str) -> (MissionProgram, MissionScenarioProgram) {
    played::scenario(&format!("{TEAM}scenario s {{ mission day  duration 1500 s  {body} }}\n"))
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

fn outcome(summary: &MissionSummary) -> Outcome {
    serde_json::from_value(summary.outcome.clone().expect("an outcome")).expect("of a schedule")
}

fn end(plan: Option<&Chart>) -> f64 {
    plan.and_then(Chart::end).expect("a plan")
}

#[test]
fn without_disturbances_the_plan_is_what_is_done() {
    let (run, ..) = logged("operations planned  expect eventually done  expect always day.reschedules < 1");
    let summary = &run.summary;
    assert!(summary.ok, "{:?}", summary.expectations);
    let End::Done { at_s } = summary.end else { panic!("{:?}", summary.end) };
    let outcome = outcome(summary);
    assert!((outcome.makespan - end(run.planned.as_ref())).abs() < 1e-6);
    assert!((at_s - outcome.makespan).abs() < 1e-6);
    assert_eq!(outcome.agents.iter().map(|a| a.served).collect::<Vec<_>>(), [2, 1, 1]);
}

#[test]
fn the_same_seed_gives_the_same_records() {
    let of = |seed: u64| serde_json::to_string(&summary(&format!("seed {seed}  travel bases"))).expect("data");
    assert_eq!(of(5), of(5));
    assert_ne!(of(5), of(6));
}

/// Margins of expectations equal those computed from the log.
#[test]
fn what_is_judged_is_what_is_logged() {
    let body = "seed 2  travel bases  step 500 ms  happens [{ at 130 s  late h2  by 40 s }]
        expect always distance(m1, m2) > 0.5 m
        expect always norm(m1.position - h1.position) > 0 m
        expect always h1.waited < 1000 s
        expect always m2.speed <= 0.5 m/s
        expect always h1.served + h2.served < 4
        expect eventually done";
    let (run, header, rows) = logged(body);
    assert_eq!(rows.len(), 3001);
    let of = |name: &str| numbers(&header, &rows, name);
    let apart = |a: &str, b: &str| -> f64 {
        let [ax, ay, bx, by] = [format!("{a}.x"), format!("{a}.y"), format!("{b}.x"), format!("{b}.y")].map(|n| of(&n));
        (0..ax.len()).map(|i| f64::hypot(ax[i] - bx[i], ay[i] - by[i])).fold(f64::INFINITY, f64::min)
    };
    let most = |all: Vec<f64>| all.into_iter().fold(f64::NEG_INFINITY, f64::max);
    let served: Vec<f64> = of("h1.served").iter().zip(of("h2.served")).map(|(a, b)| a + b).collect();
    let expected = [
        apart("m1", "m2") - 0.5,
        apart("m1", "h1"),
        1000.0 - most(of("h1.waited")),
        0.5 - most(of("m2.speed")),
        4.0 - most(served),
    ];
    for (record, expected) in run.summary.expectations.iter().zip(expected) {
        let margin = record.margin.expect("a margin");
        assert!((margin - expected).abs() < 1e-9, "{}: {margin}, and {expected} in the log", record.text);
    }
    // Waits never decrease, and end with the values of the outcome.
    let waited = of("h1.waited");
    assert!(waited.windows(2).all(|w| w[0] <= w[1] + 1e-9));
    let outcome = outcome(&run.summary);
    let total: f64 = outcome.agents[0].waits.iter().sum();
    assert!((waited.last().expect("a row") - total).abs() < 1e-6);
}

#[test]
fn people_answer_once_for_each_service() {
    let said = |body: &str| {
        let summary = summary(body);
        assert!(summary.rejected_events.is_empty(), "{:?}", summary.rejected_events);
        summary.log.iter().filter(|h| h.what.starts_with("h1 says")).map(|h| h.what.clone()).collect::<Vec<_>>()
    };
    assert_eq!(said("feedback { h1 { wait too_long } }").len(), 2);
    assert_eq!(
        said("feedback { h1 [{ wait too_long  distance close }, {}] }"),
        ["h1 says: the wait was too long, it waited close"]
    );
    assert_eq!(said("feedback { h1 [{}, { approach very_fast }] }"), ["h1 says: the robot came very fast"]);
    let after = |text: &str| {
        let h = summary("feedback { h1 [{ wait ok }, {}] }").log;
        h.into_iter().find(|h| h.what.contains(text)).map(|h| h.at_s)
    };
    assert_eq!(after("has served operation 1 of h1"), after("h1 says: all was right"));
}

/// `<` and `>` are strict for integers.
#[test]
fn counts_are_compared_strictly() {
    let body = "expect eventually w1.served >= 1  expect eventually w1.served > 0
        expect eventually w1.served > 1  expect always w1.served < 1  expect always w1.served <= 1";
    let summary = summary(body);
    let verdicts: Vec<Verdict> = summary.expectations.iter().map(|e| e.verdict).collect();
    assert_eq!(verdicts, [Verdict::Holds, Verdict::Holds, Verdict::Fails, Verdict::Fails, Verdict::Holds]);
}

#[test]
fn satisfaction_follows_what_is_said() {
    let body = "feedback { h1 [{ wait too_long  approach fast }, {}] }
        expect always (h1.served < 1 implies h1.wait_satisfaction <= 0)
        expect eventually (h1.wait_satisfaction >= 1 and h1.approach_satisfaction <= -0.5)";
    let summary = summary(body);
    assert!(summary.ok, "{:?}", summary.expectations);
}

#[test]
fn a_mission_without_robots_is_a_verdict_with_its_reason() {
    let lost = "happens [{ at 20 s  lost m1 }, { at 30 s  lost m2 }]";
    let bare = summary(lost);
    assert!(!bare.ok);
    assert!(matches!(&bare.end, End::Stranded { why } if why.contains("every robot is lost")), "{:?}", bare.end);
    assert!(bare.trouble()[0].1.contains("every robot is lost"));
    let spoken = summary(&format!("{lost}  expect eventually day.stranded  expect never done"));
    assert!(spoken.ok, "{:?}", spoken.expectations);
    // One robot comes back, and everything is served after all.
    let back = "happens [{ at 20 s  lost m1 }, { at 30 s  lost m2 }, { at 60 s  back m1 }]";
    let body = format!("{back}  expect after day.stranded : within 31 s : (not day.stranded)  expect eventually done");
    let (run, header, rows) = logged(&body);
    assert!(run.summary.ok, "{:?} {:?}", run.summary.end, run.summary.expectations);
    let served = |name: &str| *numbers(&header, &rows, name).last().expect("a row");
    assert_eq!((served("h1.served"), served("h2.served"), served("w1.served")), (2.0, 1.0, 1.0));
}

#[test]
fn what_cannot_happen_fails_the_scenario() {
    let early = summary("happens [{ at 5 s  feedback h1  wait long }, { at 6 s  failed m1 }]  expect eventually done");
    assert!(!early.ok && early.expectations.iter().all(|e| e.verdict == Verdict::Holds));
    assert_eq!(early.rejected_events.len(), 2);
    assert!(early.rejected_events[0].why.contains("has not been served"), "{:?}", early.rejected_events);
    assert_eq!(early.rejected_events[1].why, "m1 serves nobody");
    let early = summary("happens [{ at 6 s  late m1  by 9 s }]  expect eventually done");
    assert!(!early.ok);
    assert_eq!(
        (early.rejected_events[0].event.as_str(), early.rejected_events[0].why.as_str()),
        ("the service that m1 gives takes 9 s longer", "m1 serves nobody")
    );
}

/// A longer service can be reported for the robot or for its agent, with the same result.
#[test]
fn a_service_takes_longer() {
    let first = |body: &str| {
        let summary = summary(&format!("operations planned  {body}"));
        assert!(summary.rejected_events.is_empty(), "{:?}", summary.rejected_events);
        let at = |text: &str| summary.log.iter().find(|h| h.what.contains(text)).expect("it happens").clone();
        (at(" serves "), at(" has served operation 1 of "))
    };
    let (begins, ends) = first("expect eventually done");
    let (robot, agent) = begins.what.split_once(" serves ").expect("a robot and an agent");
    let at = (begins.at_s + 5.0).floor();
    for who in [robot, agent] {
        let (_, late) = first(&format!("happens [{{ at {at} s  late {who}  by 30 s }}]  expect eventually done"));
        assert_eq!(late.what, ends.what);
        assert!((late.at_s - ends.at_s - 30.0).abs() < 1e-9, "{who}: {} after {}", late.at_s, ends.at_s);
    }
}

#[test]
fn a_compiled_file_keeps_its_scenarios_and_refuses_damage() {
    let text = format!(
        "{TEAM}scenario s {{ mission day  duration 900 s  happens [{{ at 9 s  lost m1 }}]  feedback {{ h1 {{ wait ok }} }}
           expect always h1.waited < 99 s }}\n"
    );
    let missions = compiled(&text).missions;
    let json = CompiledFile::to_json("day", None, &missions).expect("a text");
    assert_eq!(CompiledFile::read(&json).expect("a file").missions, missions);
    let damaged = [
        ("\"duration\": 900.0", "\"duration\": -1.0", "duration"),
        ("\"step\": 1.0", "\"step\": 1e-9", "step"),
        ("\"waited\"", "\"waited\"", ""),
    ];
    for (from, to, place) in damaged {
        let other = json.replace(from, to);
        let read = CompiledFile::read(&other);
        match place {
            "" => assert!(read.is_ok()),
            place => assert!(read.expect_err("refused").contains(place)),
        }
    }
    let mut other = missions.clone();
    other[0].scenarios[0].replies[0].member = 4;
    assert!(other[0].check().is_err(), "a working robot says nothing");
    let mut other = missions;
    other[0].scenarios[0].predicates[0].value.inputs = vec![1000];
    assert!(other[0].check().is_err());
}

/// The text of a random event.
fn event() -> impl Strategy<Value = String> {
    let who = prop::sample::select(vec!["h1", "h2", "w1"]);
    let all = prop::sample::select(vec!["h1", "h2", "w1", "m1", "m2"]);
    let at = 0..600_u32;
    prop_oneof![
        (at.clone(), who.clone(), -40..90_i32).prop_map(|(t, a, by)| format!("{{ at {t} s  late {a}  by {by} s }}")),
        (at.clone(), who.clone(), 8..16_i32).prop_map(|(t, a, x)| format!("{{ at {t} s  moved {a}  to [{x}, 2] m }}")),
        (at.clone(), all.clone()).prop_map(|(t, a)| format!("{{ at {t} s  lost {a} }}")),
        (at.clone(), all.clone()).prop_map(|(t, a)| format!("{{ at {t} s  back {a} }}")),
        (at.clone(), all).prop_map(|(t, a)| format!("{{ at {t} s  failed {a} }}")),
        (at, who).prop_map(|(t, a)| format!("{{ at {t} s  done {a} }}")),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, ..ProptestConfig::default() })]
    /// For any events, a run ends with a verdict; each of its events is a record or has a reason for its rejection.
    #[test]
    fn random_days_end_with_a_verdict(events in prop::collection::vec(event(), 1..6), seed in 0..100_u64) {
        let body = format!("seed {seed}  step 10 s  happens [{}]  expect always day.makespan >= 0 s", events.join(", "));
        let summary = summary(&body);
        let told = played::events(&summary.log, &["h1", "h2", "w1", "m1", "m2"]);
        prop_assert_eq!(told + summary.rejected_events.len(), events.len());
        prop_assert!(summary.expectations.iter().all(|e| e.verdict == Verdict::Holds));
        let is_whole = !matches!(summary.end, End::Refused { .. } | End::Interrupted);
        prop_assert!(is_whole);
    }
}

/// Returns a folder of this test, with the team and two scenarios.
fn folder(name: &str) -> std::path::PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    let text = format!(
        "{TEAM}scenario good {{ mission day  duration 1500 s  expect eventually done }}
         scenario bad {{ mission day  duration 1500 s  happens [{{ at 9 s  lost m1 }}, {{ at 9 s  lost m2 }}] }}\n"
    );
    std::fs::write(folder.join("day.hq"), text).expect("a file");
    folder
}

fn hierarq(folder: &Path, args: &[&str]) -> (Option<i32>, String, String) {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_hierarq"))
        .args(args)
        .current_dir(folder)
        .output()
        .expect("the command line");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn the_command_line_runs_and_tests_a_spec_of_missions_alone() {
    let folder = folder("mission_scenarios");
    let (code, out, err) = hierarq(&folder, &["run", "day.hq", "--scenario", "good", "--seed", "4"]);
    assert_eq!(code, Some(0), "{out}{err}");
    assert!(out.contains("eventually done") && out.contains("done after"), "{out}");
    let read = |name: &str| std::fs::read_to_string(folder.join("out/day").join(name)).expect("a file");
    let summary: serde_json::Value = serde_json::from_str(&read("summary.json")).expect("JSON");
    assert_eq!((&summary["ok"], &summary["seed"], &summary["end"]["how"]), (&true.into(), &4.into(), &"done".into()));
    assert_eq!(read("log.csv").lines().count(), 1502);
    let report = read("report.html");
    assert_eq!(report.matches("<svg").count(), report.matches("</svg>").count());
    assert!(report.contains("Planned") && report.contains("Executed") && !report.contains("src=\"http"), "a page");

    let (code, out, _) = hierarq(&folder, &["test", "day.hq", "--json"]);
    let data: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!((code, &data["ok"]), (Some(1), &false.into()));
    let bad = &data["scenarios"][1];
    assert_eq!(
        (&bad["scenario"], &bad["ok"], &bad["mission"]["end"]["how"]),
        (&"bad".into(), &false.into(), &"stranded".into())
    );
    let (_, out, _) = hierarq(&folder, &["test", "day.hq", "--scenario", "bad"]);
    assert!(out.contains("FAILS") && out.contains("robot is") && out.contains("1 FAILED"), "{out}");

    for (args, says) in [
        (&["run", "day.hq"][..], "--scenario NAME"),
        (&["run", "day.hq", "--scenario", "god"], "did you mean `good`"),
        (&["run", "day.hq", "--scenario", "good", "--verify"], "executes a mission"),
        (&["run", "day.hq", "--scenario", "good", "--duration", "-3s"], "more than 0 s"),
        (&["sweep", "day.hq"], "choose one with `--scenario`"),
    ] {
        let (code, out, err) = hierarq(&folder, args);
        assert!(code != Some(0) && err.contains(says), "{args:?}: {out}{err}");
    }
}
