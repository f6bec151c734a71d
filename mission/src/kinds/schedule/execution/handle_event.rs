//! Events from outside: what they change in the world, and in the problem.

use crate::execution::{Replan, ReplanPolicy};
use crate::kinds::schedule::adapt::{Feedback, adapt};
use crate::kinds::schedule::duration_quantile;
use crate::kinds::schedule::plan::Actor;
use crate::kinds::schedule::problem::Problem;
use crate::numbers::MAX_NUMBER;

use super::ScheduleExecution;
use super::event::{Event, EventError};
use super::motion::Leg;
use super::record::{LogEntry, Record};
use super::settings::Travel;
use super::update::set_absence;
use super::view::{Doing, Stage};

/// `D` of thesis 5.4.1 (m): the largest change of a waiting distance that a step of feedback asks for.
const DISTANCE: f64 = 1.0;

impl ScheduleExecution {
    /// Something happens at the present time. Gives what followed from it at once.
    ///
    /// # Errors
    ///
    /// The event is of nobody, or cannot happen now. Nothing has changed then.
    pub fn handle_event(&mut self, event: Event) -> Result<&[Record], EventError> {
        let from = self.log.records.len();
        let recorded = |execution: &mut ScheduleExecution| execution.record(LogEntry::Handled { event });
        match event {
            Event::Begun { agent } => {
                self.require(agent, &[Doing::Ready], |name| EventError::NotReady { name })?;
                recorded(self);
                self.begin_now(agent);
            }
            Event::Done { agent } => {
                self.require(agent, &[Doing::Working], |name| EventError::NotWorking { name })?;
                recorded(self);
                self.ends(agent);
            }
            Event::Late { agent, by } => {
                self.require(agent, &[Doing::Working, Doing::Served], |name| EventError::NotBusy { name })?;
                if !by.is_finite() || by.abs() > MAX_NUMBER {
                    return Err(EventError::Time { value: by });
                }
                recorded(self);
                if self.world.agents[agent].doing == Doing::Served {
                    self.service_late(agent, by);
                } else {
                    let time = self.time;
                    let state = &mut self.world.agents[agent];
                    let was = state.expected;
                    state.ends = (state.ends + by).max(time);
                    state.expected = (state.expected + by).max(time);
                    let expected = state.expected;
                    if expected < was {
                        let before = self.world.schedule.clone();
                        self.serve_early(agent, was, expected);
                        self.bring_forward(&before);
                    }
                    self.update(self.problem.clone());
                }
            }
            Event::Served { agent } => {
                let robot = self.serving(agent)?;
                recorded(self);
                let (time, operation) = (self.time, self.world.agents[agent].operation);
                let by = self.service(agent, operation).map_or(0.0, |at| time - at.times.depositing);
                let before = self.world.schedule.clone();
                self.shift(agent, operation, |times| times, by);
                self.leaves(robot);
                self.bring_forward(&before);
                self.update(self.problem.clone());
            }
            Event::Failed { agent } => {
                let robot = self.serving(agent)?;
                recorded(self);
                let operation = self.world.agents[agent].operation;
                let again = self.time + self.problem.robots[robot].serve;
                let by = self.service(agent, operation).map_or(0.0, |at| again - at.times.depositing);
                self.shift(agent, operation, |times| times, by);
                self.update(self.problem.clone());
            }
            Event::Moved { agent, place } => {
                let problem = self.moved(agent, place)?;
                recorded(self);
                self.update(problem);
            }
            Event::Said { agent, wait, approach, distance } => {
                let feedback = self.in_numbers(agent, wait, approach, distance)?;
                self.apply_feedback(&feedback, event)?;
            }
            Event::Feedback(feedback) => self.apply_feedback(&feedback, event)?,
            Event::Replan => {
                recorded(self);
                self.update_or_plan(self.problem.clone(), ReplanPolicy::Asked);
            }
            Event::Lost { who: Actor::Robot(robot) } => {
                self.is_lost(Actor::Robot(robot), false)?;
                recorded(self);
                self.lose_robot(robot);
            }
            Event::Lost { who: Actor::Agent(agent) } => {
                self.is_lost(Actor::Agent(agent), false)?;
                recorded(self);
                self.lose_agent(agent);
            }
            Event::Back { who: Actor::Robot(robot) } => {
                self.is_lost(Actor::Robot(robot), true)?;
                recorded(self);
                self.robot_back(robot);
            }
            Event::Back { who: Actor::Agent(agent) } => {
                self.is_lost(Actor::Agent(agent), true)?;
                recorded(self);
                self.agent_back(agent);
            }
        }
        self.settle();
        Ok(&self.log.records[from..])
    }

    fn name(&self, agent: usize) -> String {
        self.problem.agent_label(agent).unwrap_or_default().to_string()
    }

