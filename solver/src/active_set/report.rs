//! Conversion of the result of the search into a solution.

use super::relaxed::Relaxed;
use crate::problem::Problem;
use crate::solution::{Active, Blocking, LevelStatus, MET, Solution};
use crate::structure::Structure;

/// Writes slacks, activity and status of the solved levels. The point itself is not copied.
#[inline(always)]
pub(crate) fn write(relaxed: &Relaxed, problem: &Problem, solution: &mut Solution) {
    for (l, level) in problem.levels.iter().enumerate().take(relaxed.levels) {
        let out = &mut solution.levels[l];
        let first = relaxed.rows.first[l];
        let mut sum = 0.0;
        let mut met = true;
        for i in 0..level.rows() {
            let size = relaxed.rows.norm[first + i];
            let value = match level.structure()[i] {
                Structure::Bound { column, coefficient } => coefficient * relaxed.frame.x[column],
                Structure::Absent => 0.0,
                _ => relaxed.rows.value[first + i],
            };
            let (lower, upper, weight) = (level.lower[i], level.upper[i], level.weight[i]);
            let slack = (value - upper).max(0.0) + (value - lower).min(0.0);
            let near = MET * (size + if slack > 0.0 || lower == f64::NEG_INFINITY { upper } else { lower }.abs());
            out.active[i] = if slack.abs() > near {
                met &= weight == 0.0 && !level.hard;
                Active::Violated
            } else if lower == upper {
                Active::Equality
            } else if value <= lower + MET * (size + lower.abs()) {
                Active::Lower
            } else if value >= upper - MET * (size + upper.abs()) {
                Active::Upper
            } else {
                Active::Free
            };
            out.slack[i] = slack;
            out.multipliers[i] = weight * slack;
            sum += weight * slack * slack;
        }
        out.violation = sum.sqrt();
        out.status = if met { LevelStatus::Met } else { LevelStatus::Relaxed };
        out.freedom = relaxed.freedom(l);
    }
    solution.blocking.clear();
    for (level, active) in relaxed.working_set.active.iter().enumerate().take(relaxed.levels) {
        for e in active.iter().filter(|e| e.value > e.noise) {
            solution.blocking.push(Blocking {
                level,
                by_level: e.level,
                by_row: e.row,
                at_upper: e.side > 0.0,
                multiplier: e.value / relaxed.rows.norm[relaxed.rows.at(e.level, e.row)],
            });
        }
    }
}
