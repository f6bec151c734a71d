//! The solvers that `solve` and `bench` measure, and their timing.

use std::time::Instant;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use comfy_table::{CellAlignment, Table, presets};
use runtime::record::summary::Percentiles;
use serde_json::{Value, json};
use solver::{ActiveSet, Backend, ClarabelCascade, HierarchicalSolver, Problem, Solution};

/// Returns the command-line parser for the name of a solver.
pub fn named() -> impl TypedValueParser<Value = Backend> {
    PossibleValuesParser::new(Backend::ALL.map(Backend::name)).map(|s| Backend::from_name(&s).unwrap_or_default())
}

/// A solver with its working memory for problems of one shape.
pub struct Measured {
    solver: Solver,
    cold: bool,
    /// Solution of the last call.
    pub solution: Solution,
}

enum Solver {
    ActiveSet(Box<ActiveSet>),
    Clarabel(Box<ClarabelCascade>),
}

impl Measured {
    /// Creates a solver for problems of this shape. A cold one is reset before each problem.
    pub fn new(backend: Backend, cold: bool, problem: &Problem) -> Measured {
        let solver = match backend {
            Backend::ActiveSet => Solver::ActiveSet(Box::new(ActiveSet::new(problem))),
            Backend::Clarabel => Solver::Clarabel(Box::new(ClarabelCascade::new(problem))),
        };
        Measured { solver, cold, solution: Solution::new(problem) }
    }

    /// Solves a problem, and returns the time in microseconds; the reset of a cold solver is not included.
    pub fn solve(&mut self, problem: &Problem) -> f64 {
        if self.cold {
            match &mut self.solver {
                Solver::ActiveSet(s) => s.forget(),
                Solver::Clarabel(s) => s.forget(),
            }
        }
        let solver: &mut dyn HierarchicalSolver = match &mut self.solver {
            Solver::ActiveSet(s) => s.as_mut(),
            Solver::Clarabel(s) => s.as_mut(),
        };
        let start = Instant::now();
        solver.solve(problem, &mut self.solution);
        microseconds(start)
    }
}

/// Returns the time since `start` in microseconds.
pub fn microseconds(start: Instant) -> f64 {
    start.elapsed().as_secs_f64() * 1e6
}

/// Times in microseconds, four bytes each.
#[derive(Default)]
pub struct Times(Vec<f32>);

impl Times {
    /// Adds a time.
    pub fn push(&mut self, us: f64) {
        self.0.push(us as f32);
    }

    /// Adds all times of another collection.
    pub fn extend(&mut self, other: &Times) {
        self.0.extend_from_slice(&other.0);
    }

    /// Returns the number of times.
    pub fn count(&self) -> usize {
        self.0.len()
    }

    /// Returns the median, the 99th percentile and the maximum.
    pub fn percentiles(&mut self) -> Percentiles {
        Percentiles::of(&mut self.0)
    }
}

/// Returns percentiles as JSON, in microseconds.
pub fn json_of(p: &Percentiles) -> Value {
    let short = |x: f64| (x * 1e3).round() / 1e3;
    json!({ "median": short(p.median), "p99": short(p.p99), "max": short(p.max) })
}

/// Returns percentiles as the cells of a table.
pub fn cells_of(p: &Percentiles) -> [String; 3] {
    [p.median, p.p99, p.max].map(|x| format!("{x:.1}"))
}

/// Returns a table whose columns from index `numbers` on are right-aligned.
pub fn table(header: &[&str], numbers: usize, rows: Vec<Vec<String>>) -> String {
    let mut table = Table::new();
    table.load_style(presets::UTF8_BORDERS_ONLY).set_header(header.to_vec());
    for row in rows {
        table.add_row(row);
    }
    for i in numbers..header.len() {
        if let Some(column) = table.column_mut(i) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    format!("{table}\n")
}

/// Returns a warning about the times of a debug build.
pub fn remark() -> &'static str {
    if cfg!(debug_assertions) { "a debug build: the times mean nothing\n" } else { "" }
}
