//! A problem in the form that planners use: jobs (operations whose service has not begun), their legs, and the cost as
//! a linear function of the starts of services.
//!
//! All times of an agent follow from the starts `s` of its services. An operation begins as early as possible or, if
//! the wait after it has a larger weight than the wait before it, so late that it ends when its service starts: the
//! cost is linear in that instant, so that one of the two is optimal. So `C = constant + sum c_j s_j + sum d_j delta^s
//! of j's robot + energy + kappa Delta`, plus the cost of waits beyond their limits, which the bounds of all planners
//! leave out.

use super::assistance::{Assistance, begun_of};
use super::cost::scaled;
use super::duration_quantile;
use super::problem::{Begun, Problem, Robot, Scales, ServiceTimes};
use crate::numbers::Range;

/// One of the three legs of a service by one robot, with its cost: `rate D + bend / D + constant` for duration `D`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Way {
    /// Length (m).
    pub length: f64,
    /// Cost of a joule; 0 for a leg of length zero.
    pub weight: f64,
    /// Shortest duration (s).
    pub low: f64,
    /// Longest duration (s).
    pub high: f64,
    /// Cost per second.
    pub rate: f64,
    /// Coefficient of the speed-dependent cost (cost times s).
    pub bend: f64,
    /// Cost that is independent of the duration.
    pub constant: f64,
}

impl Way {
    /// Computes the cost of this leg at this duration.
    pub fn cost(&self, time: f64) -> f64 {
        let bend = if self.bend > 0.0 { self.bend / time } else { 0.0 };
        self.rate * time + bend + self.constant
    }

    /// Returns the duration of minimum cost.
    pub fn cheapest(&self) -> f64 {
        let free = if self.rate > 0.0 { (self.bend / self.rate).sqrt() } else { f64::INFINITY };
        if self.bend == 0.0 { self.low } else { free.clamp(self.low, self.high) }
    }

    /// Returns the shortest useful duration if a second of delay costs at most `price` in total: a shorter one costs
    /// more than it saves.
    pub fn shortest_at(&self, price: f64) -> f64 {
        if self.bend > 0.0 { (self.bend / (self.rate + price)).sqrt().clamp(self.low, self.high) } else { self.low }
    }

    /// Returns true if only one duration is possible.
    pub fn is_fixed(&self) -> bool {
        self.high <= self.low
    }
}

/// Begin of an operation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Begin {
    /// It has begun, or begins with the plan, and ends at a known time.
    Fixed { start: f64, end: f64 },
    /// It begins at the end of the service of the previous job.
    Early { after: usize },
    /// It begins so late that it ends when its service starts.
    Late,
}

/// An operation whose service has not begun.
#[derive(Clone, Debug)]
pub(crate) struct Job {
    pub agent: usize,
    pub operation: usize,
    /// Planned duration of the operation (s).
    pub nominal: f64,
    /// The previous job of the agent, if its service has not begun either.
    pub previous: Option<usize>,
    /// Earliest start of the service (s) without a previous job.
    pub release: f64,
    pub begin: Begin,
    /// Legs of going, proximity and depositing, by robot.
    pub ways: Vec<[Way; 3]>,
    /// `c_j`: cost per second of the start of its service.
    pub start_cost: f64,
    /// `d_j`: cost per second of serving.
    pub serve_cost: f64,
}

/// Assignment and order of jobs: the jobs of each robot in order.
pub(crate) type Sequence = Vec<Vec<usize>>;

/// A problem prepared for planning.
#[derive(Clone)]
pub(crate) struct Instance<'a> {
    pub problem: &'a Problem,
    /// Index in the problem of each robot that takes services. Here and in all planners, robots are numbered by this
    /// list.
    pub robots: Vec<usize>,
    pub jobs: Vec<Job>,
    /// Instant from which each robot is free (s), not before the plan is made.
    pub free: Vec<f64>,
    /// Cost per second of the makespan.
    pub makespan_cost: f64,
    /// End of the last service that has begun (s).
    pub busy: f64,
    /// Cost that is independent of all decisions.
    pub constant: f64,
    /// Waits with a higher cost beyond a limit.
    pub limits: Vec<Limited>,
    /// Services that have begun.
    pub done: Vec<Assistance>,
}

