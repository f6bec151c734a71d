//! Steps of the simulation: agents begin and end operations, robots pass from one stage of a service to the next.

use crate::execution::{Durations, ReplanPolicy};
use crate::kinds::schedule::duration_quantile;
use crate::kinds::schedule::problem::ServiceTimes;

use super::ScheduleExecution;
use super::clock::Step;
use super::durations;
use super::motion::{Leg, distance, waiting_place};
use super::record::LogEntry;
use super::view::{Doing, Stage};

/// Times that differ by less are the same (s).
pub(super) const SAME: f64 = 1e-9;
/// A robot that is late is looked for again after this time at the least and at the most (s).
const LATE: (f64, f64) = (0.5, 5.0);
/// One that is held up is looked for again after this time (s).
const HELD_UP: f64 = 60.0;

impl ScheduleExecution {
    /// Lets this happen at the present time.
    pub(super) fn happens(&mut self, step: Step) {
        match step {
            Step::Ends(agent) => self.ends(agent),
            Step::Overdue(agent) => self.overdue(agent),
            Step::Tick => self.move_bases(),
            Step::Begins(agent) => self.begins(agent),
            Step::SetsOut(robot) => self.sets_out(robot),
            Step::Returned(robot) => self.returned(robot),
            Step::Home(robot) => self.home(robot),
            Step::Leaves(robot) => self.leaves(robot),
            Step::Arrives(robot) | Step::Approaches(robot) | Step::Serves(robot) => self.comes(robot),
        }
        self.settle();
    }

    /// Consequences of all steps at this time.
    pub(super) fn settle(&mut self) {
        self.wake_bases();
        let over = |doing| matches!(doing, Doing::Finished | Doing::Lost);
        let agents = self.world.agents.iter().all(|agent| over(agent.doing));
        let robots = self.world.robots.iter().all(|robot| matches!(robot.stage, Stage::Home | Stage::Lost));
        if agents && robots {
            self.finish(LogEntry::Done);
        }
    }

    pub(super) fn begins(&mut self, agent: usize) {
        let operation = self.world.agents[agent].operation;
        let nominal = duration_quantile::nominal(&self.problem, agent);
        let planned = self.service(agent, operation).filter(|at| at.start == self.time);
        let expected = planned.map_or(self.time + nominal, |at| at.end);
        let who = &self.problem.agents[agent];
        let ends = match self.settings.durations {
            _ if self.settings.reporting.contains(&agent) => f64::INFINITY,
            Durations::Planned => expected,
            Durations::Sampled { seed } => self.time + durations::sampled(seed, &who.name, operation, who.duration),
        };
        let state = &mut self.world.agents[agent];
        if operation > 0 {
            state.waited(self.time);
        }
        (state.doing, state.since, state.start) = (Doing::Working, self.time, self.time);
        (state.ends, state.expected, state.late) = (ends, expected, 0);
        self.record(LogEntry::OperationBegan { agent, operation });
    }

    pub(super) fn ends(&mut self, agent: usize) {
        let state = &mut self.world.agents[agent];
        let expected = state.expected;
        (state.doing, state.since, state.ends, state.expected) = (Doing::Waiting, self.time, self.time, self.time);
        let operation = state.operation;
        self.record(LogEntry::OperationEnded { agent, operation });
        if (expected - self.time).abs() > SAME || self.log.stranded.is_some() {
            let before = self.world.schedule.clone();
            self.serve_early(agent, expected, self.time);
            self.bring_forward(&before);
            self.update(self.problem.clone());
        }
    }

    fn overdue(&mut self, agent: usize) {
        let (duration, confidence) = (self.problem.agents[agent].duration, self.problem.confidence);
        let state = &mut self.world.agents[agent];
        state.late += 1;
        let elapsed = self.time - state.start;
        state.expected = state.start + durations::expected(duration, confidence, state.late, elapsed);
        let (operation, expected, late) = (state.operation, state.expected, state.late);
        self.record(LogEntry::OperationLate { agent, operation, expected });
        self.update_or_plan(self.problem.clone(), ReplanPolicy::while_late(late));
    }

    /// The service that a robot is at.
    fn under_way(&self, robot: usize) -> Option<(usize, usize, ServiceTimes)> {
        let (agent, operation) = self.world.robots[robot].target?;
        Some((agent, operation, self.service(agent, operation)?.times))
    }

    fn sets_out(&mut self, robot: usize) {
        let Some(at) = self.next_service(robot) else { return };
        let (agent, operation, times) = (at.agent, at.operation, at.times);
        self.world.robots[robot].begin(Stage::Going, self.time);
        self.world.robots[robot].target = Some((agent, operation));
        self.send(robot, waiting_place(&self.problem, agent, robot), times.waiting);
        self.record(LogEntry::Left { robot, agent, operation });
    }

