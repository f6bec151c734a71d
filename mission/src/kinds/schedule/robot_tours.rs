//! Minimum cost of one robot for doing a set of jobs from an instant on, under [prices](super::lagrangian_bound).
//!
//! Built backwards from the end of the day: a job is put before an order of other jobs, and the cost is a [`Curve`]
//! over minus the instant at which the robot is free. Of the orders of a set, only those are kept that are not
//! dominated.

use crate::engine::{Halt, Watch};

use super::bounds::Bounds;
use super::cost_function::Curve;
use super::instance::{Instance, Sequence};
use super::lagrangian_bound::Priced;

/// Maximum number of stored pieces of all functions of a robot, 16 bytes each.
const MOST_KEPT: usize = 4_000_000;

/// Curves of going and proximity together, and of depositing, of each job by each robot.
pub(crate) type Ways = Vec<Vec<(Curve, Curve)>>;

/// An equidistant grid of instants.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    pub origin: f64,
    pub step: f64,
    pub cells: usize,
}

impl Grid {
    /// Returns the cell of an instant; the last one for all later instants.
    pub fn cell(&self, instant: f64) -> usize {
        (((instant - self.origin) / self.step).max(0.0) as usize).min(self.cells - 1)
    }

    /// Returns the first instant of a cell.
    pub fn instant(&self, cell: usize) -> f64 {
        self.origin + cell as f64 * self.step
    }
}

/// An order of a set that is not dominated.
struct Entry {
    curve: Curve,
    /// First job of the order.
    first: usize,
    /// Entry of the set without the first job.
    after: usize,
}

/// Inputs that the orders of all robots share.
#[derive(Clone, Copy)]
pub(crate) struct Day<'a, 'b> {
    pub instance: &'a Instance<'b>,
    pub bounds: &'a Bounds,
    pub ways: &'a Ways,
    pub watch: &'a Watch,
}

/// The orders of one robot, by set of jobs (a bit for each job).
pub(crate) struct Routes {
    free: f64,
    entries: Vec<Vec<Entry>>,
}

impl Routes {
    /// Computes the orders of a robot whose end costs `end_cost` per second.
    ///
    /// # Errors
    ///
    /// There are too many orders, or the time limit is reached.
    pub fn new(day: &Day, priced: &Priced, robot: usize, end_cost: f64) -> Result<Routes, Halt> {
        let Day { instance, bounds, ways, watch } = *day;
        let (free, end) = (instance.free[robot], bounds.last_end(instance));
        let (serve, deposit) = (instance.serve(robot), instance.deposit(robot));
        // Without jobs only the end costs, which is not before the robot is free.
        let nothing = Curve::falling(-end, end_cost * end, end_cost, (end - free).max(0.0));
        let mut routes = Routes { free, entries: vec![vec![Entry { curve: nothing, first: 0, after: 0 }]] };
        let mut pieces = 0;
        for set in 1..1_usize << instance.jobs.len() {
            if watch.is_over() {
                return Err(Halt::Time);
            }
            let mut kept: Vec<Entry> = Vec::new();
            for first in (0..instance.jobs.len()).filter(|first| set >> first & 1 == 1) {
                let rest = set & !(1 << first);
                if before(instance, first) & rest != 0 {
                    continue;
                }
                let (there, back) = &ways[first][robot];
                for (after, entry) in routes.entries[rest].iter().enumerate() {
                    let leaving = entry.curve.then(back).moved(serve + deposit, priced.serve[first] * serve);
                    let Some(held) = leaving.held(bounds.first[first], priced.start[first]) else { continue };
                    let curve = held.then(there);
                    if curve.start > -free || kept.iter().any(|old| old.curve.beats(&curve)) {
                        continue;
                    }
                    kept.retain(|old| !curve.beats(&old.curve));
                    kept.push(Entry { curve, first, after });
                }
            }
            pieces += kept.iter().map(|entry| 1 + entry.curve.pieces()).sum::<usize>();
            if pieces > MOST_KEPT {
                return Err(Halt::Size);
            }
            routes.entries.push(kept);
        }
        Ok(routes)
    }

    /// Tabulates the minimum cost of each set by the cell in which the robot is free; `None` if the time limit is
    /// reached.
    pub fn table(&self, grid: Grid, watch: &Watch) -> Option<Vec<f64>> {
        let mut table = vec![f64::INFINITY; self.entries.len() * grid.cells];
        for (set, cells) in table.chunks_mut(grid.cells).enumerate() {
            if watch.is_over() {
                return None;
            }
            for entry in &self.entries[set] {
                let mut along = entry.curve.along();
                for cell in (0..grid.cells).rev() {
                    let instant = -grid.instant(cell).max(self.free);
                    if instant >= entry.curve.start {
                        cells[cell] = cells[cell].min(along.at(instant));
                    }
                }
            }
        }
        Some(table)
    }

