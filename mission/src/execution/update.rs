//! The plan follows what happens: it is repaired, planned anew when that pays or must be, and never used unchecked.

use crate::plan::{Plan, Statistics, Status};
use crate::schedule::assistance::{Assistance, from_plan, to_plan};
use crate::schedule::choose::plan;
use crate::schedule::problem::{Absence, Problem};
use crate::schedule::reallocate::{optimality_index, reallocate};
use crate::schedule::reschedule::repair;
use crate::schedule::validate::validate;

use super::Execution;
use super::motion::{distance, waiting_place};
use super::record::{Happening, NoPlan};
use super::settings::Replan;
use super::steps::SAME;
use super::view::{Doing, Stage};

/// The largest index that is written down: where nothing became something it is infinite.
const LARGE: f64 = 1e6;

/// When what has not begun is planned anew.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anew {
    /// When there is no plan otherwise.
    IfItMust,
    /// Also when the index of (5.19) is large.
    IfItPays,
    /// Somebody asks for it.
    Asked,
}

impl Execution {
    /// The plan under these parameters and with what has happened by now.
    pub(super) fn update(&mut self, problem: Problem) {
        self.update_or_plan(problem, Anew::IfItPays);
    }

    /// As [`Execution::update`], where planning anew is allowed it is done as `anew` says.
    pub(super) fn update_or_plan(&mut self, problem: Problem, anew: Anew) {
        let progress = self.progress(&problem);
        let (after, schedule) = repair(&self.problem, &self.schedule, &problem, self.time, &progress);
        if schedule.len() < after.operations() {
            return self.plan_anew(after, None);
        }
        let status = Status::Unbounded { stopped: None };
        let repaired = to_plan(&after, &schedule, status, "rescheduling".into(), Statistics::default());
        if let Some(why) = broken(&after, &repaired) {
            return self.plan_anew(after, Some(why));
        }
        let moved = differ(&self.schedule, &schedule);
        self.adopt(after, schedule, repaired);
        let index = optimality_index((&self.optimal.0, &self.optimal.1), (&self.problem, &self.schedule));
        let index = index.min(LARGE);
        if moved {
            self.reschedules += 1;
            self.record(Happening::Rescheduled { index });
        }
        let wanted = match anew {
            Anew::IfItMust => false,
            Anew::IfItPays => index > self.settings.reallocate_above,
            Anew::Asked => true,
        };
        if self.settings.replan == Replan::Both && wanted {
            self.reallocate(index);
        }
    }

    /// There is a choice: the repaired plan, or a new one for what has not begun.
    fn reallocate(&mut self, index: f64) {
        let begun = self.problem.begun.iter().filter(|begun| begun.service.is_some()).count();
        if begun >= self.problem.operations() {
            return;
        }
        match reallocate(&self.problem, &self.schedule, &self.settings.planning) {
            Err(refusal) => self.record(Happening::Refused { why: refusal.to_string() }),
            Ok(fresh) => match (broken(&self.problem, &fresh), from_plan(&fresh)) {
                (None, Ok(schedule)) => {
                    self.reallocations += 1;
                    let (cost, engine) = (fresh.cost, fresh.engine.clone());
                    self.adopt(self.problem.clone(), schedule, fresh);
                    self.record(Happening::Reallocated { index: Some(index), cost, engine });
                }
                (Some(why), _) => self.record(Happening::Refused { why }),
                (None, Err(wrong)) => self.record(Happening::Refused { why: wrong.to_string() }),
            },
        }
        self.optimal = (self.problem.clone(), self.schedule.clone());
    }

    /// There is no choice: operations have no service, or the repaired plan is none, because of `wrong`.
    fn plan_anew(&mut self, problem: Problem, wrong: Option<String>) {
        if !(0..problem.robots.len()).any(|robot| problem.ready(robot).is_some()) {
            return self.strand(problem, NoPlan::NoRobot);
        }
        let fresh = match plan(&problem, &self.settings.planning) {
            Ok(fresh) => fresh,
            Err(refusal) => {
                let why = wrong.map_or(NoPlan::NotFound { why: refusal.to_string() }, |why| NoPlan::Broken { why });
                return self.strand(problem, why);
            }
        };
        match (broken(&problem, &fresh), from_plan(&fresh)) {
            (None, Ok(schedule)) => {
                self.reallocations += 1;
                let (cost, engine) = (fresh.cost, fresh.engine.clone());
                self.adopt(problem, schedule, fresh);
                self.optimal = (self.problem.clone(), self.schedule.clone());
                self.record(Happening::Reallocated { index: None, cost, engine });
            }
            (Some(why), _) => self.strand(problem, NoPlan::Broken { why }),
            (None, Err(wrong)) => self.strand(problem, NoPlan::NotFound { why: wrong.to_string() }),
        }
    }