/// A wait with a higher cost beyond a limit.
#[derive(Clone, Debug)]
pub(crate) struct Limited {
    /// Jobs on whose starts and on whose serving times the wait depends, with their coefficients.
    pub starts: Vec<(usize, f64)>,
    pub serves: Vec<(usize, f64)>,
    /// Constant part of the wait, minus its limit (s).
    pub constant: f64,
    /// Cost per second beyond the limit.
    pub rate: f64,
}

/// A linear function of the starts of services.
#[derive(Default)]
struct Linear {
    starts: Vec<(usize, f64)>,
    serves: Vec<(usize, f64)>,
    constant: f64,
}

impl<'a> Instance<'a> {
    /// Prepares a problem in which [`Problem::check`] finds no mistake.
    pub fn new(problem: &'a Problem) -> Instance<'a> {
        let scales = Scales::of(problem);
        let (robots, free) = (0..problem.robots.len()).filter_map(|robot| Some((robot, problem.ready(robot)?))).unzip();
        let mut instance = Instance {
            problem,
            robots,
            jobs: Vec::new(),
            free,
            makespan_cost: scaled(problem.weights.makespan, scales.makespan),
            busy: f64::NEG_INFINITY,
            constant: 0.0,
            limits: Vec::new(),
            done: Vec::new(),
        };
        for begun in &problem.begun {
            if let Some((robot, times)) = begun.service {
                if let Some(place) = instance.place_of(robot) {
                    instance.free[place] = instance.free[place].max(times.end);
                }
                instance.busy = instance.busy.max(times.end);
                instance.done.push(done(begun, robot, times));
            }
        }
        instance.done.sort_by_key(Assistance::target);
        for agent in 0..problem.agents.len() {
            instance.add_jobs(agent, &scales);
        }
        for agent in 0..problem.agents.len() {
            instance.add_waits(agent, &scales);
        }
        let waits = instance.constant;
        let energy = super::cost::cost_where(problem, &instance.done, |_| true);
        instance.constant = waits + energy.going + energy.proximity + energy.depositing;
        instance
    }

    /// Returns the cost per second of waiting after this operation.
    fn wait_cost(&self, agent: usize, operation: usize, scales: &Scales) -> f64 {
        scaled(self.problem.wait_weight(agent, operation), scales.wait)
    }

    fn add_jobs(&mut self, agent: usize, scales: &Scales) {
        let problem = self.problem;
        let nominal = duration_quantile::nominal(problem, agent);
        let (mut previous, mut ready) = (None, problem.start);
        for operation in 0..problem.agents[agent].operations {
            let begun = begun_of(problem, agent, operation);
            if let Some((_, times)) = begun.and_then(|begun| begun.service) {
                ready = times.depositing;
                continue;
            }
            let eager = operation == 0
                || self.wait_cost(agent, operation - 1, scales) >= self.wait_cost(agent, operation, scales);
            let begin = match begun {
                Some(begun) => Begin::Fixed { start: begun.start, end: begun.end },
                None if operation == 0 => Begin::Fixed { start: problem.start, end: problem.start + nominal },
                None => match (eager, previous) {
                    (true, Some(after)) => Begin::Early { after },
                    (true, None) => {
                        let start = ready.max(problem.start);
                        Begin::Fixed { start, end: start + nominal }
                    }
                    (false, _) => Begin::Late,
                },
            };
            let release = match begin {
                Begin::Fixed { end, .. } => end.max(problem.start),
                Begin::Early { .. } | Begin::Late => ready.max(problem.start) + nominal,
            };
            let ways = self.robots.iter().map(|robot| ways(problem, scales, agent, operation, *robot)).collect();
            self.jobs.push(Job {
                agent,
                operation,
                nominal,
                previous,
                release,
                begin,
                ways,
                start_cost: 0.0,
                serve_cost: 0.0,
            });
            previous = Some(self.jobs.len() - 1);
        }
    }

    /// Adds the cost of an agent's waits to the coefficients of its jobs.
    fn add_waits(&mut self, agent: usize, scales: &Scales) {
        for operation in 0..self.problem.agents[agent].operations {
            let weight = self.wait_cost(agent, operation, scales);
            let from = self.end_of(agent, operation);
            let to = if operation + 1 < self.problem.agents[agent].operations {
                self.start_of(agent, operation + 1)
            } else {
                self.service_of(agent, operation)
            };
            self.limit(agent, operation, (&to, &from), scales);
            for (line, sign) in [(to, weight), (from, -weight)] {
                line.starts.into_iter().for_each(|(job, c)| self.jobs[job].start_cost += sign * c);
                line.serves.into_iter().for_each(|(job, c)| self.jobs[job].serve_cost += sign * c);
                self.constant += sign * line.constant;
            }
        }
    }

    /// Stores the cost of a wait beyond its limit.
    fn limit(&mut self, agent: usize, operation: usize, (to, from): (&Linear, &Linear), scales: &Scales) {
        let rate = scaled(self.problem.limit_weight(agent, operation), scales.wait);
        if rate <= 0.0 {
            return;
        }
        let constant = to.constant - from.constant - self.problem.agents[agent].wait_limit;
        let both = |of: fn(&Linear) -> &Vec<(usize, f64)>| -> Vec<(usize, f64)> {
            let back = of(from).iter().map(|(job, c)| (*job, -c));
            of(to).iter().copied().chain(back).collect()
        };
        let (starts, serves) = (both(|line| &line.starts), both(|line| &line.serves));
        if starts.is_empty() && serves.is_empty() {
            self.constant += rate * constant.max(0.0);
        } else {
            self.limits.push(Limited { starts, serves, constant, rate });
        }
    }

    /// Computes the cost of waits beyond their limits for these starts and robots of services.
    pub fn excess(&self, starts: &[f64], robot: &[usize]) -> f64 {
        let of = |limited: &Limited| {
            let moved: f64 = limited.starts.iter().map(|(job, c)| c * starts[*job]).sum();
            let served: f64 = limited.serves.iter().map(|(job, c)| c * self.serve(robot[*job])).sum();
            limited.rate * (moved + served + limited.constant).max(0.0)
        };
        self.limits.iter().map(of).sum()
    }

    /// Returns the index of a robot of the problem among the robots that take services.
    pub fn place_of(&self, robot: usize) -> Option<usize> {
        self.robots.binary_search(&robot).ok()
    }

    /// Returns the robot at this index.
    pub fn machine(&self, robot: usize) -> &'a Robot {
        &self.problem.robots[self.robots[robot]]
    }

