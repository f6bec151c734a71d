//! The plan follows what happens: how layers are repaired, and what replaces them; the rule is in [`crate::execution`].

use crate::execution::{Improved, PlanChange, Repaired, Replan, ReplanPolicy, Replans};
use crate::kinds::layers::choose::plan;
use crate::kinds::layers::cost::cost_at;
use crate::kinds::layers::plan::{Activity, Plan};
use crate::kinds::layers::problem::Problem;
use crate::kinds::layers::steps::{Step, from_plan, with_cost};
use crate::kinds::layers::validate::validate;
use crate::plan::{Statistics, Status};

use super::record::LogEntry;
use super::repair;
use super::settings::{Settings, of_plan};
use super::steps::SAME;
use super::{LayersExecution, LayersWorld};

impl Replans for LayersWorld {
    type Steps = Vec<Step>;

    fn changed(change: PlanChange) -> LogEntry {
        LogEntry::Plan(change)
    }

    fn rule(settings: &Settings) -> (Replan, f64) {
        (settings.replan, settings.reallocate_above)
    }

    fn repair(of: &LayersExecution, problem: Problem) -> Repaired<Self> {
        let (world, open) = (&of.world, problem.tasks.len() - problem.begun.len());
        let here = |step: &&Step| !problem.agents[step.agent].lost;
        if world.ahead.iter().filter(here).count() < open {
            return Repaired { problem, plan: None };
        }
        let moved = repair::moved(&problem, &world.ahead);
        let steps = match of.settings.replan {
            Replan::None => moved,
            Replan::Reschedule | Replan::Both => repair::best(&problem, &world.scales, &world.ahead).unwrap_or(moved),
        };
        let plan = world.part(&problem, &steps);
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

    fn adopt(of: &mut LayersExecution, steps: Vec<Step>) {
        of.world.ahead = steps;
    }

    fn index(of: &LayersExecution) -> f64 {
        let (was, is) = (of.world.optimal, of.plan.cost);
        if was == is { 0.0 } else { (was - is).abs() / was }
    }

    fn rebase_index(of: &mut LayersExecution) {
        of.world.optimal = of.plan.cost;
    }

    fn is_open(problem: &Problem) -> bool {
        problem.begun.len() < problem.tasks.len()
    }

    fn improve(of: &LayersExecution) -> Result<Improved<Activity>, String> {
        let fresh = Self::plan_anew(&of.problem, &of.settings)?;
        if let Some(why) = Self::broken(&of.problem, &fresh) {
            return Err(why);
        }
        Ok(match fresh.cost < of.plan.cost {
            true => Improved::Fresh(Box::new(fresh)),
            false => Improved::Kept(format!("rescheduling, after {}", fresh.engine)),
        })
    }

    fn plan_anew(problem: &Problem, settings: &Settings) -> Result<Plan, String> {
        plan(problem, &settings.planning).map_err(|refusal| of_plan(&refusal))
    }

    fn nobody_left(problem: &Problem) -> Option<&'static str> {
        problem.agents.iter().all(|who| who.lost).then_some("everybody")
    }

    /// Those who are there go on with what they were assigned.
    fn strand(of: &mut LayersExecution, problem: Problem, _again: bool) {
        let world = &mut of.world;
        world.ahead.retain(|step| !problem.agents[step.agent].lost);
        world.ahead = repair::moved(&problem, &world.ahead);
        of.plan = world.part(&problem, &world.ahead);
        of.problem = problem;
    }
}

impl LayersWorld {
    /// The plan of what has begun and what is ahead.
    fn part(&self, problem: &Problem, ahead: &[Step]) -> Plan {
        let mut steps: Vec<Step> = problem.begun.iter().map(|begun| begun.step()).collect();
        steps.extend(ahead);
        let cost = cost_at(problem, &self.scales, &steps).total();
        let status = Status::Unbounded { stopped: None };
        with_cost(problem, (&steps, cost), status, "rescheduling".into(), Statistics::default())
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
        self.update_plan(problem, policy);
    }

    /// The problem at the present time: what is done, and what is under way as it is expected to end.
    fn problem_now(&self) -> Problem {
        let begun = self.world.ended.iter().map(repair::begun).chain(self.running().map(|step| repair::begun(&step)));
        Problem { start: self.time, begun: begun.collect(), ..self.problem.clone() }
    }
}
