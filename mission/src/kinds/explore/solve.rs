//! Solving the program of a plan: the engine, the start from the last plan, and words for what cannot be met.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use super::foresight::Foresight;
use super::lattice::construct;
use super::problem::{EngineChoice, Problem};
use super::program::{Group, Present, Program, Trajectories, build, lacking};
use super::validate::validate;
use crate::engine::{Answer, Budget, EngineError, Highs, Microlp, Milp};
use crate::plan::Limit;

/// Factor of the time for the first plan, which is made before the mission begins.
pub const FIRST: f64 = 20.0;
/// Share of the time of a plan that the search for a cause may take.
const CAUSE: f64 = 0.5;

/// A plan of the robots.
#[derive(Clone, Debug, PartialEq)]
pub struct Best {
    /// Motions of the robots.
    pub trajectories: Trajectories,
    /// Cost (10a) without the rewards of the person, and with what is missing of the reserve.
    pub cost: f64,
    /// A lower bound on the cost of every plan.
    pub bound: f64,
    /// The limit that ended the search; none: the plan is the best one to within the gap.
    pub stopped: Option<Limit>,
    /// Nodes of the search.
    pub nodes: u64,
}

impl Best {
    /// `(cost - bound) / |bound|`, zero or more.
    pub fn gap(&self) -> f64 {
        ((self.cost - self.bound) / self.bound.abs().max(1.0)).max(0.0)
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
    /// The built-in engine, which is for small programs.
    is_built_in: bool,
    /// The rest of the last plan.
    last: Option<Trajectories>,
}

/// A known plan: its binaries, its cost, its motions.
type Known = (Vec<(usize, f64)>, f64, Trajectories);

/// The most binaries of a program that the built-in engine solves.
const MOST_BUILT_IN: usize = 120;

/// Cost of motions (10a), without the rewards of the person, and with what is missing of the reserve.
fn cost(problem: &Problem, present: &Present, foresight: &Foresight, of: &Trajectories) -> f64 {
    let effort: f64 = of.inputs.iter().flatten().flatten().map(|u| u.abs()).sum();
    let rewards: f64 = of.visits.iter().map(|visit| problem.targets[visit.target].worth).sum();
    problem.effort * effort - rewards + lacking(problem, present, foresight, of)
}

/// No plan has more than the rewards of all targets that are open to robots.
fn lower_bound(problem: &Problem, present: &Present, foresight: &Foresight) -> f64 {
    let open = |target: &usize| present.open[*target] && foresight.visits.iter().all(|(of, _)| of != target);
    -(0..problem.targets.len()).filter(open).map(|target| problem.targets[target].worth).sum::<f64>()
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
        let is_built_in = match wanted {
            EngineChoice::Highs => false,
            EngineChoice::BuiltIn => true,
            EngineChoice::Auto => !*IS_THERE.get_or_init(|| Highs::find().is_ok()),
        };
        let engine: Box<dyn Milp + Send> = if is_built_in { Box::new(Microlp) } else { Box::new(Highs::find()?) };
        Ok(Solver { engine, is_built_in, last: None })
    }

    /// Name of the engine.
    pub fn name(&self) -> &str {
        self.engine.name()
    }

    /// A period has passed: the rest of the last plan begins with its next period.
    pub fn pass_period(&mut self) {
        let Some(last) = &mut self.last else { return };
        last.states.iter_mut().for_each(|states| drop(states.drain(..1.min(states.len()))));
        last.inputs.iter_mut().for_each(|inputs| drop(inputs.drain(..1.min(inputs.len()))));
        last.visits.retain(|visit| visit.step > 1);
        last.visits.iter_mut().for_each(|visit| visit.step -= 1);
    }

    /// The last plan is of no use any more.
    pub fn forget(&mut self) {
        self.last = None;
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
        let known = self.known(problem, present, foresight, &program);
        // A program that is too large for the engine leaves the plan of the lattice.
        let too_large = self.is_built_in && program.binaries.len() > MOST_BUILT_IN;
        let start = known.as_ref().map_or(&[][..], |(start, ..)| start.as_slice());
        let left = time.saturating_sub(begun.elapsed());
        let budget = Budget { time: left, nodes: problem.planner.nodes, gap: problem.planner.gap };
        let answer = match too_large {
            true => Answer {
                values: None,
                bound: lower_bound(problem, present, foresight),
                stopped: Some(Limit::Work),
                nodes: 0,
            },
            false => match self.engine.solve(&program.model, start, &budget) {
                Ok(answer) => answer,
                Err(EngineError::Infeasible { .. }) if known.is_none() => {
                    let left = time.saturating_sub(begun.elapsed()).mul_f64(CAUSE);
                    return Err(NoPlan::Infeasible(self.cause(problem, present, foresight, left)));
                }
                // A plan is known: an engine that denies it is at the end of its accuracy.
                Err(EngineError::Infeasible { .. }) => {
                    let bound = lower_bound(problem, present, foresight);
                    Answer { values: None, bound, stopped: Some(Limit::Accuracy), nodes: 0 }
                }
                Err(other) if known.is_none() => return Err(other.into()),
                Err(_) => Answer { values: None, bound: f64::NEG_INFINITY, stopped: Some(Limit::Accuracy), nodes: 0 },
            },
        };
        let solved = answer.values.map(|values| {
            let trajectories = program.trajectories(problem, present, &values);
            (cost(problem, present, foresight, &trajectories), trajectories)
        });
        let known = known.map(|(_, cost, trajectories)| (cost, trajectories));
        let best = solved.into_iter().chain(known).min_by(|a, b| a.0.total_cmp(&b.0));
        let (cost, trajectories) = best.ok_or(NoPlan::Late)?;
        self.last = Some(trajectories.clone());
        let bound = answer.bound.max(lower_bound(problem, present, foresight)).min(cost);
        Ok(Best { trajectories, cost, bound, stopped: answer.stopped, nodes: answer.nodes })
    }

    /// The better one of the rest of the last plan and of a plan on the lattice, with its binaries and its cost.
    fn known(&self, problem: &Problem, present: &Present, foresight: &Foresight, program: &Program) -> Option<Known> {
        let rest = self.last.as_ref().filter(|last| last.inputs.iter().all(|inputs| inputs.len() == program.periods()));
        let rest = rest.map(|last| {
            let taken = |target: usize| foresight.visits.iter().any(|(of, _)| *of == target);
            let mut rest = super::program::replayed(problem, present, &last.inputs);
            rest.visits = last
                .visits
                .iter()
                .filter(|visit| present.open[visit.target] && !taken(visit.target))
                .copied()
                .collect();
            rest
        });
        let lattice = construct(problem, present, foresight, self.last.as_ref());
        let ready = rest.into_iter().chain(lattice).filter_map(|of| {
            validate(problem, present, foresight, &of).is_empty().then_some(())?;
            Some((program.start(&of)?, cost(problem, present, foresight, &of), of))
        });
        ready.min_by(|a, b| a.1.total_cmp(&b.1))
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