    /// Returns the job of an operation, unless its service has begun.
    pub fn job_of(&self, agent: usize, operation: usize) -> Option<usize> {
        self.jobs.iter().position(|job| job.agent == agent && job.operation == operation)
    }

    fn done_of(&self, agent: usize, operation: usize) -> Option<&Assistance> {
        self.done.iter().find(|done| done.agent == agent && done.operation == operation)
    }

    /// Returns the start of an operation's service, as a function of the jobs' starts.
    fn service_of(&self, agent: usize, operation: usize) -> Linear {
        match self.job_of(agent, operation) {
            Some(job) => Linear { starts: vec![(job, 1.0)], ..Linear::default() },
            None => {
                let constant = self.done_of(agent, operation).map_or(0.0, |done| done.times.serving);
                Linear { constant, ..Linear::default() }
            }
        }
    }

    fn start_of(&self, agent: usize, operation: usize) -> Linear {
        let Some(index) = self.job_of(agent, operation) else {
            let constant = self.done_of(agent, operation).map_or(0.0, |done| done.start);
            return Linear { constant, ..Linear::default() };
        };
        let job = &self.jobs[index];
        match job.begin {
            Begin::Fixed { start, .. } => Linear { constant: start, ..Linear::default() },
            Begin::Early { after } => Linear { starts: vec![(after, 1.0)], serves: vec![(after, 1.0)], constant: 0.0 },
            Begin::Late => Linear { starts: vec![(index, 1.0)], constant: -job.nominal, ..Linear::default() },
        }
    }

