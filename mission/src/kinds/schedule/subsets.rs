//! Schedules with one remaining service for each agent: a dynamic program over sets of jobs.
//!
//! Robots are then coupled only by the assignment of jobs and by the makespan. For each robot and each set of jobs, the
//! cost of the set is a convex function of the robot's return time ([`Curve`]); the best orders are those whose
//! function is not dominated, and the best orders of a set arise from those of the set without its last job. Robots are
//! combined set by set. The functions lie below the exact ones by the error of the tangents, so that their minimum
//! bounds the cost of every schedule; its sequence is timed exactly, and tangents are refined until cost and bound
//! meet. Orders that cannot beat the best known schedule are dropped. `2^n n` steps for `n` jobs and two robots, `3^n`
//! for more. No source: our own method, since neither the constraint program nor the position form proves ten jobs of
//! uneven weights in reasonable time.

use crate::engine::{Budget, Halt, Watch};
use crate::plan::{Limit, Statistics};

use super::bounds::Bounds;
use super::construct::construct;
use super::cost_function::Curve;
use super::exact::{Found, status};
use super::instance::{Instance, Sequence};
use super::relaxation::relaxation;
use super::retime::{Timed, retime};

/// Maximum number of jobs with up to two robots.
const MOST_OF_TWO: usize = 14;
/// Maximum number of jobs with more robots.
const MOST_OF_MORE: usize = 11;
/// Initial number of tangents, growth factor, and maximum number.
const FIRST_TANGENTS: usize = 4;
const MORE_TANGENTS: usize = 5;
const MOST_TANGENTS: usize = 512;
/// Maximum number of tangents if waits have limits: the bound leaves out waits beyond their limits, and so never meets
/// the cost.
const MOST_LIMITED: usize = 20;
/// Maximum number of pieces of all functions that are stored at a time (16 bytes each), and that are created in total.
const MOST_KEPT: usize = 6_000_000;
const MOST_MADE: usize = 400_000_000;

/// Number of orders between two checks of the clock.
const LOOK: u64 = 256;

/// An order of a set of jobs that is not dominated.
struct Entry {
    /// Minimum cost as a function of the return time.
    curve: Curve,
    /// The last job; or, for several robots together, the set of the last robot.
    last: usize,
    /// Entry of the set without `last`.
    before: usize,
    /// Entry of the last robot's set, for several robots together.
    own: usize,
}

/// Entries by set of jobs (a bit for each job).
type Table = Vec<Vec<Entry>>;

/// Returns true if this method applies to the problem and the problem is small enough.
pub(crate) fn is_applicable(instance: &Instance) -> bool {
    let (count, robots) = (instance.jobs.len(), instance.free.len());
    let most = if robots <= 2 { MOST_OF_TWO } else { MOST_OF_MORE };
    let alone = instance.jobs.iter().all(|job| job.previous.is_none());
    count <= most && alone && instance.is_regular()
}

/// Finds the best schedule, proven if the time suffices. Requires [`is_applicable`].
///
/// # Errors
///
/// It takes too much work, or the cone solver failed.
pub(crate) fn best(instance: &Instance, budget: &Budget) -> Result<Found, Halt> {
    let (watch, gap) = (Watch::new(budget), budget.gap);
    let mut timed = construct(instance, &watch)?;
    let mut statistics = Statistics { solves: 1, ..Statistics::default() };
    let mut tangents = if instance.is_fixed() { MOST_TANGENTS } else { FIRST_TANGENTS };
    let most = if instance.limits.is_empty() { MOST_TANGENTS } else { MOST_LIMITED };
    let mut work = 0;
    let mut known = relaxation(instance, &Bounds::new(instance, timed.cost), timed.cost, &watch);
    if timed.cost - known <= gap * timed.cost.abs() {
        let status = status(timed.cost, known, gap, None);
        return Ok(Found { timed, status, statistics });
    }
    loop {
        let mut search = Search::new(instance, &timed, tangents, work, &watch);
        let (bound, sequence) = match search.best() {
            Ok(found) => found,
            Err(Halt::Time) => {
                let status = status(timed.cost, known, gap, Some(Limit::Time));
                return Ok(Found { timed, status, statistics });
            }
            Err(halt) => return Err(halt),
        };
        work = search.made;
        known = known.max(bound);
        statistics.nodes += search.entries;
        statistics.solves += 1;
        if let Some(found) = retime(instance, &sequence, &watch)?.filter(|found| found.cost < timed.cost) {
            timed = found;
        }
        let bound = known.min(timed.cost);
        let stopped = watch.is_over().then_some(Limit::Time);
        if stopped.is_some() || tangents >= most || timed.cost - bound <= gap * timed.cost.abs() {
            let status = status(timed.cost, bound, gap, stopped);
            return Ok(Found { timed, status, statistics });
        }
        tangents *= MORE_TANGENTS;
    }
}

