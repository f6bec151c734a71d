//! Planning a schedule: which formulation for which problem, and why.
//!
//! | problem | formulation | because |
//! |---|---|---|
//! | each agent has one service to come | subsets | robots meet in the sharing and the end alone; weights may be uneven |
//! | several services of an agent, few operations | orders | proves the vineyard, where the position form does not; with fixed durations the constraint program tries first |
//! | more of them, or some waits gain by being long, every way takes a fixed time | constraint program | knows the order of an agent's operations; its times are whole |
//! | some waits gain by being long, few operations | position form | bounds the cost; re-timing is exact |
//! | more operations than one of these proves | batches | each batch is small; a relaxation bounds the whole |

use serde::{Deserialize, Serialize};

use crate::engine::{Budget, Engine, EngineError, Halt, Highs, Microlp, Milp, Watch};
use crate::plan::{Plan, Statistics, Status};

use super::assistance::{Assistance, to_plan};
use super::batches::batches;
use super::check::Mistake;
use super::constraint::constraint;
use super::exact::{Found, exact, status};
use super::instance::Instance;
use super::problem::Problem;
use super::{orders, subsets};

/// The most operations that the constraint program is given at once.
const MOST_CONSTRAINT: usize = 12;
/// What solves it.
const CONSTRAINT: &str = "constraint program, pumpkin";
/// The steps that it is given before orders are searched.
const TRIED: u64 = 2000;
/// What searches orders.
const ORDERS: &str = "branch and bound";
/// The most operations that the built-in engine is given at once.
const MOST_BUILT_IN: usize = 12;
/// The most operations that HiGHS is given at once.
const MOST_HIGHS: usize = 16;
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
    /// Dynamic program over sets of operations; for one service to come for each agent.
    Subsets,
    /// Branch and bound over the order of services; for agents with several.
    Orders,
    /// Algorithm 4: some operations at a time.
    Batches,
}

impl Formulation {
    /// All of them.
    pub const ALL: [Formulation; 5] = [
        Formulation::Position,
        Formulation::Constraint,
        Formulation::Subsets,
        Formulation::Orders,
        Formulation::Batches,
    ];

    /// The name by which it is asked for and printed.
    pub fn name(self) -> &'static str {
        match self {
            Formulation::Position => "position",
            Formulation::Constraint => "constraint",
            Formulation::Subsets => "subsets",
            Formulation::Orders => "orders",
            Formulation::Batches => "batches",
        }
    }
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
    /// The formulation that was asked for is of another kind of problem.
    #[error(
        "a program of subsets needs one service to come for each agent, at most fourteen of them, and eleven with more than \
         two robots"
    )]
    NotSubsets,
    /// The formulation that was asked for is of another kind of problem.
    #[error(
        "a search of orders needs at most twelve services to come, ten with three robots and eight with more, and no wait \
         that weighs less than the ones before and after it"
    )]
    NotOrders,
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
    if mistakes.is_empty() { Ok(choice(problem, options)) } else { Err(Refusal::Problem(mistakes)) }
}

