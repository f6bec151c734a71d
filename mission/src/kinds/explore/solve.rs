//! Solving the program of a plan: the engine, the start from the last plan, and words for what cannot be met.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

use super::bound::{Ways, lower_bound};
use super::foresight::Foresight;
use super::lattice::{Aim, Deadline, EXPOSED, Ground, construct, exposed};
use super::objective::{Costs, gap};
use super::problem::{EngineChoice, Escape, Problem};
use super::program::{Group, Present, Program, Trajectories, build, replayed};
use super::validate::validate;
use crate::engine::{Answer, Budget, EngineError, Highs, Microlp, Milp};
use crate::plan::Limit;

/// Factor of the time for the first plan, which is made before the mission begins.
pub const FIRST: f64 = 20.0;
/// Share of the time of a plan that the search for a cause may take.
const CAUSE: f64 = 0.5;
/// Share of the time of a plan that its polish may take.
const POLISH: f64 = 0.3;
/// Share of the time of a plan that is left for a way out while no plan is known, or none that is good enough for `escape required`.
const WAY_OUT: f64 = 0.2;

/// A plan of the robots.
#[derive(Clone, Debug, PartialEq)]
pub struct Best {
    /// Motions of the robots.
    pub trajectories: Trajectories,
    /// Cost (10a) without the rewards of the person, and with what is missing of the reserve.
    pub cost: f64,
    /// A lower bound on the cost of every plan.
    pub bound: f64,
    /// Number of robots for which it is not known that they can give way to the person after the first period, whatever the person does.
    pub exposed: usize,
    /// The limit that ended the search; none: the plan is the best one to within the gap.
    pub stopped: Option<Limit>,
    /// Nodes of the search.
    pub nodes: u64,
    /// Origin of the plan.
    pub origin: Origin,
}

/// Origin of a plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The rest of the last plan.
    LastPlan,
    /// The lattice.
    Lattice,
    /// The best motions that make the choices of the last plan or of the lattice.
    Polished,
    /// The engine for mixed-integer programs.
    Engine,
}

impl Origin {
    /// Words for tables.
    pub fn words(self) -> &'static str {
        match self {
            Origin::LastPlan => "the rest of the last plan",
            Origin::Lattice => "the lattice",
            Origin::Polished => "a linear program",
            Origin::Engine => "the engine",
        }
    }
}

impl Best {
    /// `(cost - bound) / |bound|`, zero or more.
    pub fn gap(&self) -> f64 {
        gap(self.cost, self.bound)
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
    prepared: OnceLock<Prepared>,
}

/// Parts that depend on the problem alone, and are made once.
struct Prepared {
    /// The ground of the lattice; none: no lattice fits.
    ground: Option<Ground>,
    ways: Ways,
}

/// The inputs of a plan.
#[derive(Clone, Copy)]
struct Situation<'p> {
    problem: &'p Problem,
    present: &'p Present,
    foresight: &'p Foresight,
}

/// A known plan with its cost and the number of robots that it exposes.
struct Known {
    cost: f64,
    exposed: usize,
    trajectories: Trajectories,
    origin: Origin,
}

impl Known {
    /// Whoever may not be able to give way costs more than any target is worth.
    fn rank(&self) -> f64 {
        self.cost + EXPOSED * self.exposed as f64
    }
}

