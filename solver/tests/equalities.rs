//! Hierarchies of equalities only, against the null-space recursion of thesis (2.11).

use crate::common;

use common::{Dice, Taste, hierarchy, recursion, solve, system};
use hierarq_solver::Status;
use proptest::prelude::*;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    #[test]
    fn the_null_space_recursion_gives_the_same(seed: u64) {
        let mut dice = Dice(seed);
        let mut problem = hierarchy(&mut dice, Taste {
            variables: 10, levels: 4, rows: 4, equalities: 1.0, dependent: 0.3, decades: 0.0, weights: true, ties: false,
        });
        let reference: Vec<f64> = (0..problem.n).map(|_| dice.unit()).collect();
        problem.reference.copy_from_slice(&reference);
        let levels: Vec<_> = (0..problem.levels.len())
            .map(|l| {
                let level = &problem.levels[l];
                let rows: Vec<(usize, f64)> = (0..level.rows()).map(|i| (i, level.lower[i])).collect();
                system(&problem, l, &rows)
            })
            .collect();
        let Some(expected) = recursion(&reference, &levels) else { return Err(TestCaseError::reject("rank unclear")) };
        let solution = solve(&problem);
        prop_assert_eq!(solution.status, Status::Optimal);
        for (found, expected) in solution.x.iter().zip(expected.iter()) {
            prop_assert!((found - expected).abs() < 1e-8 * (1.0 + expected.abs()), "{found} {expected}");
        }
    }
}
