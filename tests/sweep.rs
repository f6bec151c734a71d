//! `hierarq sweep`: the same rows for any number of jobs, any order and any interruption; and each row agrees with its
//! run.

use crate::common;

#[cfg(unix)]
mod arrays;
#[cfg(unix)]
mod interrupted;
mod missions;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use hierarq::project::{Settings, compile};
use hierarq::scenario_runner;
use hierarq::sweep::row::{Cell, Row};
use hierarq::sweep::{Head, table};
use runtime::expect::Verdict;
use serde_json::Value as Json;

const SPEC: &str = "hierarq 1
robot arm {
  urdf \"arm7.urdf\"  rate 100 Hz
  points { elbow link_4 }
  home { all [0, 0.4, 0, 1.6, 0, 1.14, 0] rad }
}
param side = 0.2 m { min 0.05 m  max 0.5 m }
param down = 0.1 m { max 0.6 m - side }
param slope = 40 deg
param quick = 3 /s
param there = [0, 0, 0] m
param on = true
task limits = joint_position_limits
task speeds = joint_velocity_limits
task gap = self_collision { between elbow  and base_link  d_min 0.1 m  gain 5 /s }
task reach = frame_position(tool) {
  position initial(position) + there + [0 m, side*cos(slope), -down]
  gain if(on, quick, 1 /s)
}
stack work { level limits hard { limits  speeds  gap }  level motion { reach } }
run { duration 1 s }
scenario \"in time\" {
  seed 5
  simulator { noise 1 mrad  lag 20 ms }
  expect \"it's there\" eventually within 0.8 s : error(reach) < 20 mm
  expect always margin(gap) >= 0 m
}
scenario late { late { at 0.5 s  by 0.1 s } }
";

fn command(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hierarq"));
    command.args(args).env("NO_COLOR", "1").env("COLUMNS", "120").current_dir(folder);
    command
}

/// Runs the program in a folder; returns its exit code and outputs.
fn hierarq(folder: &Path, args: &[&str]) -> (Option<i32>, String, String) {
    let Output { status, stdout, stderr } = command(folder, args).output().expect("the binary runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (status.code(), text(stdout), text(stderr))
}

/// Creates a folder of a test with the spec and its robot.
fn folder(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("sweep").join(name);
    let _ = std::fs::remove_dir_all(&path);
    std::fs::create_dir_all(&path).expect("writable");
    std::fs::copy(common::example("robots/arm7.urdf"), path.join("arm7.urdf")).expect("a robot");
    std::fs::write(path.join("spec.hq"), SPEC).expect("a spec");
    path
}

const VARIED: [&str; 10] =
    ["sweep", "spec.hq", "--scenario", "in time", "--vary", "side=5cm..0.3m", "--vary", "quick=2/s,8/s", "--runs", "7"];

/// Returns the arguments of the sweep in most tests, with further arguments.
fn varied<'a>(more: &[&'a str]) -> Vec<&'a str> {
    VARIED.iter().chain(more).copied().collect()
}

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).expect("written")
}

fn number(cell: &Cell) -> f64 {
    match cell {
        Cell::Number(Some(x)) => *x,
        other => panic!("{other:?} is no number"),
    }
}

