//! Scenarios of missions from texts, and the logs of their runs.

use std::path::Path;

use compiler::{Compiled, Input};
use dsl::Syntax;
use hierarq::scenario_runner::{self, Found};
use runtime::missions::csv::MissionCsv;
use runtime::missions::{LogEntry, MissionRun};
use runtime::program::{MissionProgram, MissionScenarioProgram};

/// Compiles a spec with missions only.
pub fn compiled(text: &str) -> Compiled {
    let folder = Path::new("");
    compiler::compile(&Input { name: "spec.hq", text, syntax: Syntax::Native, folder, set: &[], package_paths: &[] })
}

/// Compiles a spec as if it were in a folder.
pub fn compiled_in(folder: &Path, text: &str) -> Compiled {
    compiler::compile(&Input { name: "day.hq", text, syntax: Syntax::Native, folder, set: &[], package_paths: &[] })
}

/// Returns the scenario `s` of a spec without diagnostics, and its mission.
pub fn scenario(text: &str) -> (MissionProgram, MissionScenarioProgram) {
    let compiled = compiled(text);
    assert_eq!(compiled.report.diagnostics.len(), 0, "{}\n{text}", compiled.report.to_json());
    found(&compiled)
}

/// Returns the scenario `s` of a compiled spec without errors, and its mission.
pub fn found(compiled: &Compiled) -> (MissionProgram, MissionScenarioProgram) {
    assert_eq!(compiled.report.errors(), 0, "{}", compiled.report.to_json());
    match scenario_runner::find(None, &compiled.missions, "s") {
        Ok(Found::Mission(mission, scenario)) => (mission.clone(), scenario.clone()),
        _ => panic!("a scenario"),
    }
}

/// Runs a scenario; returns the run with the bytes of its log.
pub fn logged(mission: &MissionProgram, scenario: &MissionScenarioProgram) -> (MissionRun, Vec<u8>) {
    let mut bytes = Vec::new();
    let mut csv = MissionCsv::new(&mut bytes);
    let run = runtime::missions::run(mission, scenario, &mut csv, &mut |_| true).expect("a run");
    csv.finish().expect("a log");
    (run, bytes)
}

/// Parses the header and the rows of a log.
pub fn table(bytes: Vec<u8>) -> (Vec<String>, Vec<Vec<String>>) {
    let text = String::from_utf8(bytes).expect("a text");
    let mut lines = text.lines().map(|l| l.split(',').map(str::to_string).collect::<Vec<_>>());
    (lines.next().expect("a header"), lines.collect())
}

/// Returns the cells of a column.
pub fn cells<'r>(header: &[String], rows: &'r [Vec<String>], name: &str) -> Vec<&'r str> {
    let at = header.iter().position(|h| h == name).expect("a column");
    rows.iter().map(|r| r[at].as_str()).collect()
}

/// Returns the numbers of a column.
pub fn numbers(header: &[String], rows: &[Vec<String>], name: &str) -> Vec<f64> {
    cells(header, rows, name).into_iter().map(|cell| cell.parse().expect("a number")).collect()
}

/// Returns the number of records that are events of a scenario: `NAME is late by 5 s`, `NAME is lost`, ...
pub fn events(happened: &[LogEntry], names: &[&str]) -> usize {
    let is_event = |what: &str| {
        let ends = |of: &str| names.iter().any(|name| what == format!("the {of} of {name} fails"));
        let says = |(name, rest): (&str, &str)| {
            let begins = ["is late by ", "moves to "].iter().any(|words| rest.starts_with(words));
            names.contains(&name) && (begins || ["is lost", "is back", "is done"].contains(&rest))
        };
        ends("service") || ends("task") || what.split_once(' ').is_some_and(says)
    };
    happened.iter().filter(|h| is_event(&h.what)).count()
}
