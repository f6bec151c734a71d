//! Schedules of agents with several remaining services: branch and bound over the order in which services start.
//!
//! A node holds the first services of a schedule in the order of their starts, each with its robot. Its cost so far and
//! a bound on its remaining cost are computed under [prices](super::lagrangian_bound), which replace the order constraints of
//! agents and so decouple the robots: the cost so far is a [`Curve`] for each robot over its return time, and the rest
//! of its day a [table](super::robot_tours) by set of jobs and instant. Speeds stay decisions throughout. Two things make
//! the bound strong: services start only after everything earlier in the order can have happened, at speeds that are
//! useful; and if the prices of the root do not exclude a node, those of the last complete schedules, which are exact
//! for these, often do. A complete order that is not excluded is timed exactly. No source: our own method, since the
//! position form keeps a gap of 3 to 5 % for three services of each of four agents; this one proves them in seconds.

use crate::engine::{Budget, EngineError, Halt, Watch};
use crate::plan::{Limit, Statistics};

use super::bounds::Bounds;
use super::construct::construct;
use super::cost_function::Curve;
use super::exact::{Found, status};
use super::instance::{Instance, Sequence};
use super::lagrangian_bound::{Priced, Raised, raise};
use super::position::alike;
use super::relaxation::relaxation;
use super::retime::{Prices, Timed, retime};
use super::robot_tours::{Day, Grid, Routes, Ways, cheapest, shares, subsets};

/// Maximum number of jobs with one or two robots, with three, and with more.
const MOST: [usize; 3] = [12, 10, 8];
/// Number of tangents of a leg's energy.
const TANGENTS: usize = 5;
/// Number of cells of the tables, and their range relative to the length of the best schedule.
const CELLS: usize = 600;
const BEYOND: f64 = 1.2;
/// Number of nodes that count as one node of the budget: a node of a mixed-integer program needs several linear
/// programs, which take longer than this number of nodes here.
const CHEAP: u64 = 10;
/// Number of complete schedules whose prices are tried, and minimum number of decided services for that.
const SCHEDULES: usize = 4;
const SERVICES: usize = 4;

/// Returns true if this method applies to the problem and the problem is small enough.
pub(crate) fn is_applicable(instance: &Instance) -> bool {
    let robots = instance.free.len();
    robots > 0 && instance.jobs.len() <= MOST[robots.clamp(2, 4) - 2] && instance.is_regular()
}

/// Finds the best schedule, with a bound. Requires [`is_applicable`].
///
/// # Errors
///
/// The tables would be too large, or the cone solver failed.
pub(crate) fn orders(instance: &Instance, budget: &Budget) -> Result<Found, Halt> {
    let watch = Watch::new(budget);
    let best = construct(instance, &watch)?;
    let bounds = Bounds::new(instance, best.cost);
    let statistics = Statistics { solves: 1, ..Statistics::default() };
    let least = relaxation(instance, &bounds, best.cost, &watch);
    if best.cost - least <= budget.gap * best.cost.abs() {
        let status = status(best.cost, least, budget.gap, None);
        return Ok(Found { timed: best, status, statistics });
    }
    let ways = ways(instance);
    let robots = instance.free.len();
    // The makespan is at least the end of each robot, so that its cost can be split between the robots.
    let early = |m: usize| instance.free[m] <= bounds.first_end;
    let sharing = (0..robots).filter(|m| early(*m)).count().max(1) as f64;
    let end_cost = |m: usize| if early(m) { instance.makespan_cost / sharing } else { 0.0 };
    let day = Day { instance, bounds: &bounds, ways: &ways, watch: &watch };
    let days = |priced: &Priced| -> Result<Vec<Routes>, Halt> {
        (0..robots).map(|m| Routes::new(&day, priced, m, end_cost(m))).collect()
    };
    let full = (1_usize << instance.jobs.len()) - 1;
    let Raised { prices, bound } = raise(instance, &bounds, best.cost, &watch, |priced| {
        let (cost, sequence) = cheapest(&days(priced)?, full);
        Ok((priced.constant + cost, sequence))
    })?;
    let bound = bound.max(least);
    let priced = Priced::new(instance, &prices);
    let days = match days(&priced) {
        Ok(days) => days,
        Err(Halt::Time) => {
            let status = status(best.cost, bound, budget.gap, Some(Limit::Time));
            return Ok(Found { timed: best, status, statistics });
        }
        Err(halt) => return Err(halt),
    };
    let origin = instance.free.iter().copied().fold(f64::INFINITY, f64::min);
    let last = best.schedule.iter().map(|done| done.times.end).fold(origin, f64::max);
    let step = (BEYOND * (last - origin) / CELLS as f64).max(1e-9);
    let grid = Grid { origin, step, cells: CELLS };
    let tables: Option<Vec<Vec<f64>>> = days.iter().map(|routes| routes.table(grid, &watch)).collect();
    drop(days);
    let Some(tables) = tables else {
        let status = status(best.cost, bound, budget.gap, Some(Limit::Time));
        return Ok(Found { timed: best, status, statistics });
    };
    let mut search = Search {
        instance,
        budget,
        watch,
        priced,
        prices,
        bounds,
        ways,
        tables,
        grid,
        pool: vec![best.prices.clone()],
        lowest: f64::INFINITY,
        failed: None,
        stopped: None,
        statistics,
        best,
    };
    let root = search.root();
    search.visit(&root);
    if let Some(error) = search.failed {
        return Err(error.into());
    }
    let status = status(search.best.cost, search.lowest.max(bound), budget.gap, search.stopped);
    Ok(Found { timed: search.best, status, statistics: search.statistics })
}

