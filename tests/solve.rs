//! `hierarq solve` and `hierarq bench` for users and scripts: certified answers, rejected lines, files, exit codes.

mod bad_lines;
use crate::common;
mod generate;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use bad_lines::BAD;
use generate::{Dice, violations};
use proptest::prelude::*;
use robot::random::SplitMix64;
use serde_json::Value;
use solver::{LevelShape, Problem, certificate};

const EXAMPLE: &str = "examples/ticks/small.jsonl";
const GOOD: &str = r#"{"id":"good","n":2,"levels":[{"A":{"identity":1},"lo":[-1,null],"up":[1,null]},{"A":[[1,1]],"lo":[3],"up":[3]}]}"#;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn hierarq(args: &[&str], input: &[u8]) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_hierarq"))
        .args(args)
        .env("NO_COLOR", "1")
        .env("COLUMNS", "100")
        .current_dir(root())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the binary runs");
    let mut stdin = child.stdin.take().expect("a pipe");
    let input = input.to_vec();
    // A command that stops early closes its input: this is no failure of the test.
    let writer = std::thread::spawn(move || drop(stdin.write_all(&input)));
    let output = child.wait_with_output().expect("it ends");
    writer.join().expect("written");
    output
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Returns the path of a file for a test, which does not exist yet.
fn fresh(name: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_file(&path);
    path
}

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|l| serde_json::from_str(l).expect("JSON")).collect()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// Parses a tick independently of the command's own reader.
fn problem_of(tick: &Value) -> Problem {
    let n = tick["n"].as_u64().expect("a number") as usize;
    let levels = tick["levels"].as_array().expect("levels");
    let shape = |l: &Value| LevelShape {
        rows: l["lo"].as_array().expect("bounds").len(),
        hard: l["hard"].as_bool().unwrap_or(false),
        damping: l["damping"].as_f64().unwrap_or(0.0),
    };
    let mut problem = Problem::new(n, &levels.iter().map(shape).collect::<Vec<_>>());
    for (to, from) in problem.levels.iter_mut().zip(levels) {
        for i in 0..to.rows() {
            let row = match from["A"].is_object() {
                true => (0..n).map(|j| if i % n == j { 1.0 } else { 0.0 }).collect(),
                false => numbers(&from["A"][i]),
            };
            let (lower, upper) = (from["lo"][i].as_f64(), from["up"][i].as_f64());
            to.set(i, &row, lower.unwrap_or(f64::NEG_INFINITY), upper.unwrap_or(f64::INFINITY));
        }
        if from["weight"].is_array() {
            to.weight = numbers(&from["weight"]);
        }
    }
    if tick["reference"].is_array() {
        problem.reference = numbers(&tick["reference"]);
    }
    problem
}

/// The same structure, with numbers that differ only by rounding: `sin` differs between platforms.
fn alike(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let (a, b) = (a.as_f64().expect("a double"), b.as_f64().expect("a double"));
            (a - b).abs() <= 1e-9 * (1.0 + a.abs())
        }
        (Value::Array(a), Value::Array(b)) => a.len() == b.len() && a.iter().zip(b).all(|(a, b)| alike(a, b)),
        (Value::Object(a), Value::Object(b)) => {
            a.keys().eq(b.keys()) && a.values().zip(b.values()).all(|(a, b)| alike(a, b))
        }
        _ => a == b,
    }
}

#[test]
fn the_example_is_what_the_closed_loop_gives() {
    let made: String = generate::ticks().iter().map(|t| generate::line(t) + "\n").collect();
    let path = root().join(EXAMPLE);
    if std::env::var_os("HIERARQ_UPDATE_TICKS").is_some() {
        std::fs::write(&path, &made).expect("writable");
    }
    let is = std::fs::read_to_string(&path).expect("there is one");
    assert!(is.len() < 100_000, "{} bytes", is.len());
    let (is, made) = (lines(&is), lines(&made));
    assert_eq!(is.len(), made.len());
    for (is, made) in is.iter().zip(&made) {
        assert!(alike(is, made), "{} is stale: run `HIERARQ_UPDATE_TICKS=1 cargo test --test it solve`", is["id"]);
    }
    let held = is.iter().filter(|t| t["kind"] == "held-back" && numbers(&t["viol"])[2] > 1e-3).count();
    assert!(held >= 4, "the wall holds the arm back on {held} ticks only");
}

