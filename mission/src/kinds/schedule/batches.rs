//! Planning in batches, thesis Algorithm 4: for missions that are too large to be planned at once.
//!
//! The first batch of operations is planned; at the end of the next service everything that has begun is fixed, as many
//! operations are added as have been finished, and everything that has not begun is planned again. The thesis adds
//! operations by distance; here they are added in the order in which a quickly built schedule of the whole mission
//! serves them. The result is improved by moving single services, and never costs more than that first schedule. All
//! costs use the scales of the whole mission. A [`relaxation`](super::relaxation) of the whole mission bounds the cost
//! from below.

use crate::engine::Watch;
use crate::plan::{Limit, Statistics};

use super::assistance::Assistance;
use super::bounds::Bounds;
use super::choose::{Parts, Refusal, Solver};
use super::construct::{construct, refine};
use super::duration_quantile;
use super::exact::status;
use super::instance::{Instance, Sequence};
use super::problem::{Begun, Problem, Scales};
use super::relaxation::relaxation;
use super::retime::retime;

/// Share of the time budget for the first schedule.
const FIRST: f64 = 0.5;

/// Plans a problem without mistakes in batches of `size` operations.
///
/// # Errors
///
/// The planner of a batch refused.
pub(crate) fn batches(problem: &Problem, size: usize, solver: &Solver) -> Result<Parts, Refusal> {
    let budget = solver.budget();
    let watch = Watch::new(&budget);
    let size = size.max(1);
    let instance = Instance::new(problem);
    let first = construct(&instance, &watch.share(FIRST))?;
    let status = |cost: f64, stopped: Option<Limit>| {
        let bound = relaxation(&instance, &Bounds::new(&instance, cost), cost, &watch);
        status(cost, bound, budget.gap, stopped.or(Some(Limit::Work)))
    };
    let mut coming = order(&instance, &first.schedule);
    coming.reverse();
    let mut batch = Batch::new(problem);
    let (mut statistics, mut stopped): (Statistics, Option<Limit>) = (Statistics::default(), None);
    let mut room = size;
    loop {
        if watch.is_over() {
            return Ok((status(first.cost, Some(Limit::Time)), first.schedule, statistics));
        }
        for _ in 0..room {
            let Some(agent) = coming.pop() else { break };
            batch.add(problem, agent);
        }
        if room > 0 {
            let (found, _) = solver.solve(&batch.part, &watch.left())?;
            statistics = statistics.plus(found.statistics);
            stopped = stopped.or(found.status.stopped().filter(|limit| *limit != Limit::Accuracy));
            batch.schedule = found.timed.schedule;
        }
        if coming.is_empty() {
            let whole = retime(&instance, &sequence(&instance, &batch.schedule), &watch)?;
            let refined = whole.map(|whole| refine(&instance, whole, &watch)).transpose()?;
            let best = refined.filter(|refined| refined.cost < first.cost).unwrap_or(first);
            let stopped = if watch.is_over() { Some(Limit::Time) } else { stopped };
            return Ok((status(best.cost, stopped), best.schedule, statistics));
        }
        let ends = batch.schedule.iter().map(|assistance| assistance.times.depositing);
        let now = batch.part.start;
        let Some(next) = ends.filter(|end| *end > now).min_by(f64::total_cmp) else {
            room = size;
            continue;
        };
        room = size.saturating_sub(batch.advance(next));
    }
}

/// Returns the agent of each operation whose service has not begun, in the order in which this schedule serves them.
fn order(instance: &Instance, schedule: &[Assistance]) -> Vec<usize> {
    let free = |at: &&Assistance| instance.job_of(at.agent, at.operation).is_some();
    let mut services: Vec<&Assistance> = schedule.iter().filter(free).collect();
    services.sort_by(|a, b| a.times.serving.total_cmp(&b.times.serving).then(a.target().cmp(&b.target())));
    services.into_iter().map(|at| at.agent).collect()
}

/// Returns the sequence of a schedule.
fn sequence(instance: &Instance, schedule: &[Assistance]) -> Sequence {
    let mut sequence: Sequence = vec![Vec::new(); instance.free.len()];
    let mut services: Vec<&Assistance> = schedule.iter().collect();
    services.sort_by(|a, b| a.times.serving.total_cmp(&b.times.serving).then(a.target().cmp(&b.target())));
    for at in services {
        if let (Some(job), Some(robot)) = (instance.job_of(at.agent, at.operation), instance.place_of(at.robot)) {
            sequence[robot].push(job);
        }
    }
    sequence
}

/// The planned part of a mission.
struct Batch {
    part: Problem,
    schedule: Vec<Assistance>,
}

impl Batch {
    /// Creates a part that holds only the operations whose service has begun or ended.
    fn new(problem: &Problem) -> Batch {
        let mut part = problem.clone();
        part.scales = Some(Scales::of(problem));
        for (agent, who) in part.agents.iter_mut().enumerate() {
            let served = |begun: &&Begun| begun.agent == agent && begun.service.is_some();
            who.operations = problem.begun.iter().filter(served).count();
            who.wait_weights.truncate(who.operations);
            who.limit_weights.truncate(who.operations);
            who.approach_weights.truncate(who.operations);
        }
        part.begun.retain(|begun| begun.service.is_some());
        Batch { part, schedule: Vec::new() }
    }

