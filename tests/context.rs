//! Layers from a language model on the command line, from recorded conversations: no test contacts a model.

use crate::common::cli;

use std::path::{Path, PathBuf};
use std::process::Output;

use cli::{command, hierarq, text};
use serde_json::Value;

const SPEC: &str = "examples/letters.hq";

fn context(args: &[&str]) -> Output {
    command(&["context", SPEC, "letter_h"]).args(args).output().expect("the binary runs")
}

/// Returns the path of a file for a test, which does not exist yet.
fn file(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_file(&path);
    path
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&std::fs::read_to_string(path).expect("written")).expect("JSON")
}

/// Experiment 6.B: a misspelt action, an unknown feature, a cycle and a truncated text are rejected, and the following
/// answer is accepted.
#[test]
fn bad_plans_are_refused_until_one_is_good() {
    let (out, kept) = (file("context_out.json"), file("context_kept.jsonl"));
    let paths = [out.to_str().expect("a path"), kept.to_str().expect("a path")];
    let recorded = "examples/layers/transcripts/letter_h.jsonl";
    let run = context(&["--replay", recorded, "--out", paths[0], "--transcript", paths[1]]);
    let said = text(&run.stderr);
    assert_eq!(run.status.code(), Some(0), "{said}");
    for words in [
        "attempt 1: refused",
        "nobody performs `pick_and_plac`; did you mean `pick_and_place`?",
        "no object is `beam`",
        "attempt 2: refused",
        "in a cycle",
        "attempt 3: refused",
        "the text ends",
        "attempt 4: taken",
    ] {
        assert!(said.contains(words), "{words} in {said}");
    }
    let tasks = |value: &Value| -> Vec<(String, Value)> {
        let layers = value["layers"].as_array().expect("layers").clone();
        let tasks = layers.iter().flat_map(|l| l["tasks"].as_array().expect("tasks").clone()).collect::<Vec<_>>();
        tasks.iter().map(|t| (t["name"].to_string(), t["features"].clone())).collect()
    };
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    assert_eq!(tasks(&json(&out)), tasks(&json(&root.join("examples/layers/letter_h.json"))));
    // The written transcript equals the replayed one, except for the times.
    let lines = |path: &Path| -> Vec<Value> {
        let all = std::fs::read_to_string(path).expect("a transcript");
        let read = |line: &str| serde_json::from_str::<Value>(line).expect("an exchange");
        all.lines().map(read).map(|mut value| (value["seconds"] = 0.0.into(), value).1).collect()
    };
    assert_eq!(lines(&kept), lines(&root.join(recorded)));
}

/// A real answer of a small model: no plan.
#[test]
fn a_model_that_cannot_do_it_is_given_up() {
    let run = context(&["--replay", "examples/layers/transcripts/small_model.jsonl", "--attempts", "2"]);
    assert_eq!(run.status.code(), Some(1));
    assert!(text(&run.stderr).contains("none of 2 answers can be used"), "{}", text(&run.stderr));
    assert!(run.stdout.is_empty());
}

#[test]
fn what_the_model_is_told_can_be_read() {
    let run = context(&["--prompt", "--decides", "allocation"]);
    let told = text(&run.stdout);
    assert_eq!(run.status.code(), Some(0));
    assert!(told.contains("left_red_cube_1") && told.contains("Objects do not overlap."), "{told}");
    assert!(told.contains("Carry out the job letter_h"));
    let alone = text(&context(&["--prompt"]).stdout);
    assert!(!alone.contains("left_red_cube_1") && alone.contains("\"count\": 10"), "{alone}");
}

#[test]
fn usage_that_makes_no_sense() {
    for (args, words) in [
        (&[][..], "--endpoint"),
        (&["--endpoint", "http://127.0.0.1:1/v1"][..], "--model"),
        (&["--endpoint", "nowhere", "--model", "m"][..], "no address"),
        (&["--replay", "no_such_file"][..], "cannot read"),
        (&["--replay", "Cargo.toml"][..], "line 1 is no exchange"),
    ] {
        let run = context(args);
        assert_eq!(run.status.code(), Some(2), "{args:?}");
        assert!(text(&run.stderr).contains(words), "{args:?}: {}", text(&run.stderr));
    }
    let vineyard = hierarq(&["context", "examples/vineyard.hq", "--prompt"]);
    assert_eq!(vineyard.status.code(), Some(2));
    assert!(text(&vineyard.stderr).contains("is a schedule"));
}

/// An unreachable server ends the conversation with a reason, and the attempt is recorded.
#[test]
fn a_server_that_is_not_there() {
    let free = std::net::TcpListener::bind("127.0.0.1:0").expect("a port").local_addr().expect("bound");
    let kept = file("context_nobody.jsonl");
    let address = format!("http://{free}/v1");
    let run = context(&["--endpoint", &address, "--model", "m", "--transcript", kept.to_str().expect("a path")]);
    assert_eq!(run.status.code(), Some(1));
    assert!(text(&run.stderr).contains("no connection"), "{}", text(&run.stderr));
    assert_eq!(std::fs::read_to_string(&kept).expect("kept").lines().count(), 4);
}

/// A transcript is never overwritten, by any later conversation.
#[test]
fn no_transcript_is_written_over() {
    let (kept, second) = (file("context_stays.jsonl"), file("context_stays.2.jsonl"));
    let recorded = "examples/layers/transcripts/letter_h.jsonl";
    std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join(recorded), &kept).expect("copied");
    let before = std::fs::read(&kept).expect("readable");
    let path = kept.to_str().expect("a path");
    let same = context(&["--replay", path, "--transcript", path]);
    assert_eq!(same.status.code(), Some(2));
    assert!(text(&same.stderr).contains("is replayed"), "{}", text(&same.stderr));
    let other = context(&["--replay", recorded, "--transcript", path]);
    assert!(text(&other.stderr).contains("context_stays.2.jsonl"), "{}", text(&other.stderr));
    assert_eq!(std::fs::read_to_string(&second).expect("kept").lines().count(), 4);
    assert_eq!(std::fs::read(&kept).expect("readable"), before);
}
