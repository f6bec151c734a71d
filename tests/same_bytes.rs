//! The same inputs give the same bytes: in any folder, under any locale and time zone, with any number of threads, and
//! in a debug build and a release build. `HIERARQ_OTHER_BUILD=target/release/hierarq cargo test --test it same_bytes`
//! compares with that build too; `.ci/run` does so. Times of ticks are left out, since they are not reproducible.

use crate::common::cli;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

/// Folder and environment of a command.
struct Surroundings {
    name: &'static str,
    folder: PathBuf,
    settings: &'static [(&'static str, &'static str)],
    jobs: &'static str,
}

/// Name of a command, its arguments, and its output files. `@` stands for the folder of the examples, `%` for a folder
/// of its own.
const COMMANDS: &[(&str, &[&str], &[&str])] = &[
    ("a compiled program", &["compile", "@/harvesting.hq", "--format", "json"], &[]),
    ("a compiled program of YAML", &["compile", "@/beside_harvest.yaml", "--format", "json"], &[]),
    ("a compiled mission", &["compile", "@/vineyard_picker.hq", "--format", "json"], &[]),
    ("a program in words", &["compile", "@/tested.hq"], &[]),
    ("the other syntax", &["fmt", "@/tested.hq", "--to", "yaml"], &[]),
    ("a picture of a machine", &["graph", "@/harvesting.hq", "--format", "svg"], &[]),
    (
        "a schedule",
        &["plan", "@/vineyard_picker.hq", "--json", "--gantt", "%/gantt.svg", "--map", "%/map.svg"],
        &["gantt.svg", "map.svg"],
    ),
    ("layers", &["plan", "@/letters.hq", "letter_d", "--json"], &[]),
    ("a prompt", &["context", "@/letters.hq", "letter_d", "--prompt"], &[]),
    ("a run", &["run", "@/hello.hq", "--out", "%"], &["log.csv", "summary.json"]),
    ("a log in MCAP", &["run", "@/hello.hq", "--duration", "1s", "--out", "%", "--log", "mcap"], &["log.mcap"]),
    (
        "problems",
        &["run", "@/hello.hq", "--duration", "1s", "--out", "%", "--problems", "%/ticks.jsonl"],
        &["ticks.jsonl"],
    ),
    (
        "a scenario with noise",
        &["run", "@/tested.hq", "--scenario", "found at second sight", "--out", "%"],
        &["log.csv", "summary.json"],
    ),
    (
        "a scenario of a mission",
        &["run", "@/letters_day.hq", "--scenario", "people are no machines", "--out", "%"],
        &["log.csv", "summary.json", "report.html"],
    ),
    (
        "results of tests",
        &["test", "@/tested.hq", "@/letters_day.hq", "--json", "--junit", "%/junit.xml"],
        &["junit.xml"],
    ),
    (
        "a sweep",
        &[
            "sweep",
            "@/tested.hq",
            "--scenario",
            "found at second sight",
            "--vary",
            "near=2mm..8mm",
            "--runs",
            "9",
            "--jobs",
            "#",
            "--out",
            "%/sweep.parquet",
        ],
        &["sweep.parquet"],
    ),
    ("answers of the solver", &["solve", "@/ticks/small.jsonl", "--answers", "%/answers.jsonl"], &["answers.jsonl"]),
];

/// Removes values measured with a clock, and paths of files, from JSON.
fn without_times(value: &mut Value) {
    match value {
        Value::Object(entries) => {
            entries.retain(|key, _| !matches!(key.as_str(), "tick_us" | "us" | "outputs" | "planning_s" | "seconds"));
            entries.values_mut().for_each(without_times);
        }
        Value::Array(items) => items.iter_mut().for_each(without_times),
        _ => {}
    }
}

/// Returns the compared part of a file or an output.
fn compared(bytes: Vec<u8>, folder: &Path) -> Vec<u8> {
    let Ok(text) = String::from_utf8(bytes.clone()) else { return bytes };
    let text = text.replace(&folder.display().to_string(), "%");
    let json = |line: &str| serde_json::from_str::<Value>(line).ok();
    if let Some(mut value) = json(&text) {
        without_times(&mut value);
        return value.to_string().into_bytes();
    }
    let lines = text.lines().map(|line| match json(line) {
        Some(mut value @ Value::Object(_)) => {
            without_times(&mut value);
            value.to_string()
        }
        _ => line.to_string(),
    });
    lines.collect::<Vec<_>>().join("\n").into_bytes()
}

