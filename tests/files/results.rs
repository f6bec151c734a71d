//! The folder of a run: locked from begin to end, with results that are complete or absent.

use std::path::Path;
use std::process::{Child, Stdio};

use super::{arm, call, contents, folder, names, until, utf8};

const RESULTS: [&str; 3] = ["log.csv", "report.html", "summary.json"];

/// A running process; killed if the test fails.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Starts a run of an hour's work into a folder, and waits until rows of its log are on the disk.
fn begun(spec: &Path, out: &Path) -> Running {
    let args = ["run", utf8(spec), "--duration", "90000", "--out", utf8(out)];
    let child = super::command(&args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the binary runs");
    let mut running = Running(child);
    until("no log is written", || {
        assert!(running.0.try_wait().expect("a child").is_none(), "it ended by itself");
        out.join("log.csv.part").metadata().is_ok_and(|about| about.len() > 100_000)
    });
    running
}

#[cfg(unix)]
fn signal(Running(child): &Running, name: &str) {
    let sent = std::process::Command::new("kill").args([name, &child.id().to_string()]).status();
    assert!(sent.expect("there is a `kill`").success());
}

#[cfg(unix)]
#[test]
fn two_runs_do_not_write_into_one_folder() {
    let dir = folder("two_runs");
    let spec = arm(&dir, "first", "1 s");
    let out = dir.join("out");
    let mut first = begun(&spec, &out);
    let (code, _, err) = call(&["run", utf8(&spec), "--out", utf8(&out)]);
    assert_eq!((code, err.contains("another run is writing into")), (Some(2), true), "{err}");
    signal(&first, "-INT");
    assert_eq!(first.0.wait().expect("it ends").code(), Some(1));
    let log = contents(&out.join("log.csv"));
    let columns = log.lines().next().map(|head| head.split(',').count());
    assert!(log.ends_with('\n') && log.lines().all(|line| Some(line.split(',').count()) == columns));
    assert_eq!(call(&["run", utf8(&spec), "--out", utf8(&out)]).0, Some(0));
    assert_eq!(names(&out), RESULTS);
}

#[cfg(unix)]
#[test]
fn a_run_that_is_killed_leaves_no_verdict() {
    let dir = folder("killed");
    let spec = arm(&dir, "first", "1 s");
    let out = dir.join("out");
    for _ in 0..2 {
        assert_eq!(call(&["run", utf8(&spec), "--out", utf8(&out)]).0, Some(0));
        assert_eq!(names(&out), RESULTS);
        let mut child = begun(&spec, &out);
        signal(&child, "-KILL");
        child.0.wait().expect("it ends");
        assert_eq!(names(&out), ["log.csv.part"], "what is left says that it is a part");
    }
}

#[cfg(unix)]
#[test]
fn sigterm_ends_a_run_as_an_interruption_does() {
    let dir = folder("terminated");
    let spec = arm(&dir, "first", "1 s");
    let out = dir.join("out");
    let mut child = begun(&spec, &out);
    signal(&child, "-TERM");
    assert_eq!(child.0.wait().expect("it ends").code(), Some(1));
    assert_eq!(names(&out), RESULTS);
    let summary: serde_json::Value = serde_json::from_str(&contents(&out.join("summary.json"))).expect("JSON");
    assert_eq!(summary["interrupted"], true);
    assert_eq!(summary["ticks"].as_u64(), Some(contents(&out.join("log.csv")).lines().count() as u64 - 1));
}

#[test]
fn results_replace_results_and_nothing_else() {
    let dir = folder("foreign_results");
    let spec = arm(&dir, "first", "50 ms");
    let out = dir.join("out");
    let run = || call(&["run", utf8(&spec), "--out", utf8(&out)]);
    for name in ["log.csv", "report.html", "summary.json", "log.csv.part"] {
        assert_eq!(run().0, Some(0));
        let before: Vec<String> = RESULTS.iter().map(|name| contents(&out.join(name))).collect();
        for foreign in ["mine", "time,chest.x,chest.y,chest.z\n0,1,2,3\n", "{\"ok\": true}", "<!doctype html>\n"] {
            std::fs::write(out.join(name), foreign).expect("writable");
            let (code, _, err) = run();
            assert_eq!((code, err.contains("so it is kept")), (Some(2), true), "{err}");
            assert_eq!(contents(&out.join(name)), foreign);
        }
        std::fs::remove_file(out.join(name)).expect("removed");
        for (other, text) in RESULTS.iter().zip(&before).filter(|(other, _)| **other != name) {
            assert_eq!(contents(&out.join(other)), *text, "{other} stays where a run is refused");
        }
    }
}

/// The log of one run may be the recording that another one replays.
#[test]
fn a_recording_that_a_run_plays_is_not_replaced_by_its_log() {
    let dir = folder("played");
    let spec = arm(&dir, "first", "50 ms");
    assert_eq!(call(&["run", utf8(&spec), "--out", utf8(&dir)]).0, Some(0));
    let recorded = "time,q.first,chest.x,chest.y,chest.z\n0,0,3,0,1\n1,0,3,0,1\n";
    std::fs::write(dir.join("log.csv"), recorded).expect("writable");
    let text = contents(&spec)
        + "\nhuman anna {\n  points [chest]\n  timeout 0.1 s\n  max_speed 4 m/s\n  lost hold\n  growth 0.5 m/s\n}\n\
           scenario walks { duration 50 ms  humans { anna { file \"log.csv\" } } }\n";
    std::fs::write(&spec, text).expect("writable");
    let (code, _, err) = call(&["run", utf8(&spec), "--scenario", "walks", "--out", utf8(&dir)]);
    assert_eq!((code, err.contains("would overwrite what it is made from")), (Some(2), true), "{err}");
    assert_eq!(contents(&dir.join("log.csv")), recorded);
}

/// A parser of RFC 4180 that is independent of the writer of logs.
fn records(text: &str) -> Vec<Vec<String>> {
    let (mut records, mut record, mut cell, mut quoted) = (Vec::new(), Vec::new(), String::new(), false);
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match (c, quoted) {
            ('"', true) if rest.peek() == Some(&'"') => cell.extend(rest.next()),
            ('"', _) => quoted = !quoted,
            (',', false) => record.push(std::mem::take(&mut cell)),
            ('\n', false) => {
                record.push(std::mem::take(&mut cell));
                records.push(std::mem::take(&mut record));
            }
            (c, _) => cell.push(c),
        }
    }
    records
}

#[test]
fn a_log_has_as_many_names_as_columns_whatever_joints_are_called() {
    for (n, name) in ["j,1", "a \"b\"", "two\nlines", ",", "\""].iter().enumerate() {
        let dir = folder(&format!("names{n}"));
        let spec = arm(&dir, name, "50 ms");
        let out = dir.join("out");
        let (code, _, err) = call(&["run", utf8(&spec), "--out", utf8(&out)]);
        assert_eq!(code, Some(0), "{name:?}: {err}");
        let log = records(&contents(&out.join("log.csv")));
        assert_eq!(log.len(), 6, "{name:?}");
        assert!(log.iter().all(|record| record.len() == log[0].len()), "{name:?}: {:?}", log[0]);
        // A line end in an XML attribute is a space, unless it is written as a character reference.
        for kind in ["q", "v", "cmd"] {
            assert!(log[0].contains(&format!("{kind}.{name}")), "{name:?}: {:?}", log[0]);
        }
    }
}