#[test]
fn the_bytes_do_not_depend_on_who_runs_what() {
    let dir = folder("jobs");
    for jobs in ["1", "2", "5"] {
        let out = format!("{jobs}.parquet");
        let (code, ..) = hierarq(&dir, &varied(&["--jobs", jobs, "--out", &out]));
        assert_eq!(code, Some(1), "some of the runs fail");
        assert_eq!(bytes(&dir, &out), bytes(&dir, "1.parquet"), "{jobs} at once");
    }
    let parts = ["3", "1", "2"].map(|i| {
        let (shard, out) = (format!("{i}/3"), format!("part{i}.parquet"));
        hierarq(&dir, &varied(&["--shard", &shard, "--out", &out]));
        out
    });
    let [c, a, b] = parts.each_ref().map(String::as_str);
    let (code, text, _) = hierarq(&dir, &["sweep", "--merge", c, a, b, "--out", "all.parquet"]);
    assert_eq!((code, text.contains("14 rows in all.parquet")), (Some(1), true), "{text}");
    assert_eq!(bytes(&dir, "all.parquet"), bytes(&dir, "1.parquet"), "shards");

    for (files, wrong) in [
        (vec![a, b], "4 of 14 runs are missing, the first of them is run 2"),
        (vec![a, b, c, a], "run 0 is both in"),
        (vec![a, "none.parquet"], "cannot read none.parquet"),
        (vec![a, "spec.hq"], "spec.hq is no Parquet file"),
    ] {
        let args: Vec<&str> = ["sweep", "--merge"].into_iter().chain(files).chain(["--out", "bad.parquet"]).collect();
        let (code, _, err) = hierarq(&dir, &args);
        assert_eq!((code, err.contains(wrong)), (Some(2), true), "{err}");
    }
    hierarq(&dir, &varied(&["--seed", "6", "--shard", "3/3", "--out", "other.parquet"]));
    let (code, _, err) = hierarq(&dir, &["sweep", "--merge", a, b, "other.parquet", "--out", "bad.parquet"]);
    assert_eq!((code, err.contains("not parts of one sweep, another command")), (Some(2), true), "{err}");
    assert!(!dir.join("bad.parquet").exists());
}

/// Computes a row by running its scenario alone.
fn alone(dir: &Path, head: &Head, row: &Row) -> Row {
    let settings = Settings { set: head.sets(&row.values), ..Settings::default() };
    let program = compile(&dir.join("spec.hq"), &settings).program.expect("a program");
    let scenario = scenario_runner::of_controller(&program, &head.scenario).expect("a scenario");
    let result =
        scenario_runner::run("spec.hq", &program, &scenario_runner::seeded(scenario, row.seed)).expect("it runs");
    let mut own = row.clone();
    own.holds = result.ok;
    own.duration = result.duration_s;
    own.faults = result.faults.len() as u64;
    for (mine, e) in own.expectations.iter_mut().zip(&result.expectations) {
        (mine.verdict, mine.margin, mine.at) = (Some(e.verdict), e.margin, e.worst_s);
    }
    own
}

#[test]
fn each_row_is_the_run_that_it_speaks_of() {
    let dir = folder("rows");
    let (_, text, _) = hierarq(&dir, &varied(&["--out", "s.parquet", "--json"]));
    let (head, rows) = table::read(&dir.join("s.parquet")).expect("a sweep");
    assert_eq!((rows.len(), head.runs, head.seed), (14, 14, 5));
    let units: Vec<Option<&str>> = head.params.iter().map(|p| p.unit.as_deref()).collect();
    assert_eq!(units, [Some("m"), Some("/s")]);
    for (i, row) in rows.iter().enumerate() {
        // Two grid points with seven seeds each; random values depend on the seed only.
        assert_eq!((row.run, row.seed), (i as u64, 5 + i as u64 % 7));
        assert_eq!(number(&row.values[1]), if i < 7 { 2.0 } else { 8.0 });
        assert_eq!(row.values[0], rows[i % 7].values[0]);
        assert!((0.05..=0.3).contains(&number(&row.values[0])));
        assert_eq!(*row, alone(&dir, &head, row), "run {i}");
    }
    let drawn: Vec<u64> = rows[..7].iter().map(|r| number(&r.values[0]).to_bits()).collect();
    assert!((1..7).all(|i| !drawn[..i].contains(&drawn[i])), "seven different values");

    // The statistics of all rows, recomputed.
    let data: Json = serde_json::from_str(&text).expect("JSON");
    let held = rows.iter().filter(|r| r.holds).count();
    assert!(held > 0 && held < 14, "{held}: a test that shows nothing");
    assert_eq!((&data["version"], &data["ok"], &data["hold"]), (&1.into(), &false.into(), &held.into()));
    for (i, e) in head.expectations.iter().enumerate() {
        let margin = |r: &Row| r.expectations[i].margin.expect("a margin");
        let least = rows.iter().map(margin).fold(f64::INFINITY, f64::min);
        let worst = &data["expectations"][i]["worst"];
        assert_eq!(
            (&data["expectations"][i]["text"], worst["margin"].as_f64()),
            (&e.text.as_str().into(), Some(least))
        );
        let row = &rows[worst["run"].as_u64().expect("a number") as usize];
        assert_eq!((margin(row), worst["seed"].as_u64()), (least, Some(row.seed)));
        assert_eq!(worst["values"]["side"]["value"].as_f64(), Some(number(&row.values[0])));
        let held = rows.iter().filter(|r| r.expectations[i].verdict == Some(Verdict::Holds)).count();
        assert_eq!(data["expectations"][i]["hold"].as_u64(), Some(held as u64));
    }
}

