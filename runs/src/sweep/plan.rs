//! A sweep that is checked before any run; every run is determined by its number.

use std::path::{Path, PathBuf};

use compiler::{ParamValue, Report};
use files::quoted;
use twox_hash::XxHash3_128;

use super::axis::{Axis, Values, drawn, spread};
use super::head::{Head, Param, Shard, VERSION, line};
use super::row::Cell;
use super::subject::{self, Columns};
use crate::project::{self, Settings};
use crate::scenario_runner::{self, MAX_SEED};

/// Maximum number of runs of a sweep.
pub const MAX_RUNS: u64 = 10_000_000;

/// Default number of runs per grid point, if values are drawn.
pub const RUNS: u64 = 200;

/// Request for a sweep.
#[derive(Clone, Debug)]
pub struct Request {
    /// Spec, or a compiled program.
    pub spec: PathBuf,
    /// Settings of the compilation, common to all runs.
    pub settings: Settings,
    /// Scenario; by default the only one.
    pub scenario: Option<String>,
    /// Varied params.
    pub vary: Vec<Axis>,
    /// Number of runs per grid point.
    pub runs: Option<u64>,
    /// Seed of the first run; by default that of the scenario.
    pub seed: Option<u64>,
    /// Shard of the sweep.
    pub shard: Option<Shard>,
}

/// Reason why there is no sweep.
#[derive(Debug)]
pub enum Refusal {
    /// The spec has errors with these values.
    Spec(Box<Report>),
    /// Another problem; the message describes a remedy.
    Usage(String),
}

/// A checked sweep.
pub struct Plan {
    /// Metadata of its file.
    pub head: Head,
    /// Report of the compiler for the spec with the first value of each param.
    pub report: Report,
    spec: PathBuf,
    settings: Settings,
    axes: Vec<Points>,
    per_point: u64,
}

/// Checked values of a param.
enum Points {
    Drawn { low: f64, high: f64 },
    Listed(Vec<Cell>),
}

/// Input of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// Seed.
    pub seed: u64,
    /// Values of the params.
    pub values: Vec<Cell>,
}

impl Plan {
    /// Checks a sweep: compiles the spec with every value that is written.
    ///
    /// # Errors
    /// The spec has errors with one of the values, or the request is invalid.
    pub fn new(request: &Request) -> Result<Plan, Refusal> {
        let usage = Refusal::Usage;
        let vary = &request.vary;
        for (i, a) in vary.iter().enumerate() {
            let name = &a.name;
            if vary[..i].iter().any(|other| other.name == *name) {
                return Err(usage(format!("`{name}` is varied twice: name it once")));
            }
            if request.settings.set.iter().any(|(set, _)| set == name) {
                return Err(usage(format!("`{name}` is both set and varied: remove one of them")));
            }
        }
        let compiled = project::load(&request.spec, &with(request, None));
        if !compiled.is_good() {
            return Err(Refusal::Spec(Box::new(compiled.report)));
        }
        try_all(request)?;
        let axes = vary
            .iter()
            .enumerate()
            .map(|(i, a)| points(request, i, a))
            .collect::<Result<Vec<_>, _>>()
            .map_err(usage)?;
        let scenario = subject::choose(&compiled, request.scenario.as_deref()).map_err(usage)?;
        let columns = Columns::of(scenario).map_err(usage)?;

        let listed = |p: &Points| if let Points::Listed(all) = p { all.len() as u64 } else { 1 };
        let grid = axes.iter().try_fold(1_u64, |n, (points, _)| n.checked_mul(listed(points)));
        let draws = axes.iter().any(|(p, _)| matches!(p, Points::Drawn { .. }));
        let per_point = request.runs.unwrap_or(if draws || axes.is_empty() { RUNS } else { 1 });
        let runs = grid.and_then(|n| n.checked_mul(per_point)).filter(|n| *n <= MAX_RUNS);
        let runs = runs.ok_or_else(|| usage(format!("these are more than {MAX_RUNS} runs: give fewer values")))?;
        let seed = request.seed.unwrap_or(columns.seed);
        if seed.saturating_add(per_point) > MAX_SEED {
            return Err(usage(format!("a run would have a seed above {MAX_SEED}: begin with a smaller one")));
        }

        let (spec, name) = (request.spec.display().to_string(), scenario.name());
        let mut command = line("sweep", &spec, name, &request.settings);
        for a in vary {
            command += &format!(" --vary {}", quoted(&format!("{}={}", a.name, a.written)));
        }
        command += &format!(" --runs {per_point} --seed {seed}");
        let param = |(a, (_, unit)): (&Axis, &(Points, Option<String>))| Param {
            name: a.name.clone(),
            values: a.written.clone(),
            unit: unit.clone(),
        };
        let head = Head {
            version: VERSION,
            generated_by: concat!("hierarq ", env!("CARGO_PKG_VERSION")).to_string(),
            replay: line("run", &spec, name, &request.settings),
            program: format!("{:032x}", XxHash3_128::oneshot(&columns.bytes)),
            texts: texts(&compiled.report),
            command,
            runs,
            seed,
            params: vary.iter().zip(&axes).map(param).collect(),
            expectations: columns.expectations,
            limits: columns.limits,
            measures: columns.measures,
            scenario: name.to_string(),
            subject: columns.subject,
            shard: request.shard,
            spec,
        };
        Ok(Plan {
            head,
            report: compiled.report,
            spec: request.spec.clone(),
            settings: request.settings.clone(),
            axes: axes.into_iter().map(|a| a.0).collect(),
            per_point,
        })
    }

