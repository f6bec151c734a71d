//! The plan follows what happens: how a schedule is repaired, and what replaces it; the rule is in
//! [`crate::execution`].

use crate::execution::{Improved, PlanChange, Repaired, Replan, ReplanPolicy, Replans};
use crate::kinds::schedule::assistance::{Assistance, from_plan, to_plan};
use crate::kinds::schedule::choose::plan;
use crate::kinds::schedule::plan::{Activity, Plan};
use crate::kinds::schedule::problem::{Absence, Problem};
use crate::kinds::schedule::reallocate::{optimality_index, reallocate};
use crate::kinds::schedule::reschedule::repair;
use crate::kinds::schedule::validate::validate;
use crate::plan::{Statistics, Status};

use super::motion::{distance, waiting_place};
use super::record::LogEntry;
use super::settings::Settings;
use super::steps::SAME;
use super::view::{Doing, Stage};
use super::{ScheduleExecution, ScheduleWorld};

impl Replans for ScheduleWorld {
    type Steps = Vec<Assistance>;

    fn changed(change: PlanChange) -> LogEntry {
        LogEntry::Plan(change)
    }

    fn rule(settings: &Settings) -> (Replan, f64) {
        (settings.replan, settings.reallocate_above)
    }

    fn repair(of: &ScheduleExecution, problem: Problem) -> Repaired<Self> {
        let progress = of.progress(&problem);
        let (problem, steps) = repair(&of.problem, &of.world.schedule, &problem, of.time, &progress);
        if steps.len() < problem.operations() {
            return Repaired { problem, plan: None };
        }
        let status = Status::Unbounded { stopped: None };
        let plan = to_plan(&problem, &steps, status, "rescheduling".into(), Statistics::default());
        Repaired { problem, plan: Some((steps, plan)) }
    }

    fn broken(problem: &Problem, plan: &Plan) -> Option<String> {
        // A mission of which nothing is left has no planner's problem.
        if problem.operations() == 0 {
            return None;
        }
        let mistake = problem.check().first().map(|mistake| mistake.reason.to_string());
        mistake.or_else(|| validate(problem, plan).first().map(ToString::to_string))
    }

    fn moved(&self, steps: &Vec<Assistance>) -> bool {
        let instants = |at: &Assistance| at.times.instants().into_iter().chain([at.start, at.end]);
        let apart =
            |(a, b): (&Assistance, &Assistance)| instants(a).zip(instants(b)).any(|(a, b)| (a - b).abs() > SAME);
        self.schedule.len() != steps.len() || self.schedule.iter().zip(steps).any(apart)
    }

    fn steps_of(_: &Problem, plan: &Plan) -> Result<Vec<Assistance>, String> {
        from_plan(plan).map_err(|wrong| wrong.to_string())
    }

    fn adopt(of: &mut ScheduleExecution, steps: Vec<Assistance>) {
        of.world.schedule = steps;
        for robot in 0..of.world.robots.len() {
            of.direct(robot);
        }
    }

    fn index(of: &ScheduleExecution) -> f64 {
        let (problem, schedule) = &of.world.optimal;
        optimality_index((problem, schedule), (&of.problem, &of.world.schedule))
    }

    fn rebase_index(of: &mut ScheduleExecution) {
        of.world.optimal = (of.problem.clone(), of.world.schedule.clone());
    }

    fn is_open(problem: &Problem) -> bool {
        let begun = problem.begun.iter().filter(|begun| begun.service.is_some()).count();
        begun < problem.operations()
    }

    fn improve(of: &ScheduleExecution) -> Result<Improved<Activity>, String> {
        let fresh = reallocate(&of.problem, &of.world.schedule, &of.settings.planning);
        fresh.map(|fresh| Improved::Fresh(Box::new(fresh))).map_err(|refusal| refusal.to_string())
    }

    fn plan_anew(problem: &Problem, settings: &Settings) -> Result<Plan, String> {
        plan(problem, &settings.planning).map_err(|refusal| refusal.to_string())
    }