#[test]
fn answers_are_certified_whatever_the_backend_and_the_start() {
    let ticks = lines(&std::fs::read_to_string(root().join(EXAMPLE)).expect("readable"));
    for backend in ["active_set", "clarabel"] {
        for start in [&[][..], &["--cold"]] {
            let path = fresh(&format!("answers-{backend}-{}.jsonl", start.len()));
            let name = path.to_str().expect("UTF-8");
            let out =
                hierarq(&[&["solve", EXAMPLE, "--backend", backend, "--answers", name, "--json"], start].concat(), b"");
            assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
            let answers = lines(&std::fs::read_to_string(&path).expect("written"));
            assert_eq!(answers.len(), ticks.len());
            for (tick, answer) in ticks.iter().zip(&answers) {
                assert_eq!(tick["id"], answer["id"], "in the order of the file");
                assert_eq!(answer["status"], "optimal");
                assert!(answer["us"].as_f64() > Some(0.0));
                let problem = problem_of(tick);
                let x = numbers(&answer["x"]);
                let residual = certificate(&problem, &x);
                assert!(residual < 1e-8, "{backend}, {}: {residual:e}", tick["id"]);
                for (a, b) in x.iter().zip(numbers(&tick["x"])) {
                    assert!((a - b).abs() < 1e-8, "{backend}, {}: {a} is not {b}", tick["id"]);
                }
                for (a, b) in numbers(&answer["viol"]).iter().zip(violations(&problem, &x)) {
                    assert!((a - b).abs() < 1e-12, "{backend}, {}: {a} is not {b}", tick["id"]);
                }
            }
            let summary: Value = serde_json::from_slice(&out.stdout).expect("JSON");
            assert_eq!(summary["backend"], backend);
            assert_eq!(summary["start"], if start.is_empty() { "warm" } else { "cold" });
            assert_eq!(summary["ok"], true);
            for (kind, count) in [("reach", 8), ("held-back", 8), ("random", 4)] {
                assert_eq!(summary["kinds"][kind]["ticks"], count);
            }
            for key in ["certificate", "dx", "dviol"] {
                assert!(summary["all"][key]["value"].as_f64() < Some(1e-8), "{}", summary["all"]);
            }
            let us = &summary["all"]["us"];
            assert!(us["median"].as_f64() <= us["p99"].as_f64() && us["p99"].as_f64() <= us["max"].as_f64());
        }
    }
}

#[test]
fn a_wrong_answer_in_the_file_is_seen() {
    let ticks = std::fs::read_to_string(root().join(EXAMPLE)).expect("readable");
    let mut ticks = lines(&ticks);
    ticks[3]["x"][2] = serde_json::json!(numbers(&ticks[3]["x"])[2] + 0.125);
    ticks[5]["viol"][1] = serde_json::json!(numbers(&ticks[5]["viol"])[1] + 0.5);
    let input: String = ticks.iter().map(|t| format!("{t}\n")).collect();
    let out = hierarq(&["solve", "-", "--json"], input.as_bytes());
    let summary: Value = serde_json::from_slice(&out.stdout).expect("JSON");
    for (key, tick, by) in [("dx", 3, 0.125), ("dviol", 5, 0.5)] {
        assert!((summary["all"][key]["value"].as_f64().expect("a number") - by).abs() < 1e-8);
        assert_eq!(summary["all"][key]["id"], ticks[tick]["id"]);
    }
}

#[test]
fn bad_lines_are_refused_one_by_one_and_the_rest_is_solved() {
    let mut input = Vec::new();
    for bad in BAD {
        input.extend(format!("{bad}\n{GOOD}\r\n\n").bytes());
    }
    input.extend(b"{\"id\":\"\xff\",\"n\":1,\"levels\":[]}\n");
    input.extend(GOOD.bytes()); // without an end of line
    let path = fresh("answers-bad.jsonl");
    let name = path.to_str().expect("UTF-8");
    let out = hierarq(&["solve", "-", "--answers", name], &input);
    assert_eq!(out.status.code(), Some(1));
    let refusals = text(&out.stderr);
    assert_eq!(refusals.lines().count(), BAD.len() + 1, "{refusals}");
    insta::assert_snapshot!("refusals", refusals);
    assert!(text(&out.stdout).contains(&format!("{} refused", BAD.len() + 1)), "{}", text(&out.stdout));
    let answers = lines(&std::fs::read_to_string(&path).expect("written"));
    assert_eq!(answers.len(), BAD.len() + 1);
    for answer in answers {
        let x = numbers(&answer["x"]);
        // The smallest of the points with |x| <= 1 and x + y = 3.
        assert!((x[0] - 1.0).abs() < 1e-12 && (x[1] - 2.0).abs() < 1e-12, "{x:?}");
        assert_eq!(answer["status"], "optimal");
    }

    let out = hierarq(&["solve", "-", "--json"], &input);
    let summary: Value = serde_json::from_slice(&out.stdout).expect("JSON");
    assert_eq!(out.status.code(), Some(1));
    assert_eq!((&summary["ok"], &summary["refused"]), (&Value::from(false), &Value::from(BAD.len() + 1)));
    assert_eq!(summary["refusals"][1]["line"], 4);
    assert!(text(&out.stderr).is_empty(), "{}", text(&out.stderr));
}

