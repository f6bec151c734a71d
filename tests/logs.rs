//! Logs in MCAP on the command line: written by `run`, run again by `replay`, converted from and to `log.csv`.

use std::path::Path;

use crate::common::cli::{folder, hierarq, text};

fn utf8(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

/// Runs a command that must fail with wrong usage, and returns its message.
fn refused(args: &[&str]) -> String {
    let out = hierarq(args);
    let message = text(&out.stderr);
    assert_eq!(out.status.code(), Some(2), "{args:?}: {message}");
    assert_eq!(message.lines().filter(|l| l.starts_with("hierarq: ")).count(), 1, "{message}");
    message
}

fn good(args: &[&str]) -> String {
    let out = hierarq(args);
    assert_eq!(out.status.code(), Some(0), "{args:?}: {}", text(&out.stderr));
    text(&out.stdout)
}

#[test]
fn a_run_is_logged_replayed_and_converted() {
    let out = folder("mcap run");
    let (spec, scenario) = ("examples/tested.hq", "found at second sight");
    let shown = good(&["run", spec, "--scenario", scenario, "--seed", "7", "--log", "mcap", "--out", utf8(&out)]);
    assert!(shown.contains("log.mcap"), "{shown}");
    let log = out.join("log.mcap");
    let replayed = good(&["replay", utf8(&log)]);
    assert!(replayed.starts_with("agrees: ") && replayed.ends_with(" messages, every bit\n"), "{replayed}");
    let data: serde_json::Value = serde_json::from_str(&good(&["replay", utf8(&log), "--json"])).expect("JSON");
    assert_eq!((&data["agrees"], &data["difference"]), (&true.into(), &serde_json::Value::Null));

    let rows = |path: &Path| std::fs::read_to_string(path).expect("text");
    let (csv, again) = (out.join("log.csv"), out.join("again.csv"));
    assert_eq!(data["ticks"].as_u64(), Some(rows(&csv).lines().count() as u64 - 1));
    good(&["convert", utf8(&log), utf8(&again)]);
    assert!(rows(&again) == rows(&csv), "the numbers differ");

    let converted = out.join("converted.mcap");
    let options = ["--spec", spec, "--scenario", scenario, "--seed", "7"];
    good(&[&["convert", utf8(&csv), utf8(&converted)], &options[..]].concat());
    assert!(good(&["replay", utf8(&converted)]).starts_with("agrees: "));

    // A log that claims to be of another param is found out.
    let options = ["--spec", spec, "--scenario", scenario, "--set", "near=3mm"];
    good(&[&["convert", utf8(&csv), utf8(&converted)], &options[..]].concat());
    let other = hierarq(&["replay", utf8(&converted)]);
    assert_eq!(other.status.code(), Some(1), "{}", text(&other.stderr));
    let shown = text(&other.stdout);
    assert!(shown.starts_with("DIFFERS: tick ") && shown.contains(" in the log, "), "{shown}");

    // A run without it leaves no log of an earlier one.
    good(&["run", "examples/hello.hq", "--duration", "100ms", "--out", utf8(&out)]);
    assert!(!log.exists());
}

#[test]
fn a_compiled_program_is_logged_too() {
    let out = folder("mcap compiled");
    let program = out.join("hello.json");
    std::fs::write(&program, good(&["compile", "examples/hello.yaml", "--format", "json"])).expect("a file");
    good(&["run", utf8(&program), "--duration", "200ms", "--log", "mcap", "--out", utf8(&out)]);
    assert!(good(&["replay", utf8(&out.join("log.mcap"))]).starts_with("agrees: "));
}

#[test]
fn what_cannot_be_used_has_a_reason() {
    let out = folder("mcap refusals");
    good(&["run", "examples/hello.hq", "--duration", "200ms", "--log", "mcap", "--out", utf8(&out)]);
    let (log, csv) = (out.join("log.mcap"), out.join("log.csv"));
    let bytes = std::fs::read(&log).expect("a log");
    let cut = out.join("cut.mcap");
    std::fs::write(&cut, &bytes[..bytes.len() / 2]).expect("a file");
    assert!(refused(&["replay", utf8(&cut)]).contains("it is cut off"));
    assert!(refused(&["convert", utf8(&cut), utf8(&out.join("cut.csv"))]).contains("it is cut off"));
    assert!(!out.join("cut.csv").exists());
    assert!(refused(&["replay", utf8(&csv)]).contains("it is no log in MCAP"));
    assert!(refused(&["replay", utf8(&out.join("none.mcap"))]).contains("cannot read"));

    let other = out.join("other.mcap");
    assert!(refused(&["convert", utf8(&csv), utf8(&other)]).contains("give the spec of the run, `--spec SPEC`"));
    let foreign = refused(&["convert", utf8(&csv), utf8(&other), "--spec", "examples/rover.hq"]);
    assert!(foreign.contains("the log is of another robot, or of an earlier spec"), "{foreign}");
    assert!(!other.exists());
    assert!(refused(&["convert", utf8(&csv), utf8(&out.join("other.txt"))]).contains("ends in .csv"));
    std::fs::write(&other, b"\x89MCAP0\r\nof somebody else").expect("a file");
    let kept = refused(&["convert", utf8(&csv), utf8(&other), "--spec", "examples/hello.hq"]);
    assert!(kept.contains("is not the log of a run in MCAP that Hierarq wrote"), "{kept}");

    let mission = ["run", "examples/vineyard_day.hq", "--log", "mcap", "--out", utf8(&out), "--scenario", "as planned"];
    assert!(refused(&mission).contains("this scenario executes a mission"));
}
