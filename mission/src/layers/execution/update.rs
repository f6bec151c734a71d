//! The plan follows what happens: it is repaired, planned anew when that pays or must be, and never used unchecked.

use crate::execution::Replan;
use crate::layers::choose::plan;
use crate::layers::cost::cost_at;
use crate::layers::problem::Problem;
use crate::layers::steps::{Step, from_plan, with_cost};
use crate::layers::validate::validate;
use crate::plan::{Plan, Statistics, Status};

use super::LayeredExecution;
use super::record::{Happening, NoPlan};
use super::repair;
use super::settings::of_plan;
use super::steps::SAME;

/// The largest index that is written down: where nothing became something it is infinite.
const LARGE: f64 = 1e6;

impl LayeredExecution {
    /// The plan with what has happened by now.
    pub(super) fn update(&mut self) {
        self.update_or_plan(false);
    }

    /// As [`LayeredExecution::update`]; where planning anew is allowed and `asked`, it is not left to the index.
    pub(super) fn update_or_plan(&mut self, asked: bool) {
        let problem = self.problem_now();
        let open = problem.tasks.len() - problem.begun.len();
        let here = |step: &&Step| !problem.agents[step.agent].lost;
        if self.ahead.iter().filter(here).count() < open {
            return self.plan_anew(problem, None);
        }
        let ahead = self.repaired(&problem);
        let plan = self.part(&problem, &ahead);
        if let Some(why) = broken(&problem, &plan) {
            return self.plan_anew(problem, Some(why));
        }
        let moved = repair::differ(&self.ahead, &ahead, SAME);
        self.adopt(problem, ahead, plan);
        let index = self.index();
        if moved {
            self.reschedules += 1;
            self.record(Happening::Rescheduled { index });
        }
        let costly = index > self.settings.reallocate_above;
        if self.settings.replan == Replan::Both && open > 0 && (asked || costly) {
            self.reallocate(index);
        }
    }

    /// The problem at the present time: what is done, and what is under way as it is expected to end.
    fn problem_now(&self) -> Problem {
        let begun = self.ended.iter().map(repair::begun).chain(self.running().map(|step| repair::begun(&step)));
        Problem { start: self.time, begun: begun.collect(), ..self.problem.clone() }
    }

    fn repaired(&self, problem: &Problem) -> Vec<Step> {
        let moved = repair::moved(problem, &self.ahead);
        match self.settings.replan {
            Replan::None => moved,
            Replan::Reschedule | Replan::Both => repair::best(problem, &self.scales, &self.ahead).unwrap_or(moved),
        }
    }

    /// By how much the cost has changed since it was planned last.
    fn index(&self) -> f64 {
        let (was, is) = (self.optimal, self.plan.cost);
        if was == is { 0.0 } else { ((was - is).abs() / was).min(LARGE) }
    }

    /// There is a choice: the repaired plan, or a new one for what has not begun.
    fn reallocate(&mut self, index: f64) {
        match plan(&self.problem, &self.settings.planning) {
            Err(refusal) => self.record(Happening::Refused { why: of_plan(&refusal) }),
            Ok(fresh) => match broken(&self.problem, &fresh) {
                Some(why) => self.record(Happening::Refused { why }),
                None => {
                    self.reallocations += 1;
                    if fresh.cost < self.plan.cost {
                        self.adopt_plan(self.problem.clone(), fresh);
                    } else {
                        self.plan.engine = format!("rescheduling, after {}", fresh.engine);
                    }
                    let (cost, engine) = (self.plan.cost, self.plan.engine.clone());
                    self.record(Happening::Reallocated { index: Some(index), cost, engine });
                }
            },
        }
        self.optimal = self.plan.cost;
    }

    /// There is no choice: nobody is left for a task, or the repaired plan is none, because of `wrong`.
    fn plan_anew(&mut self, problem: Problem, wrong: Option<String>) {
        if problem.agents.iter().all(|who| who.lost) {
            return self.strand(problem, NoPlan::Nobody);
        }
        let fresh = match plan(&problem, &self.settings.planning) {
            Ok(fresh) => fresh,
            Err(refusal) => {
                let why = wrong.map_or(NoPlan::NotFound { why: of_plan(&refusal) }, |why| NoPlan::Broken { why });
                return self.strand(problem, why);
            }
        };
        if let Some(why) = broken(&problem, &fresh) {
            return self.strand(problem, NoPlan::Broken { why });
        }
        self.reallocations += 1;
        self.adopt_plan(problem, fresh);
        self.optimal = self.plan.cost;
        let (cost, engine) = (self.plan.cost, self.plan.engine.clone());
        self.record(Happening::Reallocated { index: None, cost, engine });
    }

    fn adopt_plan(&mut self, problem: Problem, plan: Plan) {
        let mut ahead = from_plan(&problem, &plan);
        ahead.retain(|step| !step.begun);
        repair::sort(&mut ahead);
        self.adopt(problem, ahead, plan);
    }

    /// A plan that has been checked becomes the one that is executed.
    fn adopt(&mut self, problem: Problem, ahead: Vec<Step>, plan: Plan) {
        (self.problem, self.ahead, self.plan, self.stranded) = (problem, ahead, plan, None);
    }

    /// There is no plan for everything any more: those who are there go on with what they were given.
    fn strand(&mut self, problem: Problem, why: NoPlan) {
        self.ahead.retain(|step| !problem.agents[step.agent].lost);
        self.ahead = repair::moved(&problem, &self.ahead);
        self.plan = self.part(&problem, &self.ahead);
        self.problem = problem;
        if self.stranded.as_ref() != Some(&why) {
            self.stranded = Some(why.clone());
            self.record(Happening::Stranded { why });
        }
    }

    /// The plan of what has begun and what is ahead.
    fn part(&self, problem: &Problem, ahead: &[Step]) -> Plan {
        let mut steps: Vec<Step> = problem.begun.iter().map(|begun| begun.step()).collect();
        steps.extend(ahead);
        let cost = cost_at(problem, &self.scales, &steps).total();
        let status = Status::Unbounded { stopped: None };
        with_cost(problem, (&steps, cost), status, "rescheduling".into(), Statistics::default())
    }
}

/// The first constraint that a plan breaks, or mistake of the problem.
fn broken(problem: &Problem, plan: &Plan) -> Option<String> {
    let first = validate(problem, plan).first().map(ToString::to_string)?;
    Some(problem.check().first().map_or(first, |mistake| mistake.reason.to_string()))
}