/// Curves of going and proximity together, and of depositing, of each job by each robot, at speeds that may be useful.
fn ways(instance: &Instance) -> Ways {
    let all = flow(instance, 0);
    let curves = |job: usize, robot: usize| {
        let worth = instance.jobs[job].ways[robot].map(|mut way| {
            way.low = way.shortest_at(all);
            Curve::of_way(&way, TANGENTS)
        });
        let [going, proximity, back] = worth;
        (going.then(&proximity), back)
    };
    (0..instance.jobs.len()).map(|job| (0..instance.free.len()).map(|robot| curves(job, robot)).collect()).collect()
}

/// Upper bound on the cost per second of a delay of all jobs except for these.
fn flow(instance: &Instance, done: usize) -> f64 {
    let left = instance.jobs.iter().enumerate().filter(|(job, _)| done >> job & 1 == 0);
    left.map(|(_, job)| job.start_cost).sum::<f64>() + instance.makespan_cost
}

/// The first services of a schedule, in the order of their starts.
#[derive(Clone)]
struct Node {
    /// Cost of each robot so far, as a function of its return time.
    curves: Vec<Curve>,
    /// Earliest return of each robot (s).
    home: Vec<f64>,
    /// Earliest start of each job's service (s), and its robot.
    start: Vec<f64>,
    robot: Vec<usize>,
    /// Jobs of the node as a set, and in order by robot.
    done: usize,
    sequence: Sequence,
    /// Earliest start of the last job (s).
    last: f64,
    /// Lower bound on the cost of every schedule with this beginning.
    bound: f64,
}

struct Search<'a, 'b> {
    instance: &'a Instance<'b>,
    budget: &'a Budget,
    watch: Watch,
    /// Prices that underlie the tables.
    prices: Vec<f64>,
    priced: Priced,
    bounds: Bounds,
    ways: Ways,
    /// Minimum cost of the rest of each robot's day, by set and cell.
    tables: Vec<Vec<f64>>,
    grid: Grid,
    /// Prices of complete schedules, the most recently useful ones first.
    pool: Vec<Prices>,
    best: Timed,
    /// Minimum of the bounds of all excluded nodes.
    lowest: f64,
    stopped: Option<Limit>,
    failed: Option<EngineError>,
    statistics: Statistics,
}

impl Search<'_, '_> {
    fn root(&self) -> Node {
        let (instance, count) = (self.instance, self.instance.jobs.len());
        Node {
            curves: instance.free.iter().map(|free| Curve::step(*free, 0.0)).collect(),
            home: instance.free.clone(),
            start: vec![0.0; count],
            robot: vec![0; count],
            done: 0,
            sequence: vec![Vec::new(); instance.free.len()],
            last: f64::NEG_INFINITY,
            bound: self.bounds.cost,
        }
    }

