//! Solving the program of a plan: the engine, the start from the last plan, and words for what cannot be met.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use super::foresight::Foresight;
use super::problem::{EngineChoice, Problem};
use super::program::{Binary, Group, Present, Program, Trajectories, build};
use crate::engine::{Budget, EngineError, Highs, Microlp, Milp};
use crate::plan::Limit;

/// How many times the time of a plan the first one has, which is made before the mission begins.
pub const FIRST: f64 = 20.0;
/// Share of the time of a plan that the search for a cause may take.
const CAUSE: f64 = 0.5;

/// A plan of the robots.
#[derive(Clone, Debug, PartialEq)]
pub struct Best {
    /// What the robots do.
    pub trajectories: Trajectories,
    /// Cost (10a) without the rewards of the person.
    pub cost: f64,
    /// A lower bound on the cost of every plan.
    pub bound: f64,
    /// The limit that ended the search; none: the plan is the best one to within the gap.
    pub stopped: Option<Limit>,
    /// Nodes of the search.
    pub nodes: u64,
}

impl Best {
    /// `(cost - bound) / |cost|`, zero or more.
    pub fn gap(&self) -> f64 {
        ((self.cost - self.bound) / self.cost.abs().max(1e-9)).max(0.0)
    }
}

/// Reason why there is no plan.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoPlan {
    /// No motion meets all constraints; without this group there is one. None: the group was not found in time.
    #[error("{}", match .0 { Some(group) => format!("no motion meets {}", group.words()), None => "no motion meets all constraints".into() })]
    Infeasible(Option<Group>),
    /// The time ended before a plan was found.
    #[error("no plan was found in time")]
    Late,
    /// The engine failed.
    #[error(transparent)]
    Engine(#[from] EngineError),
}

/// An engine, with the last plan as the start of the next one.
pub struct Solver {
    engine: Box<dyn Milp + Send>,
    /// Values of the binaries of the last plan, sorted by their meaning.
    last: Vec<(Binary, f64)>,
}

impl std::fmt::Debug for Solver {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Solver").field("engine", &self.engine.name()).finish_non_exhaustive()
    }
}

impl Solver {
    /// Finds the engine.
    ///
    /// # Errors
    /// It is not installed.
    pub fn find(wanted: EngineChoice) -> Result<Solver, EngineError> {
        // Python is asked for its folders once.
        static IS_THERE: OnceLock<bool> = OnceLock::new();
        let engine: Box<dyn Milp + Send> = match wanted {
            EngineChoice::Highs => Box::new(Highs::find()?),
            EngineChoice::BuiltIn => Box::new(Microlp),
            EngineChoice::Auto => match *IS_THERE.get_or_init(|| Highs::find().is_ok()) {
                true => Box::new(Highs::find()?),
                false => Box::new(Microlp),
            },
        };
        Ok(Solver { engine, last: Vec::new() })
    }

    /// Name of the engine.
    pub fn name(&self) -> &str {
        self.engine.name()
    }

    /// A period has passed: what the last plan had in its next period is now in its first one.
    pub fn pass_period(&mut self) {
        self.last = self.last.iter().filter_map(|(binary, value)| Some((binary.earlier()?, *value))).collect();
        self.last.sort_by(|a, b| a.0.cmp(&b.0));
    }

    /// The last plan is of no use any more.
    pub fn forget(&mut self) {
        self.last.clear();
    }

    /// Plans.
    ///
    /// # Errors
    /// See [`NoPlan`].
    pub fn plan(
        &mut self,
        problem: &Problem,
        present: &Present,
        foresight: &Foresight,
        time: Duration,
    ) -> Result<Best, NoPlan> {
        let begun = Instant::now();
        let program = build(problem, present, foresight, None).map_err(|group| NoPlan::Infeasible(Some(group)))?;
        let budget = Budget { time, nodes: problem.planner.nodes, gap: problem.planner.gap };
        let start = program.start(|binary| {
            let found = self.last.binary_search_by(|(of, _)| of.cmp(&binary));
            found.ok().map(|index| self.last[index].1)
        });
        let answer = match self.engine.solve(&program.model, &start, &budget) {
            Ok(answer) => answer,
            Err(EngineError::Infeasible { .. }) => {
                let left = time.saturating_sub(begun.elapsed()).mul_f64(CAUSE);
                return Err(NoPlan::Infeasible(self.cause(problem, present, foresight, left)));
            }
            Err(other) => return Err(other.into()),
        };
        let values = answer.values.ok_or(NoPlan::Late)?;
        self.remember(&program, &values);
        let cost = values.iter().zip(&program.model.columns).map(|(x, column)| x * column.cost).sum();
        let trajectories = program.trajectories(problem, present, &values);
        Ok(Best { trajectories, cost, bound: answer.bound, stopped: answer.stopped, nodes: answer.nodes })
    }

    fn remember(&mut self, program: &Program, values: &[f64]) {
        self.last = program.binaries.iter().map(|(binary, column)| (*binary, values[*column].round())).collect();
        self.last.sort_by(|a, b| a.0.cmp(&b.0));
    }

    /// The first group of constraints without which there is a plan for the first two periods, which is where plans become
    /// impossible.
    fn cause(&self, problem: &Problem, present: &Present, foresight: &Foresight, time: Duration) -> Option<Group> {
        let budget = Budget { time: time.div_f64(Group::ALL.len() as f64), nodes: problem.planner.nodes, gap: 0.5 };
        Group::ALL.into_iter().find(|group| {
            let program = build(problem, present, foresight, Some(*group));
            program
                .is_ok_and(|program| self.engine.solve(&program.model, &[], &budget).is_ok_and(|a| a.values.is_some()))
        })
    }
}
