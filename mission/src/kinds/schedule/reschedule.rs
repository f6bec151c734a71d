//! Repair of a plan after changes, thesis Algorithm 3: assignment and order stay, times move.
//!
//! Operations take longer, agents move, bounds change. Every service keeps its times if possible. If its operation ends
//! late, the robot waits and then approaches at the planned speed, which the person feels safe with; if the path has
//! become longer, the robot moves faster if allowed; if that does not suffice, the rest of the service is delayed. A
//! delay is passed on to the following services of that robot and of that agent, less what faster returns recover
//! (`HandleShift`; the thesis delays everything that follows by the same amount, here each service is delayed by what
//! it needs).

use serde::{Deserialize, Serialize};

use super::assistance::Assistance;
use super::batches::begun_at;
use super::duration_quantile;
use super::problem::{Begun, Problem, ServiceTimes};
use crate::numbers::Range;

/// An observed or expected end of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Observed {
    /// Index of the agent.
    pub agent: usize,
    /// Number of the operation, from 0.
    pub operation: usize,
    /// End of the operation (s).
    pub end: f64,
}

/// Progress of an operation and its service.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// The operation as in [`Problem::begun`], with its service if the robot has left for it or for a later one of the
    /// agent. The end of the operation is the observed or expected one.
    pub begun: Begun,
    /// True if the operation itself has begun; if false, its robot has left before it.
    pub started: bool,
    /// Number of the six instants of the service that have passed, in order. These are kept exactly.
    pub passed: usize,
    /// Lower bounds on the remaining instants of the service (s), regardless of the speeds: for a robot that is late.
    pub earliest: Earliest,
}

/// Lower bounds on instants of a service (s); minus infinity for none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Earliest {
    /// Arrival at the waiting place.
    pub waiting: f64,
    /// Departure from the waiting place.
    pub proximity: f64,
    /// Arrival at the agent.
    pub serving: f64,
    /// End of the work at the depot.
    pub end: f64,
}

impl Earliest {
    /// No bounds.
    pub const NONE: Earliest = Earliest {
        waiting: f64::NEG_INFINITY,
        proximity: f64::NEG_INFINITY,
        serving: f64::NEG_INFINITY,
        end: f64::NEG_INFINITY,
    };
}

/// Repairs the schedule `previous` at `time` (s) under the parameters of `problem`. Returns the repaired schedule with
/// the problem at that time: its start is `time`, its `begun` are the operations that have begun, with repaired times
/// of current services. `previous` is a schedule of `before`, which has the same robots and agents; `problem.begun` is
/// ignored. An observed end of an operation that has not begun by `time` is ignored, and so is one after the start of a
/// service that has begun.
pub fn reschedule(
    before: &Problem,
    previous: &[Assistance],
    problem: &Problem,
    time: f64,
    observed: &[Observed],
) -> (Problem, Vec<Assistance>) {
    let progress: Vec<Progress> = begun_at(previous, time)
        .into_iter()
        .map(|mut begun| {
            let same = |o: &&Observed| o.agent == begun.agent && o.operation == begun.operation;
            let started = begun.start < time;
            if let Some(seen) = observed.iter().find(same).filter(|_| started) {
                let served = begun.service.map_or(f64::INFINITY, |(_, times)| times.serving);
                let latest = if served <= time { served } else { f64::INFINITY };
                begun.end = seen.end.max(begun.start).min(latest);
            }
            let left = begun.service.filter(|(_, times)| times.going < time);
            let passed = left.map_or(0, |(_, times)| times.instants().iter().filter(|at| **at <= time).count());
            Progress { begun, started, passed, earliest: Earliest::NONE }
        })
        .collect();
    repair(before, previous, problem, time, &progress)
}

/// As [`reschedule`], with the actual progress: `progress` describes every operation that has begun or for whose
/// service the robot has left.
pub fn repair(
    before: &Problem,
    previous: &[Assistance],
    problem: &Problem,
    time: f64,
    progress: &[Progress],
) -> (Problem, Vec<Assistance>) {
    let ready = |robot| problem.ready(robot).unwrap_or(f64::NEG_INFINITY);
    let mut repair = Repair {
        before,
        problem,
        time,
        progress,
        home: (0..problem.robots.len()).map(ready).collect(),
        served: vec![None; problem.agents.len()],
        schedule: Vec::with_capacity(previous.len()),
    };
    let mut waiting: Vec<&Assistance> = previous.iter().collect();
    waiting.sort_by(|a, b| {
        a.times
            .going
            .total_cmp(&b.times.going)
            .then(a.times.serving.total_cmp(&b.times.serving))
            .then(a.target().cmp(&b.target()))
    });
    // In the order of departure, but never before an earlier operation of the same agent.
    while !waiting.is_empty() {
        let first = |at: &Assistance| {
            waiting.iter().all(|other| other.agent != at.agent || other.operation >= at.operation)
                && waiting.iter().take_while(|other| other.target() != at.target()).all(|other| other.robot != at.robot)
        };
        let place = waiting.iter().position(|at| first(at)).unwrap_or(0);
        let next = waiting.remove(place);
        repair.repair(next);
    }
    let Repair { mut schedule, .. } = repair;
    schedule.sort_by_key(Assistance::target);
    let mut after = problem.clone();
    after.start = time;
    after.begun = progress.iter().map(|progress| as_scheduled(progress.begun, &schedule)).collect();
    (after, schedule)
}

