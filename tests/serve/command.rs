//! The command itself: what it prints, and how it ends.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command, Stdio};

use crate::client::Client;

const SPEC: &str = "hierarq 1
mission field : schedule {
  robot m1 { depot [0, 0] m  speed 0.5 m/s  proximity_speed 0.5 m/s  serve 5 s  deposit 1 s }
  human anna { place [0, 5] m  operations 2  duration 60 s  wait_distance 1 m }
  human ben { place [3, 5] m  operations 2  duration 60 s  wait_distance 1 m }
}
";

fn spec() -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("serve");
    std::fs::create_dir_all(&folder).expect("writable");
    let path = folder.join("field.hq");
    std::fs::write(&path, SPEC).expect("writable");
    path
}

fn start(more: &[&str]) -> (Child, BufReader<ChildStdout>) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hierarq"));
    command.arg("serve").arg(spec()).args(more).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the binary runs");
    let out = BufReader::new(child.stdout.take().expect("piped"));
    (child, out)
}

/// What it prints until it waits.
fn greeting(out: &mut BufReader<ChildStdout>) -> String {
    let mut all = String::new();
    while !all.contains("Ctrl-C") {
        assert_ne!(out.read_line(&mut all).expect("text"), 0, "{all}");
    }
    all
}

fn links(greeting: &str) -> Vec<(String, String)> {
    let lines = greeting.lines().filter_map(|line| line.trim().split_once("  "));
    lines.filter(|(_, url)| url.contains("http://")).map(|(who, url)| (who.into(), url.trim().into())).collect()
}

#[test]
fn it_prints_links_that_open_and_a_journal_survives_its_death() {
    let journal = spec().with_extension("journal");
    let _ = std::fs::remove_file(&journal);
    let more = ["--journal", journal.to_str().expect("UTF-8"), "--begin", "--speed", "20", "--simulate", "ben"];
    let (mut child, mut out) = start(&more);
    let said = greeting(&mut out);
    let links_ = links(&said);
    assert_eq!(links_.iter().map(|link| link.0.as_str()).collect::<Vec<_>>(), ["supervisor", "anna"], "{said}");
    let (host, path) = links_[1].1.strip_prefix("http://").and_then(|url| url.split_once('/')).expect("a link");
    let mut anna = Client::new(host.parse().expect("an address"));
    anna.open(&format!("/{path}"));
    anna.until(|state| state["person"]["may"]["done"] == true);
    assert_eq!(anna.press("done", 0).status, 200);
    child.kill().expect("killed");
    child.wait().expect("dead");
    let (mut child, mut out) = start(&more);
    let said = greeting(&mut out);
    assert!(said.contains("goes on at"), "{said}");
    let again = links(&said);
    assert_ne!(again[1].1, links_[1].1, "links are new");
    let (host, path) = again[1].1.strip_prefix("http://").and_then(|url| url.split_once('/')).expect("a link");
    let mut anna = Client::new(host.parse().expect("an address"));
    anna.open(&format!("/{path}"));
    let state = anna.state();
    assert!(state["person"]["messages"].to_string().contains("Your operation 1 is finished."), "{state:#}");
    child.kill().expect("killed");
    child.wait().expect("dead");
}

#[cfg(unix)]
#[test]
fn an_interruption_ends_it_well() {
    let (mut child, mut out) = start(&[]);
    let said = greeting(&mut out);
    assert!(said.contains("the clock runs once the supervisor lets it"), "{said}");
    let interrupted = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(interrupted.success());
    assert_eq!(child.wait().expect("ended").code(), Some(0));
}

#[test]
fn a_wrong_mission_or_option_is_said() {
    let refused = |more: &[&str]| {
        let output =
            Command::new(env!("CARGO_BIN_EXE_hierarq")).arg("serve").arg(spec()).args(more).output().expect("runs");
        assert_eq!(output.status.code(), Some(2), "{more:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(refused(&["feild"]).contains("feild"));
    assert!(refused(&["--simulate", "bert"]).contains("it has anna, ben"));
    assert!(refused(&["--speed", "-1"]).contains("speed") || refused(&["--speed=-1"]).contains("speed"));
}
