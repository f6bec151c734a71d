//! Tiny hierarchies against the enumeration of every active set.
//!
//! At the optimum each row is either free or sits at (or is violated towards) one of its bounds;
//! with that choice known, the optimum is the solution of a hierarchy of equalities. So the
//! optimum is the lexicographically best of the solutions for all choices.

use crate::common;

use common::{Dice, Taste, hierarchy, recursion, size, solve, system};
use hierarq_solver::{Problem, Status};
use proptest::prelude::*;

/// The least violations, level by level, and the least norm among what reaches them; `None` if
/// some choice has an unclear rank.
fn enumerate(problem: &Problem) -> Option<(Vec<f64>, Vec<f64>)> {
    let rows: Vec<(usize, usize)> =
        (0..problem.levels.len()).flat_map(|l| (0..problem.levels[l].rows()).map(move |i| (l, i))).collect();
    let choices: Vec<Vec<Option<f64>>> = rows
        .iter()
        .map(|&(l, i)| {
            let level = &problem.levels[l];
            if level.is_equality(i) {
                return vec![Some(level.lower[i])];
            }
            let mut all = vec![None];
            all.extend([level.lower[i], level.upper[i]].into_iter().filter(|b| b.is_finite()).map(Some));
            all
        })
        .collect();
    let count: usize = choices.iter().map(Vec::len).product();
    let mut candidates: Vec<(Vec<f64>, Vec<f64>)> = Vec::new();
    for mut code in 0..count {
        let mut chosen = vec![Vec::new(); problem.levels.len()];
        for ((l, i), choice) in rows.iter().zip(&choices) {
            if let Some(bound) = choice[code % choice.len()] {
                chosen[*l].push((*i, bound));
            }
            code /= choice.len();
        }
        let systems: Vec<_> = (0..chosen.len()).map(|l| system(problem, l, &chosen[l])).collect();
        let x: Vec<f64> = recursion(&problem.reference, &systems)?.iter().copied().collect();
        let mut cost: Vec<f64> = problem
            .levels
            .iter()
            .map(|level| (0..level.rows()).map(|i| level.weight[i] * level.slack(i, &x).powi(2)).sum::<f64>().sqrt())
            .collect();
        cost.push(x.iter().map(|x| x * x).sum::<f64>().sqrt());
        candidates.push((cost, x));
    }
    for c in 0..=problem.levels.len() {
        let least = candidates.iter().fold(f64::INFINITY, |m, (cost, _)| m.min(cost[c]));
        candidates.retain(|(cost, _)| cost[c] <= least + 1e-9);
    }
    candidates.into_iter().next()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(250))]
    #[test]
    fn no_choice_of_active_rows_is_better(seed: u64, ties: bool) {
        let mut dice = Dice(seed);
        let problem = hierarchy(&mut dice, Taste {
            variables: 3, levels: 3, rows: 2, equalities: 0.25, dependent: 0.2, decades: 0.0, weights: true, ties,
        });
        let Some((cost, x)) = enumerate(&problem) else { return Err(TestCaseError::reject("rank unclear")) };
        let solution = solve(&problem);
        prop_assert_eq!(solution.status, Status::Optimal);
        for (l, level) in solution.levels.iter().enumerate() {
            let most = 1e-8 * size(&x);
            prop_assert!((level.violation - cost[l]).abs() < most, "level {l}: {} {}", level.violation, cost[l]);
        }
        for (found, x) in solution.x.iter().zip(&x) {
            prop_assert!((found - x).abs() < 1e-7 * (1.0 + x.abs()), "{:?} {:?}", solution.x, x);
        }
    }
}