    /// Returns the input of a run. Grid points are ordered with the last param changing fastest; each has the same
    /// number of runs, with the same seeds.
    pub fn point(&self, run: u64) -> Point {
        let (mut place, seed) = (run / self.per_point, self.head.seed + run % self.per_point);
        let mut values = Vec::with_capacity(self.axes.len());
        for (points, p) in self.axes.iter().zip(&self.head.params).rev() {
            values.push(match points {
                Points::Drawn { low, high } => Cell::Number(Some(drawn(seed, &p.name, *low, *high))),
                Points::Listed(all) => {
                    let count = all.len() as u64;
                    let value = all[(place % count) as usize].clone();
                    place /= count;
                    value
                }
            });
        }
        values.reverse();
        Point { seed, values }
    }

    /// Settings for the compilation of the spec with these values.
    pub fn settings(&self, values: &[Cell]) -> Settings {
        let mut settings = self.settings.clone();
        settings.set.extend(self.head.sets(values));
        settings
    }

    /// Spec, or the compiled program.
    pub fn spec(&self) -> &Path {
        &self.spec
    }
}

/// Settings of a request with one given value of a varied param, and the first values of all others.
fn with(request: &Request, one: Option<(usize, &str)>) -> Settings {
    let mut settings = request.settings.clone();
    for (i, a) in request.vary.iter().enumerate() {
        let chosen = one.filter(|(k, _)| *k == i).map(|(_, text)| text);
        let text = chosen.or_else(|| a.values.texts().first().copied());
        settings.set.extend(text.map(|text| (a.name.clone(), text.to_string())));
    }
    settings
}

/// Compiles the spec with each value that is written.
fn try_all(request: &Request) -> Result<(), Refusal> {
    let others = |(i, a): (usize, &'_ Axis)| -> Vec<Settings> {
        a.values.texts().into_iter().skip(1).map(|text| with(request, Some((i, text)))).collect()
    };
    let results: Vec<Settings> = request.vary.iter().enumerate().flat_map(others).collect();
    let compiled = scenario_runner::in_parallel(&results, |settings| project::load(&request.spec, settings));
    match compiled.into_iter().find(|c| !c.is_good()) {
        Some(bad) => Err(Refusal::Spec(Box::new(bad.report))),
        None => Ok(()),
    }
}

/// Values of a param in SI, with their unit.
fn points(request: &Request, index: usize, axis: &Axis) -> Result<(Points, Option<String>), String> {
    let name = &axis.name;
    let of = |text: &str| -> Result<ParamValue, String> {
        let all = project::params(&request.spec, &with(request, Some((index, text))));
        all.into_iter().find(|p| p.name == *name).ok_or_else(|| format!("`{name}={text}` is no value"))
    };
    let all = axis.values.texts().into_iter().map(of).collect::<Result<Vec<ParamValue>, _>>()?;
    let units: Vec<&str> = all.iter().map(|p| p.unit.as_str()).filter(|u| !u.is_empty()).collect();
    let unit = units.first().copied().unwrap_or_default();
    if let Some(other) = units.iter().find(|u| **u != unit) {
        return Err(format!("the values of `{name}` have several units, `{unit}` and `{other}`: write one"));
    }
    let numbers: Option<Vec<f64>> = all.iter().map(|p| p.number).collect();
    let kind = all.first().map_or("", |p| p.kind);
    let Some(numbers) = numbers else {
        return match &axis.values {
            Values::Listed(texts) => {
                Ok((Points::Listed(texts.iter().map(|t| Cell::Text(Some(t.clone()))).collect()), None))
            }
            _ => Err(format!("`{name}` is {kind}, and a range is one of numbers: list its values, `{name}=A,B`")),
        };
    };
    let cell = |x: f64| Cell::Number(Some(x));
    let points = match (&axis.values, &numbers[..]) {
        (Values::Drawn(low, high) | Values::Spread(low, high, _), [a, b]) if a > b => {
            return Err(format!("`{low}` is above `{high}`: write the smaller value of `{name}` first"));
        }
        (Values::Drawn(..), &[low, high]) => Points::Drawn { low, high },
        (Values::Spread(_, _, n), &[low, high]) => {
            Points::Listed((0..*n).map(|i| cell(spread(low, high, i, *n))).collect())
        }
        _ => Points::Listed(numbers.into_iter().map(cell).collect()),
    };
    Ok((points, Some(unit.to_string())))
}

/// Hash of all texts from which a spec was compiled, except for values of `--set`.
pub(super) fn texts(report: &Report) -> String {
    let mut all = Vec::new();
    for (_, source) in report.sources.iter().filter(|(_, s)| !s.name.starts_with("--set ")) {
        for part in [&source.name, &source.text] {
            all.extend((part.len() as u64).to_le_bytes());
            all.extend(part.as_bytes());
        }
    }
    format!("{:032x}", XxHash3_128::oneshot(&all))
}
