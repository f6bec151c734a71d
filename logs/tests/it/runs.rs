//! Runs of examples with a log in MCAP and one in CSV.

use std::path::Path;

use ::runs::project::{self, Settings};
use ::runs::scenario_runner::of_controller;
use hierarq_logs::{About, Finished, McapRecorder, Origin, Overflow, SourceText};
use runtime::program::ScenarioProgram;
use runtime::record::All;
use runtime::record::csv::CsvRecorder;
use runtime::{Program, Simulation};

/// A run with both logs.
pub struct Recorded {
    pub program: Program,
    pub scenario: Option<ScenarioProgram>,
    pub about: About,
    pub mcap: Vec<u8>,
    pub csv: String,
}

/// Compiles an example for a run of so many seconds.
pub fn compiled(name: &str, scenario: Option<&str>, seconds: f64) -> (Program, Option<ScenarioProgram>, String) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples").join(name);
    let compiled = project::load(&path, &Settings::default());
    let mut program = compiled.program.expect("the example has a robot");
    let mut scenario = scenario.map(|name| of_controller(&program, name).expect("a scenario").clone());
    scenario.as_mut().map_or(&mut program.run, |s| &mut s.run).duration = seconds;
    if let Some(s) = &scenario {
        program = s.program(&program);
    }
    (program, scenario, std::fs::read_to_string(path).expect("the example is text"))
}

/// A simulation of a compiled example.
pub fn simulation(program: &Program, scenario: Option<&ScenarioProgram>) -> Simulation {
    match scenario {
        Some(scenario) => Simulation::in_world(program, scenario),
        None => Simulation::new(program),
    }
    .expect("the example runs")
}

/// Runs an example with both logs.
pub fn recorded(name: &str, scenario: Option<&str>, seconds: f64) -> Recorded {
    let (program, scenario, text) = compiled(name, scenario, seconds);
    let sources = vec![SourceText { name: name.to_string(), text }];
    let about = About::new(&program, scenario.as_ref(), sources, Origin::Run);
    let mut simulation = simulation(&program, scenario.as_ref());
    let mut csv = Vec::new();
    let controller = simulation.controller();
    let mut rows = CsvRecorder::new(&mut csv, &program, controller).expect("memory");
    let mut log = McapRecorder::new(Vec::new(), &about, &program, controller, Overflow::Wait).expect("memory");
    let mut all = All(vec![&mut rows, &mut log]);
    simulation.run(&mut all, &mut || 0.0, &mut |_| true).expect("a run");
    rows.finish().expect("memory");
    let Finished { out, written } = log.finish().expect("memory");
    assert_eq!((written.ticks, written.dropped), (simulation.ticks(), 0));
    Recorded { program, scenario, about, mcap: out, csv: String::from_utf8(csv).expect("text") }
}
