//! A solve that has no time says so and gives no answer, goes on at the next one from what it reached, and comes to the same
//! optimum as one that has all the time. The tests' deadlines have passed before the solve begins, so that the one change that
//! is always made is all there is time for: no clock decides what they see.

use crate::common;

use std::time::Instant;

use common::{Dice, Taste, WILD, hierarchy, size};
use hierarq_solver::{ActiveSet, Backend, HierarchicalSolver, Problem, Smooth, Solution, Status};
use proptest::prelude::*;

const TASTE: Taste = Taste { variables: 10, levels: 4, rows: 12, ..WILD };

fn jump(problem: &mut Problem, dice: &mut Dice, by: f64) {
    for level in &mut problem.levels {
        for i in 0..level.rows() {
            let by = by * dice.unit();
            level.lower[i] += by;
            level.upper[i] += by;
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Again and again without time on the same problem: in the end there is an answer, the right one.
    #[test]
    fn a_late_solve_goes_on_at_the_next_one(seed: u64, by in 0.01..2.0) {
        let mut dice = Dice(seed);
        let mut problem = hierarchy(&mut dice, TASTE);
        let mut solver = ActiveSet::new(&problem);
        let mut solution = Solution::new(&problem);
        for _ in 0..4 {
            let mut expected = Solution::new(&problem);
            ActiveSet::new(&problem).solve(&problem, &mut expected);
            prop_assert_eq!(expected.status, Status::Optimal);
            solver.set_deadline(Some(Instant::now()));
            let mut solves = 0;
            while solves == 0 || matches!(solution.status, Status::OutOfTime { .. }) {
                let before = solver.effort();
                solver.solve(&problem, &mut solution);
                solves += 1;
                prop_assert!(solves < 400, "no answer after {} solves", solves);
                if matches!(solution.status, Status::OutOfTime { .. }) {
                    prop_assert!(solver.effort().changes > before.changes, "no step forward");
                    prop_assert_eq!(solver.effort().late, before.late + 1);
                }
            }
            prop_assert_eq!(solution.status, Status::Optimal);
            for (x, y) in solution.x.iter().zip(&expected.x) {
                prop_assert!((x - y).abs() < 1e-8 * size(&expected.x), "{} {}", x, y);
            }
            jump(&mut problem, &mut dice, by);
        }
    }

    /// A problem that moves all the time, mostly without time for it: whenever there is an answer it is the right one.
    #[test]
    fn an_answer_between_late_ones_is_right(seed: u64, by in 0.001..0.5) {
        let mut dice = Dice(seed);
        let mut problem = hierarchy(&mut dice, TASTE);
        let mut solver = ActiveSet::new(&problem);
        let (mut solution, mut expected) = (Solution::new(&problem), Solution::new(&problem));
        for tick in 0..30 {
            solver.set_deadline((tick % 4 != 3).then(Instant::now));
            solver.solve(&problem, &mut solution);
            if tick % 4 == 3 {
                prop_assert_eq!(solution.status, Status::Optimal);
            }
            if solution.status == Status::Optimal {
                ActiveSet::new(&problem).solve(&problem, &mut expected);
                for (x, y) in solution.x.iter().zip(&expected.x) {
                    prop_assert!((x - y).abs() < 1e-8 * size(&expected.x), "{} {}", x, y);
                }
            } else {
                let late = matches!(solution.status, Status::OutOfTime { .. });
                prop_assert!(late, "{:?}", solution.status);
            }
            jump(&mut problem, &mut dice, by);
        }
    }
}

/// One that needs no change is never late; a smooth hierarchy says that it is late as well.
#[test]
fn a_solve_without_a_change_is_never_late() {
    let mut dice = Dice(7);
    let problem = loop {
        let problem = hierarchy(&mut dice, TASTE);
        let mut solution = Solution::new(&problem);
        let mut solver = ActiveSet::new(&problem);
        solver.set_deadline(Some(Instant::now()));
        solver.solve(&problem, &mut solution);
        if matches!(solution.status, Status::OutOfTime { .. }) {
            break problem;
        }
    };
    let mut solution = Solution::new(&problem);
    let mut solver = ActiveSet::new(&problem);
    solver.solve(&problem, &mut solution);
    assert_eq!(solution.status, Status::Optimal);
    solver.set_deadline(Some(Instant::now()));
    solver.solve(&problem, &mut solution);
    assert_eq!(solution.status, Status::Optimal);
    let mut smooth = Smooth::new(&problem, Backend::ActiveSet);
    smooth.set_deadline(Some(Instant::now()));
    smooth.solve(&problem, &mut solution);
    assert!(matches!(solution.status, Status::OutOfTime { .. }));
}
