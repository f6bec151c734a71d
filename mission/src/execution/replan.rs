//! Repairing a plan, and planning anew: one rule for all kinds of mission.
//!
//! A plan that differs from the world is repaired first. It is planned anew if the repaired plan is infeasible, and, where
//! the settings allow it, if its cost has changed by more than a threshold (thesis 5.5.2) or somebody asks. No plan is used
//! before the validator has accepted it.

use crate::plan::Plan;

use super::Replan;
use super::log::{LARGE, Log, NoFeasiblePlan, PlanChange};

/// Condition under which the part of a plan that has not begun is planned anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ReplanPolicy {
    /// The repaired plan is infeasible.
    IfInfeasible,
    /// Also if the index of (5.19) is above the threshold.
    IfCostly,
    /// Somebody asks for it.
    Asked,
}

impl ReplanPolicy {
    /// The policy for an activity that is late for the `late`th time: less and less often. A late activity comes back at
    /// every time at which it is expected, and each replan is a whole search.
    pub fn while_late(late: usize) -> ReplanPolicy {
        if late.is_power_of_two() { ReplanPolicy::IfCostly } else { ReplanPolicy::IfInfeasible }
    }
}

/// A plan repaired for what has happened.
pub(crate) struct Repaired<R: Replans + ?Sized> {
    /// The problem at the present time.
    pub problem: R::Problem,
    /// The plan, which has not been checked yet, with the form that is executed. None: work is left without anybody to do
    /// it.
    pub plan: Option<(R::Steps, Plan<R::Activity>)>,
}

/// Result of planning anew where the repaired plan could be kept.
pub(crate) enum Improved<A> {
    /// Use this plan.
    Fresh(Box<Plan<A>>),
    /// The repaired plan is no worse; its new engine says so.
    Kept(String),
}

/// An execution whose plan follows the world.
pub(crate) trait Replans {
    /// The problem of the kind.
    type Problem: Clone;
    /// The activities of its plans.
    type Activity;
    /// The form of a plan that is executed.
    type Steps;
    /// The kind's list of what can happen.
    type Happening;

    /// The problem as it is now.
    fn problem(&self) -> &Self::Problem;
    /// The plan as it is now.
    fn plan_mut(&mut self) -> &mut Plan<Self::Activity>;
    /// The log.
    fn log(&mut self) -> &mut Log<Self::Happening>;
    /// Writes a change of the plan into the log.
    fn record_change(&mut self, change: PlanChange);
    /// The reaction that the settings ask for, and the threshold of the index.
    fn rule(&self) -> (Replan, f64);

    /// Repairs the plan under this problem for everything that has happened by now.
    fn repair(&self, problem: Self::Problem) -> Repaired<Self>;
    /// The first constraint of the problem that a plan violates, or mistake of the problem.
    fn broken(problem: &Self::Problem, plan: &Plan<Self::Activity>) -> Option<String>;
    /// True if times or speeds of these steps differ from those that are executed.
    fn moved(&self, steps: &Self::Steps) -> bool;
    /// The form of a plan that is executed.
    fn steps_of(problem: &Self::Problem, plan: &Plan<Self::Activity>) -> Result<Self::Steps, String>;
    /// Executes a checked plan from now on.
    fn adopt(&mut self, problem: Self::Problem, steps: Self::Steps, plan: Plan<Self::Activity>);
    /// Relative change of the cost since the last planning.
    fn index(&self) -> f64;
    /// Takes the present plan as the one against which the index compares.
    fn rebase_index(&mut self);
    /// True if something has not begun.
    fn is_open(&self) -> bool;
    /// Plans the part that has not begun, around the rest.
    fn improve(&self) -> Result<Improved<Self::Activity>, String>;
    /// Plans from nothing but what has begun.
    fn plan_anew(&self, problem: &Self::Problem) -> Result<Plan<Self::Activity>, String>;
    /// The words for those who are all lost, if they are.
    fn nobody_left(problem: &Self::Problem) -> Option<&'static str>;
    /// There is no plan any more: what becomes of what is under way. The log has the reason already, unless it is the same
    /// as before: then `again`.
    fn strand(&mut self, problem: Self::Problem, again: bool);
}

