//! Schedules in which every agent has one service to come: a dynamic program over sets of jobs.
//!
//! Then robots meet in nothing but the sharing of the jobs and the end. For each robot and each set of jobs, what the set
//! costs is a convex function of when the robot is home ([`Curve`]); the best orders are those whose function no other's
//! beats, and the best orders of a set arise from those of the set without its last job. Robots are put together set by
//! set. The functions lie below the true ones by what tangents miss, so the least of all bounds the cost of every schedule;
//! the sequence behind it is timed exactly, and tangents grow denser until both meet. Orders that cannot lead to less than
//! the best schedule so far are dropped on the way. `2^n n` steps for `n` jobs and two robots, `3^n` for more. No source:
//! ours, since neither the constraint program nor the position form proves ten jobs of uneven weights in reasonable time.

use crate::engine::{Budget, Halt, Watch};
use crate::plan::{Limit, Statistics};

use super::bounds::Bounds;
use super::construct::construct;
use super::curve::Curve;
use super::exact::{Found, status};
use super::instance::{Instance, Sequence};
use super::relaxation::relaxation;
use super::retime::{Timed, retime};

/// The most jobs of two robots.
const MOST_OF_TWO: usize = 14;
/// The most jobs of more.
const MOST_OF_MORE: usize = 11;
/// Tangents at first, how many times as many each time, and at most.
const FIRST_TANGENTS: usize = 4;
const MORE_TANGENTS: usize = 5;
const MOST_TANGENTS: usize = 512;
/// The most where waits beyond their limits are left out of the bound, which then meets no cost anyway.
const MOST_LIMITED: usize = 20;
/// Pieces of all functions that are kept at once at most (16 bytes each), and that are made in all.
const MOST_KEPT: usize = 6_000_000;
const MOST_MADE: usize = 400_000_000;

/// Orders between two looks at the time.
const LOOK: u64 = 256;

/// An order of a set of jobs that no other beats.
struct Entry {
    /// What it costs to be home with it by an instant.
    curve: Curve,
    /// The last job; or, of several robots together, the set of the last robot.
    last: usize,
    /// Entry of the set without it.
    before: usize,
    /// Entry of the last robot's set, of several robots together.
    own: usize,
}

/// Entries by set of jobs, a bit for each.
type Table = Vec<Vec<Entry>>;

/// Whether a problem is of this kind, and small enough.
pub(crate) fn fits(instance: &Instance) -> bool {
    let (count, robots) = (instance.jobs.len(), instance.free.len());
    let most = if robots <= 2 { MOST_OF_TWO } else { MOST_OF_MORE };
    let alone = instance.jobs.iter().all(|job| job.previous.is_none());
    count <= most && alone && instance.is_regular()
}

/// The best schedule, proven where the time suffices. The instance fits, [`fits`].
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
    /// Going and proximity, and depositing, of each job by each robot.
    ways: Vec<Vec<(Curve, Curve)>>,
    /// What the jobs outside of a set cost at least, by set.
    rest: Vec<f64>,
    /// No schedule that is looked for costs more.
    known: f64,
    /// None ends earlier (s).
    end: f64,
    /// Pieces kept and made.
    kept: usize,
    made: usize,
    /// Orders looked at.
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
            // What is as good as the best so far must be found again.
            known: known.cost + 1e-9 * known.cost.abs().max(1e-9),
            end: bounds.first_end,
            kept: 0,
            made,
            entries: 0,
        }
    }

    /// A lower bound on the cost of every schedule, and the sequence of which it is the cost but for what tangents miss.
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
            // All were dropped: nothing is better than what is known.
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

    /// The least cost of a schedule in which this set costs this.
    fn total(&self, curve: &Curve, set: usize) -> f64 {
        self.instance.constant + self.rest[set] + curve.least(self.instance.makespan_cost, self.end)
    }

    /// Adds an entry to those that nothing beats, unless it leads nowhere.
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

    /// The best orders of every set of jobs by one robot.
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

    /// Sets shared between the robots so far and one more; of the whole set alone if no other is wanted. The table of no
    /// robot has the empty set only.
    fn join(&mut self, before: &[Vec<Entry>], robot: &Table, full: usize, every: bool) -> Result<Table, Halt> {
        let mut table: Table = Vec::new();
        table.resize_with(full + 1, Vec::new);
        let first = if every { 0 } else { full };
        for (set, joined) in table.iter_mut().enumerate().skip(first) {
            // All subsets of `set`, from itself down to nothing.
            let mut own = set;
            loop {
                for (place, earlier) in before.get(set & !own).into_iter().flatten().enumerate() {
                    for (index, entry) in robot[own].iter().enumerate() {
                        // A robot that does nothing need not be home.
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

/// The order behind an entry of a robot.
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
