//! Steps of the simulation: agents begin and end tasks.

use crate::execution::{Durations, ReplanPolicy};
use crate::kinds::layers::cost::energy_at;
use crate::kinds::layers::problem::Body;
use crate::kinds::layers::steps::Step;

use super::clock::Next;
use super::durations;
use super::record::LogEntry;
use super::state::Running;
use super::view::Doing;
use super::{LayersExecution, first_layer};

/// Times that are nearer than this are the same (s).
pub(super) const SAME: f64 = 1e-6;

impl LayersExecution {
    /// Lets this happen at the present time.
    pub(super) fn happens(&mut self, next: Next) {
        match next {
            Next::Ends(agent) => self.ends(agent),
            Next::Overdue(agent) => self.overdue(agent),
            Next::Waits(agent) => self.waits(agent),
            Next::Begins(agent) => self.begins(agent),
        }
    }

    /// An agent begins its next task, whose layer has begun.
    pub(super) fn begins(&mut self, agent: usize) {
        let Some(planned) = self.ready(agent).copied() else { return };
        self.world.ahead.retain(|step| step.task != planned.task);
        let (task, object) = (planned.task, planned.object);
        let usual = planned.end - planned.start;
        let step = Step { start: self.time, end: self.time + usual, begun: true, ..planned };
        let who = &self.problem.agents[agent];
        let ends = match self.settings.durations {
            _ if self.settings.reporting.contains(&agent) => f64::INFINITY,
            Durations::Sampled { seed } if who.spread > 0.0 => {
                let name = &self.problem.tasks[task].name;
                self.time + usual * durations::sampled(seed, &who.name, name, self.world.tries[task], who.spread)
            }
            _ => step.end,
        };
        self.world.tries[task] += 1;
        let state = &mut self.world.agents[agent];
        state.begin(Doing::Working, self.time);
        state.task = Some(Running { step, ends, expected: step.end, since: (0.0, self.time), late: 0 });
        self.record(LogEntry::Begun { agent, task, object });
        if (planned.start - self.time).abs() > SAME {
            self.update();
        }
    }

    /// The task of an agent is done.
    pub(super) fn ends(&mut self, agent: usize) {
        let Some(running) = self.world.agents[agent].task.take() else { return };
        let step = Step { end: self.time, ..running.step };
        self.count(&step, 1.0);
        let state = &mut self.world.agents[agent];
        state.begin(Doing::Idle, self.time);
        state.place = self.problem.agents[agent].place;
        state.tasks += 1;
        let layer = self.problem.tasks[step.task].layer;
        self.world.ended.push(step);
        self.record(LogEntry::Ended { agent, task: step.task });
        self.world.open = first_layer(&self.problem, &self.world.ended);
        if self.world.open.is_none_or(|open| open > layer) {
            self.record(LogEntry::LayerDone { layer });
        }
        if (running.expected - self.time).abs() > SAME || self.log.stranded.is_some() {
            self.update();
        }
        if self.world.open.is_none() {
            self.finish(LogEntry::Done);
        }
    }

    fn overdue(&mut self, agent: usize) {
        let time = self.time;
        let Some(running) = &mut self.world.agents[agent].task else { return };
        running.rebase(time);
        running.expected = time + durations::longer(time - running.step.start, time);
        running.late += 1;
        let (task, expected, late) = (running.step.task, running.expected, running.late);
        self.record(LogEntry::TaskLate { agent, task, expected });
        self.update_or_plan(ReplanPolicy::while_late(late));
    }

    /// An agent that is waited for has not begun: what comes after moves.
    fn waits(&mut self, agent: usize) {
        let time = self.time;
        let state = &mut self.world.agents[agent];
        let more = durations::patience(state.waited, time);
        state.waited += more;
        state.look = time + more;
        state.looked += 1;
        let policy = ReplanPolicy::while_late(state.looked);
        if self.ready(agent).is_some_and(|step| time - step.start > SAME) {
            self.update_or_plan(policy);
        }
    }

    /// The task of an agent, if it has one, is not done: it is to be done again, by it or by somebody else.
    pub(super) fn drops(&mut self, agent: usize) {
        let time = self.time;
        let Some(running) = self.world.agents[agent].task.take() else { return };
        self.count(&Step { end: time, ..running.step }, running.share(time));
        let task = running.step.task;
        let Step { start, end, .. } = running.step;
        // Before everything else that is planned: its layer is the one under way.
        self.world.ahead.insert(0, Step { start: time, end: time + (end - start), begun: false, ..running.step });
        self.world.dropped += 1;
        self.record(LogEntry::Dropped { agent, task });
    }

    /// Counts what an agent did for a step of whose way this share was gone.
    fn count(&mut self, step: &Step, share: f64) {
        let problem = &self.problem;
        let way = share * problem.distance(step.agent, step.task, step.object);
        let time = step.end - step.start;
        let state = &mut self.world.agents[step.agent];
        state.worked += time;
        state.travelled += way;
        match problem.agents[step.agent].body {
            Body::Robot { energy, .. } => state.energy += energy_at(&energy, way, step.speed),
            Body::Human { .. } => state.workload += time * problem.mass(step.object).unwrap_or(0.0),
        }
    }
}
