//! When a repaired plan has become too costly, and planning anew what has not begun; thesis 5.5.2.

use crate::plan::{Plan, Status};

use super::assistance::{Assistance, begun_of, to_plan};
use super::choose::{Options, Refusal, plan};
use super::cost;
use super::problem::Problem;

/// `iota` of (5.19): by how much the cost of what has not begun has changed, relative to what it was in the last optimal
/// plan. What has not begun is what has not in `updated`, in both. 0 where nothing is left; infinite where nothing became
/// something.
pub fn optimality_index(optimal: (&Problem, &[Assistance]), updated: (&Problem, &[Assistance])) -> f64 {
    let free =
        |of: &Assistance| begun_of(updated.0, of.agent, of.operation).is_none_or(|begun| begun.service.is_none());
    if !updated.1.iter().any(free) {
        return 0.0;
    }
    let was = cost::cost_where(optimal.0, optimal.1, free).total();
    let is = cost::cost_where(updated.0, updated.1, free).total();
    if was == is { 0.0 } else { (was - is).abs() / was }
}

/// A new plan for what has not begun, or the repaired schedule if planning found nothing cheaper. `problem` and `repaired`
/// are what [`reschedule`](super::reschedule::reschedule) gave.
///
/// # Errors
///
/// As [`plan`].
pub fn reallocate(problem: &Problem, repaired: &[Assistance], options: &Options) -> Result<Plan, Refusal> {
    let fresh = plan(problem, options)?;
    let cost = cost::cost(problem, repaired).total();
    if fresh.cost <= cost {
        return Ok(fresh);
    }
    let status = match fresh.status {
        Status::Unbounded { stopped } => Status::Unbounded { stopped },
        Status::Proven { bound } => Status::Proven { bound },
        Status::Gap { bound, stopped, .. } => Status::Gap { bound, gap: (cost - bound) / cost, stopped },
    };
    Ok(to_plan(problem, repaired, status, format!("rescheduling, after {}", fresh.engine), fresh.statistics))
}