    fn nobody_left(problem: &Problem) -> Option<&'static str> {
        let ready = (0..problem.robots.len()).any(|robot| problem.ready(robot).is_some());
        (!ready).then_some("every robot")
    }

    /// Services under way are broken off, robots go home.
    fn strand(of: &mut ScheduleExecution, problem: Problem, again: bool) {
        of.problem = problem;
        if again {
            return;
        }
        for robot in 0..of.world.robots.len() {
            of.break_off(robot);
        }
        let agents = &of.world.agents;
        of.world.schedule.retain(|at| at.operation < agents[at.agent].operation);
        // Agents that were to begin wait as they are; the parameters stay, and so does what has been served.
        of.problem.begun = of.progress(&of.problem).into_iter().map(|progress| progress.begun).collect();
    }
}

impl ScheduleExecution {
    /// Brings the plan up to the world, under these parameters.
    pub(super) fn update(&mut self, problem: Problem) {
        self.update_plan(problem, ReplanPolicy::IfCostly);
    }

    /// As [`ScheduleExecution::update`], where planning anew is subject to a policy.
    pub(super) fn update_or_plan(&mut self, problem: Problem, policy: ReplanPolicy) {
        self.update_plan(problem, policy);
    }

    /// A robot under way goes where it now has to be, to be there when it now has to.
    fn direct(&mut self, robot: usize) {
        let state = &self.world.robots[robot];
        let (leg, stage) = (state.leg, state.stage);
        let Some((agent, operation)) = state.target else { return };
        let Some(times) = self.service(agent, operation).map(|at| at.times) else { return };
        let place = waiting_place(&self.problem, agent, robot);
        match stage {
            Stage::Going if distance(place, leg.to) > SAME => {
                // The way is no longer the one from the depot.
                self.world.robots[robot].not_before = self.reach(robot, place);
                self.send(robot, place, times.waiting);
            }
            Stage::Going if place != leg.to || times.waiting != leg.until => self.send(robot, place, times.waiting),
            Stage::Waiting if distance(place, leg.to) > SAME => {
                let until = self.reach(robot, place);
                self.send(robot, place, until);
            }
            _ => {}
        }
    }

    /// The service that a robot is at, if it has not ended, is broken off: the robot goes home.
    pub(super) fn break_off(&mut self, robot: usize) {
        let under_way = matches!(self.world.robots[robot].passed(), 1..=4);
        let Some((agent, operation)) = self.world.robots[robot].target.filter(|_| under_way) else { return };
        self.count_partial_way(robot);
        if self.world.agents[agent].doing == Doing::Served {
            // The wait of a last operation goes on.
            self.world.agents[agent].waits.truncate(operation);
            (self.world.agents[agent].doing, self.world.agents[agent].since) = (Doing::Waiting, self.time);
        }
        self.world.schedule.retain(|at| (at.agent, at.operation) != (agent, operation));
        let depot = self.problem.robots[robot].depot;
        let until = self.reach(robot, depot);
        self.send(robot, depot, until);
        self.world.robots[robot].begin(Stage::Recalled, self.time);
        self.world.robots[robot].target = None;
        set_absence(&mut self.problem, robot, Some(until));
        self.record(LogEntry::BrokenOff { robot, agent, operation });
    }

    /// Breaks off services of operations before which another one has lost its service.
    pub(super) fn break_off_dangling(&mut self) {
        for robot in 0..self.world.robots.len() {
            let Some((agent, operation)) = self.world.robots[robot].target else { continue };
            let from = self.world.agents[agent].operation;
            if (from..operation).any(|earlier| self.service(agent, earlier).is_none()) {
                self.break_off(robot);
            }
        }
    }
}

/// A robot takes no new service until then (s); none: never again.
pub(super) fn set_absence(problem: &mut Problem, robot: usize, until: Option<f64>) {
    problem.absent.retain(|absence| absence.robot != robot);
    problem.absent.push(Absence { robot, until });
}
