//! The example in C++, built by the system's compiler against the header and the library, ends where the controller of Rust ends. Without
//! a compiler, it is left out.

use std::path::{Path, PathBuf};
use std::process::Command;

use runtime::program::CompiledFile;
use runtime::{Controller, Observation};

use crate::spec;

/// Seconds of the run.
const SECONDS: usize = 2;

/// Folder of the libraries that this build has made.
fn libraries() -> PathBuf {
    let test = std::env::current_exe().expect("this test has a path");
    test.parent().expect("a test is in a folder").to_path_buf()
}

/// The joints after the run, by the controller itself.
fn expected(json: &str) -> Vec<f64> {
    let program = CompiledFile::read(json).expect("a program").program.expect("of a robot");
    let mut controller = Controller::new(&program).expect("it can be executed");
    let period = program.robot.period;
    let ticks = (SECONDS as f64 / period).round() as usize;
    let mut q = program.robot.home.clone();
    for k in 0..ticks {
        let time = k as f64 * period;
        controller.signals().set(0, &[0.45, 0.15 * time.sin(), 0.5], time);
        if k == ticks / 4 {
            controller.signals().raise(0);
        }
        let command = controller.step(&Observation { time, q: &q });
        assert_eq!(command.fault, None);
        q.iter_mut().zip(command.velocity).for_each(|(q, v)| *q += period * v);
    }
    q
}

/// A number as C prints it with `%a`.
fn hexadecimal(text: &str) -> f64 {
    let (sign, text) = text.strip_prefix('-').map_or((1.0, text), |rest| (-1.0, rest));
    let (digits, exponent) = text.strip_prefix("0x").and_then(|t| t.split_once('p')).expect("a number in hexadecimal");
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let mantissa = u64::from_str_radix(&format!("{whole}{fraction}"), 16).expect("digits");
    let exponent: i32 = exponent.parse().expect("an exponent");
    sign * mantissa as f64 * 2f64.powi(exponent - 4 * fraction.len() as i32)
}

/// Folder for what a test builds.
fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

fn succeeds(command: &mut Command) -> String {
    let output = command.output().expect("it runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    text
}

/// Runs the loop, and compares.
fn check(binary: &Path, json: &str) {
    let file = binary.with_extension("json");
    std::fs::write(&file, json).expect("the program is written");
    let mut run = Command::new(binary);
    run.arg(&file).args([&SECONDS.to_string(), "--as-fast-as-possible"]).env("LD_LIBRARY_PATH", libraries());
    let text = succeeds(&mut run);
    assert!(text.contains("state wait") && text.contains("0.500 s  state follow") && !text.contains("fault"), "{text}");
    let line = text.lines().find_map(|line| line.strip_prefix("q ")).expect("the joints");
    let found: Vec<f64> = line.split(' ').map(hexadecimal).collect();
    let wanted = expected(json);
    let sine = found.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-9);
    // C and Rust may differ in the last digit of the sine of the goal.
    assert!(sine && found.len() == wanted.len(), "{found:?} {wanted:?}");
}

fn is_there(program: &Path) -> bool {
    let there = Command::new(program).arg("--version").output().is_ok();
    if !there {
        println!("not run: there is no `{}`", program.display());
    }
    there
}

#[test]
fn a_loop_in_cpp_ends_where_the_controller_does() {
    if !is_there(Path::new("c++")) {
        return;
    }
    let json = spec::json();
    let include = Path::new(env!("CARGO_MANIFEST_DIR")).join("include");
    for library in ["libhierarq_c.so", "libhierarq_c.a"] {
        let binary = scratch("loop").join("loop");
        let mut compile = Command::new("c++");
        compile.args(["-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-I"]).arg(&include);
        compile.arg(spec::folder().join("loop.cpp")).arg(libraries().join(library));
        succeeds(compile.args(["-lpthread", "-ldl", "-lm", "-o"]).arg(&binary));
        check(&binary, &json);
    }
}

#[test]
fn cmake_builds_the_loop() {
    // The environment that `.ci/python` makes has a CMake of its own.
    let beside = std::env::var_os("HIERARQ_PYTHON").map(|python| Path::new(&python).with_file_name("cmake"));
    let cmake = beside.filter(|path| path.is_file()).unwrap_or_else(|| "cmake".into());
    if !is_there(Path::new("c++")) || !is_there(&cmake) {
        return;
    }
    let build = scratch("cmake");
    let library = libraries().join("libhierarq_c.so");
    let mut configure = Command::new(&cmake);
    configure.arg("-S").arg(spec::folder()).arg("-B").arg(&build);
    succeeds(configure.arg(format!("-DHIERARQ_LIBRARY={}", library.display())));
    succeeds(Command::new(&cmake).arg("--build").arg(&build));
    check(&build.join("loop"), &spec::json());
}
