//! Planning of a search: formulations, budget, and the plan.

use crate::engine::{Budget, Watch};
use crate::parallel;
use crate::plan::{Limit, Statistics, Status};

use super::check::Mistake;
use super::greedy::greedy;
use super::plan::{Activity, Plan};
use super::problem::Problem;
use super::reward::evaluate;
use super::team::Team;
use super::tree_search::{Found, search};
use super::ways::ActionSets;

/// A planner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Formulation {
    /// Multi-agent tree search, srs section 4.
    TreeSearch,
    /// Each agent takes the most reward a second.
    Greedy,
    /// Each agent plans as if it were alone.
    Independent,
}

impl Formulation {
    /// All of them.
    pub const ALL: [Formulation; 3] = [Formulation::TreeSearch, Formulation::Greedy, Formulation::Independent];

    /// Name, as in options.
    pub fn name(self) -> &'static str {
        match self {
            Formulation::TreeSearch => "tree-search",
            Formulation::Greedy => "greedy",
            Formulation::Independent => "independent",
        }
    }

    /// Reason for it.
    pub fn why(self) -> &'static str {
        match self {
            Formulation::TreeSearch => "it plans for all agents together",
            Formulation::Greedy => "a baseline: each agent takes the most reward a second",
            Formulation::Independent => "a baseline: each agent plans as if it were alone",
        }
    }
}

/// Options of the planner.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// The planner.
    pub formulation: Formulation,
    /// Limits: time, and the number of states; none: that of the problem.
    pub budget: Budget,
    /// Number of threads; none: those of the machine. The plan does not depend on it.
    pub threads: Option<usize>,
}

/// A search with fewer states takes no longer than starting threads.
const FEW_STATES: u64 = 2_000;

impl Options {
    /// The usual ones for a problem: the number of states ends the search, and the time only on a machine on which states
    /// take far too long.
    pub fn of(problem: &Problem) -> Options {
        Options {
            formulation: Formulation::TreeSearch,
            budget: Budget { nodes: problem.planner.states, time: std::time::Duration::from_secs(60), gap: 1e-4 },
            threads: None,
        }
    }
}

/// A plan, and whether every sequence of the action sets was tried.
#[derive(Clone, Debug)]
pub struct Planned {
    /// The plan.
    pub plan: Plan,
    /// No sequence of actions of the action sets is left untried.
    pub exhausted: bool,
}

/// Plans.
///
/// # Errors
/// The mistakes of a problem that cannot be planned.
pub fn plan(problem: &Problem, options: &Options) -> Result<Planned, Vec<Mistake>> {
    let mistakes = super::check::check(problem);
    if !mistakes.is_empty() {
        return Err(mistakes);
    }
    Ok(plan_checked(problem, options))
}

/// Plans a problem that has no mistake, such as that of a mission under way.
pub(super) fn plan_checked(problem: &Problem, options: &Options) -> Planned {
    let watch = Watch::new(&options.budget);
    let threads = options.threads.unwrap_or_else(parallel::threads);
    let sets = ActionSets::new(problem, threads);
    let team = Team::new(problem, &sets);
    // A small search is over before a thread has begun.
    let threads = if problem.planner.states < FEW_STATES { 1 } else { threads };
    let budget = options.budget.nodes;
    let first = greedy(&team);
    let (found, activities) = match options.formulation {
        Formulation::Greedy => {
            let activities = team.activities(&first.choices);
            (Found { best: first, states: 0, exhausted: false, timed_out: false }, activities)
        }
        Formulation::Independent => independent(problem, &sets, budget, &watch, threads),
        Formulation::TreeSearch => {
            // Plans of the agents on their own are an end that the search is given, srs 4.4.2.
            let (alone, combined) = independent(problem, &sets, budget / 10, &watch, threads);
            let found = search(&team, first, budget, &watch, threads);
            let activities = team.activities(&found.best.choices);
            let better = alone.best.reward > found.best.reward + 1e-9 && problem.agents.len() > 1;
            (Found { states: found.states + alone.states, ..found }, if better { combined } else { activities })
        }
    };
    let rewards = evaluate(problem, &activities);
    let stopped = match () {
        () if options.formulation == Formulation::Greedy || found.exhausted => None,
        () if found.timed_out => Some(Limit::Time),
        () => Some(Limit::Work),
    };
    let plan = Plan {
        members: problem.agents.iter().map(|agent| agent.name.clone()).collect(),
        activities,
        cost: -rewards.total,
        status: match most(problem) {
            Some(most) if rewards.total >= most - 1e-9 => Status::Proven { bound: -most },
            _ => Status::Unbounded { stopped },
        },
        engine: options.formulation.name().into(),
        statistics: Statistics { solves: 0, nodes: found.states + sets.nodes, cuts: 0 },
    };
    Planned { plan, exhausted: found.exhausted }
}

/// The reward of all pools: no plan collects more, if nothing that attracts is without end. None: something is.
fn most(problem: &Problem) -> Option<f64> {
    if problem.is_searching() {
        return None;
    }
    let pools = problem.sources.iter().filter(|source| source.attracts());
    pools.map(|source| source.pool).sum()
}

/// Each agent plans as if it were alone; together they get what is left when all do so.
fn independent(
    problem: &Problem,
    sets: &ActionSets,
    states: u64,
    watch: &Watch,
    threads: usize,
) -> (Found, Vec<Activity>) {
    let mut all = Vec::new();
    let mut whole = Found { best: greedy(&Team::new(problem, sets)), states: 0, exhausted: false, timed_out: false };
    let present = problem.agents.iter().filter(|agent| !agent.lost).count().max(1) as u64;
    for agent in (0..problem.agents.len()).filter(|agent| !problem.agents[*agent].lost) {
        let mut alone = problem.clone();
        for (other, who) in alone.agents.iter_mut().enumerate() {
            who.lost |= other != agent;
        }
        let team = Team::new(&alone, sets);
        let found = search(&team, greedy(&team), states / present, watch, threads);
        whole.states += found.states;
        whole.timed_out |= found.timed_out;
        all.extend(team.activities(&found.best.choices));
    }
    whole.best.reward = evaluate(problem, &all).total;
    (whole, all)
}
