//! Planning a schedule: which formulation for which problem, and why.
//!
//! | problem | formulation | because |
//! |---|---|---|
//! | every way takes a fixed time | constraint program | proves ten operations in a fraction of a second |
//! | speeds are decided, few operations | position form | bounds the cost; re-timing is exact |
//! | more operations than one of these proves | batches | each batch is small; no bound |

use serde::{Deserialize, Serialize};

use crate::engine::{Budget, EngineError, Highs, Microlp, Milp};
use crate::plan::{Limit, Plan, Statistics, Status};

use super::assistance::{Assistance, to_plan};
use super::batches::batches;
use super::check::Mistake;
use super::constraint::constraint;
use super::exact::{Found, exact};
use super::instance::Instance;
use super::problem::Problem;

/// The most operations that the constraint program is given at once.
const MOST_CONSTRAINT: usize = 14;
/// The most operations that the built-in engine is given at once.
const MOST_BUILT_IN: usize = 6;
/// The most operations that HiGHS is given at once.
const MOST_HIGHS: usize = 14;
/// Operations in a batch if nobody says.
pub const BATCH: usize = 4;

/// How a schedule is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Formulation {
    /// Mixed-integer program in position form, with exact re-timing.
    Position,
    /// Constraint program; for fixed durations only.
    Constraint,
    /// Algorithm 4: some operations at a time.
    Batches,
}

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

/// How to plan.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Options {
    /// The formulation; none: [`choose`] says.
    pub formulation: Option<Formulation>,
    /// The engine of the position form.
    pub engine: Engine,
    /// Operations in a batch, at least 1.
    pub batch: usize,
    /// How much work it may be.
    pub budget: Budget,
}

impl Default for Options {
    fn default() -> Options {
        Options { formulation: None, engine: Engine::BuiltIn, batch: BATCH, budget: Budget::default() }
    }
}

/// A formulation, and why it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Choice {
    /// The formulation.
    pub formulation: Formulation,
    /// Why it, in a sentence.
    pub why: String,
}

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum Refusal {
    /// The problem is wrong.
    #[error("the problem has {} mistakes", .0.len())]
    Problem(Vec<Mistake>),
    /// The formulation that was asked for needs fixed durations.
    #[error("a constraint program needs speeds that are points, and {robot} has a range")]
    Speeds {
        /// The name of a robot whose ways may take longer or shorter.
        robot: String,
    },
    /// An engine gave no answer.
    #[error(transparent)]
    Engine(#[from] EngineError),
}

/// The formulation for a problem in which [`Problem::check`] finds no mistake.
pub fn choose(problem: &Problem, options: &Options) -> Choice {
    let instance = Instance::new(problem);
    let count = instance.jobs.len();
    let chosen = |formulation, why: String| Choice { formulation, why };
    if let Some(formulation) = options.formulation {
        return chosen(formulation, "it was asked for".into());
    }
    let (exact, most, name) = if instance.is_fixed() {
        (Formulation::Constraint, MOST_CONSTRAINT, "the constraint program")
    } else {
        match options.engine {
            Engine::BuiltIn => (Formulation::Position, MOST_BUILT_IN, "the built-in engine"),
            Engine::Highs => (Formulation::Position, MOST_HIGHS, "HiGHS"),
        }
    };
    if count > most {
        let why = format!("{count} operations are to be served, and {name} is given {most} at once");
        return chosen(Formulation::Batches, why);
    }
    let why = match exact {
        Formulation::Constraint => "every way takes a fixed time",
        _ => "speeds are decided",
    };
    chosen(exact, format!("{why}, and {count} operations are few enough for {name}"))
}

/// Plans a schedule. The same problem and options give the same plan unless its status says that the wall time ended it.
///
/// # Errors
///
/// The problem has mistakes, or an engine is missing or failed.
pub fn plan(problem: &Problem, options: &Options) -> Result<Plan, Refusal> {
    let mistakes = problem.check();
    if !mistakes.is_empty() {
        return Err(Refusal::Problem(mistakes));
    }
    let choice = choose(problem, options);
    let solver = Solver::new(options, choice.formulation == Formulation::Constraint)?;
    if choice.formulation == Formulation::Batches {
        let (schedule, statistics, stopped) = batches(problem, options.batch, &solver)?;
        let engine = format!("batches of {}, {}", options.batch.max(1), solver.name(problem));
        return Ok(to_plan(problem, &schedule, Status::Unbounded { stopped }, engine, statistics));
    }
    let found = solver.solve(problem, &options.budget)?;
    let status = found.status;
    Ok(to_plan(problem, &found.timed.schedule, status, solver.name(problem), found.statistics))
}

/// What solves a problem, or a part of one, at once.
pub(crate) struct Solver {
    milp: Option<Box<dyn Milp>>,
    constraint: Option<bool>,
    pub budget: Budget,
}

impl Solver {
    fn new(options: &Options, asked_constraint: bool) -> Result<Solver, EngineError> {
        let forced = options.formulation.filter(|formulation| *formulation != Formulation::Batches);
        let constraint = forced.map(|formulation| formulation == Formulation::Constraint);
        let milp: Option<Box<dyn Milp>> = match options.engine {
            _ if asked_constraint => None,
            Engine::BuiltIn => Some(Box::new(Microlp)),
            Engine::Highs => Some(Box::new(Highs::find()?)),
        };
        Ok(Solver { milp, constraint, budget: options.budget })
    }

    fn by_constraint(&self, instance: &Instance) -> bool {
        self.constraint.unwrap_or_else(|| instance.is_fixed())
    }

    fn name(&self, problem: &Problem) -> String {
        match &self.milp {
            Some(milp) if !self.by_constraint(&Instance::new(problem)) => format!("position form, {}", milp.name()),
            _ => "constraint program, pumpkin".into(),
        }
    }

    /// The schedule of a problem without mistakes.
    pub fn solve(&self, problem: &Problem, budget: &Budget) -> Result<Found, Refusal> {
        let instance = Instance::new(problem);
        if self.by_constraint(&instance) {
            if !instance.is_fixed() {
                let ranged = |m: &usize| instance.jobs.iter().any(|job| job.ways[*m].iter().any(|way| !way.is_fixed()));
                let robot = (0..problem.robots.len()).find(ranged).map(|m| problem.robots[m].name.clone());
                return Err(Refusal::Speeds { robot: robot.unwrap_or_default() });
            }
            return Ok(constraint(&instance, budget)?);
        }
        match &self.milp {
            Some(milp) => Ok(exact(&instance, milp.as_ref(), budget)?),
            None => Ok(exact(&instance, &Microlp, budget)?),
        }
    }
}

/// A schedule in parts: what it is, how much work, what ended the search of a part.
pub(crate) type Parts = (Vec<Assistance>, Statistics, Option<Limit>);
