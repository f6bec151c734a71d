//! Search for the active set of a level by descent, used if guessing it cycles.
//!
//! The cost of a level, `f(y) = sum w_i dist(m_i y, [l_i, u_i])^2`, is convex, once differentiable and piecewise
//! quadratic. From a point that meets all higher rows, each step goes towards the minimiser of the current piece within
//! the working set, as far as an exact line search and the higher rows allow. The cost never rises, so that no piece
//! repeats (primal active-set method; Nocedal and Wright, Numerical Optimization, 16.5, with Newton steps on the
//! pieces).

use crate::dense::{axpy, dot, norm};
use crate::feasible_set::Kind;
use crate::reduced_level::{ActiveSetGuess, ReducedLevel};

/// Maximum number of steps.
const STEPS: usize = 150;

/// A step below this, relative to the point, counts as zero.
const STILL: f64 = 1e-11;

/// Descends from x0, which meets all higher rows. Returns `None` if the maximum number of steps was reached.
pub(crate) fn descend(reduced: &ReducedLevel) -> Option<ActiveSetGuess> {
    let k = reduced.space.dimension();
    let mut y = vec![0.0; k];
    let mut active = vec![0_i8; reduced.space.names.len()];
    for _ in 0..STEPS {
        let own = violated(reduced, &y);
        let flat = reduced.minimisers(&own, &active)?;
        // The minimiser of the piece that is nearest to y.
        let away: Vec<f64> = y.iter().zip(&flat.y).map(|(y, f)| y - f).collect();
        let mut goal = flat.null.apply(&flat.null.apply_transposed(&away));
        axpy(1.0, &flat.y, &mut goal);
        let step: Vec<f64> = goal.iter().zip(&y).map(|(g, y)| g - y).collect();
        if norm(&step) <= STILL * (1.0 + norm(&y)) {
            let (multipliers, noise) = reduced.multipliers(&flat, &own, &active);
            let worst = multipliers.into_iter().min_by(|a, b| a.1.total_cmp(&b.1));
            match worst {
                Some((j, multiplier)) if multiplier < -noise => active[j] = 0,
                _ => return Some(reduced.guess(own, &active)),
            }
            continue;
        }
        let (limit, blocking) = longest(reduced, &active, &y, &step);
        let length = line_search(reduced, &y, &step, limit);
        axpy(length, &step, &mut y);
        if let Some((j, side)) = blocking.filter(|_| length == limit) {
            active[j] = side;
        }
    }
    None
}

/// Returns for each row of the level the side on which `y` violates it; 0 for equalities and rows that are met.
fn violated(reduced: &ReducedLevel, y: &[f64]) -> Vec<i8> {
    (0..reduced.level.kind.len())
        .map(|i| {
            let value = dot(reduced.own.g.row(i), y);
            let tolerance = reduced.own.tolerance[i];
            if reduced.level.kind[i] != Kind::Inequality {
                0
            } else if value < reduced.own.lower[i] - tolerance {
                -1
            } else {
                i8::from(value > reduced.own.upper[i] + tolerance)
            }
        })
        .collect()
}

/// Returns the maximum length along `step` that the higher rows outside the working set allow, and the row that blocks
/// there.
fn longest(reduced: &ReducedLevel, active: &[i8], y: &[f64], step: &[f64]) -> (f64, Option<(usize, i8)>) {
    let mut limit = f64::INFINITY;
    let mut blocking = None;
    for j in (0..active.len()).filter(|j| active[*j] == 0) {
        let slope = dot(reduced.higher.g.row(j), step);
        if slope.abs() <= 1e-13 * norm(step) {
            continue;
        }
        let (bound, side) = if slope > 0.0 { (reduced.higher.upper[j], 1) } else { (reduced.higher.lower[j], -1) };
        let reach = ((bound - dot(reduced.higher.g.row(j), y)) / slope).max(0.0);
        if reach < limit {
            limit = reach;
            blocking = Some((j, side));
        }
    }
    (limit, blocking)
}

/// Returns the minimiser of the cost along `step` in `[0, limit]`: the root of its derivative, which is piecewise
/// linear and increasing.
fn line_search(reduced: &ReducedLevel, y: &[f64], step: &[f64], limit: f64) -> f64 {
    let level = reduced.level;
    // Per row: value, slope, interval, weight.
    let mut lines: Vec<(f64, f64, f64, f64, f64)> = Vec::new();
    for i in (0..level.kind.len()).filter(|i| level.kind[*i] != Kind::Silent) {
        let row = reduced.own.g.row(i);
        let weight = level.scale[i] * level.scale[i];
        lines.push((dot(row, y), dot(row, step), reduced.own.lower[i], reduced.own.upper[i], weight));
    }
    if level.damping > 0.0 {
        for (i, x0) in reduced.space.x0.iter().enumerate() {
            let row = reduced.space.z.row(i);
            let weight = level.damping * level.damping;
            lines.push((dot(row, y), dot(row, step), -x0, -x0, weight));
        }
    }
    let derivative = |t: f64| -> f64 {
        lines
            .iter()
            .map(|(value, slope, lower, upper, weight)| {
                let at = value + t * slope;
                weight * slope * ((at - upper).max(0.0) + (at - lower).min(0.0))
            })
            .sum()
    };
    let mut breaks: Vec<f64> = lines
        .iter()
        .flat_map(|(value, slope, lower, upper, _)| [(lower - value) / slope, (upper - value) / slope])
        .filter(|t| t.is_finite() && *t > 0.0 && *t < limit.min(1e6))
        .collect();
    breaks.push(limit.min(1e6));
    breaks.sort_by(f64::total_cmp);
    let (mut from, mut rise) = (0.0, derivative(0.0));
    for to in breaks {
        let slope = derivative(to);
        if slope >= 0.0 {
            let part = if slope > rise { -rise / (slope - rise) } else { 1.0 };
            return from + part.clamp(0.0, 1.0) * (to - from);
        }
        (from, rise) = (to, slope);
    }
    from
}
