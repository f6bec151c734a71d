//! Executes the scenarios of specs, and evaluates their expectations.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use compiler::Report;
use dsl::tree::{Item, ItemKind};
use dsl::{SourceId, Syntax};
use mission::parallel;
use runtime::missions::{End, MissionSummary, RejectedEvent, WorkerRecord};
use runtime::physics::PlantRecord;
use runtime::program::{MissionProgram, MissionScenarioProgram, ScenarioProgram};
use runtime::record::All;
use runtime::record::expectations::{ExpectationRecord, is_good, records};
use runtime::record::joint_motion::JointMotion;
use runtime::record::summary::{FaultRecord, Summary, SummaryRecorder};
use runtime::{ExpectationMonitors, Program, Simulation};
use serde::Serialize;

use crate::project::{self, Settings};

/// Maximum seed, as in a spec.
pub const MAX_SEED: u64 = 9_000_000_000_000_000;

/// Result of a scenario.
#[derive(Clone, Debug, Serialize)]
pub struct ScenarioResult {
    /// Name of the spec.
    pub spec: String,
    /// Name of the scenario.
    pub scenario: String,
    /// True if all results are as expected.
    pub ok: bool,
    /// Simulated time, in s.
    pub duration_s: f64,
    /// Faults, in order.
    pub faults: Vec<FaultRecord>,
    /// True if at the end a fault without an answer keeps the robot still.
    pub halted: bool,
    /// Reason why the run ended early: the simulation of its robot has diverged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diverged: Option<String>,
    /// The physics that moved the robot, if it had masses.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plant: Option<PlantRecord>,
    /// Names of limits whose margin fell below zero, if nothing else is expected.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub passed: Vec<String>,
    /// Joints whose velocity jumped or reversed, by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub rough: BTreeMap<String, JointMotion>,
    /// Result of the mission, if one was executed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mission: Option<MissionResult>,
    /// Expectations, in the order written.
    pub expectations: Vec<ExpectationRecord>,
}

/// Result of a mission that a scenario executed.
#[derive(Clone, Debug, Serialize)]
pub struct MissionResult {
    /// Name of the mission.
    pub name: String,
    /// Reason of the end.
    pub end: End,
    /// Events that were rejected at their time.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rejected_events: Vec<RejectedEvent>,
    /// Results specific to the kind of mission; `None` without a plan.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub outcome: Option<serde_json::Value>,
    /// Working robots that ran controllers.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub workers: Vec<WorkerRecord>,
    /// Failures other than expectations: time (s), if any, and description.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub trouble: Vec<(Option<f64>, String)>,
}

/// A scenario of a spec.
#[derive(Clone, Copy, Debug)]
pub enum Found<'p> {
    /// A run of the robot's controller.
    Controller(&'p Program, &'p ScenarioProgram),
    /// An execution of a mission.
    Mission(&'p MissionProgram, &'p MissionScenarioProgram),
}

impl<'p> Found<'p> {
    /// Returns the name of the scenario.
    pub fn name(self) -> &'p str {
        match self {
            Found::Controller(_, s) => &s.name,
            Found::Mission(_, s) => &s.name,
        }
    }
}

/// Returns all scenarios of a spec: those of its controller, then those of each mission.
pub fn scenarios<'p>(
    program: Option<&'p Program>,
    missions: &'p [MissionProgram],
) -> impl Iterator<Item = Found<'p>> + Clone {
    let controllers = program.into_iter().flat_map(|p| p.scenarios.iter().map(move |s| Found::Controller(p, s)));
    controllers.chain(missions.iter().flat_map(|m| m.scenarios.iter().map(move |s| Found::Mission(m, s))))
}

/// Returns the scenario of this name.
///
/// # Errors
/// There is none; the message lists the existing ones.
pub fn find<'p>(program: Option<&'p Program>, missions: &'p [MissionProgram], name: &str) -> Result<Found<'p>, String> {
    let all = || scenarios(program, missions);
    all().find(|s| s.name() == name).ok_or_else(|| {
        let names = || all().map(Found::name);
        let help = match compiler::names::suggest(name, names()) {
            Some(near) => format!("did you mean `{near}`?"),
            None if names().next().is_none() => "it declares none".to_string(),
            None => format!("it has {}", compiler::names::list(names(), 12)),
        };
        format!("the spec has no scenario `{name}`: {help}")
    })
}

/// Returns the scenario of this name, which must be one of a controller.
///
/// # Errors
/// There is none, or it executes a mission; the message says so.
pub fn of_controller<'p>(program: &'p Program, name: &str) -> Result<&'p ScenarioProgram, String> {
    match find(Some(program), &[], name)? {
        Found::Controller(_, scenario) => Ok(scenario),
        Found::Mission(..) => Err(format!("`{name}` executes a mission")),
    }
}

/// Returns the scenario with another seed.
pub fn seeded(scenario: &ScenarioProgram, seed: u64) -> ScenarioProgram {
    let mut scenario = scenario.clone();
    scenario.run.simulator.seed = seed;
    scenario
}

/// An evaluated run of a scenario.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Summary of the run.
    pub summary: Summary,
    /// Expectations, in the order written.
    pub expectations: Vec<ExpectationRecord>,
    /// True if all results are as expected.
    pub ok: bool,
}