fn choice(problem: &Problem, options: &Options) -> Choice {
    let instance = Instance::new(problem);
    let count = instance.jobs.len();
    let chosen = |formulation, why: String| Choice { formulation, why };
    if let Some(formulation) = options.formulation {
        return chosen(formulation, "it was asked for".into());
    }
    if subsets::fits(&instance) {
        let why = format!("each agent has one service to come, {count} in all");
        return chosen(Formulation::Subsets, why);
    }
    if orders::fits(&instance) {
        let speeds = if instance.is_fixed() { "every way takes a fixed time" } else { "speeds are decided" };
        let why = format!("{speeds}, agents have several services to come, and {count} are few enough");
        return chosen(Formulation::Orders, why);
    }
    let (exact, most, name) = match options.engine {
        _ if instance.is_fixed() && count <= MOST_CONSTRAINT => {
            (Formulation::Constraint, MOST_CONSTRAINT, "the constraint program")
        }
        Engine::BuiltIn => (Formulation::Position, MOST_BUILT_IN, "the built-in engine"),
        Engine::Highs => (Formulation::Position, MOST_HIGHS, "HiGHS"),
    };
    if count > most {
        let why = format!("{count} operations are to be served, and {name} is given {most} at once");
        return chosen(Formulation::Batches, why);
    }
    let why = match exact {
        Formulation::Constraint => "every way takes a fixed time",
        _ if instance.is_fixed() => "the constraint program is too slow for so many operations",
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
    let choice = choose(problem, options)?;
    let solver = Solver::new(options, choice.formulation)?;
    if choice.formulation == Formulation::Batches {
        let (status, schedule, statistics) = batches(problem, options.batch, &solver)?;
        let engine = format!("batches of {}", options.batch.max(1));
        return Ok(to_plan(problem, &schedule, status, engine, statistics));
    }
    let (found, engine) = solver.solve(problem, &options.budget)?;
    Ok(to_plan(problem, &found.timed.schedule, found.status, engine, found.statistics))
}

/// What solves a problem, or a part of one, at once.
pub(crate) struct Solver {
    milp: Box<dyn Milp>,
    options: Options,
}

impl Solver {
    fn new(options: &Options, formulation: Formulation) -> Result<Solver, EngineError> {
        let needed = formulation != Formulation::Subsets && options.formulation != Some(Formulation::Constraint);
        let milp: Box<dyn Milp> = match options.engine {
            Engine::Highs if needed => Box::new(Highs::find()?),
            _ => Box::new(Microlp),
        };
        Ok(Solver { milp, options: *options })
    }

    /// How much work the whole planning may be.
    pub fn budget(&self) -> Budget {
        self.options.budget
    }

    /// The schedule of a problem without mistakes, and what found it. A part of a mission is never cut into parts again.
    pub fn solve(&self, problem: &Problem, budget: &Budget) -> Result<(Found, String), Refusal> {
        let watch = Watch::new(budget);
        let instance = Instance::new(problem);
        let asked = self.options.formulation.filter(|formulation| *formulation != Formulation::Batches);
        let formulation = asked.unwrap_or_else(|| match () {
            () if subsets::fits(&instance) => Formulation::Subsets,
            () if orders::fits(&instance) => Formulation::Orders,
            () if instance.is_fixed() && instance.jobs.len() <= MOST_CONSTRAINT => Formulation::Constraint,
            () => Formulation::Position,
        });
        match formulation {
            Formulation::Position | Formulation::Batches => self.position(&instance, budget),
            Formulation::Constraint if !instance.is_fixed() => {
                let ranged = |m: &usize| instance.jobs.iter().any(|job| job.ways[*m].iter().any(|way| !way.is_fixed()));
                let robot = (0..instance.robots.len()).find(ranged).map(|m| instance.machine(m).name.clone());
                Err(Refusal::Speeds { robot: robot.unwrap_or_default() })
            }
            Formulation::Constraint => match constraint(&instance, budget) {
                // Numbers too far apart for whole ones: where nobody asked for them, real ones do.
                Err(EngineError::Overflow { .. }) if asked.is_none() => self.position(&instance, &watch.left()),
                found => Ok((found?, CONSTRAINT.into())),
            },
            Formulation::Orders if !orders::fits(&instance) => Err(Refusal::NotOrders),
            Formulation::Orders if asked.is_none() && instance.is_fixed() => self.fixed(&instance, budget),
            Formulation::Orders => match orders::orders(&instance, budget) {
                Ok(found) => Ok((found, ORDERS.into())),
                Err(Halt::Engine(error)) => Err(error.into()),
                Err(_) if asked.is_some() => Err(Refusal::NotOrders),
                Err(_) => self.position(&instance, &watch.left()),
            },
            Formulation::Subsets if !subsets::fits(&instance) => Err(Refusal::NotSubsets),
            Formulation::Subsets => match subsets::best(&instance, budget) {
                Ok(found) => Ok((found, "subsets".into())),
                Err(Halt::Engine(error)) => Err(error.into()),
                Err(_) if asked.is_some() => Err(Refusal::NotSubsets),
                Err(_) => self.position(&instance, &watch.left()),
            },
        }
    }

    /// By the constraint program for a few steps, which prove a mission in which robots hardly get in each other's way, and
    /// by orders where they do not.
    fn fixed(&self, instance: &Instance, budget: &Budget) -> Result<(Found, String), Refusal> {
        let watch = Watch::new(budget);
        let few = Budget { nodes: budget.nodes.min(TRIED), ..*budget };
        let tried = match constraint(instance, &few) {
            Err(EngineError::Overflow { .. }) => None,
            found => Some(found?),
        };
        let tried = match tried {
            Some(found) if matches!(found.status, Status::Proven { .. }) => return Ok((found, CONSTRAINT.into())),
            tried => tried,
        };
        let mut found = match orders::orders(instance, &watch.left()) {
            Ok(found) => found,
            Err(Halt::Engine(error)) => return Err(error.into()),
            Err(_) => return Ok((constraint(instance, &watch.left())?, CONSTRAINT.into())),
        };
        if let Some(tried) = tried {
            found.statistics = found.statistics.plus(tried.statistics);
            if tried.timed.cost < found.timed.cost {
                let (bound, stopped) = (found.status.bound().unwrap_or(0.0), found.status.stopped());
                found.status = status(tried.timed.cost, bound, budget.gap, stopped);
                found.timed = tried.timed;
            }
        }
        Ok((found, ORDERS.into()))
    }

    /// By the position form.
    fn position(&self, instance: &Instance, budget: &Budget) -> Result<(Found, String), Refusal> {
        let found = exact(instance, self.milp.as_ref(), budget)?;
        Ok((found, format!("position form, {}", self.milp.name())))
    }
}

/// A schedule in parts: how sure, what it is, how much work.
pub(crate) type Parts = (Status, Vec<Assistance>, Statistics);