struct Search<'a, 'b> {
    instance: &'a Instance<'b>,
    watch: &'a Watch,
    /// Curves of going and proximity together, and of depositing, of each job by each robot.
    ways: Vec<Vec<(Curve, Curve)>>,
    /// Lower bound on the cost of the jobs outside of a set, by set.
    rest: Vec<f64>,
    /// Upper bound on the cost of schedules that are searched for.
    known: f64,
    /// Lower bound on the end of every schedule (s).
    end: f64,
    /// Number of pieces stored and created.
    kept: usize,
    made: usize,
    /// Number of orders examined.
    entries: u64,
}

impl<'a, 'b> Search<'a, 'b> {
    fn new(
        instance: &'a Instance<'b>,
        known: &Timed,
        tangents: usize,
        made: usize,
        watch: &'a Watch,
    ) -> Search<'a, 'b> {
        let (count, robots) = (instance.jobs.len(), instance.free.len());
        let bounds = Bounds::new(instance, known.cost);
        let curves = |job: usize, robot: usize| {
            let [going, proximity, back] = instance.jobs[job].ways[robot].map(|way| Curve::of_way(&way, tangents));
            (going.then(&proximity), back)
        };
        let alone = |job: usize| {
            let of = |robot: usize| {
                let ways = &instance.jobs[job].ways[robot];
                let energy: f64 = ways.iter().map(|way| way.cost(way.cheapest())).sum();
                let start = instance.jobs[job].start_cost * bounds.earliest[job][robot];
                energy + start + instance.jobs[job].serve_cost * instance.serve(robot)
            };
            (0..robots).map(of).fold(f64::INFINITY, f64::min)
        };
        let alone: Vec<f64> = (0..count).map(alone).collect();
        let outside = |set: usize| (0..count).filter(|job| set >> job & 1 == 0).map(|job| alone[job]).sum();
        Search {
            instance,
            watch,
            ways: (0..count).map(|job| (0..robots).map(|robot| curves(job, robot)).collect()).collect(),
            rest: (0..1 << count).map(outside).collect(),
            // A schedule as good as the best known one must not be dropped.
            known: known.cost + 1e-9 * known.cost.abs().max(1e-9),
            end: bounds.first_end,
            kept: 0,
            made,
            entries: 0,
        }
    }

    /// Returns a lower bound on the cost of every schedule, with the sequence of that cost (up to the error of the
    /// tangents).
    fn best(&mut self) -> Result<(f64, Sequence), Halt> {
        let robots = self.instance.free.len();
        let full = (1_usize << self.instance.jobs.len()) - 1;
        let tables: Vec<Table> = (0..robots).map(|robot| self.orders(robot)).collect::<Result<_, Halt>>()?;
        let nothing = Entry { curve: Curve::step(self.instance.problem.start, 0.0), last: 0, before: 0, own: 0 };
        let mut together: Vec<Table> = vec![vec![vec![nothing]]];
        for (robot, table) in tables.iter().enumerate() {
            let joined = self.join(&together[robot], table, full, robot + 1 < robots)?;
            together.push(joined);
        }
        let last = &together[robots][full];
        let total = |entry: &Entry| self.total(&entry.curve, full);
        let (mut place, bound) = last
            .iter()
            .map(total)
            .enumerate()
            .min_by(|a, b| a.1.total_cmp(&b.1))
            // All orders were dropped: nothing is better than the known schedule.
            .unwrap_or((usize::MAX, self.known));
        let mut set = full;
        let mut sequence: Sequence = vec![Vec::new(); robots];
        for robot in (0..robots).rev() {
            let Some(entry) = together[robot + 1][set].get(place) else { break };
            sequence[robot] = path(&tables[robot], entry.last, entry.own);
            set &= !entry.last;
            place = entry.before;
        }
        Ok((bound, sequence))
    }

