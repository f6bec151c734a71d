//! Runs with masses and drives: the examples in both spellings, and what is said where MuJoCo is missing.

use std::process::{Command, Output};

fn with(library: Option<&str>, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hierarq"));
    command.args(arguments);
    if let Some(library) = library {
        command.env("HIERARQ_MUJOCO", library);
    }
    command.output().expect("it runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn a_run_with_a_plant_says_how_to_install_its_physics() {
    let out = with(Some("/nowhere"), &["test", "physics/examples/hand_guiding.hq"]);
    let said = text(&out.stdout) + &text(&out.stderr);
    assert_eq!(out.status.code(), Some(2), "{said}");
    let words: Vec<&str> = said.split(|c: char| c.is_whitespace() || c == '│').filter(|w| !w.is_empty()).collect();
    let said = words.join(" ");
    assert!(said.contains("MuJoCo is not installed"), "{said}");
    assert!(said.contains("python3 -m pip install mujoco"), "{said}");
    // It is checked without.
    let out = with(Some("/nowhere"), &["check", "--strict", "physics/examples/hand_guiding.hq"]);
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
}

#[test]
fn the_examples_do_with_masses_what_they_say() {
    if std::env::var_os("HIERARQ_MUJOCO").is_none() {
        println!("not run: HIERARQ_MUJOCO names no MuJoCo");
        return;
    }
    let out = with(None, &["test", "physics/examples"]);
    let said = text(&out.stdout);
    assert_eq!(out.status.code(), Some(0), "{said}\n{}", text(&out.stderr));
    assert!(!said.contains("FAILS") && said.contains("position drives"), "{said}");
}
