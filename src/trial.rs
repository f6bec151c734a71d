//! Trials: the scenarios of specs, run and judged.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use compiler::Report;
use dsl::tree::{Item, ItemKind};
use dsl::{SourceId, Spelling};
use runtime::program::ScenarioProgram;
use runtime::record::All;
use runtime::record::expectations::{ExpectationRecord, is_good, records};
use runtime::record::summary::{FaultRecord, Summary, SummaryRecorder};
use runtime::{Judge, Program, Simulation};
use serde::Serialize;

use crate::project::{self, Settings};

/// What became of a scenario.
#[derive(Clone, Debug, Serialize)]
pub struct Trial {
    /// The spec.
    pub spec: String,
    /// The scenario.
    pub scenario: String,
    /// True where it went as expected.
    pub ok: bool,
    /// Simulated time, in s.
    pub duration_s: f64,
    /// Faults, in order.
    pub faults: Vec<FaultRecord>,
    /// True where a fault that no transition answers keeps the robot still.
    pub halted: bool,
    /// Limits whose margin fell below zero, by name, where nothing else is expected.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub passed: Vec<String>,
    /// Expectations, in the order written.
    pub expectations: Vec<ExpectationRecord>,
}

/// The scenario of this name.
///
/// # Errors
/// There is none; the message says which there are.
pub fn find<'p>(program: &'p Program, name: &str) -> Result<&'p ScenarioProgram, String> {
    program.scenarios.iter().find(|s| s.name == name).ok_or_else(|| {
        let names = || program.scenarios.iter().map(|s| s.name.as_str());
        let help = match compiler::names::suggest(name, names()) {
            Some(near) => format!("did you mean `{near}`?"),
            None if program.scenarios.is_empty() => "it declares none".to_string(),
            None => format!("it has {}", compiler::names::list(names(), 12)),
        };
        format!("the spec has no scenario `{name}`: {help}")
    })
}

/// The scenario with another seed.
pub fn seeded(scenario: &ScenarioProgram, seed: u64) -> ScenarioProgram {
    let mut scenario = scenario.clone();
    scenario.run.simulator.seed = seed;
    scenario
}

/// A run of a scenario, judged.
#[derive(Clone, Debug)]
pub struct Judged {
    /// What it came to.
    pub summary: Summary,
    /// Expectations, in the order written.
    pub expectations: Vec<ExpectationRecord>,
    /// True where it went as expected.
    pub ok: bool,
}

/// Runs a scenario of a program to its end, or until `go_on` says no at a tick.
///
/// # Errors
/// The program cannot be executed, which a compiled one always can.
pub fn judged(
    program: &Program,
    scenario: &ScenarioProgram,
    go_on: &mut dyn FnMut(usize) -> bool,
) -> Result<Judged, String> {
    let program = scenario.program(program);
    let mut simulation = Simulation::in_world(&program, scenario).map_err(|e| e.to_string())?;
    let ticks = simulation.ticks();
    let mut judge = Judge::new(&program, scenario, ticks).map_err(|e| e.to_string())?;
    let mut statistics = SummaryRecorder::new(simulation.controller(), ticks);
    let mut all = All(vec![&mut judge, &mut statistics]);
    simulation.run(&mut all, &mut || 0.0, go_on).map_err(|e| e.to_string())?;
    let summary = statistics.summary(&program, simulation.controller(), Vec::new());
    let expectations = records(scenario, &judge.finish(), program.robot.period);
    let ok = is_good(scenario, &expectations, &summary);
    Ok(Judged { summary, expectations, ok })
}

/// Runs a scenario of a program.
///
/// # Errors
/// See [`judged`].
pub fn run(spec: &str, program: &Program, scenario: &ScenarioProgram) -> Result<Trial, String> {
    let Judged { summary, expectations, ok } = judged(program, scenario, &mut |_| true)?;
    Ok(Trial {
        spec: spec.to_string(),
        scenario: scenario.name.clone(),
        ok,
        duration_s: summary.duration_s,
        halted: summary.halted,
        passed: if scenario.expectations.is_empty() { passed(&summary) } else { Vec::new() },
        faults: summary.faults,
        expectations,
    })
}

