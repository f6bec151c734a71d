//! Schedules with a proof: the position form bounds the cost from below, the re-timing of its sequence gives a
//! schedule, and tangents are added at the speeds of that schedule until cost and bound meet.

use crate::engine::{Budget, EngineError, Milp, Watch};
use crate::plan::{Limit, Statistics, Status};

use super::bounds::Bounds;
use super::construct::construct;
use super::instance::Instance;
use super::position::{Position, Tangents, alike, first_tangents};
use super::relaxation::relaxation;
use super::retime::{Timed, retime};

/// Node limit of each part in the first round, and its growth factor for parts that remain open. The limit is a number
/// of nodes and not a time, so that every run is the same.
const FIRST_NODES: u64 = 60;
const MORE_NODES: u64 = 8;

/// Maximum number of parts into which a problem is split.
const PARTS: usize = 150;

/// Maximum number of rounds of adding tangents.
const ROUNDS: usize = 12;

/// A schedule with its status.
pub(crate) struct Found {
    pub timed: Timed,
    pub status: Status,
    pub statistics: Statistics,
}

/// Compares a cost with a bound: the status is proven, or a gap with this reason. No schedule has a negative cost.
pub(crate) fn status(cost: f64, bound: f64, gap: f64, stopped: Option<Limit>) -> Status {
    let bound = bound.max(0.0).min(cost);
    let relative = if cost > 0.0 { (cost - bound) / cost } else { 0.0 };
    match stopped {
        Some(stopped) if relative > gap => Status::Gap { bound, gap: relative, stopped },
        None if relative > gap => Status::Gap { bound, gap: relative, stopped: Limit::Accuracy },
        _ => Status::Proven { bound },
    }
}

/// The schedules with a given number of trips of each robot, or all schedules.
struct Part {
    trips: Option<Vec<usize>>,
    /// Lower bound on the cost of its schedules.
    bound: f64,
    /// True if more work on the part cannot improve the result.
    done: bool,
}

/// Plans by the position form with this engine.
///
/// # Errors
///
/// The engine or the cone solver failed.
pub(crate) fn exact(instance: &Instance, engine: &dyn Milp, budget: &Budget) -> Result<Found, EngineError> {
    let watch = Watch::new(budget);
    let timed = construct(instance, &watch)?;
    let statistics = Statistics { solves: 1, ..Statistics::default() };
    let tangents = first_tangents(instance);
    let mut search = Search { instance, engine, budget, watch, timed, tangents, statistics, stopped: None };
    search.add_tangents(&search.timed.clone());
    let mut parts = search.parts()?;
    let mut nodes = FIRST_NODES;
    loop {
        search.stopped = None;
        for part in parts.iter_mut().filter(|part| !part.done) {
            search.close(part, nodes)?;
        }
        parts.sort_by(|a, b| a.bound.total_cmp(&b.bound));
        if search.stopped.is_none() || search.left().is_none() {
            break;
        }
        nodes = nodes.saturating_mul(MORE_NODES);
    }
    if parts.iter().all(|part| search.is_closed(part.bound)) {
        search.stopped = None;
    }
    let bound = parts.iter().map(|part| part.bound).fold(f64::INFINITY, f64::min);
    let status = status(search.timed.cost, bound, budget.gap, search.stopped);
    Ok(Found { timed: search.timed, status, statistics: search.statistics })
}

struct Search<'a, 'b> {
    instance: &'a Instance<'b>,
    engine: &'a dyn Milp,
    budget: &'a Budget,
    watch: Watch,
    /// The best schedule so far.
    timed: Timed,
    tangents: Tangents,
    statistics: Statistics,
    stopped: Option<Limit>,
}

impl Search<'_, '_> {
    /// Returns the rest of the budget; `None` if it is used up, and then stores the reason.
    fn left(&mut self) -> Option<Budget> {
        let time = self.watch.left().time;
        let nodes = self.budget.nodes.saturating_sub(self.statistics.nodes);
        if self.watch.is_over() || nodes == 0 {
            self.stopped = Some(if nodes == 0 { Limit::Work } else { Limit::Time });
            return None;
        }
        Some(Budget { time, nodes, gap: self.budget.gap })
    }

    fn is_closed(&self, bound: f64) -> bool {
        self.timed.cost - bound <= self.budget.gap * self.timed.cost.abs()
    }

