//! Planning layers: how, and what the answer is.
//!
//! | tasks to come | formulation | because |
//! |---|---|---|
//! | up to 64 | branch and bound | proves, or says how far it may be off |
//! | more | batches | each batch is small; the bound of the whole stands beside it |

use serde::{Deserialize, Serialize};

use crate::engine::{Budget, EngineError, Highs, Microlp, Milp};
use crate::plan::{Limit, Plan, Statistics, Status};
use crate::schedule::choose::Engine;

use super::batches::batches;
use super::branch::{Found, branch, root_bound};
use super::check::Mistake;
use super::instance::Instance;
use super::mixed::mixed;
use super::problem::Problem;
use super::steps::{Step, to_plan};
use super::timeline;

/// The most tasks that are planned at once if nobody says.
const MOST_AT_ONCE: usize = 64;
/// Tasks in a batch if nobody says: thesis 6.4.3.
pub const BATCH: usize = 4;

/// How a layered plan is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Formulation {
    /// Branch and bound on agents and objects, with speeds in closed form.
    Branch,
    /// Mixed-integer program with tangents of the energy: the reference, for small problems.
    Mixed,
    /// Algorithm 6: some tasks at a time.
    Batches,
}

/// How to plan.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Options {
    /// The formulation; none: the number of tasks decides.
    pub formulation: Option<Formulation>,
    /// The engine of the mixed-integer program.
    pub engine: Engine,
    /// Tasks in a batch, at least 1.
    pub batch: usize,
    /// How much work it may be; `nodes` are parts of the branch and bound.
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
    /// An engine gave no answer.
    #[error(transparent)]
    Engine(#[from] EngineError),
}

/// The formulation for a problem, as [`plan`] takes it.
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
        None if count > MOST_AT_ONCE => {
            (Formulation::Batches, format!("{count} tasks are to come, and {MOST_AT_ONCE} are planned at once"))
        }
        None => (Formulation::Branch, format!("{count} tasks are few enough to be planned at once")),
    };
    Ok(Choice { formulation, why })
}

/// Plans. The same problem and options give the same plan unless its status says that the wall time ended it.
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
            let (steps, statistics, stopped) = batches(problem, options.batch, &options.budget).ok_or_else(failed)?;
            let choices = choices(&instance, &steps).ok_or_else(failed)?;
            let retimed = timeline::steps(&instance, &choices);
            let cost = super::cost::cost(problem, &retimed).total();
            let bound = root_bound(&instance, cost, &options.budget).min(cost);
            let gap = if cost > 0.0 { (cost - bound) / cost } else { 0.0 };
            let status = if gap <= options.budget.gap {
                Status::Proven { bound }
            } else {
                Status::Gap { bound, gap, stopped: stopped.unwrap_or(Limit::Work) }
            };
            (Found { choices, status, statistics }, format!("batches of {}", options.batch.max(1)))
        }
    };
    let steps = timeline::steps(&instance, &found.choices);
    Ok(to_plan(problem, &steps, found.status, engine, found.statistics))
}

/// The choices of an instance that these steps made.
fn choices(instance: &Instance<'_>, steps: &[Step]) -> Option<super::dual::Choices> {
    let of = |job: &super::instance::Job| {
        let step = steps.iter().find(|step| step.task == job.task)?;
        Some((step.agent, job.objects.iter().position(|object| *object == step.object)?))
    };
    instance.jobs.iter().map(of).collect()
}

/// Steps of a part of a plan, how much work, what ended the search of a part.
pub(super) type Parts = (Vec<Step>, Statistics, Option<Limit>);