#[test]
fn what_a_hard_level_forbids_is_infeasible_and_the_rest_is_proven() {
    let hard = r#"{"id":"h","n":1,"levels":[{"A":[[1]],"lo":[1],"up":[1],"hard":true},{"A":[[2]],"lo":[5],"up":[6],"hard":true},{"A":[[1]],"lo":[9],"up":[9]}]}"#;
    for backend in ["active_set", "clarabel"] {
        let path = fresh(&format!("answers-hard-{backend}.jsonl"));
        let name = path.to_str().expect("UTF-8");
        let out = hierarq(&["solve", "-", "--backend", backend, "--answers", name], hard.as_bytes());
        assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
        assert!(text(&out.stdout).contains("1 infeasible"), "{}", text(&out.stdout));
        let answer = &lines(&std::fs::read_to_string(&path).expect("written"))[0];
        assert_eq!(answer["status"], "infeasible");
        assert!((numbers(&answer["x"])[0] - 1.0).abs() < 1e-12);
        for (is, should) in numbers(&answer["viol"]).iter().zip([0.0, 3.0, 8.0]) {
            assert!((is - should).abs() < 1e-12, "{answer}");
        }
    }
}

#[test]
fn files_that_are_not_there_not_problems_or_not_to_be_overwritten() {
    let missing = hierarq(&["solve", "no/such.jsonl"], b"");
    assert_eq!(missing.status.code(), Some(1));
    assert!(text(&missing.stderr).contains("cannot read no/such.jsonl"), "{}", text(&missing.stderr));

    let empty = hierarq(&["solve", "-"], b"\n \n");
    assert_eq!(empty.status.code(), Some(1));
    assert!(text(&empty.stderr).contains("contains no problems"), "{}", text(&empty.stderr));

    let path = fresh("own.jsonl");
    std::fs::write(&path, GOOD).expect("writable");
    let name = path.to_str().expect("UTF-8");
    let same = hierarq(&["solve", name, "--answers", name], b"");
    assert_eq!(same.status.code(), Some(2));
    assert_eq!(std::fs::read_to_string(&path).expect("readable"), GOOD, "nothing of the user's is lost");

    let blocked = path.join("below/a/file");
    let out = hierarq(&["solve", name, "--answers", blocked.to_str().expect("UTF-8")], b"");
    assert_eq!(out.status.code(), Some(2));
    assert!(text(&out.stderr).contains("cannot write"), "{}", text(&out.stderr));
    assert_eq!(hierarq(&["solve"], b"").status.code(), Some(2));
}

