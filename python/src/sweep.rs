//! Sweeps: one scenario over ranges of params and seeds, in memory or in the file of `hierarq sweep`.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use runs::sweep::axis::axis;
use runs::sweep::row::{Cell, Kind, columns};
use runs::sweep::stored::{self, Execution, Stored};
use runs::sweep::{Digest, Plan, Refusal, Request, Shard, execute, merge, table};

use crate::interruption::interruptible;
use crate::program::refused;
use crate::reading::{Rendered, settings};

/// The request of a sweep, as the package passes it on.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Wanted {
    spec: PathBuf,
    set: Vec<(String, String)>,
    package_paths: Vec<PathBuf>,
    scenario: Option<String>,
    vary: Vec<(String, String)>,
    runs: Option<u64>,
    seed: Option<u64>,
    shard: Option<String>,
    out: Option<PathBuf>,
    jobs: Option<usize>,
    resume: bool,
}

impl Wanted {
    fn request(&self) -> Result<Request, String> {
        let vary = self.vary.iter().map(|(name, values)| axis(name, values)).collect::<Result<_, _>>()?;
        let shard = self.shard.as_deref().map(Shard::from_str).transpose();
        Ok(Request {
            spec: self.spec.clone(),
            settings: settings(self.set.clone(), self.package_paths.clone()),
            scenario: self.scenario.clone(),
            vary,
            runs: self.runs,
            seed: self.seed,
            shard: shard.map_err(|e| format!("`shard`: {e}"))?,
        })
    }
}

/// A checked sweep, or the rendered diagnostics of its spec.
fn planned(py: Python<'_>, wanted: &Wanted) -> PyResult<Result<Plan, Rendered>> {
    let request = wanted.request().map_err(refused)?;
    match py.detach(|| Plan::new(&request)) {
        Ok(plan) => Ok(Ok(plan)),
        Err(Refusal::Spec(report)) => Ok(Err(Rendered::new(&report))),
        Err(Refusal::Usage(message)) => Err(refused(message)),
    }
}

/// The number of runs of a sweep; or the rendered diagnostics of a spec with errors.
///
/// # Errors
/// The request is wrong.
#[pyfunction]
pub(crate) fn sweep_runs(py: Python<'_>, wanted: Wanted) -> PyResult<(Option<u64>, Option<Rendered>)> {
    Ok(match planned(py, &wanted)? {
        Ok(plan) => (Some(plan.head.runs), None),
        Err(rendered) => (None, Some(rendered)),
    })
}

/// Runs a sweep. Returns its columns and its summary; or the rendered diagnostics of a spec with errors.
///
/// # Errors
/// The request is wrong, the file cannot be written, or the user has interrupted.
#[pyfunction]
pub(crate) fn sweep(py: Python<'_>, wanted: Wanted) -> PyResult<(Option<Shown<'_>>, Option<Rendered>)> {
    let plan = match planned(py, &wanted)? {
        Ok(plan) => plan,
        Err(rendered) => return Ok((None, Some(rendered))),
    };
    let jobs = wanted.jobs.unwrap_or_else(mission::parallel::threads).max(1);
    let stored = interruptible(py, |go_on| match &wanted.out {
        Some(out) => {
            stored::run(&plan, out, Execution { jobs, resume: wanted.resume, go_on, progress: &mut |_, _| () })
        }
        None => {
            let mut rows = Vec::new();
            let all: Vec<u64> = plan.head.own().collect();
            execute::execute(&plan, &all, jobs, go_on, &mut |row| {
                rows.push(row);
                Ok(())
            })?;
            rows.sort_by_key(|r| r.run);
            Ok(Stored { head: plan.head.clone(), rows, speed: None })
        }
    })?;
    let out = wanted.out.as_deref().unwrap_or(Path::new(""));
    Ok((Some(shown(py, &stored.map_err(refused)?, out)?), None))
}

/// Merges the files of all shards of a sweep into one, and returns its columns and its summary.
///
/// # Errors
/// A file cannot be read, belongs to another sweep, or is missing.
#[pyfunction]
pub(crate) fn merged(py: Python<'_>, files: Vec<PathBuf>, out: PathBuf) -> PyResult<Shown<'_>> {
    let stored = py.detach(|| {
        let target = table::target(&out, &files)?;
        let (head, rows) = merge::merge(&files)?;
        stored::folder(&out)?;
        table::write(target, &head, &rows)?;
        Ok::<_, String>(Stored { head, rows, speed: None })
    });
    shown(py, &stored.map_err(refused)?, &out)
}

/// A sweep as the package shows it.
#[derive(IntoPyObject)]
pub(crate) struct Shown<'py> {
    /// The columns by name: arrays of numbers and truth values where each row has one, else lists with `None`.
    columns: Bound<'py, PyDict>,
    /// JSON, as of `hierarq sweep --json`.
    summary: String,
}

fn shown<'py>(py: Python<'py>, stored: &Stored, out: &Path) -> PyResult<Shown<'py>> {
    let (head, rows) = (&stored.head, &stored.rows);
    let cells: Vec<Vec<Cell>> = rows.iter().map(|row| row.cells(head)).collect();
    let values_of = PyDict::new(py);
    for (i, column) in columns(head).iter().enumerate() {
        let of = cells.iter().map(|row| &row[i]);
        let values = match (column.kind, column.always) {
            (Kind::Number, _) => PyArray1::from_iter(py, of.map(|c| number(c).unwrap_or(f64::NAN))).into_any(),
            (Kind::Whole, true) => PyArray1::from_iter(py, of.map(|c| whole(c).unwrap_or(0))).into_any(),
            (Kind::Truth, true) => PyArray1::from_iter(py, of.map(|c| truth(c).unwrap_or(false))).into_any(),
            (Kind::Whole, false) => of.map(whole).collect::<Vec<_>>().into_pyobject(py)?,
            (Kind::Truth, false) => of.map(truth).collect::<Vec<_>>().into_pyobject(py)?,
            (Kind::Text, _) => of.map(text).collect::<Vec<_>>().into_pyobject(py)?,
        };
        values_of.set_item(&column.name, values)?;
    }
    let summary = Digest::new(head, rows).json(&out.display().to_string());
    Ok(Shown { columns: values_of, summary: summary.to_string() })
}

fn number(cell: &Cell) -> Option<f64> {
    if let Cell::Number(x) = cell { *x } else { None }
}

fn whole(cell: &Cell) -> Option<u64> {
    if let Cell::Whole(x) = cell { *x } else { None }
}

fn truth(cell: &Cell) -> Option<bool> {
    if let Cell::Truth(x) = cell { *x } else { None }
}

fn text(cell: &Cell) -> Option<&str> {
    if let Cell::Text(x) = cell { x.as_deref() } else { None }
}
