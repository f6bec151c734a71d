//! Planning of a schedule, with the choice of the formulation.
//!
//! | problem | formulation | reason |
//! |---|---|---|
//! | one remaining service per agent | subsets | robots are coupled only by assignment and makespan; any weights |
//! | several per agent, few operations | orders | proves the vineyard; fixed durations: constraint program first |
//! | more, or waits that gain by length; fixed durations | constraint program | knows each agent's order |
//! | waits that gain by length, few operations | position form | bounds the cost; re-timing is exact |
//! | more operations than these can prove | batches | each batch is small; a relaxation bounds the whole |
//!
//! The position form does not prove the vineyard.

use serde::{Deserialize, Serialize};

use super::plan::Plan;
use crate::engine::{Budget, Engine, EngineError, Halt, Highs, Microlp, Milp, Watch};
use crate::plan::{Statistics, Status};
use crate::planned;

use super::assistance::{Assistance, to_plan};
use super::batches::batches;
use super::check::Mistake;
use super::constraint::constraint;
use super::exact::{Found, exact, status};
use super::instance::Instance;
use super::problem::Problem;
use super::{orders, subsets};

/// Maximum number of operations that the constraint program solves at once.
const MOST_CONSTRAINT: usize = 12;
/// Name of the engine for the constraint program.
const CONSTRAINT: &str = "constraint program, pumpkin";
/// Limit of solver steps for the constraint program before orders are searched.
const TRIED: u64 = 2000;
/// Name of the engine for orders.
const ORDERS: &str = "branch and bound";
/// Maximum number of operations that the built-in engine solves at once.
const MOST_BUILT_IN: usize = 12;
/// Maximum number of operations that HiGHS solves at once.
const MOST_HIGHS: usize = 16;
/// Default number of operations in a batch.
pub const BATCH: usize = 4;

/// Formulation of the planning problem.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Formulation {
    /// Mixed-integer program in position form, with exact re-timing.
    Position,
    /// Constraint program; for fixed durations only.
    Constraint,
    /// Dynamic program over sets of operations; only if each agent has one remaining service.
    Subsets,
    /// Branch and bound over the order of services; for agents with several remaining services.
    Orders,
    /// Algorithm 4: planning in batches of operations.
    Batches,
}

impl Formulation {
    /// All formulations.
    pub const ALL: [Formulation; 5] = [
        Formulation::Position,
        Formulation::Constraint,
        Formulation::Subsets,
        Formulation::Orders,
        Formulation::Batches,
    ];

    /// Returns the name of the formulation, as in options and output.
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

/// Options of the planner.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Options {
    /// The formulation; `None`: chosen by [`choose`].
    pub formulation: Option<Formulation>,
    /// The engine for the position form.
    pub engine: Engine,
    /// Number of operations in a batch, at least 1.
    pub batch: usize,
    /// Limits on the work of the search.
    pub budget: Budget,
}

impl Default for Options {
    fn default() -> Options {
        Options { formulation: None, engine: Engine::BuiltIn, batch: BATCH, budget: Budget::default() }
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
    /// The requested formulation needs fixed durations.
    #[error("a constraint program needs speeds that are points, and {robot} has a range")]
    Speeds {
        /// Name of a robot whose legs have variable durations.
        robot: String,
    },
    /// The subsets formulation was requested, but does not fit the problem.
    #[error(
        "a program of subsets needs one service to come for each agent, at most fourteen of them, and eleven with more than \
         two robots"
    )]
    NotSubsets,
    /// The orders formulation was requested, but does not fit the problem.
    #[error(
        "a search of orders needs at most twelve services to come, ten with three robots and eight with more, and no wait \
         that weighs less than the ones before and after it"
    )]
    NotOrders,
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
    if mistakes.is_empty() { Ok(choice(problem, options)) } else { Err(Refusal::Problem(mistakes)) }
}

fn choice(problem: &Problem, options: &Options) -> Choice {
    let instance = Instance::new(problem);
    let count = instance.jobs.len();
    let chosen = |formulation, why: String| Choice { formulation, why };
    if let Some(formulation) = options.formulation {
        return chosen(formulation, "as requested".into());
    }
    if subsets::is_applicable(&instance) {
        let why = format!("each agent has one remaining service, {count} in total");
        return chosen(Formulation::Subsets, why);
    }
    if orders::is_applicable(&instance) {
        let speeds =
            if instance.is_fixed() { "the times of all paths are fixed" } else { "speeds are decision variables" };
        let why = format!("{speeds}, agents have several services, and {count} are few enough");
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
        let why = format!("{count} operations remain, and {name} plans at most {most} at once");
        return chosen(Formulation::Batches, why);
    }
    let why = match exact {
        Formulation::Constraint => "the times of all paths are fixed",
        _ if instance.is_fixed() => "the constraint program is too slow for so many operations",
        _ => "speeds are decision variables",
    };
    chosen(exact, format!("{why}, and {count} operations are few enough for {name}"))
}

/// Plans a schedule. The same problem and options give the same plan, unless its status reports the time limit.
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

/// Solves a problem, or one batch of it, at once.
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

    /// Returns the budget of the whole planning.
    pub fn budget(&self) -> Budget {
        self.options.budget
    }

    /// Plans a problem without mistakes; returns the schedule and the name of the engine. Never splits the problem into
    /// batches.
    pub fn solve(&self, problem: &Problem, budget: &Budget) -> Result<(Found, String), Refusal> {
        let watch = Watch::new(budget);
        let instance = Instance::new(problem);
        let asked = self.options.formulation.filter(|formulation| *formulation != Formulation::Batches);
        let formulation = asked.unwrap_or_else(|| match () {
            () if subsets::is_applicable(&instance) => Formulation::Subsets,
            () if orders::is_applicable(&instance) => Formulation::Orders,
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
                // The coefficients differ too much for integers: unless the constraint program was requested, use real
                // numbers.
                Err(EngineError::Overflow { .. }) if asked.is_none() => self.position(&instance, &watch.left()),
                found => Ok((found?, CONSTRAINT.into())),
            },
            Formulation::Orders if !orders::is_applicable(&instance) => Err(Refusal::NotOrders),
            Formulation::Orders if asked.is_none() && instance.is_fixed() => self.fixed(&instance, budget),
            Formulation::Orders => match orders::orders(&instance, budget) {
                Ok(found) => Ok((found, ORDERS.into())),
                Err(Halt::Engine(error)) => Err(error.into()),
                Err(_) if asked.is_some() => Err(Refusal::NotOrders),
                Err(_) => self.position(&instance, &watch.left()),
            },
            Formulation::Subsets if !subsets::is_applicable(&instance) => Err(Refusal::NotSubsets),
            Formulation::Subsets => match subsets::best(&instance, budget) {
                Ok(found) => Ok((found, "subsets".into())),
                Err(Halt::Engine(error)) => Err(error.into()),
                Err(_) if asked.is_some() => Err(Refusal::NotSubsets),
                Err(_) => self.position(&instance, &watch.left()),
            },
        }
    }

    /// Tries the constraint program for a limited number of steps, which suffice to prove a mission in which robots
    /// rarely conflict, and then the orders formulation.
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

    /// Solves the position form.
    fn position(&self, instance: &Instance, budget: &Budget) -> Result<(Found, String), Refusal> {
        let found = exact(instance, self.milp.as_ref(), budget)?;
        Ok((found, format!("position form, {}", self.milp.name())))
    }
}

/// Parts of a schedule: its status, its assistances and the statistics of the search.
pub(crate) type Parts = (Status, Vec<Assistance>, Statistics);