    /// Lower bound on the cost of a schedule in which this set has this cost.
    fn total(&self, curve: &Curve, set: usize) -> f64 {
        self.instance.constant + self.rest[set] + curve.least(self.instance.makespan_cost, self.end)
    }

    /// Adds an entry to the non-dominated ones, unless it cannot beat the best known schedule.
    fn keep(&mut self, entries: &mut Vec<Entry>, new: Entry, set: usize) -> Result<(), Halt> {
        self.entries += 1;
        if self.entries.is_multiple_of(LOOK) && self.watch.is_over() {
            return Err(Halt::Time);
        }
        self.made += 1 + new.curve.pieces();
        if self.total(&new.curve, set) > self.known {
            return Ok(());
        }
        if entries.iter().any(|old| old.curve.beats(&new.curve)) {
            return Ok(());
        }
        let before: usize = entries.iter().map(|entry| 1 + entry.curve.pieces()).sum();
        entries.retain(|old| !new.curve.beats(&old.curve));
        let after: usize = entries.iter().map(|entry| 1 + entry.curve.pieces()).sum();
        self.kept = self.kept + after + 1 + new.curve.pieces() - before;
        entries.push(new);
        if self.kept <= MOST_KEPT && self.made <= MOST_MADE { Ok(()) } else { Err(Halt::Size) }
    }

    /// Computes the best orders of every set of jobs by one robot.
    fn orders(&mut self, robot: usize) -> Result<Table, Halt> {
        let instance = self.instance;
        let mut table: Table = Vec::with_capacity(1 << instance.jobs.len());
        table.push(vec![Entry { curve: Curve::step(instance.free[robot], 0.0), last: 0, before: 0, own: 0 }]);
        let (serve, deposit) = (instance.serve(robot), instance.deposit(robot));
        for set in 1..1_usize << instance.jobs.len() {
            let mut entries = Vec::new();
            for (last, job) in instance.jobs.iter().enumerate().filter(|(last, _)| set >> last & 1 == 1) {
                for (before, entry) in table[set & !(1 << last)].iter().enumerate() {
                    let (there, back) = &self.ways[last][robot];
                    let started = entry.curve.then(there).started(job.release, job.start_cost);
                    let curve = started.then(back).moved(serve + deposit, job.serve_cost * serve);
                    self.keep(&mut entries, Entry { curve, last, before, own: 0 }, set)?;
                }
            }
            table.push(entries);
        }
        Ok(table)
    }

    /// Combines the robots so far with one more; only for the full set if `every` is false. The table of no robot has
    /// only the empty set.
    fn join(&mut self, before: &[Vec<Entry>], robot: &Table, full: usize, every: bool) -> Result<Table, Halt> {
        let mut table: Table = Vec::new();
        table.resize_with(full + 1, Vec::new);
        let first = if every { 0 } else { full };
        for (set, joined) in table.iter_mut().enumerate().skip(first) {
            // Enumerate all subsets of `set`, from itself down to the empty set.
            let mut own = set;
            loop {
                for (place, earlier) in before.get(set & !own).into_iter().flatten().enumerate() {
                    for (index, entry) in robot[own].iter().enumerate() {
                        // A robot without jobs does not have to return.
                        let curve = match (own, set & !own) {
                            (0, _) => earlier.curve.clone(),
                            (_, 0) => entry.curve.clone(),
                            _ => earlier.curve.with(&entry.curve),
                        };
                        self.keep(joined, Entry { curve, last: own, before: place, own: index }, set)?;
                    }
                }
                if own == 0 {
                    break;
                }
                own = (own - 1) & set;
            }
        }
        Ok(table)
    }
}

/// Returns the order of an entry of a robot.
fn path(table: &Table, mut set: usize, mut place: usize) -> Vec<usize> {
    let mut jobs = Vec::new();
    while let Some(entry) = table[set].get(place).filter(|_| set != 0) {
        jobs.push(entry.last);
        set &= !(1 << entry.last);
        place = entry.before;
    }
    jobs.reverse();
    jobs
}
