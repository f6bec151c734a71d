//! Sweeps of scenarios that execute missions: the same file however they are cut, and rows that agree with runs alone.

use mission::kinds::schedule::execution::Outcome;
use runtime::missions::{End, MissionRun};
use runtime::program::MissionScenarioProgram;

use super::*;
use crate::common::played;

const MISSION: &str = "hierarq 1
param slow = 0.2 m/s { min 0.05 m/s  max 0.6 m/s }
mission day : schedule {
  reallocate_above 0.05
  robot m1 { depot [0, 0] m  speed slow  proximity_speed slow  serve 20 s  deposit 10 s }
  robot m2 { depot [0, 6] m  speed 0.2 m/s  proximity_speed 0.2 m/s  serve 20 s  deposit 10 s }
  human h1 { place [12, 1] m  operations 2  duration normal(120 s, 12 s)  severity 0.5 }
  human h2 { place [14, 5] m  operations 1  duration normal(150 s, 15 s) }
}
scenario \"a day\" {
  mission day  duration 800 s  seed 4
  happens { at 100 s  late h2  by 30 s }
  expect \"early\" always day.makespan < 370 s
  expect eventually done
}
scenario \"as planned\" { mission day  duration 800 s  operations planned }
scenario \"too short\" { mission day  duration 100 s }
";

/// Creates a folder of a test with the mission.
fn folder(name: &str) -> PathBuf {
    let path = super::folder(&format!("mission_{name}"));
    std::fs::write(path.join("day.hq"), MISSION).expect("a spec");
    path
}

const DAY: [&str; 8] = ["sweep", "day.hq", "--scenario", "a day", "--vary", "slow=0.1m/s..0.3m/s", "--runs", "6"];

fn day<'a>(more: &[&'a str]) -> Vec<&'a str> {
    DAY.iter().chain(more).copied().collect()
}

#[test]
fn the_bytes_do_not_depend_on_who_runs_what() {
    let dir = folder("jobs");
    let codes = ["1", "2"].map(|jobs| hierarq(&dir, &day(&["--jobs", jobs, "--out", &format!("{jobs}.parquet")])).0);
    assert_eq!(codes, [Some(1); 2], "some of the days are late");
    for part in ["1/2", "2/2"] {
        hierarq(&dir, &day(&["--shard", part, "--out", &format!("part{}.parquet", &part[..1])]));
    }
    hierarq(&dir, &["sweep", "--merge", "part2.parquet", "part1.parquet", "--out", "all.parquet"]);
    for other in ["2.parquet", "all.parquet"] {
        assert_eq!(bytes(&dir, other), bytes(&dir, "1.parquet"), "{other}");
    }
    // A finished sweep is shown again without a run.
    let (code, text, _) = hierarq(&dir, &day(&["--out", "1.parquet", "--resume"]));
    assert_eq!((code, text.contains("the mission was done in 6 runs")), (Some(1), true), "{text}");
    let (code, _, err) = hierarq(&dir, &["sweep", "day.hq", "--scenario", "a day", "--out", "1.parquet", "--resume"]);
    assert_eq!((code, err.contains("another command")), (Some(2), true), "{err}");
}

/// Runs the mission of a row alone.
fn alone(dir: &Path, head: &Head, row: &Row) -> (MissionRun, Vec<String>, Vec<Vec<String>>) {
    let settings = Settings { set: head.sets(&row.values), ..Settings::default() };
    let compiled = compile(&dir.join("day.hq"), &settings);
    let mission = &compiled.missions[0];
    let scenario = mission.scenarios.iter().find(|s| s.name == head.scenario).expect("the scenario");
    let scenario = MissionScenarioProgram { seed: row.seed, ..scenario.clone() };
    let (run, bytes) = played::logged(mission, &scenario);
    let (header, rows) = played::table(bytes);
    (run, header, rows)
}

/// The value of a measure in a row.
fn measure(head: &Head, row: &Row, title: &str) -> f64 {
    let index = head.measures.iter().position(|m| m.title == title).expect("a measure");
    row.measures[index].expect("a value")
}