/// Brings the plan up to the world: repaired, or made anew as the policy says.
pub(crate) fn update<R: Replans>(of: &mut R, problem: R::Problem, policy: ReplanPolicy) {
    let Repaired { problem, plan } = of.repair(problem);
    let Some((steps, plan)) = plan else { return replace(of, problem, None) };
    if let Some(why) = R::broken(&problem, &plan) {
        return replace(of, problem, Some(why));
    }
    let moved = of.moved(&steps);
    of.adopt(problem, steps, plan);
    let index = of.index().min(LARGE);
    if moved {
        of.log().reschedules += 1;
        of.record_change(PlanChange::Rescheduled { index });
    }
    let (replan, threshold) = of.rule();
    let wanted = match policy {
        ReplanPolicy::IfInfeasible => false,
        ReplanPolicy::IfCostly => index > threshold,
        ReplanPolicy::Asked => true,
    };
    if replan == Replan::Both && wanted && of.is_open() {
        improve(of, index);
    }
}

/// The repaired plan is feasible; a new one for what has not begun may be better.
fn improve<R: Replans>(of: &mut R, index: f64) {
    match of.improve() {
        Err(why) => of.record_change(PlanChange::Refused { why }),
        Ok(Improved::Kept(engine)) => {
            of.plan_mut().engine = engine;
            reallocated(of, Some(index));
        }
        Ok(Improved::Fresh(fresh)) => {
            let problem = of.problem().clone();
            match checked::<R>(&problem, &fresh) {
                Ok(steps) => {
                    of.adopt(problem, steps, *fresh);
                    reallocated(of, Some(index));
                }
                Err(NoFeasiblePlan::NotFound { why } | NoFeasiblePlan::Broken { why }) => {
                    of.record_change(PlanChange::Refused { why });
                }
                Err(nobody) => of.record_change(PlanChange::Refused { why: nobody.to_string() }),
            }
        }
    }
    of.rebase_index();
}

/// The repaired plan is infeasible: work has nobody to do it, or a constraint is `violated`.
fn replace<R: Replans>(of: &mut R, problem: R::Problem, violated: Option<String>) {
    if let Some(who) = R::nobody_left(&problem) {
        return strand(of, problem, NoFeasiblePlan::NobodyLeft { who: who.into() });
    }
    let fresh = match of.plan_anew(&problem) {
        Ok(fresh) => fresh,
        Err(why) => {
            let why = violated.map_or(NoFeasiblePlan::NotFound { why }, |why| NoFeasiblePlan::Broken { why });
            return strand(of, problem, why);
        }
    };
    match checked::<R>(&problem, &fresh) {
        Ok(steps) => {
            of.adopt(problem, steps, fresh);
            of.rebase_index();
            reallocated(of, None);
        }
        Err(why) => strand(of, problem, why),
    }
}

fn checked<R: Replans>(problem: &R::Problem, plan: &Plan<R::Activity>) -> Result<R::Steps, NoFeasiblePlan> {
    match R::broken(problem, plan) {
        Some(why) => Err(NoFeasiblePlan::Broken { why }),
        None => R::steps_of(problem, plan).map_err(|why| NoFeasiblePlan::NotFound { why }),
    }
}

fn reallocated<R: Replans>(of: &mut R, index: Option<f64>) {
    of.log().reallocations += 1;
    let plan = of.plan_mut();
    let (cost, engine) = (plan.cost, plan.engine.clone());
    of.record_change(PlanChange::Reallocated { index, cost, engine });
}

fn strand<R: Replans>(of: &mut R, problem: R::Problem, why: NoFeasiblePlan) {
    let again = of.log().stranded.as_ref() == Some(&why);
    if !again {
        of.log().stranded = Some(why.clone());
        of.record_change(PlanChange::Stranded { why });
    }
    of.strand(problem, again);
}
