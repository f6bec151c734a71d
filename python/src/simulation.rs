//! Whole runs: a program on its simulated robot, the scenarios of specs, plans of missions.

use std::path::PathBuf;
use std::time::Duration;

use mission::engine::Engine;
use mission::planned::PlanOptions;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use runs::project;
use runs::scenario_runner::{self, seeded};
use runtime::program::Subject;
use runtime::record::All;
use runtime::record::columns::Columns;
use runtime::record::expectations::{is_good, records};
use runtime::record::series::SeriesRecorder;
use runtime::record::summary::SummaryRecorder;
use runtime::{ExpectationMonitors, Recorder, Simulation, Tick};
use views::{gantt, report};

use crate::interruption::interruptible;
use crate::program::{Program, refused};
use crate::reading::{Rendered, settings};

/// Records the numbers of all ticks, with states and faults.
struct Table {
    columns: Columns,
    row: Vec<f64>,
    numbers: Vec<f64>,
    states: Vec<String>,
    faults: Vec<&'static str>,
}

impl Recorder for Table {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        self.columns.fill(tick, &mut self.row);
        self.numbers.extend_from_slice(&self.row);
        self.states.push(tick.state.to_string());
        self.faults.push(tick.fault.map_or("", |f| f.kind().word()));
        Ok(())
    }
}

/// The outcome of a run before it is handed to Python.
struct Ran {
    names: Vec<String>,
    table: Table,
    ok: bool,
    summary: String,
    page: String,
    machine: bool,
}

/// Runs a program, or one of its scenarios, on the simulated robot.
///
/// # Errors
/// There is no such scenario, or the duration cannot be run.
#[pyfunction]
#[pyo3(signature = (program, scenario, seed, duration))]
pub(crate) fn simulate<'py>(
    py: Python<'py>,
    program: &Program,
    scenario: Option<&str>,
    seed: Option<u64>,
    duration: Option<f64>,
) -> PyResult<Bound<'py, PyDict>> {
    let ran = interruptible(py, |go_on| run(program, scenario, seed, duration, go_on))??;
    let out = PyDict::new(py);
    let width = ran.names.len();
    let rows = ran.table.numbers.len().checked_div(width).unwrap_or(0);
    let table: Bound<'py, PyArray2<f64>> = PyArray1::from_vec(py, ran.table.numbers).reshape([rows, width])?;
    out.set_item("names", ran.names)?;
    out.set_item("table", table)?;
    out.set_item("states", ran.machine.then_some(ran.table.states))?;
    out.set_item("faults", ran.table.faults)?;
    out.set_item("ok", ran.ok)?;
    out.set_item("summary", ran.summary)?;
    out.set_item("page", ran.page)?;
    Ok(out)
}