#[cfg(unix)]
#[test]
fn the_command_line_that_is_given_runs_the_worst_run_again() {
    let dir = folder("replay");
    let args = varied(&["--vary", "slope=-30deg..30deg", "--set", "down=0.03m", "--out", "s.parquet", "--json"]);
    let data: Json = serde_json::from_str(&hierarq(&dir, &args).1).expect("JSON");
    for e in data["expectations"].as_array().expect("a list") {
        let worst = &e["worst"];
        let line = worst["replay"].as_str().expect("a command line").replacen("hierarq", "\"$HIERARQ\"", 1);
        let mut shell = Command::new("sh");
        shell.args(["-c", &format!("{line} --json")]).env("HIERARQ", env!("CARGO_BIN_EXE_hierarq")).current_dir(&dir);
        let out = shell.output().expect("a shell");
        let run: Json = serde_json::from_slice(&out.stdout).expect("JSON");
        let all = run["expectations"].as_array().expect("a list");
        let again = all.iter().find(|a| a["text"] == e["text"]).expect("the same expectation");
        assert_eq!((&again["margin"], &again["worst_s"]), (&worst["margin"], &worst["at_s"]), "{line}");
    }
    // The other command line produces the same file.
    let line = data["command"].as_str().expect("a command line").replacen("hierarq", "\"$HIERARQ\"", 1);
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("{line} --out t.parquet")]).env("HIERARQ", env!("CARGO_BIN_EXE_hierarq"));
    shell.current_dir(&dir).output().expect("a shell");
    assert_eq!(bytes(&dir, "s.parquet"), bytes(&dir, "t.parquet"));
}

#[test]
fn steps_texts_and_values_that_do_not_go_together() {
    let dir = folder("values");
    let base = ["sweep", "spec.hq", "--scenario", "in time", "--out", "s.parquet"];
    let run = |more: &[&str]| {
        let args: Vec<&str> = base.iter().chain(more).copied().collect();
        let out = hierarq(&dir, &args);
        (out.0, table::read(&dir.join("s.parquet")).expect("a sweep"))
    };
    let (_, (head, rows)) = run(&["--vary", "quick=1/s..3/s:5", "--vary", "there=[0, 0, 0] m,[0, 0.1, 0] m"]);
    let quick: Vec<f64> = rows.iter().map(|r| number(&r.values[0])).collect();
    assert_eq!(quick, [1.0, 1.0, 1.5, 1.5, 2.0, 2.0, 2.5, 2.5, 3.0, 3.0]);
    assert_eq!(rows[3].values[1], Cell::Text(Some("[0, 0.1, 0] m".to_string())));
    assert_eq!(
        (head.params[1].unit.clone(), rows[3].seed),
        (None, 5),
        "one run at each point: the scenario's own seed"
    );
    let (_, (_, rows)) = run(&["--vary", "on=true,false"]);
    assert_ne!(rows[0].expectations, rows[1].expectations);
    // Each value alone is within its range, but their combination is not.
    let (code, (_, rows)) = run(&["--vary", "side=0.1m,0.45m", "--vary", "down=0.05m,0.4m"]);
    let refused: Vec<Option<&str>> = rows.iter().map(|r| r.refused.as_deref()).collect();
    assert_eq!((code, refused), (Some(1), vec![None, None, None, Some("HQ0315")]));
    assert!(!rows[3].holds && rows[3].expectations[0].verdict.is_none());

    let (code, (head, rows)) = {
        let args = ["sweep", "spec.hq", "--scenario", "late", "--runs", "3", "--out", "s.parquet"];
        let (code, ..) = hierarq(&dir, &args);
        (code, table::read(&dir.join("s.parquet")).expect("a sweep"))
    };
    assert_eq!((code, head.expectations.len(), rows.len()), (Some(1), 0, 3));
    assert_eq!(rows[2].first_fault.as_deref(), Some("deadline"));
    assert!(rows[2].halted && rows[2].first_fault_tick >= Some(50) && rows[2].first_fault_tick <= Some(60));
}

