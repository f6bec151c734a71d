//! State of the agents in the world.

use crate::kinds::layers::problem::Agent;
use crate::kinds::layers::steps::Step;

use super::view::Doing;

/// A task under way.
#[derive(Clone, Debug)]
pub(super) struct Running {
    /// As it was planned, from when it began.
    pub step: Step,
    /// True end (s); infinite: an event reports it.
    pub ends: f64,
    /// Expected end (s).
    pub expected: f64,
    /// The share of the way that was done at the time beside it (s).
    pub since: (f64, f64),
    /// Number of expected ends that have passed.
    pub late: usize,
}

impl Running {
    /// End that an observer assumes (s).
    fn until(&self) -> f64 {
        if self.ends.is_finite() { self.ends } else { self.expected }
    }

    /// Completed share, 0 to 1.
    pub fn share(&self, time: f64) -> f64 {
        let (share, since) = self.since;
        let left = self.until() - since;
        if left > 0.0 { (share + (1.0 - share) * (time - since) / left).clamp(share, 1.0) } else { 1.0 }
    }

    /// It goes on from where it is; its end may change then.
    pub fn rebase(&mut self, time: f64) {
        self.since = (self.share(time), time);
    }

    /// With the end that is expected.
    pub fn expected_step(&self) -> Step {
        Step { end: self.expected, ..self.step }
    }
}

/// An agent.
#[derive(Clone, Debug)]
pub(super) struct AgentState {
    pub doing: Doing,
    /// Since when (s).
    pub since: f64,
    /// Position while it does not work (m).
    pub place: [f64; 3],
    pub task: Option<Running>,
    /// Time of the next check that it has begun its task (s), if an event reports the begin.
    pub look: f64,
    /// Time waited for it until then (s).
    pub waited: f64,
    /// Number of times that it had not begun then.
    pub looked: usize,
    /// Tasks that it has done.
    pub tasks: usize,
    /// Time at work, in tasks that have ended (s).
    pub worked: f64,
    /// Way that it has gone in these (m).
    pub travelled: f64,
    /// Energy that these took (J), of a robot.
    pub energy: f64,
    /// Time of these times the mass of their objects (kg s), of a person.
    pub workload: f64,
}

impl AgentState {
    pub fn new(who: &Agent, time: f64) -> AgentState {
        AgentState {
            doing: if who.lost { Doing::Lost } else { Doing::Idle },
            since: time,
            place: who.place,
            task: None,
            look: time,
            waited: 0.0,
            looked: 0,
            tasks: 0,
            worked: 0.0,
            travelled: 0.0,
            energy: 0.0,
            workload: 0.0,
        }
    }

    /// Passes to something else.
    pub fn begin(&mut self, doing: Doing, time: f64) {
        (self.doing, self.since) = (doing, time);
        (self.look, self.waited, self.looked) = (time, 0.0, 0);
    }
}
