//! Sweeps that are interrupted by Ctrl-C or killed, and resumed.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use super::{bytes, command, folder, hierarq};

const LONG: [&str; 10] =
    ["sweep", "spec.hq", "--scenario", "in time", "--vary", "side=0.1m..0.3m", "--runs", "300", "--out", "s.parquet"];

fn long<'a>(more: &[&'a str]) -> Vec<&'a str> {
    LONG.iter().chain(more).copied().collect()
}

fn lines(dir: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(dir.join("s.parquet.journal")).unwrap_or_default();
    text.lines().map(str::to_string).collect()
}

/// Starts a sweep, and waits until some of its runs are finished.
fn begun(dir: &Path, args: &[&str]) -> Child {
    let mut child = command(dir, args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("the binary runs");
    let end = Instant::now() + Duration::from_secs(60);
    while lines(dir).len() < 5 {
        assert!(child.try_wait().expect("a process").is_none(), "it ended before it could be interrupted");
        assert!(Instant::now() < end, "it does not come on");
        std::thread::sleep(Duration::from_millis(2));
    }
    child
}

#[test]
fn what_was_killed_goes_on_where_it_was() {
    let dir = folder("killed");
    hierarq(&dir, &long(&["--jobs", "2"]));
    let whole = bytes(&dir, "s.parquet");
    std::fs::remove_file(dir.join("s.parquet")).expect("deleted");
    for _ in 0..2 {
        let mut child = begun(&dir, &long(&["--resume"]));
        child.kill().expect("killed");
        child.wait().expect("ended");
    }
    assert!(!dir.join("s.parquet").exists(), "nothing half done");
    // The last line may be truncated.
    let mut journal = bytes(&dir, "s.parquet.journal");
    journal.truncate(journal.len() - 7);
    let kept = journal.iter().filter(|b| **b == b'\n').count() - 1;
    std::fs::write(dir.join("s.parquet.journal"), journal).expect("written");

    let (code, _, err) = hierarq(&dir, &long(&[]));
    assert_eq!((code, err.contains(&format!("{kept} finished runs"))), (Some(2), true), "{err}");
    let (code, _, err) = hierarq(&dir, &long(&["--resume", "--seed", "1"]));
    assert_eq!((code, err.contains("another sweep, another command")), (Some(2), true), "{err}");
    let spec = std::fs::read_to_string(dir.join("spec.hq")).expect("a spec");
    std::fs::write(dir.join("spec.hq"), spec.replace("20 mm", "21 mm")).expect("written");
    let (code, _, err) = hierarq(&dir, &long(&["--resume"]));
    assert_eq!((code, err.contains("is not the same any more")), (Some(2), true), "{err}");
    std::fs::write(dir.join("spec.hq"), spec).expect("written");

    hierarq(&dir, &long(&["--resume"]));
    assert!(bytes(&dir, "s.parquet") == whole && lines(&dir).is_empty());
    // A second resume has nothing to do, and prints the same.
    let (code, text, _) = hierarq(&dir, &long(&["--resume"]));
    assert!(code == Some(1) && text.contains("300 rows"), "{text}");
}

#[test]
fn an_interruption_keeps_what_is_finished_and_the_file_that_was_there() {
    let dir = folder("interrupted");
    hierarq(&dir, &long(&[]));
    let before = bytes(&dir, "s.parquet");
    let many = |more: &[&'static str]| [&LONG[..6], &["--runs", "5000", "--out", "s.parquet"], more].concat();
    let child = begun(&dir, &many(&["--json"]));
    // Two sweeps cannot write the same file at once.
    let (code, _, err) = hierarq(&dir, &many(&["--resume"]));
    assert_eq!((code, err.contains("another sweep is writing s.parquet")), (Some(2), true), "{err}");
    Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("`kill` runs");
    let out = child.wait_with_output().expect("ended");
    assert_eq!(out.status.code(), Some(1));
    assert!(bytes(&dir, "s.parquet") == before, "as it was");
    let kept = lines(&dir);
    assert!(kept.len() > 4 && kept.len() < 5001);
    assert!(kept.iter().all(|line| serde_json::from_str::<serde_json::Value>(line).is_ok()));
}

#[test]
fn a_spec_that_changes_under_a_sweep_ends_it() {
    let dir = folder("changed");
    let args = [&LONG[..6], &["--runs", "3000", "--out", "s.parquet"]].concat();
    let mut child = begun(&dir, &args);
    let spec = std::fs::read_to_string(dir.join("spec.hq")).expect("a spec");
    std::fs::write(dir.join("spec.hq"), spec + "\n// later\n").expect("written");
    assert_eq!(child.wait().expect("ended").code(), Some(2));
    assert!(lines(&dir).len() > 4 && !dir.join("s.parquet").exists());
}