    /// Returns the cost and the index of the cheapest order of a set from the instant at which the robot is free.
    fn cheapest(&self, set: usize) -> (f64, usize) {
        let cost =
            |entry: &Entry| if -self.free < entry.curve.start { f64::INFINITY } else { entry.curve.at(-self.free) };
        let costs = self.entries[set].iter().map(cost).enumerate();
        costs.min_by(|a, b| a.1.total_cmp(&b.1)).map_or((f64::INFINITY, 0), |(place, cost)| (cost, place))
    }

    /// Returns the jobs of an order.
    fn jobs(&self, mut set: usize, mut place: usize) -> Vec<usize> {
        let mut jobs = Vec::new();
        while let Some(entry) = self.entries[set].get(place).filter(|_| set != 0) {
            jobs.push(entry.first);
            set &= !(1 << entry.first);
            place = entry.after;
        }
        jobs
    }
}

/// Returns the set of the earlier jobs of a job's agent.
fn before(instance: &Instance, job: usize) -> usize {
    let previous = |job: &usize| instance.jobs[*job].previous;
    std::iter::successors(previous(&job), previous).map(|job| 1 << job).sum()
}

/// Returns the cheapest distribution of all jobs over the robots, with its cost without the constant part.
pub(crate) fn cheapest(robots: &[Routes], full: usize) -> (f64, Sequence) {
    let mut costs: Vec<Vec<(f64, usize)>> = Vec::new();
    for routes in robots {
        costs.push((0..=full).map(|set| routes.cheapest(set)).collect());
    }
    let values: Vec<Vec<f64>> = costs.iter().map(|own| own.iter().map(|(cost, _)| *cost).collect()).collect();
    let together = shares(&values.iter().collect::<Vec<_>>(), full);
    let mut sequence: Sequence = vec![Vec::new(); robots.len()];
    let (mut set, total) = (full, together.last().map_or(f64::INFINITY, |last| last[full]));
    for (m, routes) in robots.iter().enumerate().rev() {
        let own = match m.checked_sub(1) {
            None => set,
            Some(before) => subsets(set)
                .min_by(|a, b| {
                    let cost = |own: usize| values[m][own] + together[before][set & !own];
                    cost(*a).total_cmp(&cost(*b))
                })
                .unwrap_or(0),
        };
        sequence[m] = routes.jobs(own, costs[m][own].1);
        set &= !own;
    }
    (total, sequence)
}

/// For each robot, minimum costs of distributing each subset of `full` over it and the robots before it; for the last
/// robot only for `full`. `values` are by robot and set.
pub(crate) fn shares(values: &[&Vec<f64>], full: usize) -> Vec<Vec<f64>> {
    let mut together: Vec<Vec<f64>> = Vec::with_capacity(values.len());
    for (m, own) in values.iter().enumerate() {
        let Some(before) = together.last() else {
            together.push((*own).clone());
            continue;
        };
        let mut next = vec![f64::INFINITY; full + 1];
        let wanted = if m + 1 == values.len() { full } else { 0 };
        for set in subsets(full).filter(|set| set & wanted == wanted) {
            next[set] = subsets(set).map(|part| own[part] + before[set & !part]).fold(f64::INFINITY, f64::min);
        }
        together.push(next);
    }
    together
}

