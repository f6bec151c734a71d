//! The schedule as a constraint program, thesis 5.6.1, for fixed durations: one optional block per job and robot, from
//! going to the end of depositing; blocks of one robot do not overlap. Waiting is not part of the block: a robot that
//! would wait near the agent may as well leave later, and the times of the result are recomputed from its order.
//!
//! Times are integer ticks, those of a job relative to its earliest start. Durations and coefficients are rounded down,
//! so that the optimum of the program is a lower bound on the cost; the schedule computed from its order has the exact
//! cost.

use crate::engine::cp::{Choice, Number, Optional, Outcome, Program, Term};
use crate::engine::{Budget, EngineError, Watch};
use crate::plan::{Limit, Statistics};

use super::bounds::Bounds;
use super::construct::construct;
use super::exact::{Found, status};
use super::instance::{Instance, Sequence};
use super::relaxation::relaxation;
use super::retime::{Timed, retime};

/// Candidate ticks (s), the longest first. A tick that divides all durations keeps them exact.
const TICKS: [f64; 7] = [1.0, 0.5, 0.25, 0.1, 0.05, 0.02, 0.01];

/// Number of ticks in the horizon if none of the candidates divides all durations.
const FINE: f64 = 20_000.0;

/// Target of the scaling for the largest sum of the program.
const REACH: f64 = 5e8;

/// Plans by a constraint program. All legs of the instance have fixed durations.
///
/// # Errors
///
/// The numbers do not fit the engine, or the cone solver failed.
pub(crate) fn constraint(instance: &Instance, budget: &Budget) -> Result<Found, EngineError> {
    let watch = Watch::new(budget);
    let known = construct(instance, &watch)?;
    let bounds = Bounds::new(instance, known.cost);
    let mut statistics = Statistics { solves: 1, ..Statistics::default() };
    if known.cost - bounds.cost <= budget.gap * known.cost.abs() {
        let status = status(known.cost, bounds.cost, budget.gap, None);
        return Ok(Found { timed: known, status, statistics });
    }
    if watch.is_over() {
        let status = status(known.cost, bounds.cost, budget.gap, Some(Limit::Time));
        return Ok(Found { timed: known, status, statistics });
    }
    let model = Model::new(instance, &bounds, &known)?;
    let (program, objective) = (model.program, model.objective);
    let (outcome, steps) = program.minimise(objective, (&model.asked, &model.chosen), &watch.left());
    statistics.solves += 1;
    statistics.nodes += steps;
    let mut bound = relaxation(instance, &bounds, known.cost, &watch);
    let (mut timed, mut stopped) = (known, None);
    match outcome {
        Outcome::Found(values, ended) => {
            let robots = instance.free.len();
            let mut sequence: Sequence = vec![Vec::new(); robots];
            for (at, chosen) in values.choices.iter().enumerate() {
                if *chosen {
                    sequence[at % robots].push(at / robots);
                }
            }
            for jobs in &mut sequence {
                jobs.sort_by_key(|job| (values.numbers[1 + *job] + model.first[*job], *job));
            }
            if let Some(next) = retime(instance, &sequence, &watch)?.filter(|next| next.cost < timed.cost) {
                timed = next;
            }
            stopped = ended.or(watch.is_over().then_some(Limit::Time));
            if ended.is_none() {
                bound = bound.max(model.base + values.numbers[0] as f64 / model.resolution);
            }
        }
        // No schedule costs less than the known one.
        Outcome::Impossible => bound = timed.cost,
        Outcome::Nothing(ended) => stopped = Some(ended),
    }
    let status = status(timed.cost, bound, budget.gap, stopped);
    Ok(Found { timed, status, statistics })
}

struct Model {
    program: Program,
    objective: Number,
    /// Variables whose values are read: the objective, then the start of each job.
    asked: Vec<Number>,
    /// Earliest start of each job (ticks), to which its start is relative.
    first: Vec<i64>,
    /// Earliest end (ticks), to which the end is relative.
    end_first: i64,
    /// True if the robot serves the job, by job and robot.
    chosen: Vec<Choice>,
    /// `cost >= base + objective / resolution`
    base: f64,
    resolution: f64,
}