/// Lines that would need gigabytes in a reader without limits, in a process with limited memory.
#[test]
#[cfg(target_os = "linux")]
fn memory_is_bounded() {
    let huge = 40 << 20;
    let mut input = vec![b'['; huge];
    input.push(b'\n');
    let mut long = |head: &str, part: &str, tail: &str| {
        input.extend(head.bytes());
        input.extend(part.repeat((15 << 20) / part.len()).bytes());
        input.extend(tail.bytes());
        input.push(b'\n');
    };
    let level = r#"{"id":"a","n":1,"levels":[{"A":[],"lo":[],"up":[]}"#;
    long(level, r#",{"A":[],"lo":[],"up":[]}"#, "]}");
    long(r#"{"id":"a","n":1,"levels":[{"A":[[0"#, "],[0", "]]}]}");
    long(r#"{"id":"a","n":1,"levels":[{"A":[[0"#, ",0", "]]}]}");
    long(r#"{"id":"a","n":1,"levels":[{"lo":[0"#, ",0", "]}]}");
    long(r#"{"id":"a","n":1,"levels":[],"x":[0"#, ",0", "]}");
    long(r#"{"id":"a","n":1,"levels":[],"note":"#, "[", "");
    long(r#"{"id":""#, "a", r#"","n":1,"levels":[]}"#);
    input.extend(br#"{"id":"a","n":1000000000,"levels":[{"A":{"identity":1},"lo":[],"up":[]}]}"#);
    input.extend(format!("\n{GOOD}\n").bytes());
    let mut child = Command::new("sh")
        .args(["-c", "ulimit -v 300000; exec \"$0\" solve - --json", env!("CARGO_BIN_EXE_hierarq")])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("a shell");
    let mut stdin = child.stdin.take().expect("a pipe");
    let writer = std::thread::spawn(move || drop(stdin.write_all(&input)));
    let out = child.wait_with_output().expect("it ends");
    writer.join().expect("written");
    assert_eq!(out.status.code(), Some(1), "{}", text(&out.stderr));
    let summary: Value = serde_json::from_slice(&out.stdout).expect("JSON");
    let refused: Vec<u64> =
        summary["refusals"].as_array().expect("a list").iter().map(|r| r["line"].as_u64().expect("a number")).collect();
    assert_eq!(refused, [1, 2, 3, 4, 5, 6, 7, 8, 9]);
    assert_eq!(summary["all"]["ticks"], 1);
}

/// Damages a line: a byte removed, changed or doubled, or a number replaced by an extreme one.
fn damaged(line: &str, dice: &mut Dice) -> Vec<u8> {
    let mut bytes = line.as_bytes().to_vec();
    let at = dice.below(bytes.len());
    match dice.below(5) {
        0 => drop(bytes.remove(at)),
        1 => bytes[at] = b" ,:[]{}\"0e-."[dice.below(12)],
        2 => bytes[at] = dice.below(256) as u8,
        3 => bytes.truncate(at),
        _ => {
            let end = (at..bytes.len()).find(|i| !b"0123456789.e-".contains(&bytes[*i])).unwrap_or(at);
            let nasty = ["1e308", "-1e308", "1e-320", "NaN", "null", "1e15", "-0", "99999999999999999999", "[]"];
            bytes.splice(at..end, nasty[dice.below(nasty.len())].bytes());
        }
    }
    bytes.retain(|b| *b != b'\n');
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    /// For any damage of a line, the program continues, and solves the next one.
    #[test]
    fn accidents_stay_on_their_line(seed: u64) {
        let example = std::fs::read_to_string(root().join(EXAMPLE)).expect("readable");
        let mut dice = Dice(SplitMix64(seed));
        let mut input = Vec::new();
        for line in example.lines().cycle().take(100) {
            input.extend(damaged(line, &mut dice));
            input.push(b'\n');
        }
        input.extend(GOOD.replace("\"good\"", "\"good\",\"kind\":\"good\"").bytes());
        for backend in ["active_set", "clarabel"] {
            let out = hierarq(&["solve", "-", "--json", "--backend", backend], &input);
            prop_assert!(matches!(out.status.code(), Some(0 | 1)), "{}", text(&out.stderr));
            prop_assert!(!text(&out.stderr).contains("panicked"), "{}", text(&out.stderr));
            let summary: Value = serde_json::from_slice(&out.stdout).expect("JSON");
            prop_assert_eq!(&summary["kinds"]["good"]["ticks"], 1);
            prop_assert!(summary["kinds"]["good"]["certificate"]["value"].as_f64() < Some(1e-8));
        }
    }
}

#[test]
fn bench_measures_the_loop_and_every_solver() {
    let out = hierarq(&["bench", "examples/safety_tasks.hq", "--ticks", "30", "--json"], b"");
    assert_eq!(out.status.code(), Some(0), "{}", text(&out.stderr));
    let data: Value = serde_json::from_slice(&out.stdout).expect("JSON");
    assert_eq!((&data["ticks"], &data["ok"], &data["fault"]), (&Value::from(30), &Value::from(true), &Value::Null));
    for us in [&data["kinematics_and_rows_us"], &data["tick"]["us"]] {
        assert!(us["median"].as_f64() > Some(0.0) && us["median"].as_f64() <= us["max"].as_f64());
    }
    for solver in ["active_set", "active_set_cold", "clarabel"] {
        let s = &data["solve"][solver];
        assert!(s["us"]["median"].as_f64() > Some(0.0) && s["ratio_to_clarabel"].as_f64() > Some(0.0), "{s}");
        assert!(s["dx"].as_f64() < Some(1e-8) && s["failed"] == 0, "{s}");
    }
    assert_eq!(data["solve"]["clarabel"]["ratio_to_clarabel"], 1.0);
    let program = common::program("safety_tasks.hq");
    let (_, problem) =
        runtime::Evaluator::new(&program, program.first_stack().expect("it runs a stack")).expect("it can be executed");
    let levels = data["levels"].as_array().expect("a list");
    assert_eq!(levels.len(), problem.levels.len());
    for (is, should) in levels.iter().zip(&problem.levels) {
        assert_eq!((&is["rows"], &is["hard"]), (&Value::from(should.rows()), &Value::from(should.hard)));
    }

    let table = hierarq(&["bench", "examples/hello.hq", "--ticks", "3"], b"");
    assert_eq!(table.status.code(), Some(0), "{}", text(&table.stderr));
    for word in ["kinematics and rows", "solve, active_set, cold", "solve, clarabel", "whole tick", "limits (hard)"] {
        assert!(text(&table.stdout).contains(word), "{}", text(&table.stdout));
    }
    assert_eq!(hierarq(&["bench", "examples/hello.hq", "--ticks", "0"], b"").status.code(), Some(2));
    assert_eq!(hierarq(&["bench", "examples/no.hq"], b"").status.code(), Some(1));
}

#[test]
fn bench_says_where_a_fault_ended_the_loop() {
    let spec = fresh("fault.hq");
    let body = format!(
        "hierarq 1\nrobot arm {{ urdf \"{}\"  rate 100 Hz  home {{ all [0, 0.4, 0, 1.6, 0, 1.14, 0] rad }} }}\n\
         stack s {{ level motion {{ frame_position(tool) {{ position initial(position)  gain 2 /s * (1 - t/(0.1 s)) }} }} }}\n\
         run {{ duration 1 s }}\n",
        common::example("robots/arm7.urdf").display()
    );
    std::fs::write(&spec, body).expect("writable");
    let out = hierarq(&["bench", spec.to_str().expect("UTF-8"), "--json"], b"");
    assert_eq!(out.status.code(), Some(1), "{}", text(&out.stderr));
    let data: Value = serde_json::from_slice(&out.stdout).expect("JSON");
    let fault = data["fault"].as_str().expect("a fault");
    assert!(fault.contains("`gain`"), "{fault}");
    let ticks = data["ticks"].as_u64().expect("a number");
    assert!((10..=12).contains(&ticks), "the gain leaves its range after 0.1 s: {ticks} ticks");
}

/// The recorded problems of a run are those that it solved: their solutions are the velocities of its log.
#[test]
fn the_problems_of_a_run_are_solved_alike() {
    let (problems, answers, out) = (fresh("problems.jsonl"), fresh("problem_answers.jsonl"), fresh("problems_out"));
    let path = |p: &PathBuf| p.display().to_string();
    let spec = "examples/uncooperative_motion.hq";
    let run = ["run", spec, "--duration", "0.2s", "--out", &path(&out), "--problems", &path(&problems)];
    let ran = hierarq(&run, b"");
    assert!(ran.status.success(), "{}", text(&ran.stderr));
    let solved = hierarq(&["solve", &path(&problems), "--answers", &path(&answers)], b"");
    assert!(solved.status.success(), "{}", text(&solved.stderr));
    let log = std::fs::read_to_string(out.join("log.csv")).expect("a log");
    let mut log = log.lines().map(|l| l.split(',').collect::<Vec<_>>());
    let head = log.next().expect("a head");
    let columns: Vec<usize> = (0..head.len()).filter(|k| head[*k].starts_with("v.")).collect();
    let answers = lines(&std::fs::read_to_string(&answers).expect("answers"));
    assert_eq!(answers.len(), log.clone().count());
    for (answer, row) in answers.iter().zip(log) {
        let v: Vec<f64> = columns.iter().map(|k| row[*k].parse().expect("a number")).collect();
        let x: Vec<f64> = answer["x"].as_array().expect("x").iter().map(|x| x.as_f64().expect("a number")).collect();
        assert_eq!(v.len(), x.len());
        assert!(v.iter().zip(&x).all(|(a, b)| (a - b).abs() < 1e-10), "{v:?} and {x:?}");
    }
    let refused = hierarq(&["run", spec, "--out", &path(&out), "--problems", spec], b"");
    assert_eq!(refused.status.code(), Some(2));
    assert!(text(&refused.stderr).contains("would overwrite"), "{}", text(&refused.stderr));
}
