//! A lower bound on the cost of every plan, within a millisecond or a few.
//!
//! The bound is the optimum of a problem with fewer constraints: each robot takes a set of targets in some order. It is in a target at the end of
//! a period only if its limits, its way around the obstacles, the connection of the team and the person allow that for this
//! target alone ([`windows`]), and between two targets it needs the time of the way ([`ways`]). Its effort is at least that of any
//! one of these visits ([`effort`]), and that of staying where the team is connected; in the period in which it costs most that somebody
//! sees the person, at least one robot has this effort. All sets of targets and all orders are tried. The reserve that is missing at
//! the end of the first period is at least that of the best position that each robot can have then.

mod effort;
mod tours;
mod ways;
mod windows;

use super::foresight::Foresight;
use super::objective::{RESERVE_COST, gain, reserve};
use super::polygon::{Convex, Point, dot, minus};
use super::problem::Problem;
use super::program::Present;

use self::tours::Tours;
use self::ways::SLACK;
pub use self::ways::Ways;
use self::windows::Windows;

/// Targets of which all sets are tried: the most valued ones. Each of the others counts as taken at its earliest.
const MOST_TARGETS: usize = 6;

/// A lower bound on the cost of every plan.
pub fn lower_bound(problem: &Problem, ways: &Ways, present: &Present, foresight: &Foresight) -> f64 {
    let left = |target: &usize| present.open[*target] && foresight.visits.iter().all(|(of, _)| of != target);
    let mut targets: Vec<usize> = (0..problem.targets.len()).filter(left).collect();
    targets.sort_by(|a, b| problem.targets[*b].worth.total_cmp(&problem.targets[*a].worth));
    let Some(windows) = Windows::new(problem, ways, present, foresight) else {
        return 0.0 - targets.iter().map(|target| problem.targets[*target].worth).sum::<f64>();
    };
    let single = targets.split_off(targets.len().min(MOST_TARGETS));
    let best_alone = |target: usize| {
        let steps = windows.active.iter().flat_map(|robot| {
            let can = windows.of(*robot, &[target]).remove(0);
            can.into_iter().position(|can| can)
        });
        steps.min().map_or(0.0, |step| gain(&problem.targets[target], step + 1).max(0.0))
    };
    let alone: f64 = single.into_iter().map(best_alone).sum();
    assigned(problem, &windows, present, &targets) + missing_reserve(problem, &windows, foresight) - alone
}

/// The least cost of all ways to share targets among the robots. In the period in which seeing the person costs most, one of them has the
/// effort of it.
fn assigned(problem: &Problem, windows: &Windows, present: &Present, targets: &[usize]) -> f64 {
    let tours: Vec<Tours> =
        windows.active.iter().map(|robot| Tours::new(problem, windows, *robot, present.states[*robot])).collect();
    let seeing = |step: usize| -> Vec<f64> {
        let there = windows.seen[step].bounds();
        tours.iter().map(|tours| tours.effort(step, there)).collect()
    };
    let more = |efforts: &Vec<f64>| {
        let more = efforts.iter().zip(&tours).map(|(effort, tours)| effort - tours.idle());
        more.fold(f64::INFINITY, f64::min)
    };
    let efforts = (0..windows.periods).map(seeing).max_by(|a, b| more(a).total_cmp(&more(b)));
    let efforts = efforts.unwrap_or_default();
    let sets = 1_usize << targets.len();
    // Least costs of the robots so far, by the set of targets that they take, while none of them sees the person, and with one that does.
    let (mut unseen, mut seen) = (vec![f64::INFINITY; sets], vec![f64::INFINITY; sets]);
    unseen[0] = 0.0;
    for (tours, effort) in tours.iter().zip(&efforts) {
        let table = tours.table(targets, *effort);
        let (mut next_unseen, mut next_seen) = (vec![f64::INFINITY; sets], vec![f64::INFINITY; sets]);
        for set in 0..sets {
            // All subsets of a set, from itself down to none.
            let mut own = set;
            loop {
                let others = set & !own;
                next_unseen[set] = f64::min(next_unseen[set], unseen[others] + table.any[own]);
                next_seen[set] =
                    next_seen[set].min(seen[others] + table.any[own]).min(unseen[others] + table.with_effort[own]);
                if own == 0 {
                    break;
                }
                own = (own - 1) & set;
            }
        }
        (unseen, seen) = (next_unseen, next_seen);
    }
    let all = if tours.is_empty() { unseen } else { seen };
    all.into_iter().fold(f64::INFINITY, f64::min)
}

/// The least cost of what is missing of the reserve at the end of the first period.
fn missing_reserve(problem: &Problem, windows: &Windows, foresight: &Foresight) -> f64 {
    let (Some(from), reserve) = (foresight.positions.first(), reserve(problem)) else { return 0.0 };
    let strides = problem.strides(problem.period);
    let (mut short, mut link) = (0.0, f64::INFINITY);
    for robot in &windows.active {
        let set = problem.person.body.sum(&problem.robots[*robot].body.reflected()).sum_with_points(&strides);
        let places = windows.first(*robot);
        if places.is_empty() {
            link = 0.0;
            continue;
        }
        let farthest = |along: Point| places.iter().map(|place| place.support(along)).fold(f64::NEG_INFINITY, f64::max);
        // The distance from the set is convex, so that it is greatest at corners.
        let corners = places.iter().flat_map(Convex::corners);
        let clear = corners.map(|at| set.outside(minus(*at, *from))).fold(f64::NEG_INFINITY, f64::max);
        short += (reserve - clear - SLACK).clamp(0.0, reserve);
        let left = problem.connection.faces().iter().map(|face| {
            let stride = strides.iter().map(|s| dot(face.normal, *s)).fold(0.0, f64::max);
            let back = face.normal.map(|x| 0.0 - x);
            face.bound + dot(face.normal, *from) + farthest(back) - stride
        });
        link = f64::min(link, (reserve - left.fold(f64::INFINITY, f64::min) - SLACK).max(0.0));
    }
    RESERVE_COST * (short + if link.is_finite() { link.min(reserve) } else { 0.0 })
}