fn run(
    of: &Program,
    scenario: Option<&str>,
    seed: Option<u64>,
    duration: Option<f64>,
    go_on: &dyn Fn() -> bool,
) -> PyResult<Ran> {
    let mut program = (**of.of_robot()?).clone();
    let mut scenario = match scenario {
        Some(name) => match scenario_runner::find(Some(&program), &of.missions, name).map_err(refused)? {
            scenario_runner::Found::Controller(_, scenario) => Some(scenario.clone()),
            scenario_runner::Found::Mission(..) => {
                return Err(refused(format!("`{name}` executes a mission: run it by `hierarq.test`")));
            }
        },
        None => None,
    };
    if let (Some(s), Some(seed)) = (&scenario, seed) {
        scenario = Some(seeded(s, seed));
    }
    let run = scenario.as_mut().map_or(&mut program.run, |s| &mut s.run);
    run.duration = duration.unwrap_or(run.duration);
    run.simulator.seed = seed.unwrap_or(run.simulator.seed);
    if let Some(s) = &scenario {
        program = s.program(&program);
    }
    program.check().map_err(refused)?;
    let simulation = match &scenario {
        Some(scenario) => Simulation::in_world(&program, scenario),
        None => Simulation::new(&program),
    };
    let mut simulation = simulation.map_err(refused)?;
    let (ticks, controller) = (simulation.ticks(), simulation.controller());
    let columns = Columns::new(&program, controller);
    let names = columns.names(&program);
    let numbers = Vec::with_capacity(ticks * names.len());
    let mut table = Table { columns, row: Vec::new(), numbers, states: Vec::new(), faults: Vec::new() };
    let mut statistics = SummaryRecorder::new(controller, ticks);
    let mut series = SeriesRecorder::new(controller, ticks, report::drawn_links(&program));
    let monitors = scenario.as_ref().map(|s| ExpectationMonitors::new(&program, s, ticks));
    let mut monitors = monitors.transpose().map_err(refused)?;
    let mut all = All(vec![&mut table, &mut statistics, &mut series]);
    if let Some(monitors) = &mut monitors {
        all.0.push(monitors);
    }
    simulation.run(&mut all, &mut || 0.0, &mut |_| go_on()).map_err(refused)?;
    let mut summary = statistics.summary(&program, simulation.controller(), Vec::new());
    let mut ok = summary.ok;
    if let Some((monitors, scenario)) = monitors.zip(scenario.as_ref()) {
        summary.expectations = records(scenario, &monitors.finish(), program.robot.period);
        ok = is_good(scenario, &summary.expectations, &summary);
    }
    let text = serde_json::to_string(&summary).map_err(refused)?;
    let scenario = scenario.as_ref();
    let page = report::html(&report::Run {
        program: &program,
        scenario,
        spec: &of.spec,
        summary: &summary,
        good: ok,
        series: &series,
    });
    Ok(Ran { names, table, ok, summary: text, page, machine: program.run.subject == Subject::Machine })
}

/// Results of the scenarios of specs as JSON, and the rendered diagnostics of specs with errors.
///
/// # Errors
/// A folder cannot be read.
#[pyfunction]
pub(crate) fn test(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    scenario: Option<String>,
    seed: Option<u64>,
    set: Vec<(String, String)>,
) -> PyResult<(String, Vec<Rendered>)> {
    py.detach(|| {
        let specs = scenario_runner::specs(&paths).map_err(refused)?;
        let tested = scenario_runner::compiled(&specs, &settings(set, Vec::new()));
        let wrong = tested.iter().filter(|t| t.report.errors() > 0);
        let wrong = wrong.map(|t| Rendered::new(&t.report)).collect();
        let results = scenario_runner::all(&tested, scenario.as_deref(), seed).map_err(refused)?;
        Ok((serde_json::to_string(&results).map_err(refused)?, wrong))
    })
}

/// The plan of a mission as JSON, with its Gantt chart as SVG.
///
/// # Errors
/// There is no such mission, or no plan of it.
#[pyfunction]
#[pyo3(signature = (program, mission, engine, formulation, budget))]
pub(crate) fn plan(
    py: Python<'_>,
    program: &Program,
    mission: Option<&str>,
    engine: &str,
    formulation: Option<&str>,
    budget: Option<f64>,
) -> PyResult<(String, String)> {
    let chosen = project::mission(&program.missions, mission).map_err(|e| refused(format!("{}: {e}", program.spec)))?;
    let known = Engine::ALL.into_iter().find(|e| e.name() == engine);
    let names = || Engine::ALL.iter().map(|e| e.name());
    let engine = known.ok_or_else(|| refused(crate::inputs::unknown("engine", engine, names)))?;
    let time = budget.map(Duration::try_from_secs_f64).transpose().map_err(refused)?;
    py.detach(|| {
        let options = PlanOptions { formulation, engine, batch: None, time };
        let of: &dyn mission::kind::Mission = &*chosen.kind;
        let planned = of.plan(&options).map_err(refused)?;
        let json = planned.to_json(&program.spec, &chosen.name, of.kind().name).map_err(refused)?;
        Ok((json, gantt::svg(&planned.chart)))
    })
}