/// Enumerates all subsets of a set, from the set itself down to the empty set.
pub(crate) fn subsets(set: usize) -> impl Iterator<Item = usize> {
    let mut next = Some(set);
    std::iter::from_fn(move || {
        let now = next?;
        next = (now != 0).then(|| (now - 1) & set);
        Some(now)
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot unwrap fails")]
mod tests {
    use super::super::problem::{AgentKind, Distances, Duration, Problem, Robot, WorkingAgent};
    use super::*;
    use crate::engine::Budget;
    use crate::numbers::{Energy, Range};
    use proptest::prelude::*;

    /// One robot and two agents with two and one operations, all legs at one speed.
    fn problem(lengths: [f64; 2], means: [f64; 2]) -> Problem {
        let agent = |a: usize| {
            let duration = Duration { mean: means[a], sigma: 0.0 };
            WorkingAgent::new(format!("a{a}"), AgentKind::Worker, [0.0, 0.0], 2 - a, duration)
        };
        let robot = Robot {
            name: "m".into(),
            depot: [0.0, 0.0],
            speed: Range::point(0.1),
            proximity: Some(Range::point(0.1)),
            serve: 10.0,
            deposit: 20.0,
            factor: 1.0,
            energy: Energy::of_factor(1.0),
        };
        let distances = Distances::Table(vec![lengths.to_vec()]);
        Problem { distances, ..Problem::new(vec![robot], vec![agent(0), agent(1)]) }
    }

    /// Cost of these jobs one after the other from an instant on; `None` if they end after the day.
    fn cost(
        instance: &Instance,
        priced: &Priced,
        bounds: &Bounds,
        jobs: &[usize],
        from: f64,
        end_cost: f64,
    ) -> Option<f64> {
        let (mut free, mut cost) = (from, 0.0);
        for &job in jobs {
            let ways = instance.jobs[job].ways[0];
            let start = (free + ways[0].low + ways[1].low).max(bounds.first[job]);
            cost += ways.iter().map(|way| way.cost(way.low)).sum::<f64>();
            cost += priced.start[job] * start + priced.serve[job] * instance.serve(0);
            free = start + instance.serve(0) + ways[2].low + instance.deposit(0);
        }
        (free <= bounds.last_end(instance)).then_some(cost + end_cost * free)
    }

    proptest! {
        #[test]
        fn a_table_has_the_least_cost_of_all_orders(
            lengths in proptest::array::uniform2(2.0..20.0_f64), means in proptest::array::uniform2(10.0..300.0_f64),
            price in 0.0..0.02_f64, end_cost in 0.0..0.01_f64,
        ) {
            let problem = problem(lengths, means);
            let instance = Instance::new(&problem);
            let bounds = Bounds::new(&instance, 1e6);
            let priced = Priced::new(&instance, &[0.0, price, 0.0]);
            let ways: Ways = instance.jobs.iter().map(|job| {
                let [going, proximity, back] = job.ways[0].map(|way| Curve::of_way(&way, 1));
                vec![(going.then(&proximity), back)]
            }).collect();
            let watch = Watch::new(&Budget::default());
            let day = Day { instance: &instance, bounds: &bounds, ways: &ways, watch: &watch };
            let routes = Routes::new(&day, &priced, 0, end_cost).unwrap();
            let grid = Grid { origin: 0.0, step: 37.0, cells: 30 };
            let table = routes.table(grid, &watch).unwrap();
            // Jobs 0 and 1 are the operations of one agent, in this order.
            let orders: [(usize, &[&[usize]]); 5] = [
                (0b000, &[&[]]),
                (0b010, &[&[1]]),
                (0b011, &[&[0, 1]]),
                (0b101, &[&[0, 2], &[2, 0]]),
                (0b111, &[&[0, 1, 2], &[0, 2, 1], &[2, 0, 1]]),
            ];
            for (set, orders) in orders {
                for cell in [0, 1, 7, 29] {
                    let from = grid.instant(cell);
                    let least =
                        orders.iter().filter_map(|jobs| cost(&instance, &priced, &bounds, jobs, from, end_cost));
                    let least = least.fold(f64::INFINITY, f64::min);
                    let found = table[set * grid.cells + cell];
                    let same = found == least || (found - least).abs() < 1e-9 * (1.0 + least);
                    prop_assert!(same, "{set:b} {cell}: {found} {least}");
                }
            }
            let (total, sequence) = cheapest(std::slice::from_ref(&routes), 0b111);
            prop_assert!((total - table[0b111 * grid.cells]).abs() < 1e-12);
            let again = cost(&instance, &priced, &bounds, &sequence[0], 0.0, end_cost).unwrap();
            prop_assert!((again - total).abs() < 1e-9);
        }
    }

    #[test]
    fn sharing_is_the_least_over_all_ways_to_share() {
        let mut random: u64 = 9;
        let mut next = || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (random >> 40) as f64
        };
        let values: Vec<Vec<f64>> = (0..3).map(|_| (0..16).map(|_| next()).collect()).collect();
        let full = 0b1101;
        let mut least = f64::INFINITY;
        for first in 0..16_usize {
            for second in 0..16_usize {
                let third = full & !(first | second);
                if first & second == 0 && (first | second) & !full == 0 {
                    least = least.min(values[0][first] + values[1][second] + values[2][third]);
                }
            }
        }
        assert_eq!(shares(&values.iter().collect::<Vec<_>>(), full)[2][full], least);
        assert_eq!(subsets(0b101).collect::<Vec<_>>(), [0b101, 0b100, 0b001, 0]);
    }
}