    /// A plan that has been checked becomes the one that is executed.
    fn adopt(&mut self, problem: Problem, schedule: Vec<Assistance>, plan: Plan) {
        (self.problem, self.schedule, self.plan, self.stranded) = (problem, schedule, plan, None);
        for robot in 0..self.robots.len() {
            self.direct(robot);
        }
    }

    /// A robot under way goes where it now has to be, to be there when it now has to.
    fn direct(&mut self, robot: usize) {
        let state = &self.robots[robot];
        let (leg, stage) = (state.leg, state.stage);
        let Some((agent, operation)) = state.target else { return };
        let Some(times) = self.service(agent, operation).map(|at| at.times) else { return };
        let place = waiting_place(&self.problem, agent, robot);
        match stage {
            Stage::Going if distance(place, leg.to) > SAME => {
                // The way is no longer the one from the depot.
                self.robots[robot].not_before = self.reach(robot, place);
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

    /// There is no plan any more: services under way are broken off, robots go home.
    fn strand(&mut self, problem: Problem, why: NoPlan) {
        self.problem = problem;
        if self.stranded.as_ref() == Some(&why) {
            return;
        }
        self.stranded = Some(why.clone());
        self.record(Happening::Stranded { why });
        for robot in 0..self.robots.len() {
            self.break_off(robot);
        }
        let agents = &self.agents;
        self.schedule.retain(|at| at.operation < agents[at.agent].operation);
        // Agents that were to begin wait as they are; the parameters stay, and so does what has been served.
        self.problem.begun = self.progress(&self.problem).into_iter().map(|progress| progress.begun).collect();
    }

    /// The service that a robot is at, if it has not ended, is broken off: the robot goes home.
    pub(super) fn break_off(&mut self, robot: usize) {
        let under_way = matches!(self.robots[robot].passed(), 1..=4);
        let Some((agent, operation)) = self.robots[robot].target.filter(|_| under_way) else { return };
        self.count_partial_way(robot);
        if self.agents[agent].doing == Doing::Served {
            // The wait of a last operation goes on.
            self.agents[agent].waits.truncate(operation);
            (self.agents[agent].doing, self.agents[agent].since) = (Doing::Waiting, self.time);
        }
        self.schedule.retain(|at| (at.agent, at.operation) != (agent, operation));
        let depot = self.problem.robots[robot].depot;
        let until = self.reach(robot, depot);
        self.send(robot, depot, until);
        self.robots[robot].begin(Stage::Recalled, self.time);
        self.robots[robot].target = None;
        set_absence(&mut self.problem, robot, Some(until));
        self.record(Happening::BrokenOff { robot, agent, operation });
    }

    /// Breaks off services of operations before which another one has lost its service.
    pub(super) fn break_off_dangling(&mut self) {
        for robot in 0..self.robots.len() {
            let Some((agent, operation)) = self.robots[robot].target else { continue };
            let from = self.agents[agent].operation;
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

/// The first constraint that a plan breaks.
fn broken(problem: &Problem, plan: &Plan) -> Option<String> {
    if problem.operations() == 0 {
        return None;
    }
    let mistake = problem.check().first().map(|mistake| mistake.reason.to_string());
    mistake.or_else(|| validate(problem, plan).first().map(ToString::to_string))
}

/// An instant of one is another in the other.
fn differ(before: &[Assistance], after: &[Assistance]) -> bool {
    let instants = |at: &Assistance| at.times.instants().into_iter().chain([at.start, at.end]);
    before.len() != after.len()
        || before.iter().zip(after).any(|(a, b)| instants(a).zip(instants(b)).any(|(a, b)| (a - b).abs() > SAME))
}
