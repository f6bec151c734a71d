//! The cascade as textbooks have it: at every level one quadratic program in the point and a slack for each row, the
//! slacks of the levels above fixed, and a small weight on the point so that the program has one solution. It is not
//! exact; it is what a strict hierarchy costs with a good general solver and no idea of the problem.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SupportedConeT, ZeroConeT};
use hierarq_solver::{HierarchicalSolver, Level, Problem, Solution};

/// Weight of the point against the slacks.
const REGULAR: f64 = 1e-6;

pub struct Textbook;

/// One row `coefficients z (= or <=) bound` of a program in `z = (x, s)`.
struct Row {
    coefficients: Vec<(usize, f64)>,
    bound: f64,
    equal: bool,
}

/// The rows of a level; `slack(i)` is the slack of row `i`: a variable of the program, or a number that is known.
fn rows(level: &Level, n: usize, known: Option<&[f64]>, out: &mut Vec<Row>) {
    for i in 0..level.rows() {
        let (lower, upper) = (level.lower[i], level.upper[i]);
        let mut side = |sign: f64, bound: f64, equal: bool| {
            let mut coefficients: Vec<(usize, f64)> =
                level.row(i).iter().enumerate().filter(|(_, a)| **a != 0.0).map(|(j, a)| (j, sign * a)).collect();
            let fixed = known.map_or(0.0, |s| sign * s[i]);
            if known.is_none() {
                coefficients.push((n + i, -sign));
            }
            out.push(Row { coefficients, bound: sign * bound + fixed, equal });
        };
        if lower == upper {
            side(1.0, upper, true);
        } else {
            if upper.is_finite() {
                side(1.0, upper, false);
            }
            if lower.is_finite() {
                side(-1.0, lower, false);
            }
        }
    }
}

impl HierarchicalSolver for Textbook {
    fn name(&self) -> &'static str {
        "textbook"
    }

    fn solve_first(&mut self, problem: &Problem, levels: usize, solution: &mut Solution) {
        let n = problem.n;
        let mut slacks: Vec<Vec<f64>> = Vec::new();
        for level in &problem.levels[..levels] {
            let size = n + level.rows();
            let mut list = Vec::new();
            for (above, slack) in problem.levels.iter().zip(&slacks) {
                rows(above, n, Some(slack), &mut list);
            }
            rows(level, n, None, &mut list);
            list.sort_by_key(|r| !r.equal);
            let equal = list.iter().filter(|r| r.equal).count();
            let entries = list.iter().enumerate().flat_map(|(i, r)| r.coefficients.iter().map(move |c| (i, c.0, c.1)));
            let (mut i, mut j, mut v) = (Vec::new(), Vec::new(), Vec::new());
            for (row, column, value) in entries {
                i.push(row);
                j.push(column);
                v.push(value);
            }
            let a = CscMatrix::new_from_triplets(list.len(), size, i, j, v);
            let weight = (0..size).map(|k| if k < n { REGULAR } else { level.weight[k - n] }).collect();
            let p = CscMatrix::new_from_triplets(size, size, (0..size).collect(), (0..size).collect(), weight);
            let bounds: Vec<f64> = list.iter().map(|r| r.bound).collect();
            let cones: [SupportedConeT<f64>; 2] = [ZeroConeT(equal), NonnegativeConeT(list.len() - equal)];
            let settings = DefaultSettings { verbose: false, ..DefaultSettings::default() };
            let mut solver =
                DefaultSolver::new(&p, &vec![0.0; size], &a, &bounds, &cones, settings).expect("its form is right");
            solver.solve();
            let z = &solver.solution.x;
            solution.x.copy_from_slice(&z[..n]);
            slacks.push(z[n..].to_vec());
        }
    }
}
