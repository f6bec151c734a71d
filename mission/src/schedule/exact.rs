//! Schedules with a proof: the position form bounds the cost from below, the re-timing of its sequence gives a schedule,
//! and tangents are added at the speeds of that schedule until both meet.

use std::time::Instant;

use crate::engine::{Budget, EngineError, Milp};
use crate::plan::{Limit, Statistics, Status};

use super::bounds::Bounds;
use super::construct::construct;
use super::instance::Instance;
use super::position::{Position, Tangents, first_tangents};
use super::retime::{Timed, retime};

/// Rounds of adding tangents at most.
const ROUNDS: usize = 12;

/// A schedule with what is known of it.
pub(crate) struct Found {
    pub timed: Timed,
    pub status: Status,
    pub statistics: Statistics,
}

/// Compares a cost with a bound: proven, or a gap for this reason.
pub(crate) fn status(cost: f64, bound: f64, gap: f64, stopped: Option<Limit>) -> Status {
    let bound = bound.min(cost);
    let relative = if cost > 0.0 { (cost - bound) / cost } else { 0.0 };
    match stopped {
        Some(stopped) if relative > gap => Status::Gap { bound, gap: relative, stopped },
        None if relative > gap => Status::Gap { bound, gap: relative, stopped: Limit::Accuracy },
        _ => Status::Proven { bound },
    }
}

/// Plans by the position form on this engine.
///
/// # Errors
///
/// The engine or the cone solver failed.
pub(crate) fn exact(instance: &Instance, engine: &dyn Milp, budget: &Budget) -> Result<Found, EngineError> {
    let begun = Instant::now();
    let mut timed = construct(instance)?;
    let mut statistics = Statistics { solves: 1, ..Statistics::default() };
    let mut tangents = first_tangents(instance);
    statistics.cuts += add_tangents(instance, &timed, &mut tangents);
    let mut bound = Bounds::new(instance, timed.cost).cost;
    let mut stopped = None;
    for _ in 0..ROUNDS {
        if timed.cost - bound <= budget.gap * timed.cost.abs() {
            break;
        }
        let time = budget.time.saturating_sub(begun.elapsed());
        let nodes = budget.nodes.saturating_sub(statistics.nodes);
        if time.is_zero() || nodes == 0 {
            stopped = Some(if nodes == 0 { Limit::Work } else { Limit::Time });
            break;
        }
        let bounds = Bounds::new(instance, timed.cost);
        let position = Position::new(instance, &bounds, &tangents);
        let start = position.point(&timed.sequence);
        let answer = engine.solve(&position.model, &start, &Budget { time, nodes, ..*budget })?;
        statistics.solves += 1;
        statistics.nodes += answer.nodes;
        bound = bound.max(answer.bound);
        let mut added = 0;
        let sequence = answer.values.map(|values| position.sequence(&values));
        if let Some(next) = sequence.map(|sequence| retime(instance, &sequence)).transpose()?.flatten() {
            statistics.solves += 1;
            added += add_tangents(instance, &next, &mut tangents);
            if next.cost < timed.cost {
                timed = next;
            }
        }
        statistics.cuts += added;
        stopped = answer.stopped;
        if stopped.is_some() || added == 0 {
            break;
        }
    }
    let status = status(timed.cost, bound, budget.gap, stopped);
    Ok(Found { timed, status, statistics })
}

/// Lays tangents at the speeds of a schedule where none is near: how many.
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
