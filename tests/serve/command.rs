//! The command `hierarq serve`: its output, and its end.

use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command, Stdio};

use super::client::{Client, may};

pub const SPEC: &str = "hierarq 1
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

/// Returns the output up to the waiting message.
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
    for old in [&journal, &spec().with_extension("journal.key")] {
        let _ = std::fs::remove_file(old);
    }
    let more = ["--journal", journal.to_str().expect("UTF-8"), "--begin", "--speed", "20", "--simulate", "ben"];
    let (mut child, mut out) = start(&more);
    let said = greeting(&mut out);
    let links_ = links(&said);
    assert_eq!(links_.iter().map(|link| link.0.as_str()).collect::<Vec<_>>(), ["supervisor", "anna"], "{said}");
    let (host, path) = links_[1].1.strip_prefix("http://").and_then(|url| url.split_once('/')).expect("a link");
    let mut anna = Client::new(host.parse().expect("an address"));
    anna.open(&format!("/{path}"));
    anna.until(may("done"));
    assert_eq!(anna.press("done", 0).status, 200);
    child.kill().expect("killed");
    child.wait().expect("dead");
    let (mut child, mut out) = start(&more);
    let said = greeting(&mut out);
    assert!(said.contains("continues at"), "{said}");
    assert!(said.contains("still signed in, until their new link is opened: anna\n"), "{said}");
    assert_ne!(links(&said)[1].1, links_[1].1, "what was opened opens no more");
    assert_eq!(links(&said)[0].1, links_[0].1, "what nobody opened still opens");
    let state = anna.state();
    assert!(state["person"]["messages"].to_string().contains("Your operation 1 is finished."), "{state:#}");
    // The phone is lost.
    let made = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hierarq"));
        command.args(["serve", "--journal"]).arg(&journal).args(more).output().expect("runs")
    };
    let link = String::from_utf8(made(&["--link", "anna"]).stdout).expect("text");
    let (_, path) = link.trim().strip_prefix("http://").and_then(|url| url.split_once('/')).expect("a link");
    let mut other = Client::new(anna.address);
    other.open(&format!("/{path}"));
    assert_eq!(other.state()["person"]["name"], "anna");
    assert_eq!(anna.get("/person/1/state").status, 401);
    assert!(String::from_utf8_lossy(&made(&["--link"]).stdout).contains("/s/"));
    let nobody = made(&["--link", "ben"]);
    assert_eq!(nobody.status.code(), Some(2));
    assert!(
        String::from_utf8_lossy(&nobody.stderr)
            .contains("`ben` has no page in the mission `field`; it has pages for the supervisor and anna")
    );
    child.kill().expect("killed");
    child.wait().expect("dead");
}

#[cfg(unix)]
#[test]
fn an_interruption_ends_it_well() {
    for signal in ["-INT", "-TERM"] {
        let (mut child, mut out) = start(&[]);
        let said = greeting(&mut out);
        assert!(said.contains("the supervisor starts the clock"), "{said}");
        let interrupted = Command::new("kill").args([signal, &child.id().to_string()]).status().expect("kill runs");
        assert!(interrupted.success());
        assert_eq!(child.wait().expect("ended").code(), Some(0), "{signal}");
    }
}

#[test]
fn a_wrong_mission_or_option_is_said() {
    let refused = |more: &[&str]| {
        let output =
            Command::new(env!("CARGO_BIN_EXE_hierarq")).arg("serve").arg(spec()).args(more).output().expect("runs");
        assert_eq!(output.status.code(), Some(2), "{more:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(refused(&["--link"]).contains("cannot be used with"));
    assert!(refused(&["feild"]).contains("feild"));
    assert!(refused(&["--simulate", "bert"]).contains("it has anna, ben"));
    assert!(refused(&["--speed", "-1"]).contains("speed") || refused(&["--speed=-1"]).contains("speed"));
}
