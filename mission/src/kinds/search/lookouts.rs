//! Lookouts: places from which an agent considers to look for hidden objects.
//!
//! They are chosen one after the other, each the place from which the most is seen of what the ones before leave: a greedy cover,
//! whose worth is at least `1 - 1/e` of the best one (Nemhauser, Wolsey and Fisher 1978).

use super::belief::Undetected;
use super::geometry::{Point, distance};
use super::ground::{Ground, Reached};
use super::problem::Problem;

/// Share of the weight of what a lookout sees that is left for the next ones.
const LEFT: f64 = 0.1;
/// Least distance between two lookouts, in widths of a cell.
const APART: f64 = 1.5;

/// Returns the lookouts of an agent (m), the best first; none if it does not look for anything.
pub fn lookouts(problem: &Problem, agent: usize, ground: &Ground, reached: Option<&Reached<'_>>) -> Vec<Point> {
    let Some(sees) = problem.looks(agent) else { return Vec::new() };
    let sight = problem.sight();
    let mut left = Undetected::of(problem);
    let exposure = -f64::ln(LEFT);
    let mut chosen: Vec<Point> = Vec::new();
    let mut open = vec![true; sight.len()];
    // Of those whose gain was once low none becomes high: a bound spares most evaluations.
    let mut bounds: Vec<f64> = vec![f64::INFINITY; sight.len()];
    while chosen.len() < problem.planner.lookouts {
        let mut best: Option<(f64, usize)> = None;
        let mut order: Vec<usize> = (0..sight.len()).filter(|cell| open[*cell]).collect();
        order.sort_by(|a, b| bounds[*b].total_cmp(&bounds[*a]).then(a.cmp(b)));
        for cell in order {
            if best.is_some_and(|(gain, _)| bounds[cell] <= gain) {
                break;
            }
            let at = sight.middles()[cell];
            let good = ground.fits(at)
                && chosen.iter().all(|other| distance(*other, at) >= APART * problem.cell)
                && reached.is_none_or(|reached| reached.reaches(at));
            if !good {
                open[cell] = false;
                continue;
            }
            bounds[cell] = left.gain(&sight, cell as u32, sees.within, exposure);
            if best.is_none_or(|(gain, _)| bounds[cell] > gain) {
                best = Some((bounds[cell], cell));
            }
        }
        let Some((_, cell)) = best.filter(|(gain, _)| *gain > 1e-12) else { break };
        left.look(&sight, cell as u32, sees.within, exposure);
        open[cell] = false;
        chosen.push(sight.middles()[cell]);
    }
    chosen
}
