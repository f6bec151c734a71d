//! Solvers behind traits: what a planner asks of a mixed-integer linear program, and who can answer.
//!
//! [`Microlp`] is pure Rust and always there. [`Highs`] is far stronger and comes from outside, found at run time.

pub mod cp;
pub mod highs;
pub mod microlp;

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::plan::Limit;

pub use self::highs::Highs;
pub use self::microlp::Microlp;

/// Which engine solves mixed-integer programs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Engine {
    /// The one that is always there.
    #[default]
    BuiltIn,
    /// HiGHS, which must be installed.
    Highs,
}

impl Engine {
    /// All of them.
    pub const ALL: [Engine; 2] = [Engine::BuiltIn, Engine::Highs];

    /// The name by which it is asked for.
    pub fn name(self) -> &'static str {
        match self {
            Engine::BuiltIn => "built-in",
            Engine::Highs => "highs",
        }
    }
}

/// How much work a planner may do. `nodes` ends every run at the same place; `time` is the outer bound, and a plan says
/// when it was that which ended the search.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Budget {
    /// Wall time of the whole planning.
    pub time: Duration,
    /// Nodes of a branch and bound, or conflicts of a constraint program.
    pub nodes: u64,
    /// Relative gap between cost and bound at which a plan counts as proven. More than 0.
    pub gap: f64,
}

impl Default for Budget {
    fn default() -> Budget {
        Budget { time: Duration::from_secs(10), nodes: 1_000_000, gap: 1e-4 }
    }
}

/// The time of a budget while it passes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Watch {
    begun: Instant,
    budget: Budget,
}

impl Watch {
    /// From now on.
    pub fn new(budget: &Budget) -> Watch {
        Watch { begun: Instant::now(), budget: *budget }
    }

    /// The time has passed.
    pub fn is_over(&self) -> bool {
        #[cfg(test)]
        if looks::count() {
            return true;
        }
        self.begun.elapsed() >= self.budget.time
    }

    /// The same clock, over when this share of what is left now has passed.
    pub fn share(&self, share: f64) -> Watch {
        let gone = self.begun.elapsed();
        let time = gone.saturating_add(self.budget.time.saturating_sub(gone).mul_f64(share));
        Watch { begun: self.begun, budget: Budget { time, ..self.budget } }
    }

    /// The budget with the time that is left.
    pub fn left(&self) -> Budget {
        Budget { time: self.budget.time.saturating_sub(self.begun.elapsed()), ..self.budget }
    }
}

/// Looks at the clock, counted, so that tests can let the time end at any of them.
#[cfg(test)]
pub(crate) mod looks {
    use std::cell::Cell;

    thread_local! {
        static COUNT: Cell<u64> = const { Cell::new(0) };
        static LAST: Cell<u64> = const { Cell::new(u64::MAX) };
    }

    /// Counts a look: whether the time has ended by it.
    pub fn count() -> bool {
        COUNT.set(COUNT.get() + 1);
        COUNT.get() > LAST.get()
    }

    /// Runs with a time that ends after so many looks at the clock: the number of looks, and the result.
    pub fn ended_after<T>(looks: u64, run: impl FnOnce() -> T) -> (u64, T) {
        COUNT.set(0);
        LAST.set(looks);
        let found = run();
        LAST.set(u64::MAX);
        (COUNT.get(), found)
    }
}

/// Why a dynamic program did not come to its end.
#[derive(Debug)]
pub(crate) enum Halt {
    /// Its tables grow too large.
    Size,
    /// The time of the budget has passed.
    Time,
    /// A solver failed.
    Engine(EngineError),
}

impl From<EngineError> for Halt {
    fn from(error: EngineError) -> Halt {
        Halt::Engine(error)
    }
}

/// A variable of a [`Model`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Column {
    /// Coefficient in the cost.
    pub cost: f64,
    /// Least value, finite.
    pub low: f64,
    /// Greatest value; may be infinite.
    pub high: f64,
    /// Only whole values.
    pub integer: bool,
}

/// A constraint `low <= sum of terms <= high`; either end may be infinite.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Columns and their coefficients, each column at most once.
    pub terms: Vec<(usize, f64)>,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// A mixed-integer linear program, to be minimised.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Model {
    /// Variables.
    pub columns: Vec<Column>,
    /// Constraints.
    pub rows: Vec<Row>,
    /// Constant of the cost.
    pub offset: f64,
}

impl Model {
    /// A new real variable from `low` to `high`: its column.
    pub fn real(&mut self, cost: f64, low: f64, high: f64) -> usize {
        self.columns.push(Column { cost, low, high, integer: false });
        self.columns.len() - 1
    }

    /// A new variable that is 0 or 1: its column.
    pub fn binary(&mut self, cost: f64) -> usize {
        self.columns.push(Column { cost, low: 0.0, high: 1.0, integer: true });
        self.columns.len() - 1
    }

    /// `low <= terms <= high`. Terms of the same column are added up, zeros left out.
    pub fn row(&mut self, low: f64, terms: impl IntoIterator<Item = (usize, f64)>, high: f64) {
        let mut terms: Vec<(usize, f64)> = terms.into_iter().collect();
        terms.sort_by_key(|(column, _)| *column);
        terms.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1 += next.1;
            }
            same
        });
        terms.retain(|(_, coefficient)| *coefficient != 0.0);
        if !terms.is_empty() {
            self.rows.push(Row { terms, low, high });
        }
    }

    /// `terms >= low`.
    pub fn at_least(&mut self, low: f64, terms: impl IntoIterator<Item = (usize, f64)>) {
        self.row(low, terms, f64::INFINITY);
    }

    /// `terms <= high`.
    pub fn at_most(&mut self, terms: impl IntoIterator<Item = (usize, f64)>, high: f64) {
        self.row(f64::NEG_INFINITY, terms, high);
    }
}

/// What an engine found.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// The best point, by column; none if a limit came first.
    pub values: Option<Vec<f64>>,
    /// Lower bound on the cost of every point.
    pub bound: f64,
    /// What ended the search; none: `values` is optimal to within the gap asked for.
    pub stopped: Option<Limit>,
    /// Nodes of the search.
    pub nodes: u64,
}

/// Why an engine gave no answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum EngineError {
    /// It is not on this machine.
    #[error("the engine {engine} is not there ({searched}); install it with `{install}`")]
    Missing {
        /// Its name.
        engine: String,
        /// Where it was looked for.
        searched: String,
        /// The one command that installs it.
        install: String,
    },
    /// Its numbers cannot hold the problem.
    #[error("the engine {engine} cannot hold the problem: {what}")]
    Overflow {
        /// Its name.
        engine: String,
        /// What is too large.
        what: String,
    },
    /// The program has no point.
    #[error("the engine {engine} found that the program has no point")]
    Infeasible {
        /// Its name.
        engine: String,
    },
    /// It failed on a problem that has a solution.
    #[error("the engine {engine} failed: {message}")]
    Failed {
        /// Its name.
        engine: String,
        /// What it said.
        message: String,
    },
}

/// A solver of mixed-integer linear programs.
pub trait Milp {
    /// The name by which it is printed.
    fn name(&self) -> &str;

    /// Minimises. `start` gives values to some columns, from a point that is feasible.
    ///
    /// # Errors
    ///
    /// The program has no point, or the engine failed.
    fn solve(&self, model: &Model, start: &[(usize, f64)], budget: &Budget) -> Result<Answer, EngineError>;
}
