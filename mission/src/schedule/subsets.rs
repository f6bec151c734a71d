//! Schedules of fixed durations in which every agent has one service to come: a dynamic program over sets of jobs.
//!
//! Then robots meet in nothing but the sharing of the jobs and the end. For each robot and each set of jobs, the best orders
//! are those that no other order beats both in when the robot is home and in cost; the best orders of a set arise from those
//! of the set without its last job. Robots are put together set by set. Exact, to the last digit; `2^n n` steps for `n` jobs
//! and two robots, `3^n` for more. No source: ours, since the constraint program proves ten jobs in minutes only.

use super::instance::{Instance, Sequence};

/// The most jobs of two robots.
const MOST_OF_TWO: usize = 14;
/// The most jobs of more.
const MOST_OF_MORE: usize = 11;

/// An order of a set of jobs that no other beats.
#[derive(Clone, Copy)]
struct Entry {
    /// When the last robot is home (s).
    end: f64,
    cost: f64,
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
    count <= most && alone && instance.is_fixed() && instance.is_regular()
}

/// The best sequence. The instance fits, [`fits`].
pub(crate) fn best(instance: &Instance) -> Sequence {
    let robots = instance.free.len();
    let full = (1_usize << instance.jobs.len()) - 1;
    let tables: Vec<Table> = (0..robots).map(|robot| orders(instance, robot)).collect();
    let mut together: Vec<Table> = Vec::new();
    for (robot, table) in tables.iter().enumerate() {
        let joined = match together.last() {
            None => {
                join(&[vec![Entry { end: instance.busy, cost: 0.0, last: 0, before: 0, own: 0 }]], table, full, true)
            }
            Some(before) => join(before, table, full, robot + 1 < robots),
        };
        together.push(joined);
    }
    let total = |entry: &Entry| entry.cost + instance.makespan_cost * entry.end;
    let Some(last) = together.last().map(|table| &table[full]) else { return Vec::new() };
    let mut place = (0..last.len()).min_by(|a, b| total(&last[*a]).total_cmp(&total(&last[*b]))).unwrap_or(0);
    let mut set = full;
    let mut sequence: Sequence = vec![Vec::new(); robots];
    for robot in (0..robots).rev() {
        let entry = together[robot][set][place];
        sequence[robot] = path(&tables[robot], entry.last, entry.own);
        set &= !entry.last;
        place = entry.before;
    }
    sequence
}

/// Adds an entry to those that nothing beats.
fn keep(entries: &mut Vec<Entry>, new: Entry) {
    if entries.iter().any(|old| old.end <= new.end && old.cost <= new.cost) {
        return;
    }
    entries.retain(|old| old.end < new.end || old.cost < new.cost);
    entries.push(new);
}

/// The best orders of every set of jobs by one robot.
fn orders(instance: &Instance, robot: usize) -> Table {
    let count = instance.jobs.len();
    let mut table: Table = vec![Vec::new(); 1 << count];
    table[0].push(Entry { end: instance.free[robot], cost: 0.0, last: 0, before: 0, own: 0 });
    let (serve, deposit) = (instance.serve(robot), instance.deposit(robot));
    for set in 1..table.len() {
        let mut entries = Vec::new();
        for (last, job) in instance.jobs.iter().enumerate().filter(|(last, _)| set >> last & 1 == 1) {
            let [going, proximity, back] = job.ways[robot];
            let price: f64 = job.ways[robot].iter().map(|way| way.cost(way.low)).sum::<f64>() + job.serve_cost * serve;
            for (before, entry) in table[set & !(1 << last)].iter().enumerate() {
                let start = job.release.max(entry.end + going.low + proximity.low);
                let end = start + serve + back.low + deposit;
                let cost = entry.cost + price + job.start_cost * start;
                keep(&mut entries, Entry { end, cost, last, before, own: 0 });
            }
        }
        table[set] = entries;
    }
    table
}

/// Sets shared between the robots so far and one more; of the whole set alone if no other is wanted. The table of no robot
/// has the empty set only.
fn join(before: &[Vec<Entry>], robot: &Table, full: usize, every: bool) -> Table {
    let mut table: Table = vec![Vec::new(); full + 1];
    let first = if every { 0 } else { full };
    for (set, joined) in table.iter_mut().enumerate().skip(first) {
        let mut entries = Vec::new();
        // All subsets of `set`, from itself down to nothing.
        let mut own = set;
        loop {
            for (place, earlier) in before.get(set & !own).into_iter().flatten().enumerate() {
                for (index, entry) in robot[own].iter().enumerate() {
                    let end = if own == 0 { earlier.end } else { earlier.end.max(entry.end) };
                    let cost = earlier.cost + entry.cost;
                    keep(&mut entries, Entry { end, cost, last: own, before: place, own: index });
                }
            }
            if own == 0 {
                break;
            }
            own = (own - 1) & set;
        }
        *joined = entries;
    }
    table
}

/// The order behind an entry of a robot.
fn path(table: &Table, mut set: usize, mut place: usize) -> Vec<usize> {
    let mut jobs = Vec::new();
    while set != 0 {
        let entry = table[set][place];
        jobs.push(entry.last);
        set &= !(1 << entry.last);
        place = entry.before;
    }
    jobs.reverse();
    jobs
}