    fn require(&self, agent: usize, doing: &[Doing], or: impl Fn(String) -> EventError) -> Result<(), EventError> {
        let state = self.world.agents.get(agent).ok_or(EventError::NoAgent { agent })?;
        match state.doing {
            is if doing.contains(&is) => Ok(()),
            Doing::Lost => Err(EventError::IsLost { name: self.name(agent) }),
            _ => Err(or(self.name(agent))),
        }
    }

    /// The robot that serves this agent.
    fn serving(&self, agent: usize) -> Result<usize, EventError> {
        let or = |name| EventError::NotServing { name };
        self.require(agent, &[Doing::Served], or)?;
        let operation = self.world.agents[agent].operation;
        let serves = |robot: &super::state::RobotState| {
            robot.target == Some((agent, operation)) && robot.stage == Stage::Serving
        };
        self.world.robots.iter().position(serves).ok_or_else(|| or(self.name(agent)))
    }

    /// The service of an agent takes so much longer (s), and ends now at the earliest.
    fn service_late(&mut self, agent: usize, by: f64) {
        let operation = self.world.agents[agent].operation;
        let left = self.service(agent, operation).map_or(0.0, |at| at.times.depositing - self.time);
        let before = self.world.schedule.clone();
        self.shift(agent, operation, |times| times, by.max(-left));
        if by < 0.0 {
            self.bring_forward(&before);
        }
        self.update(self.problem.clone());
    }

    fn begin_now(&mut self, agent: usize) {
        let (time, operation) = (self.time, self.world.agents[agent].operation);
        let end = time + duration_quantile::nominal(&self.problem, agent);
        for at in self.world.schedule.iter_mut().filter(|at| (at.agent, at.operation) == (agent, operation)) {
            (at.start, at.end) = (time, end);
        }
        self.begins(agent);
        self.update(self.problem.clone());
    }

    fn moved(&self, agent: usize, place: [f64; 2]) -> Result<Problem, EventError> {
        let state = self.world.agents.get(agent).ok_or(EventError::NoAgent { agent })?;
        if state.doing == Doing::Lost {
            return Err(EventError::IsLost { name: self.name(agent) });
        }
        if !self.has_places() {
            return Err(EventError::NoPlaces);
        }
        let near = |robot: &super::state::RobotState| {
            let (is_for, stage) = (robot.target.is_some_and(|(who, _)| who == agent), robot.stage);
            is_for && matches!(stage, Stage::Approaching | Stage::Serving)
        };
        if self.world.robots.iter().any(near) {
            return Err(EventError::RobotNear { name: self.name(agent) });
        }
        if let Travel::Bases(potentials) = &self.settings.travel
            && potentials.obstacles.iter().any(|obstacle| potentials.covers(obstacle, place))
        {
            return Err(EventError::Impossible { why: "an obstacle covers the place".into() });
        }
        let mut problem = self.problem.clone();
        problem.agents[agent].place = place;
        self.still_possible(&problem)?;
        Ok(problem)
    }

    /// A change makes no mistake in a problem without one.
    fn still_possible(&self, problem: &Problem) -> Result<(), EventError> {
        // The part of the way that is behind may have had another length.
        let now = |problem: &Problem| Problem { start: self.time, ..problem.clone() }.check();
        match now(problem).first() {
            Some(first) if now(&self.problem).is_empty() => {
                Err(EventError::Impossible { why: first.reason.to_string() })
            }
            _ => Ok(()),
        }
    }

    /// The five steps of Fig. 5.5 as numbers, for the last service of this person.
    fn in_numbers(&self, agent: usize, wait: i8, approach: i8, distance: i8) -> Result<Feedback, EventError> {
        let state = self.world.agents.get(agent).ok_or(EventError::NoAgent { agent })?;
        if let Some(step) = [wait, approach, distance].into_iter().find(|step| !(-2..=2).contains(step)) {
            return Err(EventError::Step { step });
        }
        let not_served = || EventError::NotServed { name: self.name(agent) };
        let robot = state.last.ok_or_else(not_served)?;
        let speed = *state.speeds.last().ok_or_else(not_served)?;
        let share = |step: i8| f64::from(step) / 2.0;
        Ok(Feedback {
            agent,
            operation: state.operation - 1,
            robot,
            speed,
            wait: share(wait),
            approach: share(approach),
            distance: DISTANCE * share(distance),
        })
    }

