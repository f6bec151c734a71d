//! Common parts of whole-program tests: examples, compilation, and a recorder of every tick.

#![allow(dead_code, reason = "each test binary uses a part of it")]

pub mod cli;
pub mod played;
pub mod reckoner;
pub mod sources;

use std::path::{Path, PathBuf};

use hierarq::project::{Settings, compile};
use runtime::expect::Outcome;
use runtime::program::ScenarioProgram;
use runtime::record::All;
use runtime::record::summary::{Summary, SummaryRecorder};
use runtime::{Evaluator, ExpectationMonitors, Fault, Program, Recorder, Simulation, Tick};

/// Stems of the examples; each exists in both syntaxes.
pub const EXAMPLES: &[&str] = &[
    "hello",
    "safety_tasks",
    "uncooperative_motion",
    "cooperative_motion",
    "swivel_angle",
    "own_tasks",
    "balance",
    "stance",
    "smooth",
    "dexterity",
    "both_arms",
    "compliance",
    "tested",
    "bystander",
    "covered",
    "postures",
    "nearness",
    "protective_stop",
    "enabled",
    "screwdriver",
    "admittance",
    "hand_guiding",
    "harvesting",
    "trajectories",
    "safety_planner",
    "give_way",
    "beside_harvest",
    "picker",
    "carrier",
    "completion",
    "on_ros",
    "regions",
    "room",
    "cloud",
    "hook",
    "free_flyer",
    "rover",
    "handover",
    "delivery",
];

/// Stems of the examples that declare missions without a robot; each exists in both syntaxes.
pub const MISSIONS: &[&str] = &[
    "vineyard",
    "vineyard_day",
    "vineyard_picker",
    "letters",
    "letters_day",
    "supermarket",
    "panel",
    "hazards",
    "lab",
    "reminders",
    "tokens",
    "errands",
    "beside_anna",
    "sparse_targets",
    "grouped_targets",
];

/// Computes the velocity of a link in the world (m/s), by central differences of its position.
pub fn velocity_by_differences(tick: &Tick, link: &str) -> nalgebra::Vector3<f64> {
    let model = tick.controller.evaluator().model();
    let (mut data, link) = (robot::Data::new(model), model.link(link).expect("a link"));
    let mut place = |seconds: f64| {
        let mut q = tick.q.to_vec();
        model.integrate(&mut q, tick.v, seconds);
        model.forward(&q, &mut data);
        data.pose(link).translation.vector
    };
    (place(1e-5) - place(-1e-5)) / 2e-5
}

/// Runs a scenario in its world, and shows each tick to a recorder.
pub fn record(program: &Program, scenario: &ScenarioProgram, with: &mut dyn Recorder) {
    let program = scenario.program(program);
    let mut simulation = Simulation::in_world(&program, scenario).expect("it can be executed");
    simulation.run(with, &mut || 0.0, &mut |_| true).expect("no recorder fails");
}

/// Records a run of the first scenario.
pub fn recorded<R: Recorder + Default>(program: &Program) -> R {
    let mut recorder = R::default();
    record(program, &program.scenarios[0], &mut recorder);
    recorder
}

/// Runs a scenario in its world with another recorder; returns the summary, and the outcomes of the expectations.
pub fn judged(program: &Program, scenario: &ScenarioProgram, with: &mut dyn Recorder) -> (Summary, Vec<Outcome>) {
    let program = scenario.program(program);
    let mut simulation = Simulation::in_world(&program, scenario).expect("it can be executed");
    let ticks = simulation.ticks();
    let mut monitors = ExpectationMonitors::new(&program, scenario, ticks).expect("it can be judged");
    let mut summary = SummaryRecorder::new(simulation.controller(), ticks);
    let mut all = All(vec![&mut monitors, &mut summary, with]);
    simulation.run(&mut all, &mut || 0.0, &mut |_| true).expect("no recorder fails");
    (summary.summary(&program, simulation.controller(), Vec::new()), monitors.finish())
}

/// Checks that every expectation of the first scenario holds.
pub fn holds(program: &Program) {
    let scenario = &program.scenarios[0];
    let (_, outcomes) = judged(program, scenario, &mut All(Vec::new()));
    for (outcome, e) in outcomes.iter().zip(&scenario.expectations) {
        assert_eq!(format!("{:?}", outcome.verdict), "Holds", "{}", e.title());
    }
}

/// Returns the least of some numbers.
pub fn least(numbers: &[f64]) -> f64 {
    numbers.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Returns the path of a file in the `examples` folder.
pub fn example(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples").join(name)
}

/// Writes a URDF to a new file.
pub fn urdf_file(urdf: &str, name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("urdf");
    std::fs::create_dir_all(&folder).expect("writable");
    let path = folder.join(format!("{name}.urdf"));
    std::fs::write(&path, urdf).expect("writable");
    path
}

/// Compiles an example; panics with the diagnostics on failure.
pub fn program(name: &str) -> Program {
    let compiled = compile(&example(name), &Settings::default());
    compiled.program.unwrap_or_else(|| panic!("{}", compiled.report.render(compiler::Style::Plain, 100)))
}

/// Compiles a text, with `examples` as its folder; panics with the diagnostics on failure.
pub fn program_of(text: &str) -> Program {
    program_in(text, dsl::Syntax::Native)
}

/// As [`program_of`] in either syntax.
pub fn program_in(text: &str, syntax: dsl::Syntax) -> Program {
    let folder = example("");
    let compiled = compiler::compile(&compiler::Input {
        name: "test.hq",
        text,
        syntax,
        folder: &folder,
        set: &[],
        package_paths: &[],
    });
    compiled.program.unwrap_or_else(|| panic!("{}", compiled.report.render(compiler::Style::Plain, 100)))
}

/// One recorded tick.
#[derive(Clone, Debug)]
pub struct Sample {
    pub time: f64,
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub command: Vec<f64>,
    pub margins: Vec<f64>,
    pub measures: Vec<f64>,
    pub fault: Option<Fault>,
}

/// Records every tick.
#[derive(Default)]
pub struct Everything(pub Vec<Sample>);

impl Recorder for Everything {
    fn tick(&mut self, t: &Tick) -> std::io::Result<()> {
        self.0.push(Sample {
            time: t.time,
            q: t.q.to_vec(),
            v: t.v.to_vec(),
            command: t.command.to_vec(),
            margins: t.evaluator.margins().to_vec(),
            measures: t.evaluator.measures().to_vec(),
            fault: t.fault,
        });
        Ok(())
    }
}

/// Runs a program to its end.
pub fn run(program: &Program) -> Vec<Sample> {
    let mut simulation = Simulation::new(program).expect("a compiled program can be executed");
    let mut all = Everything::default();
    simulation.run(&mut all, &mut || 0.0, &mut |_| true).expect("memory does not fail");
    all.0
}

/// Returns the evaluator of a program's run stack, for names and indices of rows.
pub fn evaluator(program: &Program) -> Evaluator {
    Evaluator::new(program, program.first_stack().expect("it runs a stack"))
        .expect("a compiled program can be executed")
        .0
}