    /// Adds the next operation of an agent. The agent has been working on it since it could begin, not since it was
    /// added.
    fn add(&mut self, problem: &Problem, agent: usize) {
        let who = &mut self.part.agents[agent];
        let operation = who.operations;
        who.operations += 1;
        let whole = &problem.agents[agent];
        who.wait_weights.extend(whole.wait_weights.get(operation));
        who.limit_weights.extend(whole.limit_weights.get(operation));
        who.approach_weights.extend(whole.approach_weights.get(operation));
        let same = |begun: &&Begun| begun.agent == agent && begun.operation == operation;
        if let Some(begun) = problem.begun.iter().find(same) {
            self.part.begun.push(*begun);
            return;
        }
        let before = |assistance: &&Assistance| assistance.agent == agent && assistance.operation + 1 == operation;
        let ready = match self.schedule.iter().find(before) {
            Some(previous) => previous.times.depositing.max(problem.start),
            None if operation == 0 => problem.start,
            None => return,
        };
        let settled = operation == 0 || self.settled(agent, operation - 1);
        if ready < self.part.start && settled {
            let end = ready + duration_quantile::nominal(problem, agent);
            self.part.begun.push(Begun { agent, operation, start: ready, end, service: None });
        }
    }

    fn settled(&self, agent: usize, operation: usize) -> bool {
        let same = |begun: &Begun| begun.agent == agent && begun.operation == operation && begun.service.is_some();
        self.part.begun.iter().any(same)
    }

    /// Advances the time and fixes everything that has begun by then. Returns the number of operations that are not
    /// served.
    fn advance(&mut self, time: f64) -> usize {
        self.part.start = time;
        self.part.begun = begun_at(&self.schedule, time);
        self.schedule.iter().filter(|assistance| assistance.times.depositing > time).count()
    }
}

/// Returns the operations of a schedule that have begun before `time` (s), and the services whose robot has left its
/// depot. If a robot has left for an operation, the earlier operations of the same agent are fixed too.
pub fn begun_at(schedule: &[Assistance], time: f64) -> Vec<Begun> {
    let left = |of: &Assistance| {
        let later = |other: &&Assistance| other.agent == of.agent && other.operation >= of.operation;
        schedule.iter().filter(later).any(|other| other.times.going < time)
    };
    let begun = |assistance: &Assistance| {
        let Assistance { agent, operation, start, end, robot, times } = *assistance;
        let service = left(assistance).then_some((robot, times));
        (start < time || service.is_some()).then_some(Begun { agent, operation, start, end, service })
    };
    schedule.iter().filter_map(begun).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot unwrap fails")]
mod tests {
    use super::super::choose::{Formulation, Options, plan};
    use super::super::problem::{AgentKind, Duration, Robot, WorkingAgent};
    use super::*;
    use crate::engine::looks::ended_after;
    use crate::numbers::{Energy, Range};

    fn large(agents: usize, robots: usize, operations: usize, speed: Range) -> Problem {
        let robot = |m: usize| Robot {
            name: format!("m{m}"),
            depot: [-4.0 * m as f64, 7.0],
            speed,
            proximity: Some(speed),
            serve: 10.0,
            deposit: 20.0,
            factor: 1.0,
            energy: Energy::of_factor(1.0),
        };
        let agent = |a: usize| {
            let kind = if a.is_multiple_of(3) { AgentKind::Worker } else { AgentKind::Human };
            let place = [2.0 * (a % 7) as f64, -3.0 * (a / 7) as f64];
            let duration = Duration { mean: 150.0 + 37.0 * (a % 5) as f64, sigma: 10.0 };
            WorkingAgent::new(format!("a{a}"), kind, place, operations, duration)
        };
        Problem::new((0..robots).map(robot).collect(), (0..agents).map(agent).collect())
    }

    /// All planners stop soon after their time limit, at whichever check of the clock it is reached.
    #[test]
    fn whoever_plans_ends_when_the_time_does() {
        let ranged = Range::new(0.05, 0.2);
        let shapes = [
            (large(12, 3, 3, ranged), Formulation::Batches),
            (large(12, 3, 3, Range::point(0.1)), Formulation::Batches),
            (large(9, 2, 1, ranged), Formulation::Subsets),
            (large(4, 2, 2, ranged), Formulation::Orders),
            (large(4, 2, 2, Range::point(0.1)), Formulation::Constraint),
            (large(3, 2, 2, ranged), Formulation::Position),
        ];
        for (problem, formulation) in shapes {
            let options = Options { formulation: Some(formulation), ..Options::default() };
            let jobs = problem.operations() as u64;
            for looks in [0, 1, 2, 5, 17, 60, 200, 900, 4000] {
                let (looked, plan) = ended_after(looks, || plan(&problem, &options).unwrap());
                assert!(looked <= looks + 4 * jobs + 20, "{formulation:?}: {looked} looks, over at {looks}");
                let by_time = plan.status.stopped() == Some(Limit::Time);
                assert!(
                    by_time || looked <= looks || plan.status.stopped().is_none(),
                    "{formulation:?} {:?}",
                    plan.status
                );
            }
        }
    }
}