    fn apply_feedback(&mut self, feedback: &Feedback, event: Event) -> Result<(), EventError> {
        let agent = feedback.agent;
        let state = self.world.agents.get(agent).ok_or(EventError::NoAgent { agent })?;
        match state.doing {
            Doing::Lost => return Err(EventError::IsLost { name: self.name(agent) }),
            _ if feedback.operation >= state.operation => {
                return Err(EventError::NotServed { name: self.name(agent) });
            }
            _ => {}
        }
        let (problem, satisfied) =
            adapt(&self.problem, self.world.satisfied[agent], feedback, &self.settings.adaptation)?;
        self.still_possible(&problem)?;
        self.record(LogEntry::Handled { event });
        let before = self.next_wait_and_speed(agent);
        if self.settings.replan != Replan::None {
            self.world.satisfied[agent] = Some(satisfied);
            // Services that have become possible are in no plan, and so in no cost that could have changed.
            let policy =
                if widened(&self.problem, &problem, agent) { ReplanPolicy::Asked } else { ReplanPolicy::IfCostly };
            self.update_or_plan(problem, policy);
        }
        if let (Some(before), Some(after)) = (before, self.next_wait_and_speed(agent)) {
            self.world.indices[agent] =
                self.world.indices[agent].after(feedback.wait, feedback.approach, before, after);
        }
        Ok(())
    }

    /// Checks that somebody exists and is, or is not, lost.
    fn is_lost(&self, who: Actor, wanted: bool) -> Result<(), EventError> {
        let (lost, name) = match who {
            Actor::Robot(robot) => {
                let state = self.world.robots.get(robot).ok_or(EventError::NoRobot { robot })?;
                (state.stage == Stage::Lost, self.problem.robot_label(robot).unwrap_or_default().to_string())
            }
            Actor::Agent(agent) => {
                let state = self.world.agents.get(agent).ok_or(EventError::NoAgent { agent })?;
                (state.doing == Doing::Lost, self.name(agent))
            }
        };
        match (lost, wanted) {
            (true, false) => Err(EventError::IsLost { name }),
            (false, true) => Err(EventError::NotLost { name }),
            _ => Ok(()),
        }
    }

    fn lose_robot(&mut self, robot: usize) {
        self.break_off(robot);
        let here = self.position(robot, self.time);
        let state = &mut self.world.robots[robot];
        state.begin(Stage::Lost, self.time);
        (state.leg, state.target) = (Leg::rest(here, self.time), None);
        (state.position, state.velocity) = (here, [0.0; 2]);
        let agents = &self.world.agents;
        self.world.schedule.retain(|at| at.robot != robot || at.operation < agents[at.agent].operation);
        self.break_off_dangling();
        let mut problem = self.problem.clone();
        set_absence(&mut problem, robot, None);
        self.update(problem);
    }

    fn robot_back(&mut self, robot: usize) {
        let (place, depot) = (self.free_place(robot), self.problem.robots[robot].depot);
        let state = &mut self.world.robots[robot];
        state.begin(Stage::Home, self.time);
        state.position = place;
        state.leg = Leg::rest(depot, self.time);
        self.let_on();
        let mut problem = self.problem.clone();
        problem.absent.retain(|absence| absence.robot != robot);
        self.update_or_plan(problem, ReplanPolicy::Asked);
    }

    fn lose_agent(&mut self, agent: usize) {
        for robot in 0..self.world.robots.len() {
            if self.world.robots[robot].target.is_some_and(|(who, _)| who == agent) {
                self.break_off(robot);
            }
        }
        let served = self.world.agents[agent].operation;
        self.world.schedule.retain(|at| at.agent != agent || at.operation < served);
        let state = &mut self.world.agents[agent];
        state.carried = state.waiting(self.time);
        (state.doing, state.since) = (Doing::Lost, self.time);
        let mut problem = self.problem.clone();
        let who = &mut problem.agents[agent];
        self.world.lost[agent] = Some(who.clone());
        who.operations = served;
        who.wait_weights.truncate(served);
        who.limit_weights.truncate(served);
        who.approach_weights.truncate(served);
        self.update(problem);
    }

    fn agent_back(&mut self, agent: usize) {
        let mut problem = self.problem.clone();
        if let Some(who) = self.world.lost[agent].take() {
            problem.agents[agent] = who;
        }
        let state = &mut self.world.agents[agent];
        let over = state.operation >= problem.agents[agent].operations;
        state.doing = if over { Doing::Finished } else { Doing::Ready };
        // Its wait begins with its return.
        (state.since, state.ends) = (self.time, self.time);
        // The wait before the operation that begins again is a part of the wait before it.
        if !over && state.operation > 0 && state.waits.len() >= state.operation {
            state.carried += state.waits.pop().unwrap_or(0.0);
        }
        if !over {
            self.log.done = None;
        }
        self.update(problem);
    }
}

/// A robot may approach this agent faster, or more slowly, than it might before.
fn widened(before: &Problem, after: &Problem, agent: usize) -> bool {
    let (Some(was), Some(is)) = (before.agents.get(agent), after.agents.get(agent)) else { return false };
    (0..after.robots.len()).any(|robot| {
        let (was, is) = (before.approach(was, robot).0, after.approach(is, robot).0);
        is.high > was.high || is.low < was.low
    })
}
