//! The plan follows what happens: how layers are repaired, and what replaces them; the rule is in [`crate::execution`].

use crate::execution::{Improved, Log, PlanChange, Repaired, Replan, ReplanPolicy, Replans, update};
use crate::kinds::layers::choose::plan;
use crate::kinds::layers::cost::cost_at;
use crate::kinds::layers::plan::{Activity, Plan};
use crate::kinds::layers::problem::Problem;
use crate::kinds::layers::steps::{Step, from_plan, with_cost};
use crate::kinds::layers::validate::validate;
use crate::plan::{Statistics, Status};

use super::LayersExecution;
use super::record::Happening;
use super::repair;
use super::settings::of_plan;
use super::steps::SAME;

impl Replans for LayersExecution {
    type Problem = Problem;
    type Activity = Activity;
    type Steps = Vec<Step>;
    type Happening = Happening;

    fn problem(&self) -> &Problem {
        &self.problem
    }

    fn plan_mut(&mut self) -> &mut Plan {
        &mut self.plan
    }

    fn log(&mut self) -> &mut Log<Happening> {
        &mut self.log
    }

    fn record_change(&mut self, change: PlanChange) {
        self.record(Happening::Plan(change));
    }

    fn rule(&self) -> (Replan, f64) {
        (self.settings.replan, self.settings.reallocate_above)
    }

    fn repair(&self, problem: Problem) -> Repaired<Self> {
        let open = problem.tasks.len() - problem.begun.len();
        let here = |step: &&Step| !problem.agents[step.agent].lost;
        if self.ahead.iter().filter(here).count() < open {
            return Repaired { problem, plan: None };
        }
        let moved = repair::moved(&problem, &self.ahead);
        let steps = match self.settings.replan {
            Replan::None => moved,
            Replan::Reschedule | Replan::Both => repair::best(&problem, &self.scales, &self.ahead).unwrap_or(moved),
        };
        let plan = self.part(&problem, &steps);
        Repaired { problem, plan: Some((steps, plan)) }
    }

    fn broken(problem: &Problem, plan: &Plan) -> Option<String> {
        let first = validate(problem, plan).first().map(ToString::to_string)?;
        // A mistake of the problem is the reason for a constraint that no plan keeps.
        Some(problem.check().first().map_or(first, |mistake| mistake.reason.to_string()))
    }

    fn moved(&self, steps: &Vec<Step>) -> bool {
        repair::differ(&self.ahead, steps, SAME)
    }

    fn steps_of(_: &Problem, plan: &Plan) -> Result<Vec<Step>, String> {
        let mut ahead = from_plan(plan);
        ahead.retain(|step| !step.begun);
        repair::sort(&mut ahead);
        Ok(ahead)
    }

    fn adopt(&mut self, problem: Problem, steps: Vec<Step>, plan: Plan) {
        (self.problem, self.ahead, self.plan, self.log.stranded) = (problem, steps, plan, None);
    }

    fn index(&self) -> f64 {
        let (was, is) = (self.optimal, self.plan.cost);
        if was == is { 0.0 } else { (was - is).abs() / was }
    }

    fn rebase_index(&mut self) {
        self.optimal = self.plan.cost;
    }

    fn is_open(&self) -> bool {
        self.problem.begun.len() < self.problem.tasks.len()
    }

    fn improve(&self) -> Result<Improved<Activity>, String> {
        let fresh = self.plan_anew(&self.problem)?;
        if let Some(why) = LayersExecution::broken(&self.problem, &fresh) {
            return Err(why);
        }
        Ok(match fresh.cost < self.plan.cost {
            true => Improved::Fresh(Box::new(fresh)),
            false => Improved::Kept(format!("rescheduling, after {}", fresh.engine)),
        })
    }

    fn plan_anew(&self, problem: &Problem) -> Result<Plan, String> {
        plan(problem, &self.settings.planning).map_err(|refusal| of_plan(&refusal))
    }

    fn nobody_left(problem: &Problem) -> Option<&'static str> {
        problem.agents.iter().all(|who| who.lost).then_some("everybody")
    }

    /// Those who are there go on with what they were assigned.
    fn strand(&mut self, problem: Problem, _again: bool) {
        self.ahead.retain(|step| !problem.agents[step.agent].lost);
        self.ahead = repair::moved(&problem, &self.ahead);
        self.plan = self.part(&problem, &self.ahead);
        self.problem = problem;
    }
}

impl LayersExecution {
    /// Brings the plan up to the world.
    pub(super) fn update(&mut self) {
        self.update_or_plan(ReplanPolicy::IfCostly);
    }

    /// As [`LayersExecution::update`], where planning anew is subject to a policy.
    pub(super) fn update_or_plan(&mut self, policy: ReplanPolicy) {
        let problem = self.problem_now();
        update(self, problem, policy);
    }

    /// The problem at the present time: what is done, and what is under way as it is expected to end.
    fn problem_now(&self) -> Problem {
        let begun = self.ended.iter().map(repair::begun).chain(self.running().map(|step| repair::begun(&step)));
        Problem { start: self.time, begun: begun.collect(), ..self.problem.clone() }
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
