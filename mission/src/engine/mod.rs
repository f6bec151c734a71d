//! Solvers behind traits: the interface of mixed-integer linear programs, and its engines.
//!
//! [`Microlp`] is pure Rust and always available. [`Highs`] is far more powerful; it is external and found at run time.

pub mod cp;
pub mod highs;
pub mod microlp;

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::plan::Limit;

pub use self::highs::Highs;
pub use self::microlp::Microlp;

/// Engine for mixed-integer programs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Engine {
    /// The built-in engine, which is always available.
    #[default]
    BuiltIn,
    /// HiGHS, which must be installed.
    Highs,
}

impl Engine {
    /// All engines.
    pub const ALL: [Engine; 2] = [Engine::BuiltIn, Engine::Highs];

    /// Returns the name of the engine, as in options.
    pub fn name(self) -> &'static str {
        match self {
            Engine::BuiltIn => "built-in",
            Engine::Highs => "highs",
        }
    }
}

/// Limits on the work of a planner. `nodes` ends every run at the same point; `time` is an additional limit, and the
/// status of a plan reports if it ended the search.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Budget {
    /// Wall time of the whole planning.
    pub time: Duration,
    /// Nodes of branch and bound, or conflicts of a constraint program.
    pub nodes: u64,
    /// Relative gap between cost and bound at which a plan counts as proven. More than 0.
    pub gap: f64,
}

impl Default for Budget {
    fn default() -> Budget {
        Budget { time: Duration::from_secs(10), nodes: 1_000_000, gap: 1e-4 }
    }
}

/// A running clock with a budget.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Watch {
    begun: Instant,
    budget: Budget,
}

impl Watch {
    /// Starts the clock.
    pub fn new(budget: &Budget) -> Watch {
        Watch { begun: Instant::now(), budget: *budget }
    }

    /// Returns true if the time limit is reached.
    pub fn is_over(&self) -> bool {
        #[cfg(test)]
        if looks::count() {
            return true;
        }
        self.begun.elapsed() >= self.budget.time
    }

    /// Returns the same clock with the limit at this share of the remaining time.
    pub fn share(&self, share: f64) -> Watch {
        let gone = self.begun.elapsed();
        let time = gone.saturating_add(self.budget.time.saturating_sub(gone).mul_f64(share));
        Watch { begun: self.begun, budget: Budget { time, ..self.budget } }
    }

    /// Returns the budget with the remaining time.
    pub fn left(&self) -> Budget {
        Budget { time: self.budget.time.saturating_sub(self.begun.elapsed()), ..self.budget }
    }
}

/// Counts checks of the clock, so that tests can end the time at any of them.
#[cfg(test)]
pub(crate) mod looks {
    use std::cell::Cell;

    thread_local! {
        static COUNT: Cell<u64> = const { Cell::new(0) };
        static LAST: Cell<u64> = const { Cell::new(u64::MAX) };
    }

    /// Counts a check; returns true if the time has ended by then.
    pub fn count() -> bool {
        COUNT.set(COUNT.get() + 1);
        COUNT.get() > LAST.get()
    }

    /// Runs `run` with a time limit after this number of checks; returns the number of checks and the result.
    pub fn ended_after<T>(looks: u64, run: impl FnOnce() -> T) -> (u64, T) {
        COUNT.set(0);
        LAST.set(looks);
        let found = run();
        LAST.set(u64::MAX);
        (COUNT.get(), found)
    }
}

/// Reason why a dynamic program stopped early.
#[derive(Debug)]
pub(crate) enum Halt {
    /// Its tables are too large.
    Size,
    /// The time limit is reached.
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
    /// Lower bound, finite.
    pub low: f64,
    /// Upper bound; may be infinite.
    pub high: f64,
    /// True if only integers are valid.
    pub integer: bool,
}

/// A constraint `low <= sum of terms <= high`; either end may be infinite.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Columns and their coefficients, each column at most once.
    pub terms: Vec<(usize, f64)>,
    /// Lower bound.
    pub low: f64,
    /// Upper bound.
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
    /// Adds a real variable from `low` to `high`; returns its column.
    pub fn real(&mut self, cost: f64, low: f64, high: f64) -> usize {
        self.columns.push(Column { cost, low, high, integer: false });
        self.columns.len() - 1
    }

    /// Adds a binary variable; returns its column.
    pub fn binary(&mut self, cost: f64) -> usize {
        self.columns.push(Column { cost, low: 0.0, high: 1.0, integer: true });
        self.columns.len() - 1
    }

    /// Adds `low <= terms <= high`. Terms of the same column are summed, zeros are omitted.
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

    /// Adds `terms >= low`.
    pub fn at_least(&mut self, low: f64, terms: impl IntoIterator<Item = (usize, f64)>) {
        self.row(low, terms, f64::INFINITY);
    }

    /// Adds `terms <= high`.
    pub fn at_most(&mut self, terms: impl IntoIterator<Item = (usize, f64)>, high: f64) {
        self.row(f64::NEG_INFINITY, terms, high);
    }
}

/// Result of an engine.
#[derive(Clone, Debug, PartialEq)]
pub struct Answer {
    /// The best point, by column; `None` if a limit was reached before the first one.
    pub values: Option<Vec<f64>>,
    /// Lower bound on the cost of every point.
    pub bound: f64,
    /// Limit that ended the search; `None`: `values` is optimal to within the requested gap.
    pub stopped: Option<Limit>,
    /// Number of nodes of the search.
    pub nodes: u64,
}

/// Reason why an engine failed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum EngineError {
    /// The engine is not installed.
    #[error("the engine {engine} is not there ({searched}); install it with `{install}`")]
    Missing {
        /// Name of the engine.
        engine: String,
        /// Places that were searched.
        searched: String,
        /// Command that installs it.
        install: String,
    },
    /// The numbers of the problem are out of the engine's range.
    #[error("the engine {engine} cannot hold the problem: {what}")]
    Overflow {
        /// Name of the engine.
        engine: String,
        /// Description of the value that is too large.
        what: String,
    },
    /// The program is infeasible.
    #[error("the engine {engine} found that the program has no point")]
    Infeasible {
        /// Name of the engine.
        engine: String,
    },
    /// The engine failed on a feasible problem.
    #[error("the engine {engine} failed: {message}")]
    Failed {
        /// Name of the engine.
        engine: String,
        /// Message of the engine.
        message: String,
    },
}

/// A solver of mixed-integer linear programs.
pub trait Milp {
    /// Returns the name of the engine for output.
    fn name(&self) -> &str;

    /// Minimises the cost. `start` holds values of some columns, from a feasible point.
    ///
    /// # Errors
    ///
    /// The program is infeasible, or the engine failed.
    fn solve(&self, model: &Model, start: &[(usize, f64)], budget: &Budget) -> Result<Answer, EngineError>;
}
