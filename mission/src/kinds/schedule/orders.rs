//! Schedules of agents with several services to come: branch and bound over the order in which services start.
//!
//! A node is the first services of a schedule in the order of their starts, each with its robot. What they cost and what
//! remains costs at least is known under [prices](super::prices) in place of the agents' orders: then robots have nothing in
//! common, the cost so far is a [`Curve`] for each robot over when it is home, and the rest of its day a
//! [table](super::routes) by set of jobs and instant. So speeds stay decisions everywhere. Two things make that strong:
//! services do not start before all that comes earlier can have happened, at speeds that are worth it; and where the prices
//! of the whole do not exclude a node, those of the last complete schedules, which are exact for these, often do. A
//! complete order that nothing excludes is timed exactly. No source: ours, since the position form is left with a gap of
//! 3 to 5 % for three services of each of four agents; this proves them in seconds.

use crate::engine::{Budget, EngineError, Halt, Watch};
use crate::plan::{Limit, Statistics};

use super::bounds::Bounds;
use super::construct::construct;
use super::curve::Curve;
use super::exact::{Found, status};
use super::instance::{Instance, Sequence};
use super::position::alike;
use super::prices::{Priced, Raised, raise};
use super::relaxation::relaxation;
use super::retime::{Prices, Timed, retime};
use super::routes::{Day, Grid, Routes, Ways, cheapest, shares, subsets};

/// The most jobs of one or two robots, of three, and of more.
const MOST: [usize; 3] = [12, 10, 8];
/// Tangents of the energy of a way.
const TANGENTS: usize = 5;
/// Cells of the tables, and how much longer they reach than the best schedule.
const CELLS: usize = 600;
const BEYOND: f64 = 1.2;
/// Nodes that count as one of the budget: one of a mixed-integer program, which stands for some linear programs, takes more
/// than so many.
const CHEAP: u64 = 10;
/// Complete schedules whose prices are tried, and from how many services on.
const SCHEDULES: usize = 4;
const SERVICES: usize = 4;

/// Whether a problem is of this kind, and small enough.
pub(crate) fn fits(instance: &Instance) -> bool {
    let robots = instance.free.len();
    robots > 0 && instance.jobs.len() <= MOST[robots.clamp(2, 4) - 2] && instance.is_regular()
}

/// The best schedule, with a bound. The instance fits, [`fits`].
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
    // The end is no earlier than any robot's: each has a share in its cost.
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

/// Going and proximity, and depositing, of each job by each robot, at speeds that may be worth it.
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

/// What a second costs at most that delays everything but these jobs.
fn flow(instance: &Instance, done: usize) -> f64 {
    let left = instance.jobs.iter().enumerate().filter(|(job, _)| done >> job & 1 == 0);
    left.map(|(_, job)| job.start_cost).sum::<f64>() + instance.makespan_cost
}

/// The first services of a schedule, in the order of their starts.
#[derive(Clone)]
struct Node {
    /// What each robot costs so far, by when it is home.
    curves: Vec<Curve>,
    /// When each robot is home at the earliest (s).
    home: Vec<f64>,
    /// The earliest start of each job's service (s), and its robot.
    start: Vec<f64>,
    robot: Vec<usize>,
    /// The jobs, as a set, and for each robot in order.
    done: usize,
    sequence: Sequence,
    /// The earliest start of the last one (s).
    last: f64,
    /// No schedule that begins like this costs less.
    bound: f64,
}

struct Search<'a, 'b> {
    instance: &'a Instance<'b>,
    budget: &'a Budget,
    watch: Watch,
    /// The prices of the tables.
    prices: Vec<f64>,
    priced: Priced,
    bounds: Bounds,
    ways: Ways,
    /// The least cost of the rest of each robot's day, by set and cell.
    tables: Vec<Vec<f64>>,
    grid: Grid,
    /// Prices of complete schedules, the last useful ones first.
    pool: Vec<Prices>,
    best: Timed,
    /// The least bound of what was left out.
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

    /// Nothing of at least this cost is looked for.
    fn enough(&self) -> f64 {
        self.best.cost - 0.5 * self.budget.gap * self.best.cost.abs()
    }

    /// The budget is spent.
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

    /// Times an order exactly.
    fn complete(&mut self, node: &Node) {
        self.statistics.solves += 1;
        match retime(self.instance, &node.sequence, &self.watch) {
            Ok(Some(timed)) => {
                // Timed in a hurry, it may cost less than that.
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

    /// The node with one more service; none if it cannot come next. `days` are the robots' at the node.
    fn child(&self, node: &Node, days: &[Vec<f64>], index: usize, robot: usize) -> Option<Node> {
        let (instance, job) = (self.instance, &self.instance.jobs[index]);
        if node.done >> index & 1 == 1 || job.previous.is_some_and(|previous| node.done >> previous & 1 == 0) {
            return None;
        }
        // Of robots that are alike and have nothing to do yet, the first goes first.
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

    /// What a robot costs by when it is home, with one more service.
    fn then(&self, curve: &Curve, priced: &Priced, job: usize, robot: usize, start: f64) -> Curve {
        let (serve, deposit) = (self.instance.serve(robot), self.instance.deposit(robot));
        let (there, back) = &self.ways[job][robot];
        let started = curve.then(there).started(start, priced.start[job]);
        started.then(back).moved(serve + deposit, priced.serve[job] * serve)
    }

    /// The prices of complete schedules, for what is decided, raise the bound of a node beyond what is looked for.
    fn is_dearer(&mut self, node: &mut Node) -> bool {
        let instance = self.instance;
        if (node.done.count_ones() as usize) < SERVICES {
            return false;
        }
        // Decided are the first services of each agent, so that what is left costs what it does in the tables.
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

    /// The least cost of robots that cost this so far, to the end of the day.
    fn rest(&self, curves: &[Curve], done: usize) -> f64 {
        let left = self.left(done);
        let days: Vec<Vec<f64>> = curves.iter().enumerate().map(|(m, curve)| self.day(m, curve, left)).collect();
        together(&days.iter().collect::<Vec<_>>(), left)
    }

    /// The jobs that are not done, as a set.
    fn left(&self, done: usize) -> usize {
        ((1 << self.instance.jobs.len()) - 1) & !done
    }

    /// The least cost of a robot that costs this so far, if it does this set of what is left; by set.
    fn day(&self, robot: usize, curve: &Curve, left: usize) -> Vec<f64> {
        let grid = self.grid;
        let first = grid.cell(curve.start);
        // Home within a cell it costs at least what it does at the cell's end, and the rest what it does at its beginning.
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

/// The least cost of sharing what is left among robots.
fn together(days: &[&Vec<f64>], left: usize) -> f64 {
    shares(days, left).last().map_or(0.0, |together| together[left])
}
