//! `hierarq learn`: trainings from rewards and from demonstrations, continued from checkpoints; and what it rejects.

use std::path::Path;
use std::process::Output;

use cli::{folder, hierarq, text};
use learning::grid::{Rewards, World};
use learning::policy::{Method, Policy};
use learning::training::{Run, Settings};

use crate::common::cli;

const SPEC: &str = "hierarq 1

mission help : explore {
  area [[0, 0], [4, 0], [4, 3], [0, 3]] m
  exit [[3, 2], [4, 2], [4, 3], [3, 3]] m
  range 4 m
  robot r { start [0.5, 0.5] m }
  human anna { start [2.5, 0.5] m }
  target key { at [0.5, 2.5] m  kind b }
  obstacle leg { polygon [[1, 1], [2, 1], [2, 2], [1, 2]] m }
}
";

/// Short trainings of small numbers.
const SHORT: [&str; 8] = ["--steps", "1500", "--surrogate-steps", "1500", "--trajectories", "20", "--targets", "0..2"];

fn world() -> World {
    World::new(4, 3, &[5], &[11], 2).expect("a world")
}

fn settings() -> Settings {
    Settings {
        seed: 1,
        most_targets: 2,
        rewards: Rewards::paper(),
        surrogate_steps: 1500,
        demonstrations: 20,
        recovery_steps: 1500,
        ..Settings::paper()
    }
}

/// A folder with the spec, and the path of a file in it.
fn project(name: &str) -> impl Fn(&str) -> String {
    let folder = folder(name);
    std::fs::write(folder.join("help.hq"), SPEC).expect("writable");
    move |file| folder.join(file).to_str().expect("UTF-8").to_string()
}

fn learn(spec: &str, more: &[&str]) -> Output {
    hierarq(&[&["learn", spec], &SHORT[..], more].concat())
}

fn policy(file: &str) -> Policy {
    Policy::from_bytes(&std::fs::read(file).expect("a file")).expect("a policy")
}