    /// Returns the cost from which on nodes are excluded.
    fn enough(&self) -> f64 {
        self.best.cost - 0.5 * self.budget.gap * self.best.cost.abs()
    }

    /// Returns true if the budget is used up or the search failed.
    fn is_over(&mut self) -> bool {
        if self.statistics.nodes >= self.budget.nodes.saturating_mul(CHEAP) {
            self.stopped = Some(Limit::Work);
        } else if self.watch.is_over() {
            self.stopped = Some(Limit::Time);
        }
        self.stopped.is_some() || self.failed.is_some()
    }

    fn visit(&mut self, node: &Node) {
        self.statistics.nodes += 1;
        if node.done + 1 == 1 << self.instance.jobs.len() {
            self.complete(node);
            return;
        }
        let left = self.left(node.done);
        let days: Vec<Vec<f64>> = node.curves.iter().enumerate().map(|(m, curve)| self.day(m, curve, left)).collect();
        let mut children = Vec::new();
        for job in 0..self.instance.jobs.len() {
            for robot in 0..self.instance.free.len() {
                if self.is_over() {
                    self.lowest = self.lowest.min(node.bound);
                    return;
                }
                children.extend(self.child(node, &days, job, robot));
            }
        }
        children.sort_by(|a, b| a.bound.total_cmp(&b.bound));
        for child in &mut children {
            if child.bound >= self.enough() || self.is_over() || self.is_dearer(child) {
                self.lowest = self.lowest.min(child.bound);
            } else {
                self.visit(child);
            }
        }
    }

    /// Times a complete order exactly.
    fn complete(&mut self, node: &Node) {
        self.statistics.solves += 1;
        match retime(self.instance, &node.sequence, &self.watch) {
            Ok(Some(timed)) => {
                // If the time limit was reached, the timing may not be optimal, and its cost is no bound.
                self.lowest = self.lowest.min(if self.is_over() { node.bound } else { timed.cost });
                self.pool.insert(0, timed.prices.clone());
                self.pool.truncate(SCHEDULES);
                if timed.cost < self.best.cost {
                    self.best = timed;
                }
            }
            Ok(None) => {}
            Err(error) => self.failed = Some(error),
        }
    }

    /// Returns the node with one more service; `None` if the service cannot be the next one. `days` are those of the
    /// robots at the node.
    fn child(&self, node: &Node, days: &[Vec<f64>], index: usize, robot: usize) -> Option<Node> {
        let (instance, job) = (self.instance, &self.instance.jobs[index]);
        if node.done >> index & 1 == 1 || job.previous.is_some_and(|previous| node.done >> previous & 1 == 0) {
            return None;
        }
        // Symmetry: of identical robots without jobs, only the first one is used.
        let unused = |m: usize| node.sequence[m].is_empty();
        if unused(robot) && (0..robot).any(|m| unused(m) && alike(instance, m, robot)) {
            return None;
        }
        let ready = match job.previous {
            Some(previous) => node.start[previous] + instance.serve(node.robot[previous]) + job.nominal,
            None => job.release,
        };
        let ways = &job.ways[robot];
        let (serve, deposit) = (instance.serve(robot), instance.deposit(robot));
        let (before, after) = (flow(instance, node.done), flow(instance, node.done | 1 << index));
        let arrival = node.home[robot] + ways[0].shortest_at(before) + ways[1].shortest_at(before);
        let start = ready.max(arrival).max(node.last);
        if start > self.bounds.latest[index] + 1e-6 {
            return None;
        }
        let mut child = node.clone();
        child.start[index] = start;
        child.robot[index] = robot;
        child.home[robot] = start + serve + ways[2].shortest_at(after) + deposit;
        child.last = start;
        child.done |= 1 << index;
        child.sequence[robot].push(index);
        child.curves[robot] = self.then(&node.curves[robot], &self.priced, index, robot, start);
        let left = self.left(child.done);
        let own = self.day(robot, &child.curves[robot], left);
        let days: Vec<&Vec<f64>> =
            days.iter().enumerate().map(|(m, day)| if m == robot { &own } else { day }).collect();
        child.bound = node.bound.max(self.priced.constant + together(&days, left));
        Some(child)
    }

