//! The simulation in which a mission of any kind is executed: its clock, its plan and its log.

use std::fmt::Debug;

use crate::plan::Plan;

use super::clock::DiscreteEvents;
use super::log::{Log, NoFeasiblePlan, Record};

/// The part of a simulation that only the kind knows: the state of those who take part, and the steps that happen by
/// themselves.
pub trait World: Clone + Debug + Send + Sized {
    /// The problem of the kind.
    type Problem: Clone + Debug + Send;
    /// Settings of an execution.
    type Settings: Clone + Debug + Send;
    /// The activities of its plans.
    type Activity: Clone + Debug + Send;
    /// The kind's list of what can happen.
    type LogEntry: Clone + Debug + Send;
    /// A step that happens by itself; see [`DiscreteEvents::Step`].
    type Step: Copy + Ord;

    /// Every step that is due; see [`DiscreteEvents::due`].
    fn due(of: &Simulation<Self>, ticks: bool) -> Vec<(f64, Self::Step)>;

    /// Lets a step happen at the present time.
    fn perform(of: &mut Simulation<Self>, step: Self::Step);
}

/// A mission under way, as a discrete-event simulation.
#[derive(Clone, Debug)]
pub struct Simulation<W: World> {
    pub(crate) settings: W::Settings,
    /// As it is now: `start` is when the plan was made or repaired last.
    pub(crate) problem: W::Problem,
    pub(crate) plan: Plan<W::Activity>,
    /// Start of the mission (s).
    pub(crate) begin: f64,
    pub(crate) time: f64,
    pub(crate) log: Log<W::LogEntry>,
    pub(crate) world: W,
}

impl<W: World> Simulation<W> {
    /// Stands at the start (s) of a plan.
    pub(crate) fn at_start(
        problem: W::Problem,
        plan: Plan<W::Activity>,
        settings: W::Settings,
        begin: f64,
        world: W,
    ) -> Simulation<W> {
        Simulation { settings, problem, plan, begin, time: begin, log: Log::new(), world }
    }

    /// The present (s).
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The plan as it is now: what was done and is under way as it happened, the rest as planned. If there is no plan for
    /// everything, the kind says what it is.
    pub fn plan(&self) -> &Plan<W::Activity> {
        &self.plan
    }

    /// The problem as it is now: with what people asked for, who moved, who is lost, and what had begun when the plan was
    /// made or repaired last.
    pub fn problem(&self) -> &W::Problem {
        &self.problem
    }

    /// True if everything is done that can be.
    pub fn done(&self) -> bool {
        self.log.done.is_some()
    }

    /// Reason why there is no plan for everything any more, if so.
    pub fn stranded(&self) -> Option<&NoFeasiblePlan> {
        self.log.stranded.as_ref()
    }

    /// Everything that has happened, in order.
    pub fn records(&self) -> &[Record<W::LogEntry>] {
        &self.log.records
    }

    /// Lets time pass until `to` (s), and returns the records of that time. A time before the present, or no finite number,
    /// lets nothing pass.
    pub fn advance(&mut self, to: f64) -> &[Record<W::LogEntry>] {
        let from = self.log.records.len();
        self.run_until(to);
        &self.log.records[from..]
    }

    /// Time of the next step that happens by itself (s), as far as it is known: an activity may be late, and one that ends
    /// when it is reported may end at any time. None: there is no such step.
    pub fn next(&self) -> Option<f64> {
        self.upcoming(false).map(|(time, _)| time)
    }

    /// Writes into the log that this happens at the present time.
    pub(crate) fn record(&mut self, what: W::LogEntry) {
        self.log.records.push(Record { time: self.time, what });
    }

    /// Notes that everything is done at the present time, with this entry of the log; once.
    pub(crate) fn finish(&mut self, what: W::LogEntry) {
        if self.log.done.is_none() {
            self.log.done = Some(self.time);
            self.record(what);
        }
    }
}

impl<W: World> DiscreteEvents for Simulation<W> {
    type Step = W::Step;

    fn now(&self) -> f64 {
        self.time
    }

    fn set_time(&mut self, time: f64) {
        self.time = time;
    }

    fn due(&self, ticks: bool) -> Vec<(f64, W::Step)> {
        W::due(self, ticks)
    }

    fn perform(&mut self, step: W::Step) {
        W::perform(self, step);
    }
}