    /// Splits the schedules into parts, each bounded by its linear relaxation.
    fn parts(&mut self) -> Result<Vec<Part>, EngineError> {
        let bounds = Bounds::new(self.instance, self.timed.cost);
        let least = relaxation(self.instance, &bounds, self.timed.cost, &self.watch);
        if self.is_closed(least) {
            return Ok(vec![Part { trips: None, bound: least, done: true }]);
        }
        let mut parts = Vec::new();
        let shares = shares(self.instance, &bounds);
        for trips in shares {
            let mut bound = least;
            if let (Some(_), Some(left)) = (&trips, self.left()) {
                let mut model = Position::new(self.instance, &bounds, &self.tangents, trips.as_deref()).model;
                model.columns.iter_mut().for_each(|column| column.integer = false);
                bound = bound.max(match self.engine.solve(&model, &[], &left) {
                    Err(EngineError::Infeasible { .. }) if !self.is_here(trips.as_deref()) => self.timed.cost,
                    answer => answer?.bound,
                });
                self.statistics.solves += 1;
            }
            parts.push(Part { trips, bound, done: false });
        }
        parts.sort_by(|a, b| a.bound.total_cmp(&b.bound));
        Ok(parts)
    }

    /// Closes the gap of a part as far as possible with this number of nodes for each of its programs.
    fn close(&mut self, part: &mut Part, nodes: u64) -> Result<(), EngineError> {
        for _ in 0..ROUNDS {
            part.done = self.is_closed(part.bound);
            if part.done {
                return Ok(());
            }
            let Some(left) = self.left() else { return Ok(()) };
            let share = Budget { nodes: left.nodes.min(nodes), ..left };
            let bounds = Bounds::new(self.instance, self.timed.cost);
            let position = Position::new(self.instance, &bounds, &self.tangents, part.trips.as_deref());
            let start = position.point(&self.timed.sequence);
            let answer = match self.engine.solve(&position.model, &start, &share) {
                Err(EngineError::Infeasible { .. }) if !self.is_here(part.trips.as_deref()) => {
                    (part.bound, part.done) = (self.timed.cost, true);
                    return Ok(());
                }
                answer => answer?,
            };
            self.statistics.solves += 1;
            self.statistics.nodes += answer.nodes;
            part.bound = part.bound.max(answer.bound);
            let mut added = 0;
            let sequence = answer.values.map(|values| position.sequence(&values));
            let next = sequence.map(|sequence| retime(self.instance, &sequence, &self.watch)).transpose()?.flatten();
            if let Some(next) = next {
                self.statistics.solves += 1;
                added = self.add_tangents(&next);
                if next.cost < self.timed.cost {
                    self.timed = next;
                }
            }
            self.stopped = answer.stopped.or(self.watch.is_over().then_some(Limit::Time));
            if self.stopped.is_some() {
                return Ok(());
            }
            part.done = added == 0;
            if part.done {
                return Ok(());
            }
        }
        part.done = true;
        Ok(())
    }

    /// Returns true if the best schedule so far belongs to the part with these trips. Any other part that is infeasible
    /// within the bounds has no cheaper schedule; this one is feasible by construction.
    fn is_here(&self, trips: Option<&[usize]>) -> bool {
        trips.is_none_or(|trips| self.timed.sequence.iter().map(Vec::len).eq(trips.iter().copied()))
    }

    /// Adds tangents at the speeds of a schedule that have none nearby; returns their number.
    fn add_tangents(&mut self, timed: &Timed) -> u64 {
        let added = add_tangents(self.instance, timed, &mut self.tangents);
        self.statistics.cuts += added;
        added
    }
}

/// Enumerates the distributions of trips over the robots within the bounds; of two identical neighbours the first has
/// at least as many trips. Returns a single `None` (trips not given) if there are too many.
fn shares(instance: &Instance, bounds: &Bounds) -> Vec<Option<Vec<usize>>> {
    let mut shares: Vec<Vec<usize>> = vec![Vec::new()];
    let robots = bounds.trips.len();
    for (m, most) in bounds.trips.iter().enumerate() {
        let like = m > 0 && alike(instance, m - 1, m);
        let mut longer = Vec::new();
        for share in &shares {
            let left = instance.jobs.len() - share.iter().sum::<usize>();
            let most = if like { left.min(*most).min(share[m - 1]) } else { left.min(*most) };
            let least = if m + 1 == robots { left } else { 0 };
            longer.extend((least..=most).map(|own| [share.as_slice(), &[own]].concat()));
        }
        if longer.len() > PARTS {
            return vec![None];
        }
        shares = longer;
    }
    shares.into_iter().map(Some).collect()
}

/// Adds tangents at the speeds of a schedule that have none nearby; returns their number.
fn add_tangents(instance: &Instance, timed: &Timed, tangents: &mut Tangents) -> u64 {
    let mut added = 0;
    for (m, jobs) in timed.sequence.iter().enumerate() {
        for &job in jobs {
            for (z, way) in instance.jobs[job].ways[m].iter().enumerate() {
                if way.bend == 0.0 || way.is_fixed() {
                    continue;
                }
                let speed = way.length / timed.durations[job][z];
                let speeds = &mut tangents[m][z];
                if speeds.iter().all(|other| (other / speed - 1.0).abs() > 5e-3) {
                    let place = speeds.partition_point(|other| *other < speed);
                    speeds.insert(place, speed);
                    added += 1;
                }
            }
        }
    }
    added
}