#[test]
fn mistakes_are_said_before_anything_runs() {
    let dir = folder("mistakes");
    for (vary, code, wrong) in [
        ("side=0.1m..0.9m", 1, "`side` is 0.9 m, above its range"),
        ("side=0.1m,0.2m,0.7m", 1, "`side` is 0.7 m, above its range"),
        ("side=1s..2s", 1, "`side` is a length, and this is a time"),
        ("sde=1..2", 1, "did you mean `side`?"),
        ("side=0.3m..0.1m", 2, "`0.3m` is above `0.1m`"),
        ("there=[0, 0, 0] m..[0, 0, 1] m", 2, "`there` is a vector, and a range is one of numbers"),
        ("side=", 2, "write NAME=VALUE"),
        ("side=1m..2m:x", 2, "no number of values"),
        ("quick=1/s..2/s:100000", 2, "more than 10000000 runs"),
    ] {
        let args = ["sweep", "spec.hq", "--scenario", "in time", "--runs", "101", "--out", "s.parquet", "--vary", vary];
        let (got, _, err) = hierarq(&dir, &args);
        assert_eq!((got, err.contains(wrong)), (Some(code), true), "{vary}: {err}");
    }
    for (args, wrong) in [
        (vec!["sweep", "spec.hq"], "several scenarios"),
        (vec!["sweep", "spec.hq", "--scenario", "in tme"], "did you mean `in time`?"),
        (vec!["sweep"], "required"),
        (vec!["sweep", "spec.hq", "--scenario", "late", "--shard", "3/2"], "write I/N"),
        (vec!["sweep", "spec.hq", "--scenario", "late", "--vary", "quick=1,2", "--vary", "quick=3"], "varied twice"),
        (
            vec!["sweep", "spec.hq", "--scenario", "late", "--vary", "quick=1,2", "--set", "quick=3"],
            "both set and varied",
        ),
        (vec!["sweep", "spec.hq", "--scenario", "late", "--seed", "9000000000000000"], "a seed above"),
        (vec!["sweep", "--merge", "a.parquet"], "--out"),
        (vec!["sweep", "--merge", "a.parquet", "--out", "b.parquet", "--jobs", "2"], "runs nothing"),
    ] {
        let (code, _, err) = hierarq(&dir, &args);
        assert_eq!((code, err.contains(wrong)), (Some(2), true), "{args:?}: {err}");
    }
    assert!(!dir.join("s.parquet").exists() && !dir.join("out").exists());
}

#[test]
fn run_and_test_take_a_seed() {
    let dir = folder("seed");
    let margins = |args: &[&str]| {
        let data: Json = serde_json::from_str(&hierarq(&dir, args).1).expect("JSON");
        let of = if args[0] == "run" { &data["expectations"] } else { &data["scenarios"][0]["expectations"] };
        of[0]["margin"].as_f64().expect("a margin")
    };
    let run = |more: &[&str]| margins(&[&["run", "spec.hq", "--scenario", "in time", "--json"], more].concat());
    let test = |more: &[&str]| margins(&[&["test", "spec.hq", "--scenario", "in time", "--json"], more].concat());
    assert_eq!((run(&[]), run(&["--seed", "6"])), (run(&["--seed", "5"]), test(&["--seed", "6"])));
    assert_eq!(test(&[]), run(&[]));
    assert_ne!(run(&[]), run(&["--seed", "6"]));
}