/// Runs a scenario of a program to its end, or until `go_on` returns false at a tick.
///
/// # Errors
/// The program cannot be executed, which never happens for a compiled one.
pub fn judged(
    program: &Program,
    scenario: &ScenarioProgram,
    go_on: &mut dyn FnMut(usize) -> bool,
) -> Result<Judged, String> {
    let program = scenario.program(program);
    let mut simulation = Simulation::in_world(&program, scenario).map_err(|e| e.to_string())?;
    let ticks = simulation.ticks();
    let mut monitors = ExpectationMonitors::new(&program, scenario, ticks).map_err(|e| e.to_string())?;
    let mut statistics = SummaryRecorder::new(simulation.controller(), ticks);
    let mut all = All(vec![&mut monitors, &mut statistics]);
    simulation.run(&mut all, &mut || 0.0, go_on).map_err(|e| e.to_string())?;
    let summary = statistics.summary(&program, simulation.controller(), Vec::new());
    let expectations = records(scenario, &monitors.finish(), program.robot.period);
    let ok = is_good(scenario, &expectations, &summary);
    Ok(Judged { summary, expectations, ok })
}

/// Runs a scenario of a program.
///
/// # Errors
/// See [`judged`].
pub fn run(spec: &str, program: &Program, scenario: &ScenarioProgram) -> Result<ScenarioResult, String> {
    let Judged { summary, expectations, ok } = judged(program, scenario, &mut |_| true)?;
    Ok(ScenarioResult {
        spec: spec.to_string(),
        scenario: scenario.name.clone(),
        ok,
        duration_s: summary.duration_s,
        halted: summary.halted,
        passed: if scenario.expectations.is_empty() { passed(&summary) } else { Vec::new() },
        diverged: summary.diverged,
        plant: summary.plant,
        faults: summary.faults,
        rough: summary.joints.into_iter().filter(|(_, j)| j.is_rough()).collect(),
        mission: None,
        expectations,
    })
}

/// Runs a scenario of a mission.
///
/// # Errors
/// It cannot be evaluated, which never happens for a compiled one.
pub fn run_mission(
    spec: &str,
    mission: &MissionProgram,
    scenario: &MissionScenarioProgram,
) -> Result<ScenarioResult, String> {
    let run = runtime::missions::run(mission, scenario, &mut runtime::missions::NullRecorder, &mut |_| true);
    let summary = run.map_err(|e| e.to_string())?.summary;
    let trouble = summary.trouble();
    let MissionSummary { mission, duration_s, ok, end, rejected_events, workers, outcome, expectations, .. } = summary;
    Ok(ScenarioResult {
        spec: spec.to_string(),
        scenario: scenario.name.clone(),
        ok,
        duration_s,
        halted: false,
        diverged: None,
        plant: None,
        passed: Vec::new(),
        faults: Vec::new(),
        rough: BTreeMap::new(),
        mission: Some(MissionResult { name: mission, end, rejected_events, outcome, workers, trouble }),
        expectations,
    })
}

fn passed(summary: &Summary) -> Vec<String> {
    let below = |m: f64| m < -runtime::record::summary::MARGIN_TOLERANCE;
    summary.tasks.iter().filter(|(_, t)| t.min_margin.is_some_and(below)).map(|(name, _)| name.clone()).collect()
}

/// Returns the specs of files and folders: for a folder, all specs below it that declare scenarios.
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
        // A symbolic link may lead into a cycle.
        if hidden || path.is_symlink() {
            continue;
        }
        if path.is_dir() {
            below(&path, all)?;
        } else if Syntax::of_path(&path).is_some() && declares_scenarios(&path) {
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
    let Ok((syntax, text)) = project::read(path) else { return false };
    dsl::parse(SourceId(0), &text, syntax).0.items.iter().any(is_one)
}

/// A spec compiled for its scenarios.
pub struct Tested {
    /// The spec, as named by the user.
    pub spec: String,
    /// Report of the compiler.
    pub report: Report,
    /// The program, if there is one.
    pub program: Option<Program>,
    /// Its missions.
    pub missions: Vec<MissionProgram>,
}

/// Applies `work` to all elements on all processors; returns the results in order.
pub(crate) fn in_parallel<T: Sync, R: Send>(all: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    parallel::in_parallel(all.len(), parallel::threads(), |i| work(&all[i]))
}

/// Compiles specs in parallel.
pub fn compiled(specs: &[PathBuf], settings: &Settings) -> Vec<Tested> {
    in_parallel(specs, |path| {
        let compiled = project::load(path, settings);
        let compiler::Compiled { program, missions, report, .. } = compiled;
        Tested { spec: path.display().to_string(), report, program, missions }
    })
}

/// Runs the scenarios of specs in parallel; optionally only those with this name, and with this seed instead of their
/// own.
///
/// # Errors
/// A program cannot be executed, which never happens for a compiled one.
pub fn all(specs: &[Tested], name: Option<&str>, seed: Option<u64>) -> Result<Vec<ScenarioResult>, String> {
    let mut chosen: Vec<(&Tested, Found)> = Vec::new();
    for t in specs {
        chosen.extend(scenarios(t.program.as_ref(), &t.missions).map(|found| (t, found)));
    }
    chosen.retain(|(_, found)| name.is_none_or(|n| found.name() == n));
    let result = |(t, found): &(&Tested, Found)| match (*found, seed) {
        (Found::Controller(program, scenario), None) => run(&t.spec, program, scenario),
        (Found::Controller(program, scenario), Some(seed)) => run(&t.spec, program, &seeded(scenario, seed)),
        (Found::Mission(mission, scenario), None) => run_mission(&t.spec, mission, scenario),
        (Found::Mission(mission, scenario), Some(seed)) => {
            run_mission(&t.spec, mission, &MissionScenarioProgram { seed, ..scenario.clone() })
        }
    };
    in_parallel(&chosen, result).into_iter().collect()
}
