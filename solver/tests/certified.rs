//! Random hierarchies with dependent rows, contradictions, weights and rows of very different
//! size: the optimality certificate, which shares no step with the cascade, holds at every
//! solution and nowhere near it; and going through Clarabel leads to the same point.

use crate::common;

use common::{Dice, Taste, WILD, hierarchy, solve};
use hierarq_solver::{ClarabelCascade, HierarchicalSolver, Problem, Solution, Status, certificate};
use proptest::prelude::*;

/// Checks that the problem is solved, with a certificate below a bound; returns the solution.
fn certified(problem: &Problem, bound: f64) -> Solution {
    let solution = solve(problem);
    assert_eq!(solution.status, Status::Optimal);
    let residual = certificate(problem, &solution.x);
    assert!(residual < bound, "{residual:e}");
    solution
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn solutions_are_certified(seed: u64) {
        let problem = hierarchy(&mut Dice(seed), WILD);
        certified(&problem, 1e-8);
    }

    #[test]
    fn rows_of_very_different_size_are_certified(seed: u64) {
        let problem = hierarchy(&mut Dice(seed), Taste { decades: 4.6, weights: false, ..WILD });
        certified(&problem, 1e-7);
    }

    /// Degenerate on purpose: multipliers that are zero, bounds that just touch.
    #[test]
    fn ties_are_certified(seed: u64) {
        let problem = hierarchy(&mut Dice(seed), Taste { ties: true, ..WILD });
        certified(&problem, 1e-8);
    }

    #[test]
    fn damped_levels_are_certified(seed: u64) {
        let mut dice = Dice(seed);
        let mut problem = hierarchy(&mut dice, WILD);
        let l = dice.below(problem.levels.len());
        problem.levels[l].damping = 10_f64.powf(2.0 * dice.unit() - 2.0);
        prop_assert_eq!(certified(&problem, 1e-8).levels[l].freedom, 0);
    }

    #[test]
    fn clarabel_first_leads_to_the_same_point(seed: u64) {
        let problem = hierarchy(&mut Dice(seed), Taste { rows: 8, ..WILD });
        let direct = solve(&problem);
        let mut solution = Solution::new(&problem);
        ClarabelCascade::new(&problem).with_search_first(false).solve(&problem, &mut solution);
        prop_assert_eq!(solution.status, Status::Optimal);
        for (a, b) in solution.x.iter().zip(&direct.x) {
            prop_assert!((a - b).abs() < 1e-7 * (1.0 + a.abs()), "{:?} {:?}", solution.x, direct.x);
        }
    }
}

/// The certificate can say no: a step away from the optimum is not certified.
#[test]
fn other_points_are_not_certified() {
    for seed in 0..300 {
        let mut dice = Dice(seed);
        let problem = hierarchy(&mut dice, WILD);
        let mut x = solve(&problem).x;
        x.iter_mut().for_each(|x| *x += 0.01_f64.copysign(dice.unit()));
        let residual = certificate(&problem, &x);
        assert!(residual > 1e-7, "seed {seed}: {residual:e}");
    }
}
