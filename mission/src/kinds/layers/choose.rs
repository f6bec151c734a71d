//! Planning of layers, with the choice of the formulation.
//!
//! Branch and bound, unless a batch size is given: it proves plans of about thirty tasks, and for hundreds of tasks its
//! first bound and plan are within a few percent. Batches are the method of the thesis; the bound of the whole problem
//! is reported with their plan.

use serde::{Deserialize, Serialize};

use super::plan::Plan;
use crate::engine::Engine;
use crate::engine::{Budget, EngineError, Highs, Microlp, Milp};
use crate::plan::{Limit, Statistics, Status};
use crate::planned;

use super::batches::batches;
use super::branch::{Found, branch, root_bound};
use super::check::Mistake;
use super::cost::cost_at;
use super::instance::Instance;
use super::mixed::mixed;
use super::problem::Problem;
use super::steps::{Step, to_plan};
use super::timeline;

/// Default number of tasks in a batch: thesis 6.4.3.
pub const BATCH: usize = 4;
/// Default limit of branch-and-bound nodes.
const PARTS: u64 = 20_000;

/// Number of branch-and-bound nodes that take about a second: fewer for a larger problem. A search that ends by such a
/// count ends at the same node in every run.
pub fn parts_of_a_second(problem: &Problem) -> u64 {
    let size = problem.tasks.len() * problem.agents.len() * problem.objects.len().max(1);
    (2_500_000 / size.max(1) as u64).clamp(1, 1000)
}

/// Formulation of the planning problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Formulation {
    /// Branch and bound on agents and objects, with speeds in closed form.
    Branch,
    /// Mixed-integer program with tangents of the energy: the reference for tests, for small problems.
    Mixed,
    /// Algorithm 6: planning in batches of tasks.
    Batches,
}

impl Formulation {
    /// All formulations.
    pub const ALL: [Formulation; 3] = [Formulation::Branch, Formulation::Mixed, Formulation::Batches];

    /// Returns the name of the formulation, as in options and output.
    pub fn name(self) -> &'static str {
        match self {
            Formulation::Branch => "branch",
            Formulation::Mixed => "mixed",
            Formulation::Batches => "batches",
        }
    }
}

/// Options of the planner.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Options {
    /// The formulation; `None`: batches if `batch` is set, else branch and bound.
    pub formulation: Option<Formulation>,
    /// The engine for the mixed-integer program.
    pub engine: Engine,
    /// Number of tasks in a batch, at least 1; `None`: all at once.
    pub batch: Option<usize>,
    /// Limits on the work of the search; `nodes` limits the nodes of branch and bound.
    pub budget: Budget,
}

impl Default for Options {
    fn default() -> Options {
        let budget = Budget { nodes: PARTS, ..Budget::default() };
        Options { formulation: None, engine: Engine::BuiltIn, batch: None, budget }
    }
}

/// A formulation, and the reason for its choice.
pub type Choice = planned::Choice<Formulation>;

/// Reason why there is no plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum Refusal {
    /// The problem has mistakes.
    #[error("the problem has {} mistakes", .0.len())]
    Problem(Vec<Mistake>),
    /// An engine failed.
    #[error(transparent)]
    Engine(#[from] EngineError),
}

/// Returns the formulation that [`plan`] uses for a problem.
///
/// # Errors
///
/// The problem has mistakes.
pub fn choose(problem: &Problem, options: &Options) -> Result<Choice, Refusal> {
    let mistakes = problem.check();
    if !mistakes.is_empty() {
        return Err(Refusal::Problem(mistakes));
    }
    let count = problem.tasks.len() - problem.begun.len();
    let (formulation, why) = match options.formulation {
        Some(formulation) => (formulation, "it was asked for".into()),
        None if options.batch.is_some() => (Formulation::Batches, "a batch size is given".into()),
        None => (Formulation::Branch, format!("{count} tasks are planned at once")),
    };
    Ok(Choice { formulation, why })
}

/// Plans a problem. The same problem and options give the same plan, unless its status reports the time limit.
///
/// # Errors
///
/// The problem has mistakes, or an engine is missing or failed.
pub fn plan(problem: &Problem, options: &Options) -> Result<Plan, Refusal> {
    let formulation = choose(problem, options)?.formulation;
    let instance = Instance::whole(problem);
    let failed = || EngineError::Failed { engine: "branch and bound".into(), message: "no plan".into() };
    let (found, engine) = match formulation {
        Formulation::Branch => (branch(&instance, &options.budget).ok_or_else(failed)?, "branch and bound".into()),
        Formulation::Mixed => {
            let milp: Box<dyn Milp> = match options.engine {
                Engine::Highs => Box::new(Highs::find()?),
                Engine::BuiltIn => Box::new(Microlp),
            };
            let found = mixed(&instance, milp.as_ref(), &options.budget)?;
            (found, format!("mixed-integer program, {}", milp.name()))
        }
        Formulation::Batches => {
            let size = options.batch.unwrap_or(BATCH).max(1);
            // A quarter of the time is reserved for the bound.
            let quarter = options.budget.time / 4;
            let most = Budget { time: 3 * quarter, ..options.budget };
            let (steps, statistics, stopped) = batches(&instance, size, &most).ok_or_else(failed)?;
            let choices = choices(&instance, &steps).ok_or_else(failed)?;
            let retimed = timeline::steps(&instance, &choices);
            let cost = cost_at(problem, &instance.scales, &retimed).total();
            let bound = root_bound(&instance, cost, &Budget { time: quarter, ..options.budget }).min(cost);
            let gap = if cost > 0.0 { (cost - bound) / cost } else { 0.0 };
            let status = if gap <= options.budget.gap {
                Status::Proven { bound }
            } else {
                Status::Gap { bound, gap, stopped: stopped.unwrap_or(Limit::Work) }
            };
            (Found { choices, status, statistics }, format!("batches of {size}"))
        }
    };
    let steps = timeline::steps(&instance, &found.choices);
    Ok(to_plan(problem, &steps, found.status, engine, found.statistics))
}

/// Converts steps into choices of an instance; `None` if they do not fit.
fn choices(instance: &Instance<'_>, steps: &[Step]) -> Option<super::dual::Choices> {
    let of = |job: &super::instance::Job| {
        let step = steps.iter().find(|step| step.task == job.task)?;
        Some((step.agent, job.objects.iter().position(|object| *object == step.object)?))
    };
    instance.jobs.iter().map(of).collect()
}

/// Parts of a result: steps, statistics, and the limit that ended the search of a batch.
pub(super) type Parts = (Vec<Step>, Statistics, Option<Limit>);
