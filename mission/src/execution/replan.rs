//! Repairing a plan, and planning anew: one rule for all kinds of mission.
//!
//! A plan that differs from the world is repaired first. It is planned anew if the repaired plan is infeasible, and, where
//! the settings allow it, if its cost has changed by more than a threshold (thesis 5.5.2) or somebody asks. No plan is used
//! before the validator has accepted it.

use crate::plan::Plan;

use super::Replan;
use super::log::{LARGE, NoFeasiblePlan, PlanChange};
use super::simulation::{Simulation, World};

/// Condition under which the part of a plan that has not begun is planned anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ReplanPolicy {
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
pub struct Repaired<W: Replans> {
    /// The problem at the present time.
    pub problem: W::Problem,
    /// The plan, which has not been checked yet, with the form that is executed. None: work is left without anybody to do
    /// it.
    pub plan: Option<(W::Steps, Plan<W::Activity>)>,
}

/// Result of planning anew where the repaired plan could be kept.
pub enum Improved<A> {
    /// Use this plan.
    Fresh(Box<Plan<A>>),
    /// The repaired plan is no worse; its new engine says so.
    Kept(String),
}

/// A world whose plan follows what happens.
pub trait Replans: World {
    /// The form of a plan that is executed.
    type Steps;

    /// The entry of the log for a change of the plan.
    fn changed(change: PlanChange) -> Self::LogEntry;
    /// The reaction that the settings ask for, and the threshold of the index.
    fn rule(settings: &Self::Settings) -> (Replan, f64);

    /// Repairs the plan under this problem for everything that has happened by now.
    fn repair(of: &Simulation<Self>, problem: Self::Problem) -> Repaired<Self>;
    /// The first constraint of the problem that a plan violates, or mistake of the problem.
    fn broken(problem: &Self::Problem, plan: &Plan<Self::Activity>) -> Option<String>;
    /// True if times or speeds of these steps differ from those that are executed.
    fn moved(&self, steps: &Self::Steps) -> bool;
    /// The form of a plan that is executed.
    fn steps_of(problem: &Self::Problem, plan: &Plan<Self::Activity>) -> Result<Self::Steps, String>;
    /// Executes the steps of a checked plan from now on. The simulation has the plan and its problem.
    fn adopt(of: &mut Simulation<Self>, steps: Self::Steps);
    /// Relative change of the cost since the last planning.
    fn index(of: &Simulation<Self>) -> f64;
    /// Takes the present plan as the one against which the index compares.
    fn rebase_index(of: &mut Simulation<Self>);
    /// True if something has not begun.
    fn is_open(problem: &Self::Problem) -> bool;
    /// Plans the part that has not begun, around the rest.
    fn improve(of: &Simulation<Self>) -> Result<Improved<Self::Activity>, String>;
    /// Plans from nothing but what has begun.
    fn plan_anew(problem: &Self::Problem, settings: &Self::Settings) -> Result<Plan<Self::Activity>, String>;
    /// The words for those who are all lost, if they are.
    fn nobody_left(problem: &Self::Problem) -> Option<&'static str>;
    /// There is no plan any more: what becomes of what is under way. The log has the reason already, unless it is the same
    /// as before: then `again`.
    fn strand(of: &mut Simulation<Self>, problem: Self::Problem, again: bool);
}

impl<W: Replans> Simulation<W> {
    /// Brings the plan up to the world, under this problem: repaired, or made anew as the policy says.
    pub(crate) fn update_plan(&mut self, problem: W::Problem, policy: ReplanPolicy) {
        let Repaired { problem, plan } = W::repair(self, problem);
        let Some((steps, plan)) = plan else { return self.replace_plan(problem, None) };
        if let Some(why) = W::broken(&problem, &plan) {
            return self.replace_plan(problem, Some(why));
        }
        let moved = self.world.moved(&steps);
        self.adopt(problem, steps, plan);
        let index = W::index(self).min(LARGE);
        if moved {
            self.log.reschedules += 1;
            self.record_change(PlanChange::Rescheduled { index });
        }
        let (replan, threshold) = W::rule(&self.settings);
        let wanted = match policy {
            ReplanPolicy::IfInfeasible => false,
            ReplanPolicy::IfCostly => index > threshold,
            ReplanPolicy::Asked => true,
        };
        if replan == Replan::Both && wanted && W::is_open(&self.problem) {
            self.improve_plan(index);
        }
    }

    /// The repaired plan is feasible; a new one for what has not begun may be better.
    fn improve_plan(&mut self, index: f64) {
        match W::improve(self) {
            Err(why) => self.record_change(PlanChange::Refused { why }),
            Ok(Improved::Kept(engine)) => {
                self.plan.engine = engine;
                self.record_reallocation(Some(index));
            }
            Ok(Improved::Fresh(fresh)) => match checked::<W>(&self.problem, &fresh) {
                Ok(steps) => {
                    self.adopt(self.problem.clone(), steps, *fresh);
                    self.record_reallocation(Some(index));
                }
                Err(NoFeasiblePlan::NotFound { why } | NoFeasiblePlan::Broken { why }) => {
                    self.record_change(PlanChange::Refused { why });
                }
                Err(nobody) => self.record_change(PlanChange::Refused { why: nobody.to_string() }),
            },
        }
        W::rebase_index(self);
    }

    /// The repaired plan is infeasible: work has nobody to do it, or a constraint is `violated`.
    fn replace_plan(&mut self, problem: W::Problem, violated: Option<String>) {
        if let Some(who) = W::nobody_left(&problem) {
            return self.strand(problem, NoFeasiblePlan::NobodyLeft { who: who.into() });
        }
        let fresh = match W::plan_anew(&problem, &self.settings) {
            Ok(fresh) => fresh,
            Err(why) => {
                let why = violated.map_or(NoFeasiblePlan::NotFound { why }, |why| NoFeasiblePlan::Broken { why });
                return self.strand(problem, why);
            }
        };
        match checked::<W>(&problem, &fresh) {
            Ok(steps) => {
                self.adopt(problem, steps, fresh);
                W::rebase_index(self);
                self.record_reallocation(None);
            }
            Err(why) => self.strand(problem, why),
        }
    }

    fn adopt(&mut self, problem: W::Problem, steps: W::Steps, plan: Plan<W::Activity>) {
        (self.problem, self.plan, self.log.stranded) = (problem, plan, None);
        W::adopt(self, steps);
    }

    fn record_change(&mut self, change: PlanChange) {
        self.record(W::changed(change));
    }

    fn record_reallocation(&mut self, index: Option<f64>) {
        self.log.reallocations += 1;
        let (cost, engine) = (self.plan.cost, self.plan.engine.clone());
        self.record_change(PlanChange::Reallocated { index, cost, engine });
    }

    fn strand(&mut self, problem: W::Problem, why: NoFeasiblePlan) {
        let again = self.log.stranded.as_ref() == Some(&why);
        if !again {
            self.log.stranded = Some(why.clone());
            self.record_change(PlanChange::Stranded { why });
        }
        W::strand(self, problem, again);
    }
}

fn checked<W: Replans>(problem: &W::Problem, plan: &Plan<W::Activity>) -> Result<W::Steps, NoFeasiblePlan> {
    match W::broken(problem, plan) {
        Some(why) => Err(NoFeasiblePlan::Broken { why }),
        None => W::steps_of(problem, plan).map_err(|why| NoFeasiblePlan::NotFound { why }),
    }
}