/// Returns all outputs of the commands, by name.
fn everything(program: &Path, around: &Surroundings, out: &Path) -> BTreeMap<String, Vec<u8>> {
    let examples = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").display().to_string();
    let mut all = BTreeMap::new();
    for (i, (name, arguments, files)) in COMMANDS.iter().enumerate() {
        let own = out.join(i.to_string());
        std::fs::create_dir_all(&own).expect("writable");
        let mut command = Command::new(program);
        for argument in *arguments {
            let argument = argument.replacen('@', &examples, 1).replacen('%', &own.display().to_string(), 1);
            command.arg(if argument == "#" { around.jobs } else { &argument });
        }
        command.current_dir(&around.folder).env("NO_COLOR", "1").env("COLUMNS", "100").env("HIERARQ_HIGHS", "/nowhere");
        command.env_remove("HIERARQ_API_KEY").envs(around.settings.iter().copied());
        let output = command.output().expect("the binary runs");
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{name}, {}: {told}", around.name);
        // The standard output of a run and of a sweep is about times and paths.
        if !matches!(arguments[0], "run" | "sweep" | "solve") {
            all.insert((*name).to_string(), compared(output.stdout, &own));
        }
        for file in *files {
            let bytes = std::fs::read(own.join(file)).unwrap_or_else(|e| panic!("{name}: {file}: {e}"));
            assert!(!bytes.is_empty(), "{name}: {file} is empty");
            all.insert(format!("{name}: {file}"), compared(bytes, &own));
        }
    }
    all
}

/// Returns the first difference of two texts, with a few characters around it.
fn parting(a: &[u8], b: &[u8]) -> String {
    let at = a.iter().zip(b).position(|(x, y)| x != y).unwrap_or(a.len().min(b.len()));
    let shown = |bytes: &[u8]| {
        let (from, to) = (at.saturating_sub(60).min(bytes.len()), (at + 60).min(bytes.len()));
        String::from_utf8_lossy(&bytes[from..to]).into_owned()
    };
    format!("at byte {at}: `{}` and `{}`", shown(a), shown(b))
}

#[test]
fn the_same_inputs_give_the_same_bytes() {
    let folder = cli::folder("same_bytes");
    let deep = folder.join("a folder of é and blanks");
    std::fs::create_dir_all(&deep).expect("writable");
    let here =
        |name, folder: &Path, settings, jobs| Surroundings { name, folder: folder.to_path_buf(), settings, jobs };
    let all = [
        here("at home", Path::new(env!("CARGO_MANIFEST_DIR")), &[("LC_ALL", "C"), ("TZ", "UTC")], "1"),
        here("in Germany", &deep, &[("LC_ALL", "de_DE.UTF-8"), ("LANG", "de_DE.UTF-8"), ("TZ", "Asia/Kathmandu")], "2"),
        here(
            "in Turkey",
            Path::new("/"),
            &[("LC_ALL", "tr_TR.UTF-8"), ("LC_NUMERIC", "tr_TR.UTF-8"), ("TZ", "America/St_Johns")],
            "5",
        ),
    ];
    let own = Path::new(env!("CARGO_BIN_EXE_hierarq"));
    let first = everything(own, &all[0], &folder.join("0"));
    let mut wrong = Vec::new();
    let mut compare = |with: &str, other: &BTreeMap<String, Vec<u8>>| {
        assert!(first.keys().eq(other.keys()));
        for (name, bytes) in first.iter().filter(|(name, bytes)| other[*name] != **bytes) {
            wrong.push(format!("{name}, {with}: {}", parting(bytes, &other[name])));
        }
    };
    for (i, around) in all.iter().enumerate().skip(1) {
        compare(around.name, &everything(own, around, &folder.join(i.to_string())));
    }
    if let Some(other) = std::env::var_os("HIERARQ_OTHER_BUILD") {
        let other = Path::new(env!("CARGO_MANIFEST_DIR")).join(other);
        compare("another build", &everything(&other, &all[0], &folder.join("other")));
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