/// The most binaries of a program that the built-in engine solves.
const MOST_BUILT_IN: usize = 120;

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
        Ok(Solver { engine, is_built_in, last: None, prepared: OnceLock::new() })
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

    /// Plans: the rest of the last plan, a plan on the lattice, and then the engine, until one of them is within the gap.
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
        let prepared = || Prepared { ground: Ground::new(problem), ways: Ways::new(problem) };
        let Prepared { ground, ways } = self.prepared.get_or_init(prepared);
        let ground = ground.as_ref();
        let bound = lower_bound(problem, ways, present, foresight);
        let is_good =
            |known: &Option<Known>| known.as_ref().is_some_and(|of| gap(of.cost, bound) <= problem.planner.gap);
        let known_as = |trajectories: Trajectories, origin: Origin| {
            let cost = Costs::of(problem, present, foresight, &trajectories).total();
            let exposed = ground.map_or(0, |ground| exposed(problem, ground, present, foresight, &trajectories));
            Known { cost, exposed, trajectories, origin }
        };
        let sound = |of: Trajectories, origin: Origin| {
            validate(problem, present, foresight, &of).is_empty().then(|| known_as(of, origin))
        };
        let best = |known: Option<Known>, new: Option<Known>| {
            known.into_iter().chain(new).min_by(|a, b| a.rank().total_cmp(&b.rank()))
        };
        let rest = self.rest(problem, present, foresight);
        let mut known = rest.and_then(|rest| sound(rest, Origin::LastPlan));
        // Whoever may need a way out needs time to look for one.
        let time_for = |known: &Option<Known>| {
            let required = problem.planner.escape == Escape::Required;
            match known.as_ref().is_some_and(|known| !required || known.exposed == 0) {
                true => time,
                false => time.mul_f64(1.0 - WAY_OUT),
            }
        };
        if !is_good(&known) || known.as_ref().is_some_and(|known| known.exposed > 0) {
            let (until, last) = (Deadline::at(begun + time_for(&known)), self.last.as_ref());
            let aim = Aim { bound, until: &until };
            let lattice = ground.and_then(|ground| construct(problem, ground, present, foresight, last, &aim));
            known = best(known, lattice.and_then(|found| sound(found, Origin::Lattice)));
        }
        let searched = match is_good(&known) {
            true => Answer { values: None, bound, stopped: None, nodes: 0 },
            false => {
                let left = time_for(&known).saturating_sub(begun.elapsed());
                let program =
                    build(problem, present, foresight, None).map_err(|group| NoPlan::Infeasible(Some(group)))?;
                // Away from the lattice little is known of safe states.
                let is_free = ground.is_none_or(|ground| !ground.knows_safe_states());
                if let Some(of) = known.as_ref().filter(|_| is_free) {
                    let polished = program.polished(problem, present, &of.trajectories, left.mul_f64(POLISH));
                    known = best(known, polished.and_then(|of| sound(of, Origin::Polished)));
                }
                match is_good(&known) {
                    true => Answer { values: None, bound, stopped: None, nodes: 0 },
                    false => {
                        let start = known.as_ref().map(|known| &known.trajectories);
                        let left = time_for(&known).saturating_sub(begun.elapsed());
                        let situation = Situation { problem, present, foresight };
                        let (answer, found) = self.search(&situation, &program, start, left)?;
                        known = best(found.map(|of| known_as(of, Origin::Engine)), known);
                        answer
                    }
                }
            }
        };
        let Known { cost, exposed, trajectories, origin } = known.ok_or(NoPlan::Late)?;
        self.last = Some(trajectories.clone());
        let bound = searched.bound.max(bound).min(cost);
        Ok(Best { trajectories, cost, bound, exposed, stopped: searched.stopped, nodes: searched.nodes, origin })
    }

    /// The ground of the lattice; none: no plan was made yet, or no lattice fits.
    pub fn ground(&self) -> Option<&Ground> {
        self.prepared.get()?.ground.as_ref()
    }

    /// The search of the engine from a known plan.
    fn search(
        &self,
        Situation { problem, present, foresight }: &Situation,
        program: &Program,
        known: Option<&Trajectories>,
        time: Duration,
    ) -> Result<(Answer, Option<Trajectories>), NoPlan> {
        let begun = Instant::now();
        let without = |stopped| Answer { values: None, bound: f64::NEG_INFINITY, stopped: Some(stopped), nodes: 0 };
        // A program that is too large for the engine leaves the plan of the lattice.
        if self.is_built_in && program.binaries.len() > MOST_BUILT_IN {
            return Ok((without(Limit::Work), None));
        }
        let start = known.and_then(|known| program.start(known)).unwrap_or_default();
        let left = time.saturating_sub(begun.elapsed());
        let budget = Budget { time: left, nodes: problem.planner.nodes, gap: problem.planner.gap };
        match self.engine.solve(&program.model, &start, &budget) {
            Ok(answer) => {
                let found = answer.values.as_ref().map(|values| program.trajectories(problem, present, values));
                Ok((answer, found))
            }
            Err(EngineError::Infeasible { .. }) if known.is_none() => {
                let left = time.saturating_sub(begun.elapsed()).mul_f64(CAUSE);
                Err(NoPlan::Infeasible(self.cause(problem, present, foresight, left)))
            }
            Err(other) if known.is_none() => Err(other.into()),
            // A plan is known: an engine that denies it is at the end of its accuracy.
            Err(_) => Ok((without(Limit::Accuracy), None)),
        }
    }

    /// The rest of the last plan, under the new prediction.
    fn rest(&self, problem: &Problem, present: &Present, foresight: &Foresight) -> Option<Trajectories> {
        let periods = foresight.periods().min(problem.periods);
        let last = self.last.as_ref().filter(|last| last.inputs.iter().all(|inputs| inputs.len() == periods))?;
        let taken = |target: usize| foresight.visits.iter().any(|(of, _)| *of == target);
        let visits = last.visits.iter().filter(|visit| present.open[visit.target] && !taken(visit.target));
        Some(Trajectories { visits: visits.copied().collect(), ..replayed(problem, present, &last.inputs) })
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
