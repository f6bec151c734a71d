//! `hierarq solve TICKS`

use std::collections::BTreeMap;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::PathBuf;

use clap::Args;
use files::{Output, Target};
use hierarq::outputs;
use serde::Serialize;
use serde_json::{Value, json};
use solver::{Backend, Problem, Status, certificate};

use super::backend::{Measured, Times, cells_of, json_of, named, remark, table};
use super::{Outcome, output};
use hierarq::qp_log::{self, Line, Lines, LoggedProblem, MAX_LINE, Refusal};

/// Tolerance of the certificate: an answer that exceeds it is not optimal, whatever status the solver reports.
const CERTIFIED: f64 = 1e-6;
/// Maximum number of kinds with their own row in the table.
const MAX_KINDS: usize = 100;
/// Maximum number of refusals in the JSON; all are counted, and all are printed without `--json`.
const MAX_LISTED: usize = 1000;

#[derive(Args)]
#[command(after_long_help = "\
A line of the file, in full:

  {\"id\": \"t0\", \"n\": 2, \"levels\": [
    {\"A\": {\"identity\": 1}, \"lo\": [-1, null], \"up\": [1, null]},
    {\"A\": [[1, 1]], \"lo\": [3], \"up\": [3]}]}

on one line. `A` is a list of rows, or so many identities; `null` is no bound; equal bounds are an
equality. A level may have `weight` (a number a row), `hard` (true: takes no slack) and `damping`; a
tick may have `kind`, `reference`, and the answers `x` and `viol` to be compared with.")]
pub struct Arguments {
    /// Problems, one JSON object a line (`*.jsonl`); `-` reads standard input.
    ticks: PathBuf,
    /// The solver.
    #[arg(long, default_value = Backend::ActiveSet.name(), value_parser = named())]
    backend: Backend,
    /// Write `id`, `x`, `viol`, `status`, `us` of each problem to this file, one JSON object a line.
    #[arg(long, value_name = "FILE")]
    answers: Option<PathBuf>,
    /// Solve every problem without a warm start.
    #[arg(long)]
    cold: bool,
    /// Print the table as JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(a: &Arguments) -> Result<Outcome, String> {
    let stdin = a.ticks.as_os_str() == "-";
    let name = if stdin { "standard input".to_string() } else { a.ticks.display().to_string() };
    let input: Box<dyn Read> = if stdin {
        Box::new(std::io::stdin())
    } else {
        match files::stream(&a.ticks) {
            Ok(file) => Box::new(file),
            Err(e) => {
                output::error_line(&format!("cannot read {name}: {e}"));
                return Ok(Outcome::Failed);
            }
        }
    };
    let sources = [a.ticks.clone()];
    let answers = a.answers.as_deref().map(|path| -> Result<Answers, String> {
        let output = Target::new("--answers", path, outputs::ANSWERS, &sources)?.begin()?;
        Ok((path.display().to_string(), BufWriter::with_capacity(1 << 16, output)))
    });
    let answers = answers.transpose()?;
    let mut session = Session {
        name,
        backend: a.backend,
        cold: a.cold,
        json: a.json,
        answers,
        measured: None,
        kinds: BTreeMap::new(),
        refused: 0,
        refusals: Vec::new(),
    };
    session.all(&mut Lines::new(BufReader::with_capacity(1 << 16, input)))?;
    Ok(session.finish())
}

type Answers = (String, BufWriter<Output>);

/// An output line of an answer. The order of the keys is that of the docs.
#[derive(Serialize)]
struct Answer<'a> {
    id: &'a str,
    /// `None` (null) without a usable solution.
    x: Option<&'a [f64]>,
    viol: Option<Vec<f64>>,
    status: &'static str,
    us: f64,
}

/// Statistics of the ticks of one kind.
#[derive(Default)]
struct Kind {
    us: Times,
    certificate: Worst,
    dx: Worst,
    dviol: Worst,
    infeasible: usize,
    failed: usize,
    uncertified: usize,
}

/// Maximum of some numbers, with its tick. NaN counts as infinite.
#[derive(Default)]
struct Worst(Option<(f64, String)>);

impl Worst {
    fn see(&mut self, value: f64, id: &str) {
        let value = if value.is_nan() { f64::INFINITY } else { value };
        if self.0.as_ref().is_none_or(|w| value > w.0) {
            self.0 = Some((value, id.to_string()));
        }
    }

    fn join(&mut self, other: &Worst) {
        if let Some((value, id)) = &other.0 {
            self.see(*value, id);
        }
    }

    fn cell(&self) -> String {
        self.0.as_ref().map_or_else(String::new, |w| format!("{:.1e}", w.0))
    }

    fn json(&self) -> Value {
        self.0.as_ref().map_or(Value::Null, |(value, id)| json!({ "value": value, "id": id }))
    }
}

impl Kind {
    fn join(&mut self, other: &Kind) {
        self.us.extend(&other.us);
        self.certificate.join(&other.certificate);
        self.dx.join(&other.dx);
        self.dviol.join(&other.dviol);
        self.infeasible += other.infeasible;
        self.failed += other.failed;
        self.uncertified += other.uncertified;
    }

    fn json(&mut self) -> Value {
        json!({
            "ticks": self.us.count(),
            "us": json_of(&self.us.percentiles()),
            "certificate": self.certificate.json(),
            "dx": self.dx.json(),
            "dviol": self.dviol.json(),
            "infeasible": self.infeasible,
            "failed": self.failed,
            "uncertified": self.uncertified,
        })
    }

    fn row(&mut self, name: &str) -> Vec<String> {
        let name = if name.is_empty() { "(no kind)" } else { name };
        let mut row = vec![name.to_string(), self.us.count().to_string()];
        row.extend(cells_of(&self.us.percentiles()));
        row.extend([self.certificate.cell(), self.dx.cell(), self.dviol.cell()]);
        row
    }
}

/// State while a file is solved.
struct Session {
    name: String,
    backend: Backend,
    cold: bool,
    json: bool,
    answers: Option<Answers>,
    measured: Option<(Vec<usize>, Measured)>,
    kinds: BTreeMap<String, Kind>,
    refused: usize,
    refusals: Vec<Value>,
}

/// Returns the number of variables, then the number of rows of each level.
fn shape(problem: &Problem) -> Vec<usize> {
    std::iter::once(problem.n).chain(problem.levels.iter().map(solver::Level::rows)).collect()
}

/// Computes for each level the norm of the distances of its rows from their intervals.
fn violations(problem: &Problem, x: &[f64]) -> Vec<f64> {
    // `hypot` avoids overflow and underflow of intermediate results.
    let of = |level: &solver::Level| (0..level.rows()).fold(0.0_f64, |norm, i| norm.hypot(level.slack(i, x)));
    problem.levels.iter().map(of).collect()
}

fn furthest(a: &[f64], b: &[f64]) -> f64 {
    // `max` would lose a NaN.
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, |m, d| if d > m || d.is_nan() { d } else { m })
}

impl Session {
    fn all(&mut self, lines: &mut Lines<impl std::io::BufRead>) -> Result<(), String> {
        while let Some((number, line)) = lines.read().map_err(|e| format!("cannot read {}: {e}", self.name))? {
            let tick = match line {
                Line::Bytes(bytes) if bytes.trim_ascii().is_empty() => continue,
                Line::Bytes(bytes) => qp_log::read(bytes),
                Line::TooLong => Err(Refusal::new(
                    format!("the line is longer than {} MiB", MAX_LINE >> 20),
                    "check if line breaks are missing",
                )),
            };
            match tick {
                Ok(tick) => self.one(&tick)?,
                Err(refusal) => self.refuse(number, &refusal),
            }
        }
        if let Some((name, file)) = self.answers.take() {
            file.into_inner().map_err(|e| format!("cannot write {name}: {}", e.into_error()))?.finish()?;
        }
        Ok(())
    }

    fn refuse(&mut self, number: u64, refusal: &Refusal) {
        self.refused += 1;
        let Refusal { reason, help } = refusal;
        if !self.json {
            output::error_line(&format!("{}:{number}: {reason}; {help}", self.name));
        } else if self.refusals.len() < MAX_LISTED {
            self.refusals.push(json!({ "line": number, "reason": reason, "help": help }));
        }
    }

    fn one(&mut self, tick: &LoggedProblem) -> Result<(), String> {
        let problem = &tick.problem;
        let shape = shape(problem);
        if self.measured.as_ref().is_none_or(|b| b.0 != shape) {
            self.measured = None;
        }
        let (choice, cold) = (self.backend, self.cold);
        let (_, measured) = self.measured.get_or_insert_with(|| (shape, Measured::new(choice, cold, problem)));
        let us = measured.solve(problem);
        let solution = &measured.solution;
        let (status, x) = match solution.status {
            Status::Optimal => ("optimal", Some(&solution.x[..])),
            Status::Infeasible { .. } => ("infeasible", Some(&solution.x[..])),
            Status::NotFinite { .. } => ("not_finite", None),
            Status::OutOfTime { .. } => ("out_of_time", None),
            Status::Unproven { .. } => ("unproven", None),
            Status::Failed { .. } => ("failed", None),
        };
        let viol = x.map(|x| violations(problem, x));

        let known = self.kinds.contains_key(&tick.kind) || self.kinds.len() < MAX_KINDS;
        let kind = self.kinds.entry(if known { tick.kind.clone() } else { "(other kinds)".to_string() }).or_default();
        kind.us.push(us);
        if let Some(x) = x {
            let residual = match solution.status {
                // The solution is the optimum of the levels above the infeasible one.
                Status::Infeasible { level } => {
                    let mut above = problem.clone();
                    above.levels.truncate(level);
                    kind.infeasible += 1;
                    certificate(&above, x)
                }
                _ => certificate(problem, x),
            };
            kind.certificate.see(residual, &tick.id);
            if residual > CERTIFIED || residual.is_nan() {
                kind.uncertified += 1;
                output::error_line(&format!(
                    "`{}`: the answer is not optimal, its certificate leaves {residual:.1e}",
                    tick.id
                ));
            }
            if let (Some(expected), Status::Optimal) = (&tick.x, solution.status) {
                kind.dx.see(furthest(x, expected), &tick.id);
            }
            if let (Some(expected), Some(viol), Status::Optimal) = (&tick.viol, &viol, solution.status) {
                kind.dviol.see(furthest(viol, expected), &tick.id);
            }
        } else {
            kind.failed += 1;
            output::error_line(&format!("`{}`: no usable answer ({:?})", tick.id, solution.status));
        }
        if let Some((name, file)) = &mut self.answers {
            let answer = Answer { id: &tick.id, x, viol, status, us: (us * 1e3).round() / 1e3 };
            serde_json::to_writer(&mut *file, &answer)
                .map_err(std::io::Error::from)
                .and_then(|()| file.write_all(b"\n"))
                .map_err(|e| format!("cannot write {name}: {e}"))?;
        }
        Ok(())
    }

    fn finish(mut self) -> Outcome {
        let mut all = Kind::default();
        self.kinds.values().for_each(|k| all.join(k));
        let count = all.us.count();
        let nothing = count + self.refused == 0;
        if nothing {
            output::error_line(&format!("{} contains no problems", self.name));
        }
        let bad = nothing || self.refused + all.failed + all.uncertified > 0;
        let start = if self.cold { "cold" } else { "warm" };
        if self.json {
            let kinds: serde_json::Map<String, Value> =
                self.kinds.iter_mut().map(|(name, kind)| (name.clone(), kind.json())).collect();
            let data = json!({
                "version": 1,
                "file": self.name,
                "ok": !bad,
                "backend": self.backend.name(),
                "start": start,
                "refused": self.refused,
                "refusals": self.refusals,
                "kinds": kinds,
                "all": all.json(),
            });
            output::data(&format!("{data:#}\n"));
        } else {
            let mut rows: Vec<Vec<String>> = self.kinds.iter_mut().map(|(name, kind)| kind.row(name)).collect();
            if rows.len() != 1 {
                rows.push(all.row("all"));
            }
            let header = ["kind", "ticks", "median us", "p99 us", "max us", "certificate", "|dx|", "|dviol|"];
            output::print(&format!(
                "{}{count} solved by {}, {start}; {} refused, {} infeasible, {} failed, {} not optimal\n{}",
                table(&header, 1, rows),
                self.backend.name(),
                self.refused,
                all.infeasible,
                all.failed,
                all.uncertified,
                remark(),
            ));
        }
        Outcome::of(!bad)
    }
}