    fn end_of(&self, agent: usize, operation: usize) -> Linear {
        let Some(index) = self.job_of(agent, operation) else {
            let constant = self.done_of(agent, operation).map_or(0.0, |done| done.end);
            return Linear { constant, ..Linear::default() };
        };
        match self.jobs[index].begin {
            Begin::Fixed { end, .. } => Linear { constant: end, ..Linear::default() },
            Begin::Early { .. } | Begin::Late => {
                let mut end = self.start_of(agent, operation);
                end.constant += self.jobs[index].nominal;
                end
            }
        }
    }

    /// Returns true if no service gains by starting late.
    pub fn is_regular(&self) -> bool {
        self.jobs.iter().all(|job| job.start_cost >= 0.0)
    }

    /// Returns true if every leg of every job has a fixed duration.
    pub fn is_fixed(&self) -> bool {
        self.jobs.iter().all(|job| job.ways.iter().flatten().all(Way::is_fixed))
    }

    /// Returns the serving time of a robot (s).
    pub fn serve(&self, robot: usize) -> f64 {
        self.machine(robot).serve
    }

    /// Returns the time of a robot at its depot after a service (s).
    pub fn deposit(&self, robot: usize) -> f64 {
        self.machine(robot).deposit
    }

    /// Computes the time from leaving the depot to the end of depositing without waiting, at the greatest speeds (s).
    pub fn shortest(&self, job: usize, robot: usize) -> f64 {
        let ways = &self.jobs[job].ways[robot];
        ways.iter().map(|way| way.low).sum::<f64>() + self.serve(robot) + self.deposit(robot)
    }

    /// Computes the time from leaving the depot to the end of depositing without waiting, at the least speeds (s).
    pub fn longest(&self, job: usize, robot: usize) -> f64 {
        let ways = &self.jobs[job].ways[robot];
        ways.iter().map(|way| way.high).sum::<f64>() + self.serve(robot) + self.deposit(robot)
    }
}

fn done(begun: &Begun, robot: usize, times: ServiceTimes) -> Assistance {
    let Begun { agent, operation, start, end, .. } = *begun;
    Assistance { agent, operation, start, end, robot, times }
}

/// Returns a leg at these speeds, with the cost of its energy.
fn way(machine: &Robot, speeds: Range, length: f64, weight: f64, scale: f64) -> Way {
    let weight = if length > 0.0 { scaled(weight, scale) } else { 0.0 };
    Way {
        length,
        weight,
        low: length / speeds.high,
        high: length / speeds.low,
        rate: weight * machine.energy.standby,
        bend: weight * machine.energy.drag * length * length,
        constant: weight * machine.energy.friction * length,
    }
}

/// Returns the leg of this length (m) from the depot of this robot.
pub(crate) fn going(problem: &Problem, scales: &Scales, robot: usize, length: f64) -> Way {
    let machine = &problem.robots[robot];
    way(machine, machine.speed, length, problem.weights.energy / 3.0, scales.energy[0])
}

fn ways(problem: &Problem, scales: &Scales, agent: usize, operation: usize, robot: usize) -> [Way; 3] {
    let machine = &problem.robots[robot];
    let lengths = problem.lengths(agent, robot);
    let (near, _) = problem.approach(&problem.agents[agent], robot);
    let third = problem.weights.energy / 3.0;
    let zeta = problem.approach_weight(agent, operation);
    [
        going(problem, scales, robot, lengths.going),
        way(machine, near, lengths.proximity, third * zeta, scales.energy[1]),
        way(machine, machine.speed, lengths.depositing, third, scales.energy[2]),
    ]
}