#[test]
fn each_row_is_the_run_that_it_speaks_of() {
    let dir = folder("rows");
    let (_, text, _) = hierarq(&dir, &day(&["--out", "s.parquet", "--json"]));
    let (head, rows) = table::read(&dir.join("s.parquet")).expect("a sweep");
    assert_eq!((rows.len(), rows[2].seed, head.expectations.len(), head.limits.len()), (6, 6, 2, 0));
    for row in &rows {
        let (run, header, log) = alone(&dir, &head, row);
        let summary = run.summary;
        let outcome: Outcome =
            serde_json::from_value(summary.outcome.clone().expect("an outcome")).expect("a schedule");
        let ended = row.mission.as_ref().expect("of a mission");
        let End::Done { at_s } = summary.end else { panic!("{:?}", summary.end) };
        assert_eq!((ended.how.as_deref(), ended.done_at, row.holds), (Some("done"), Some(at_s), summary.ok));
        assert_eq!((ended.broken, &ended.trouble), (0, &None));
        for (own, e) in row.expectations.iter().zip(&summary.expectations) {
            assert_eq!((own.verdict, own.margin, own.at), (Some(e.verdict), e.margin, e.worst_s));
        }
        // The measures against the results and the last row of the log of states.
        assert_eq!(measure(&head, row, "makespan"), outcome.makespan);
        assert_eq!(measure(&head, row, "h1.served"), 2.0);
        assert_eq!(measure(&head, row, "done"), 1.0);
        assert_eq!(measure(&head, row, "m1.travelled"), outcome.robots[0].travelled);
        for column in ["m1.x", "m2.y"] {
            let logged = *played::numbers(&header, &log, column).last().expect("a row");
            let (member, axis) = column.split_once('.').expect("a dot");
            let measured = measure(&head, row, &format!("{member}.position.{axis}"));
            assert!((measured - logged).abs() < 1e-6, "{column}: {measured} and {logged}");
        }
    }
    // The statistics of all rows, recomputed.
    let data: Json = serde_json::from_str(&text).expect("JSON");
    let held = rows.iter().filter(|r| r.holds).count();
    assert!(held > 0 && held < 6, "{held}: a test that shows nothing");
    assert_eq!((&data["hold"], &data["ends"]["done"]), (&held.into(), &6.into()));
    let all: Vec<f64> = rows.iter().map(|row| measure(&head, row, "makespan")).collect();
    let said = data["measures"].as_array().expect("a list").iter().find(|m| m["measure"] == "makespan");
    let said = said.expect("makespan");
    let mean = all.iter().sum::<f64>() / 6.0;
    let deviation = (all.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 5.0).sqrt();
    for (key, own) in [("mean", mean), ("deviation", deviation)] {
        let given = said[key].as_f64().expect("a number");
        assert!((given - own).abs() < 1e-9, "{key}: {given} and {own}");
    }
    // The bootstrap of a mean is nearly normal, with the deviation of the values themselves in place of the estimate.
    let half = 1.96 * deviation * (5.0_f64 / 6.0).sqrt() / 6.0_f64.sqrt();
    for (end, normal) in [(0, mean - half), (1, mean + half)] {
        let given = said["interval"][end].as_f64().expect("a number");
        assert!((given - normal).abs() < 0.25 * half, "{given} and {normal} about {mean}");
    }
    let least = &said["smallest"];
    let run = least["run"].as_u64().expect("a number") as usize;
    assert_eq!(
        (least["value"].as_f64(), all[run]),
        (Some(all[run]), all.iter().copied().fold(f64::INFINITY, f64::min))
    );
    assert_eq!(said["unit"], "s");
}

#[test]
fn ends_that_are_no_success_and_values_that_do_not_go_together() {
    let dir = folder("ends");
    let run = |args: &[&str]| {
        let (code, out, err) = hierarq(&dir, &[&["sweep"], args, &["--out", "s.parquet"]].concat());
        (code, out, err, table::read(&dir.join("s.parquet")))
    };
    let (code, text, _, rows) = run(&["day.hq", "--scenario", "too short", "--runs", "3"]);
    let (_, rows) = rows.expect("a sweep");
    let ended = rows[0].mission.as_ref().expect("of a mission");
    assert_eq!((code, ended.how.as_deref(), ended.done_at), (Some(1), Some("unfinished"), None));
    assert_eq!(ended.trouble.as_deref(), Some("the mission was not done after 100 s"));
    assert!(text.contains("the mission was unfinished in 3 runs"), "{text}");
    assert!(text.contains("the mission was not done after 100 s, run 0:\n  hierarq run day.hq"), "{text}");

    // Nothing random happens if operations last as planned.
    let (code, text, ..) = run(&["day.hq", "--scenario", "as planned", "--runs", "2"]);
    assert_eq!((code, text.contains("no result depends on the seed")), (Some(0), true), "{text}");
    let (_, text, ..) = run(&["day.hq", "--scenario", "a day", "--runs", "2"]);
    assert!(!text.contains("depends on the seed"), "{text}");

    // A compiled program is swept like its spec.
    let (_, _, _, spec) = run(&["day.hq", "--scenario", "a day", "--runs", "2"]);
    let (_, json, _) = hierarq(&dir, &["compile", "day.hq", "--format", "json"]);
    std::fs::write(dir.join("day.json"), json).expect("written");
    let (_, _, _, program) = run(&["day.json", "--scenario", "a day", "--runs", "2"]);
    assert_eq!(program.expect("a sweep").1, spec.expect("a sweep").1);

    let (code, _, err, _) = run(&["day.hq"]);
    assert_eq!((code, err.contains("choose one with `--scenario`, of `a day`")), (Some(2), true), "{err}");
    let (code, _, err, _) = run(&["day.hq", "--scenario", "a dya"]);
    assert_eq!((code, err.contains("did you mean `a day`?")), (Some(2), true), "{err}");
    let (code, _, err, _) = run(&["day.hq", "--scenario", "a day", "--vary", "slow=0.1m/s..0.9m/s"]);
    assert_eq!((code, err.contains("`slow` is 0.9 m/s, above its range")), (Some(1), true), "{err}");
}