    /// Extends the cost of a robot over its return time by one more service.
    fn then(&self, curve: &Curve, priced: &Priced, job: usize, robot: usize, start: f64) -> Curve {
        let (serve, deposit) = (self.instance.serve(robot), self.instance.deposit(robot));
        let (there, back) = &self.ways[job][robot];
        let started = curve.then(there).started(start, priced.start[job]);
        started.then(back).moved(serve + deposit, priced.serve[job] * serve)
    }

    /// Raises the bound of a node by the prices of complete schedules, applied to its decided jobs; returns true if
    /// that excludes the node.
    fn is_dearer(&mut self, node: &mut Node) -> bool {
        let instance = self.instance;
        if (node.done.count_ones() as usize) < SERVICES {
            return false;
        }
        // The decided jobs are the first ones of each agent, so that their prices do not change the tables of the
        // others.
        for place in 0..self.pool.len() {
            let decided = |job: usize| node.done >> job & 1 == 1;
            let order = &self.pool[place].order;
            let price = |job: usize| if decided(job) { order[job] } else { self.prices[job] };
            let priced = Priced::new(instance, &(0..instance.jobs.len()).map(price).collect::<Vec<f64>>());
            let day = |m: usize| {
                let nothing = Curve::step(instance.free[m], 0.0);
                let jobs = node.sequence[m].iter();
                jobs.fold(nothing, |curve, job| self.then(&curve, &priced, *job, m, node.start[*job]))
            };
            let curves: Vec<Curve> = (0..instance.free.len()).map(day).collect();
            let rest = if node.done + 1 == 1 << instance.jobs.len() {
                let ends = &self.pool[place].end;
                let used = curves.iter().zip(ends).zip(&node.sequence).filter(|(_, jobs)| !jobs.is_empty());
                used.map(|((curve, end), _)| curve.least(*end, f64::NEG_INFINITY)).sum()
            } else {
                self.rest(&curves, node.done)
            };
            node.bound = node.bound.max(priced.constant + rest);
            if node.bound >= self.enough() {
                self.pool[..=place].rotate_right(1);
                return true;
            }
        }
        false
    }

    /// Minimum cost to the end of the day for robots with these costs so far.
    fn rest(&self, curves: &[Curve], done: usize) -> f64 {
        let left = self.left(done);
        let days: Vec<Vec<f64>> = curves.iter().enumerate().map(|(m, curve)| self.day(m, curve, left)).collect();
        together(&days.iter().collect::<Vec<_>>(), left)
    }

    /// Returns the set of jobs that are not done.
    fn left(&self, done: usize) -> usize {
        ((1 << self.instance.jobs.len()) - 1) & !done
    }

    /// Minimum cost of a robot with this cost so far if it does a subset of `left`, by subset.
    fn day(&self, robot: usize, curve: &Curve, left: usize) -> Vec<f64> {
        let grid = self.grid;
        let first = grid.cell(curve.start);
        // Lower bound for a return within a cell: the cost so far at the end of the cell plus the remaining cost from
        // its beginning.
        let mut along = curve.along();
        let mut home = Vec::new();
        for cell in first..grid.cells {
            let until = if cell + 1 < grid.cells { grid.instant(cell + 1).max(curve.start) } else { f64::INFINITY };
            home.push(along.at(until));
            if along.is_flat() {
                break;
            }
        }
        let flat = home.last().copied().unwrap_or(0.0);
        let mut day = vec![f64::INFINITY; left + 1];
        for set in subsets(left) {
            let rest = &self.tables[robot][set * grid.cells + first..(set + 1) * grid.cells];
            let mut best = f64::INFINITY;
            for (home, rest) in home.iter().zip(rest) {
                if flat + rest >= best {
                    break;
                }
                best = best.min(home + rest);
            }
            day[set] = best;
        }
        day
    }
}

/// Minimum cost of distributing the remaining jobs over the robots.
fn together(days: &[&Vec<f64>], left: usize) -> f64 {
    shares(days, left).last().map_or(0.0, |together| together[left])
}