/// Returns an operation that has begun with its times in the repaired schedule.
fn as_scheduled(begun: Begun, schedule: &[Assistance]) -> Begun {
    let same = |at: &&Assistance| at.agent == begun.agent && at.operation == begun.operation;
    let Some(at) = schedule.iter().find(same) else { return begun };
    Begun { start: at.start, end: at.end, service: begun.service.map(|(robot, _)| (robot, at.times)), ..begun }
}

struct Repair<'a> {
    before: &'a Problem,
    problem: &'a Problem,
    time: f64,
    progress: &'a [Progress],
    /// Return of each robot to its depot (s).
    home: Vec<f64>,
    /// End of the last service of each agent (s).
    served: Vec<Option<f64>>,
    schedule: Vec<Assistance>,
}

impl Repair<'_> {
    fn repair(&mut self, planned: &Assistance) {
        let Assistance { agent, operation, robot, times: was, .. } = *planned;
        if agent >= self.served.len() || robot >= self.home.len() {
            return;
        }
        let same = |p: &&Progress| p.begun.agent == agent && p.begun.operation == operation;
        let progress = self.progress.iter().find(same).copied();
        let (start, end) = self.operation(planned, progress);
        let passed = progress.map_or(0, |progress| progress.passed);
        let earliest = progress.map_or(Earliest::NONE, |progress| progress.earliest);
        // Past instants are kept exactly; all others are not before the current time.
        let instant = |place: usize, was: f64, is: f64| if place < passed { was } else { is.max(self.time) };
        let lengths = self.problem.lengths(agent, robot);
        let machine = &self.problem.robots[robot];
        let (near, _) = self.problem.approach(&self.problem.agents[agent], robot);

        let going = instant(0, was.going, was.going.max(self.home[robot]));
        let (fast, slow) = ends(lengths.going, machine.speed);
        // Arrive at the planned time if possible, else as early as possible.
        let arrival = was.waiting.clamp(going + fast, going + slow).max(earliest.waiting);
        let waiting = instant(1, was.waiting, arrival);
        let planned_time = (was.serving - was.proximity).max(0.0);
        let approach = self.approach(lengths.proximity, near, planned, planned_time);
        let late = was.serving < end;
        let ready = if late { end } else { (was.serving - approach).max(end - approach) };
        let proximity = instant(2, was.proximity, waiting.max(ready).max(earliest.proximity));
        let arrival = if passed > 2 { was.serving } else { proximity + approach };
        let serving = instant(3, was.serving, arrival.max(end).max(earliest.serving));
        let serve = if passed > 3 { was.depositing - was.serving } else { machine.serve };
        let depositing = instant(4, was.depositing, serving + serve);
        let (fast, slow) = ends(lengths.depositing, machine.speed);
        let way = was.end.clamp(depositing + fast + machine.deposit, depositing + slow + machine.deposit);
        let home = if passed > 4 { was.end } else { way };
        let home = instant(5, was.end, home.max(earliest.end));
        let times = ServiceTimes { going, waiting, proximity, serving, depositing, end: home };
        self.home[robot] = self.home[robot].max(home);
        self.served[agent] = Some(depositing);
        self.schedule.push(Assistance { agent, operation, start, end, robot, times });
    }

    /// Returns the repaired start and end of an operation.
    fn operation(&self, planned: &Assistance, progress: Option<Progress>) -> (f64, f64) {
        let served = self.served[planned.agent];
        let nominal = duration_quantile::nominal(self.problem, planned.agent);
        match progress {
            Some(Progress { begun, started: true, .. }) => (begun.start, begun.end),
            // The robot has left, but the operation has not begun: it keeps its planned duration.
            Some(Progress { begun, .. }) => {
                let start = begun.start.max(served.unwrap_or(f64::NEG_INFINITY)).max(self.time);
                (start, start + nominal)
            }
            None => {
                let start = match served {
                    Some(served) => planned.start.max(served),
                    None => self.time,
                };
                (start.max(self.time), start.max(self.time) + nominal)
            }
        }
    }

    /// Computes the duration of the approach (s): at the planned speed, within the present limits of the agent.
    fn approach(&self, length: f64, near: Range, planned: &Assistance, time: f64) -> f64 {
        if length == 0.0 {
            return 0.0;
        }
        let before = self.before.lengths(planned.agent, planned.robot).proximity;
        let speed = if time > 0.0 && before > 0.0 { before / time } else { near.high };
        length / speed.clamp(near.low, near.high)
    }
}

/// Returns the shortest and longest duration of a leg (s).
fn ends(length: f64, speeds: Range) -> (f64, f64) {
    (length / speeds.high, length / speeds.low)
}