fn passed(summary: &Summary) -> Vec<String> {
    let below = |m: f64| m < -runtime::record::summary::MARGIN_TOLERANCE;
    summary.tasks.iter().filter(|(_, t)| t.min_margin.is_some_and(below)).map(|(name, _)| name.clone()).collect()
}

/// The specs of some files and folders: of a folder, all below it that declare scenarios.
///
/// # Errors
/// A folder cannot be read.
pub fn specs(paths: &[PathBuf]) -> std::io::Result<Vec<PathBuf>> {
    let mut all = Vec::new();
    for path in paths {
        if path.is_dir() { below(path, &mut all)? } else { all.push(path.clone()) }
    }
    Ok(all)
}

fn below(folder: &Path, all: &mut Vec<PathBuf>) -> std::io::Result<()> {
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder)?.map(|e| e.map(|e| e.path())).collect::<std::io::Result<_>>()?;
    entries.sort();
    for path in entries {
        let hidden = path.file_name().is_some_and(|n| n.to_string_lossy().starts_with('.'));
        // A link could lead round in a circle.
        if hidden || path.is_symlink() {
            continue;
        }
        if path.is_dir() {
            below(&path, all)?;
        } else if Spelling::of_path(&path).is_some() && declares_scenarios(&path) {
            all.push(path);
        }
    }
    Ok(())
}

fn declares_scenarios(path: &Path) -> bool {
    fn is_one(item: &Item) -> bool {
        match &item.kind {
            ItemKind::Scenario(_) => true,
            ItemKind::For(repeat) => repeat.body.iter().any(is_one),
            _ => false,
        }
    }
    let Ok((spelling, text)) = project::read(path) else { return false };
    dsl::parse(SourceId(0), &text, spelling).0.items.iter().any(is_one)
}

/// A spec that was compiled for its scenarios.
pub struct Tested {
    /// The spec, as the user named it.
    pub spec: String,
    /// What the compiler said.
    pub report: Report,
    /// The program, where there is one.
    pub program: Option<Program>,
}

/// All elements worked on by all processors, in their order.
pub(crate) fn in_parallel<T: Sync, R: Send>(all: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<(usize, R)>> = Mutex::new(Vec::new());
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(all.len());
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some((i, item)) = {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    all.get(i).map(|item| (i, item))
                } {
                    let result = work(item);
                    if let Ok(mut done) = done.lock() {
                        done.push((i, result));
                    }
                }
            });
        }
    });
    let mut done = done.into_inner().unwrap_or_default();
    done.sort_by_key(|d| d.0);
    done.into_iter().map(|d| d.1).collect()
}

/// Compiles specs, several at once.
pub fn compiled(specs: &[PathBuf], settings: &Settings) -> Vec<Tested> {
    in_parallel(specs, |path| {
        let compiled = project::load(path, settings);
        Tested { spec: path.display().to_string(), report: compiled.report, program: compiled.program }
    })
}

/// Runs the scenarios of specs, several at once; only those of this name where one is given, and with this seed instead
/// of their own.
///
/// # Errors
/// A program cannot be executed, which a compiled one always can.
pub fn all(specs: &[Tested], name: Option<&str>, seed: Option<u64>) -> Result<Vec<Trial>, String> {
    let scenarios = |t: &'_ Tested| t.program.iter().flat_map(|p| &p.scenarios).count();
    let chosen: Vec<(&Tested, usize)> = specs.iter().flat_map(|t| (0..scenarios(t)).map(move |i| (t, i))).collect();
    let wanted = |(t, i): &(&Tested, usize)| {
        let program = t.program.as_ref()?;
        let scenario = program.scenarios.get(*i).filter(|s| name.is_none_or(|n| s.name == n))?;
        match seed {
            None => Some(run(&t.spec, program, scenario)),
            Some(seed) => Some(run(&t.spec, program, &seeded(scenario, seed))),
        }
    };
    in_parallel(&chosen, wanted).into_iter().flatten().collect()
}