impl Model {
    fn new(instance: &Instance, bounds: &Bounds, known: &Timed) -> Result<Model, EngineError> {
        let (count, robots) = (instance.jobs.len(), instance.free.len());
        let zero = instance.problem.start;
        let latest = bounds.latest.iter().copied().fold(zero, f64::max);
        let blocks = (0..count).flat_map(|job| (0..robots).map(move |m| instance.longest(job, m)));
        let horizon = latest + blocks.fold(0.0, f64::max) - zero;
        let tick = tick(instance, horizon);
        let ticks = |seconds: f64| (seconds / tick + 1e-6).floor() as i64;
        let first =
            |job: usize| ticks(bounds.earliest[job].iter().copied().fold(f64::INFINITY, f64::min) - zero).max(0);
        let last = |job: usize| ticks(bounds.latest[job] - zero).max(first(job));
        let end_low = (0..count).map(first).max().unwrap_or(0).max(ticks(instance.busy.max(zero) - zero));
        let end_high = ticks(if bounds.end.is_finite() { bounds.end - zero } else { horizon }).max(end_low);
        let price = |job: usize, robot: usize| {
            let ways: f64 = instance.jobs[job].ways[robot].iter().map(|way| way.cost(way.low)).sum();
            ways + instance.jobs[job].serve_cost * instance.serve(robot)
        };
        let cheapest = |job: usize| (0..robots).map(|m| price(job, m)).fold(f64::INFINITY, f64::min);
        let dearest = |job: usize| (0..robots).map(|m| price(job, m)).fold(0.0, f64::max);
        // Upper bound of the program's objective before scaling.
        let mut reach = instance.makespan_cost * (end_high - end_low) as f64 * tick;
        let mut base = instance.constant + instance.makespan_cost * (zero + end_low as f64 * tick);
        for (job, data) in instance.jobs.iter().enumerate() {
            reach += data.start_cost.abs() * (last(job) - first(job)) as f64 * tick + dearest(job) - cheapest(job);
            base += data.start_cost * (zero + first(job) as f64 * tick) + cheapest(job);
            // The program rounds starts down: a job that gains by starting late may start up to one tick later.
            base += data.start_cost.min(0.0) * tick;
        }
        let resolution = REACH / reach.max(1e-12);
        let rate = |cost: f64| (cost * tick * resolution).floor() as i64;
        let mut program = Program::default();
        let most = ((known.cost - base) * resolution).ceil().max(0.0) as i64;
        let least = instance
            .jobs
            .iter()
            .enumerate()
            .map(|(job, data)| rate(data.start_cost.min(0.0)) * (last(job) - first(job)));
        let objective = program.number(least.sum(), most)?;
        let end = program.number(0, end_high - end_low)?;
        let mut asked = vec![objective];
        let mut chosen = Vec::new();
        let mut sum: Vec<(Term, i64)> = vec![(Term::Number(objective), -1)];
        sum.push((Term::Number(end), rate(instance.makespan_cost)));
        for job in 0..count {
            let start = program.number(0, last(job) - first(job))?;
            let choices: Vec<Choice> = (0..robots).map(|_| program.choice()).collect();
            program.exactly_one(&choices)?;
            sum.push((Term::Number(start), rate(instance.jobs[job].start_cost)));
            for (m, choice) in choices.iter().enumerate() {
                sum.push((Term::Choice(*choice), ((price(job, m) - cheapest(job)) * resolution).floor() as i64));
            }
            asked.push(start);
            chosen.extend(choices);
        }
        program.at_most(&sum, 0, None)?;
        let first = (0..count).map(first).collect();
        let mut model = Model { program, objective, asked, first, end_first: end_low, chosen, base, resolution };
        for job in 0..count {
            model.after(instance, bounds, job, &ticks)?;
        }
        for robot in 0..robots {
            model.robot(instance, robot, end, ticks(horizon) + 1, &ticks)?;
        }
        Ok(model)
    }

    /// A job's service starts after its robot can arrive and after its operation has ended.
    fn after(
        &mut self,
        instance: &Instance,
        bounds: &Bounds,
        job: usize,
        ticks: &impl Fn(f64) -> i64,
    ) -> Result<(), EngineError> {
        let robots = instance.free.len();
        let start = Term::Number(self.asked[1 + job]);
        for robot in 0..robots {
            let choice = self.chosen[job * robots + robot];
            let earliest = ticks(bounds.earliest[job][robot] - instance.problem.start).max(0);
            self.program.at_most(&[(start, -1)], self.first[job] - earliest, Some(choice))?;
        }
        let Some(previous) = instance.jobs[job].previous else { return Ok(()) };
        let served = Term::Number(self.asked[1 + previous]);
        for robot in 0..robots {
            let choice = self.chosen[previous * robots + robot];
            let wait = ticks(instance.serve(robot) + instance.jobs[job].nominal);
            let room = self.first[job] - self.first[previous] - wait;
            self.program.at_most(&[(served, 1), (start, -1)], room, Some(choice))?;
        }
        Ok(())
    }

    /// The blocks of a robot do not overlap and end before the makespan; so does the sum of their durations.
    fn robot(
        &mut self,
        instance: &Instance,
        robot: usize,
        end: Number,
        horizon: i64,
        ticks: &impl Fn(f64) -> i64,
    ) -> Result<(), EngineError> {
        let robots = instance.free.len();
        let mut blocks = Vec::new();
        let mut load: Vec<(Term, i64)> = vec![(Term::Number(end), -1)];
        for (job, data) in instance.jobs.iter().enumerate() {
            let ways = &data.ways[robot];
            let lead = ticks(ways[0].low + ways[1].low);
            let tail = ticks(instance.serve(robot) + ways[2].low + instance.deposit(robot));
            let (anchor, present) = (self.asked[1 + job], self.chosen[job * robots + robot]);
            blocks.push(Optional { present, anchor, offset: self.first[job] - lead, length: lead + tail });
            load.push((Term::Choice(present), lead + tail));
            let ends = [(Term::Number(anchor), 1), (Term::Number(end), -1)];
            self.program.at_most(&ends, self.end_first - self.first[job] - tail, Some(present))?;
        }
        let free = ticks(instance.free[robot] - instance.problem.start);
        self.program.at_most(&load, self.end_first - free, None)?;
        self.program.no_overlap(&blocks, horizon)
    }
}

/// Chooses the tick (s): one that divides all durations, or else a small part of the horizon.
fn tick(instance: &Instance, horizon: f64) -> f64 {
    let robots = 0..instance.free.len();
    let mut times: Vec<f64> = instance.free.iter().map(|free| free - instance.problem.start).collect();
    times.extend(robots.flat_map(|m| [instance.serve(m), instance.deposit(m)]));
    for job in &instance.jobs {
        times.extend([job.nominal, job.release - instance.problem.start]);
        times.extend(job.ways.iter().flatten().map(|way| way.low));
    }
    let whole = |tick: &f64| times.iter().all(|time| (time / tick - (time / tick).round()).abs() < 1e-7);
    let fine = horizon / FINE;
    TICKS.into_iter().filter(|tick| *tick >= fine / 10.0).find(whole).unwrap_or(fine.max(1e-6))
}