    /// A robot arrives at the waiting place, leaves it, or begins to serve, if it is where it should be.
    fn comes(&mut self, robot: usize) {
        let Some((agent, operation, times)) = self.under_way(robot) else { return };
        let stage = self.world.robots[robot].stage;
        if stage != Stage::Waiting && !self.is_there(robot) {
            return self.is_late(robot);
        }
        let lengths = self.problem.lengths(agent, robot);
        match stage {
            Stage::Going => {
                self.count_way(robot, lengths.going, self.time - self.world.robots[robot].since);
                self.rest(robot);
                self.world.robots[robot].begin(Stage::Waiting, self.time);
                self.record(LogEntry::Waits { robot, agent, operation });
            }
            Stage::Waiting => {
                let (near, _) = self.problem.approach(&self.problem.agents[agent], robot);
                let (length, time) = (lengths.proximity, times.serving - self.time);
                let goes = length > 0.0 && time > 0.0;
                self.world.robots[robot].approach = if goes { length / time } else { near.high };
                self.world.robots[robot].begin(Stage::Approaching, self.time);
                self.send(robot, self.problem.agents[agent].place, times.serving);
                self.record(LogEntry::Approaches { robot, agent, operation });
            }
            // A plan may serve a rounding error before the operation ends.
            _ if self.world.agents[agent].doing != Doing::Waiting => self.update(self.problem.clone()),
            _ => {
                let state = &mut self.world.agents[agent];
                (state.doing, state.since) = (Doing::Served, self.time);
                if operation + 1 == self.problem.agents[agent].operations {
                    state.waited(self.time);
                }
                let way = self.world.robots[robot].leg.until - self.world.robots[robot].since;
                self.count_way(robot, lengths.proximity, way);
                self.rest(robot);
                self.world.robots[robot].begin(Stage::Serving, self.time);
                self.record(LogEntry::Serves { robot, agent, operation });
            }
        }
    }

    pub(super) fn leaves(&mut self, robot: usize) {
        let Some((agent, operation, times)) = self.under_way(robot) else { return };
        let machine = &self.problem.robots[robot];
        let (depot, until) = (machine.depot, times.end - machine.deposit);
        let state = &mut self.world.agents[agent];
        state.operation += 1;
        state.since = self.time;
        let over = state.operation >= self.problem.agents[agent].operations;
        state.doing = if over { Doing::Finished } else { Doing::Ready };
        let robot_state = &mut self.world.robots[robot];
        state.speeds.push(robot_state.approach);
        state.last = Some(robot);
        robot_state.served += 1;
        robot_state.begin(Stage::Returning, self.time);
        self.send(robot, depot, until);
        self.record(LogEntry::Served { robot, agent, operation });
    }

    fn returned(&mut self, robot: usize) {
        if !self.is_there(robot) {
            return self.is_late(robot);
        }
        let planned = self.under_way(robot).map_or(0.0, |(agent, ..)| self.problem.lengths(agent, robot).depositing);
        self.count_way(robot, planned, self.time - self.world.robots[robot].since);
        self.rest(robot);
        if self.world.robots[robot].stage == Stage::Recalled {
            self.problem.absent.retain(|absence| absence.robot != robot);
            self.home(robot);
        } else {
            self.world.robots[robot].begin(Stage::Unloading, self.time);
        }
    }

    fn home(&mut self, robot: usize) {
        self.world.robots[robot].begin(Stage::Home, self.time);
        self.world.robots[robot].target = None;
        self.record(LogEntry::Home { robot });
    }

    /// A robot stands where it was going to.
    fn rest(&mut self, robot: usize) {
        let state = &mut self.world.robots[robot];
        state.leg = Leg::rest(state.leg.to, self.time);
    }

    /// A robot is not where it should be: it goes on, and the plan learns when it is expected.
    fn is_late(&mut self, robot: usize) {
        let state = &self.world.robots[robot];
        let (to, stage, since) = (state.leg.to, state.stage, state.since);
        let speed = match stage {
            Stage::Approaching if state.approach > 0.0 => state.approach,
            _ => self.problem.robots[robot].speed.high,
        };
        let left = distance(self.position(robot, self.time), to) / speed;
        let was = self.world.robots[robot].held_up;
        let held_up = self.held_up_by(robot);
        // It is sent on when the way is free; until then nobody knows more.
        let again = if held_up.is_some() { HELD_UP } else { (0.2 * (self.time - since)).clamp(LATE.0, LATE.1) };
        let expected = self.time + left.max(again);
        self.send(robot, to, expected);
        self.world.robots[robot].not_before = expected;
        self.world.robots[robot].held_up = held_up;
        match (held_up, self.world.robots[robot].target) {
            (Some(by), target) if was != held_up => {
                self.record(LogEntry::HeldUp { robot, agent: target.map(|(agent, _)| agent), by });
            }
            (Some(_), _) | (None, None) => {}
            (None, Some((agent, operation))) => {
                self.record(LogEntry::RobotLate { robot, agent, operation, expected });
            }
        }
        let mut problem = self.problem.clone();
        if stage == Stage::Recalled {
            super::update::set_absence(&mut problem, robot, Some(expected));
        }
        // Around one that is still held up no plan is any better.
        let policy = match held_up {
            Some(_) if was == held_up => ReplanPolicy::IfInfeasible,
            _ => ReplanPolicy::IfCostly,
        };
        self.update_or_plan(problem, policy);
    }
}
