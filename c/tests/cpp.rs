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

fn run(library: &Path, json: &str) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("loop");
    std::fs::create_dir_all(&folder).expect("a folder");
    let (binary, file) = (folder.join("loop"), folder.join("reach.json"));
    std::fs::write(&file, json).expect("the program is written");
    let include = Path::new(env!("CARGO_MANIFEST_DIR")).join("include");
    let mut compile = Command::new("c++");
    compile.args(["-std=c++17", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-I"]).arg(include);
    compile.arg(spec::folder().join("loop.cpp")).arg(library).args(["-lpthread", "-ldl", "-lm", "-o"]).arg(&binary);
    let output = compile.output().expect("the compiler runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut run = Command::new(&binary);
    run.arg(&file).args([&SECONDS.to_string(), "--as-fast-as-possible"]).env("LD_LIBRARY_PATH", libraries());
    let output = run.output().expect("it runs");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}{}", String::from_utf8_lossy(&output.stderr));
    assert!(text.contains("state wait") && text.contains("0.500 s  state follow") && !text.contains("fault"), "{text}");
    let line = text.lines().find_map(|line| line.strip_prefix("q ")).expect("the joints");
    let found: Vec<f64> = line.split(' ').map(hexadecimal).collect();
    let wanted = expected(json);
    let sine = found.iter().zip(&wanted).all(|(a, b)| (a - b).abs() < 1e-9);
    // C and Rust may differ in the last digit of the sine of the goal.
    assert!(sine && found.len() == wanted.len(), "{found:?} {wanted:?}");
}

#[test]
fn a_loop_in_cpp_ends_where_the_controller_does() {
    if Command::new("c++").arg("--version").output().is_err() {
        println!("not run: there is no C++ compiler");
        return;
    }
    let json = spec::json();
    for library in ["libhierarq_c.so", "libhierarq_c.a"] {
        run(&libraries().join(library), &json);
    }
}
