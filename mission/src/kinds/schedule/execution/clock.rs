//! Steps that happen by themselves, and their times.

use crate::execution::World;
use crate::kinds::schedule::assistance::Assistance;
use crate::kinds::schedule::plan::Activity;
use crate::kinds::schedule::problem::Problem;

use super::record::LogEntry;
use super::settings::{Settings, Travel};
use super::view::{Doing, Stage};
use super::{ScheduleExecution, ScheduleWorld};

/// Something that happens by itself, of an agent or a robot. Of what happens at the same time, the first comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Step {
    /// An operation ends.
    Ends(usize),
    /// An operation has not ended when it was expected to.
    Overdue(usize),
    /// The bases get their next commands.
    Tick,
    /// A robot has done what is done at its depot.
    Home(usize),
    /// A robot is back at its depot.
    Returned(usize),
    /// A service ends.
    Leaves(usize),
    /// A robot serves.
    Serves(usize),
    /// A robot leaves the waiting place.
    Approaches(usize),
    /// A robot is at the waiting place.
    Arrives(usize),
    /// An operation begins.
    Begins(usize),
    /// A robot leaves its depot.
    SetsOut(usize),
}

impl World for ScheduleWorld {
    type Problem = Problem;
    type Settings = Settings;
    type Activity = Activity;
    type LogEntry = LogEntry;
    type Step = Step;

    fn due(of: &ScheduleExecution, ticks: bool) -> Vec<(f64, Step)> {
        let agents = (0..of.world.agents.len()).filter_map(|agent| of.of_agent(agent));
        let robots = (0..of.world.robots.len()).filter_map(|robot| of.of_robot(robot));
        let tick = match (&of.settings.travel, of.world.tick) {
            (Travel::Bases(potentials), Some(tick)) if ticks => {
                Some((of.begin + (tick + 1) as f64 * potentials.step, Step::Tick))
            }
            _ => None,
        };
        agents.chain(robots).chain(tick).collect()
    }

    fn perform(of: &mut ScheduleExecution, step: Step) {
        of.happens(step);
    }
}

impl ScheduleExecution {
    fn of_agent(&self, agent: usize) -> Option<(f64, Step)> {
        let state = &self.world.agents[agent];
        let planned = self.log.stranded.is_none();
        match state.doing {
            // If nothing is planned, an agent goes on with its work.
            Doing::Ready if !planned => Some((self.time, Step::Begins(agent))),
            Doing::Ready => Some((self.service(agent, state.operation)?.start, Step::Begins(agent))),
            Doing::Working if state.ends <= state.expected || (!planned && state.ends.is_finite()) => {
                Some((state.ends, Step::Ends(agent)))
            }
            Doing::Working if planned => Some((state.expected, Step::Overdue(agent))),
            _ => None,
        }
    }

    fn of_robot(&self, robot: usize) -> Option<(f64, Step)> {
        let state = &self.world.robots[robot];
        let times = state.target.and_then(|(agent, operation)| self.service(agent, operation)).map(|at| at.times);
        match state.stage {
            Stage::Home => Some((self.next_service(robot)?.times.going, Step::SetsOut(robot))),
            Stage::Going => Some((times?.waiting, Step::Arrives(robot))),
            Stage::Waiting => Some((times?.proximity, Step::Approaches(robot))),
            Stage::Approaching => {
                // One that is there before the operation has ended stands by, whatever was planned.
                let ended = state.target.is_some_and(|(agent, _)| self.world.agents[agent].doing == Doing::Waiting);
                let serving = Some(times?.serving).filter(|serving| ended || *serving > self.time);
                serving.map(|serving| (serving, Step::Serves(robot)))
            }
            Stage::Serving => Some((times?.depositing, Step::Leaves(robot))),
            Stage::Returning | Stage::Recalled => Some((state.leg.until, Step::Returned(robot))),
            Stage::Unloading => Some((times?.end, Step::Home(robot))),
            Stage::Lost => None,
        }
    }

    /// The service for which a robot that is at home leaves next.
    pub(super) fn next_service(&self, robot: usize) -> Option<&Assistance> {
        let coming = |at: &&Assistance| at.robot == robot && at.operation >= self.world.agents[at.agent].operation;
        let services = self.world.schedule.iter().filter(coming).filter(|_| self.log.stranded.is_none());
        services.min_by(|a, b| a.times.going.total_cmp(&b.times.going).then(a.target().cmp(&b.target())))
    }
}