#[test]
fn policies_are_trained_on_the_grid_of_the_mission() {
    let at = project("learn_rewards");
    let out = learn(&at("help.hq"), &["--out", &at("p.safetensors"), "--surrogate", &at("s.safetensors")]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert_eq!(text(&out.stdout).trim(), at("p.safetensors"));
    let told = text(&out.stderr);
    assert!(told.contains("mission help: 4 x 3 cells, 2 types of targets"), "{told}");
    assert!(
        told.contains("the synthetic person has given 20 demonstrations")
            && told.contains("demonstrations: 2048 of 1500 steps"),
        "{told}"
    );
    let mut run = Run::new(&world(), settings()).expect("settings");
    run.step(u64::MAX).expect("a training");
    assert_eq!(policy(&at("p.safetensors")), run.recovered().expect("a policy"));
    assert_eq!(policy(&at("s.safetensors")), *run.surrogate().expect("a policy"));
    assert_eq!(policy(&at("s.safetensors")).training().method, Method::Ppo);
    // The spec can then name the policy.
    let spec = SPEC
        .replace("start [2.5, 0.5] m }", "start [2.5, 0.5] m  predicted { model policy  file \"p.safetensors\" } }");
    std::fs::write(at("named.hq"), spec).expect("writable");
    let out = hierarq(&["check", &at("named.hq")]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
}

#[test]
fn continued_trainings_give_the_same_policy() {
    let at = project("learn_resume");
    let mut run = Run::new(&world(), settings()).expect("settings");
    run.step(1100).expect("a training");
    std::fs::write(at("c.safetensors"), run.checkpoint()).expect("writable");
    run.step(u64::MAX).expect("a training");
    let more = ["--out", &at("p.safetensors"), "--checkpoint", &at("c.safetensors"), "--resume"];
    let out = learn(&at("help.hq"), &more);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert_eq!(policy(&at("p.safetensors")), run.recovered().expect("a policy"));
    let other = learn(&at("help.hq"), &[&more[..], &["--seed", "2"]].concat());
    assert_eq!(other.status.code(), Some(2));
    let told = text(&other.stderr);
    assert!(told.contains("belongs to another training: its settings differ"), "{told}");
}

#[test]
fn demonstrations_are_read_and_checked() {
    let at = project("learn_demonstrations");
    let line = r#"{"targets":[{"cell":8,"kind":1}],"cells":[8,8,9,10,11],"actions":["collect","east","east","east"]}"#;
    std::fs::write(at("good.jsonl"), format!("{line}\n{line}\n")).expect("writable");
    let out = learn(&at("help.hq"), &["--demonstrations", &at("good.jsonl"), "--out", &at("p.safetensors")]);
    let told = text(&out.stderr);
    // The number of trajectories is that of the synthetic person.
    assert_eq!(out.status.code(), Some(2), "{told}");
    let plain = |file: &str| {
        let (spec, demonstrations, out) = (at("help.hq"), at(file), at("p.safetensors"));
        hierarq(&["learn", &spec, "--demonstrations", &demonstrations, "--steps", "1500", "--out", &out])
    };
    let out = plain("good.jsonl");
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert_eq!(policy(&at("p.safetensors")).training().method, Method::Airl);
    std::fs::write(at("gap.jsonl"), format!("{line}\n{}\n", line.replace("9,10", "9,9"))).expect("writable");
    let out = plain("gap.jsonl");
    assert_eq!(out.status.code(), Some(2));
    let told = text(&out.stderr);
    assert!(told.contains("line 2: action 2, `east`, leads from cell 9 to cell 10, and the line says 9"), "{told}");
}

#[test]
fn what_cannot_be_trained_is_rejected() {
    let at = project("learn_rejected");
    let rejected = |more: &[&str]| {
        let out = hierarq(&[&["learn", &at("help.hq"), "--out", &at("p.safetensors")], more].concat());
        assert_eq!(out.status.code(), Some(2), "{more:?}");
        text(&out.stderr)
    };
    let told = rejected(&["--values", "1"]);
    assert!(told.contains("the targets have 2 types, and the policy would know 1"), "{told}");
    let told = rejected(&["--values", "1,-1"]);
    assert!(told.contains("the reward of targets of type 1 is -1, and must be more than 0"), "{told}");
    assert!(rejected(&["--targets", "3..2"]).contains("write a range such as `0..4`"));
    assert!(rejected(&["--targets", "0..30"]).contains("need 31 cells, and 10 are free"));
    assert!(rejected(&["--resume"]).contains("--checkpoint"));
    let told = rejected(&["--checkpoint", &at("p.safetensors")]);
    assert!(told.contains("--out and --checkpoint name the same file"), "{told}");
    std::fs::write(at("c.safetensors"), "mine").expect("writable");
    let told = rejected(&["--checkpoint", &at("c.safetensors")]);
    assert!(told.contains("is not a checkpoint of a training that Hierarq wrote"), "{told}");
    assert!(!Path::new(&at("p.safetensors")).exists());
    let out = hierarq(&["learn", "examples/vineyard.hq"]);
    assert_eq!(out.status.code(), Some(2));
    let told = text(&out.stderr);
    assert!(told.contains("which has no person with a learned policy"), "{told}");
}

/// Specs with a policy that does not exist, in both spellings.
fn specs_of_a_missing_policy(at: &impl Fn(&str) -> String) -> [String; 2] {
    let named = "start [2.5, 0.5] m  predicted { model policy  file \"p.safetensors\" } }";
    std::fs::write(at("named.hq"), SPEC.replace("start [2.5, 0.5] m }", named)).expect("writable");
    let out = hierarq(&["fmt", "--to", "yaml", &at("named.hq")]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    std::fs::write(at("named.yaml"), &out.stdout).expect("writable");
    [at("named.hq"), at("named.yaml")]
}

/// The only error of a check: the underlined text, and the command in its help.
fn error_with_command(spec: &str) -> (String, String) {
    let out = hierarq(&["check", "--json", spec]);
    assert_eq!(out.status.code(), Some(1), "{}", text(&out.stderr));
    let told: serde_json::Value = serde_json::from_slice(&out.stdout).expect("JSON");
    let [error] = &told["diagnostics"].as_array().expect("a list")[..] else { panic!("{told}") };
    assert_eq!(error["code"], "HQ0975", "{error}");
    let offset = |key: &str| error["place"][key].as_u64().expect("an offset") as usize;
    let underlined = &std::fs::read_to_string(spec).expect("a file")[offset("start")..offset("end")];
    let command = error["help"].as_str().and_then(|help| help.split('`').nth(1)).expect("a command");
    (underlined.to_string(), command.to_string())
}

/// Runs the command with short trainings, and checks the spec.
fn trained_by(command: &str, spec: &str) {
    let words: Vec<&str> = command.split(' ').collect();
    assert_eq!(words[..4], ["hierarq", "learn", spec, "help"], "{command}");
    let out = hierarq(&[&words[1..], &SHORT[..]].concat());
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let out = hierarq(&["check", spec]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
}

#[test]
fn the_error_of_a_missing_policy_has_the_command_that_makes_it() {
    let at = project("learn_missing");
    for spec in specs_of_a_missing_policy(&at) {
        let _ = std::fs::remove_file(at("p.safetensors"));
        let (underlined, command) = error_with_command(&spec);
        assert_eq!(underlined.trim_matches('"'), "p.safetensors");
        assert!(command.ends_with(&format!(" --out {}", at("p.safetensors"))), "{command}");
        trained_by(&command, &spec);
    }
}

/// A policy that was trained for a grid without the obstacle is replaced, and a file of something else is not.
#[test]
fn a_policy_of_another_grid_is_trained_anew() {
    let at = project("learn_broken");
    let [spec, yaml] = specs_of_a_missing_policy(&at);
    let empty = SPEC.replace("  obstacle leg { polygon [[1, 1], [2, 1], [2, 2], [1, 2]] m }\n", "");
    std::fs::write(at("empty.hq"), empty).expect("writable");
    let out = learn(&at("empty.hq"), &["--out", &at("p.safetensors")]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    assert_eq!(error_with_command(&yaml).0.trim_matches('"'), "p.safetensors");
    trained_by(&error_with_command(&spec).1, &spec);
    std::fs::write(at("p.safetensors"), "mine").expect("writable");
    let out = learn(&spec, &["--out", &at("p.safetensors")]);
    assert_eq!(out.status.code(), Some(2));
    assert!(text(&out.stderr).contains("is not a policy"), "{}", text(&out.stderr));
    let told = text(&hierarq(&["check", &spec]).stderr);
    assert!(told.contains("move this one away"), "{told}");
}
