//! Replanning: index of the cost of a repaired plan, and a new plan for everything that has not begun; thesis 5.5.2.

use super::plan::Plan;
use crate::plan::Status;

use super::assistance::{Assistance, begun_of, to_plan};
use super::choose::{Options, Refusal, plan};
use super::cost;
use super::problem::Problem;

/// Computes `iota` of (5.19): change of the cost of the services that have not begun, relative to their cost in the
/// last optimal plan. Both costs count the services that have not begun in `updated`. 0 if there are none; infinite if
/// the cost was zero and is not any more.
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

/// Replans everything that has not begun; returns the repaired schedule if planning finds nothing cheaper. `problem`
/// and `repaired` are the results of [`reschedule`](super::reschedule::reschedule).
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
