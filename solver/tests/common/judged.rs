//! Degenerate hierarchies from any bytes, and what is wrong with an answer: for the fuzzer and for tests.

use hierarq_solver::{ActiveSet, HierarchicalSolver, LevelShape, Problem, Smooth, Solution, Status, certificate};

/// An answer is proven up to this, and to the rounding of the largest row's value.
const PROVEN: f64 = 1e-7;
const ROUNDING: f64 = 1e-14;

fn proven(problem: &Problem, solution: &Solution, by: f64) -> f64 {
    let norms = problem.levels.iter().flat_map(|level| {
        (0..level.rows()).map(move |i| (level.weight[i] * level.row(i).iter().map(|a| a * a).sum::<f64>()).sqrt())
    });
    let far = 1.0 + solution.x.iter().map(|x| x * x).sum::<f64>().sqrt();
    by + ROUNDING * far * norms.fold(1.0, f64::max)
}

/// Returns the first error of an answer, if it has one.
pub fn wrong(problem: &Problem, solution: &Solution) -> Option<String> {
    wrong_by(problem, solution, PROVEN)
}

/// The same with another residual that an answer may have.
pub fn wrong_by(problem: &Problem, solution: &Solution, by: f64) -> Option<String> {
    match solution.status {
        Status::Optimal => {
            let residual = certificate(problem, &solution.x);
            (residual > proven(problem, solution, by)).then(|| format!("certificate {residual:.1e}"))
        }
        Status::Infeasible { level } => {
            // The levels above it are at their optimum.
            let mut above = problem.clone();
            for below in &mut above.levels[level..] {
                below.lower.fill(f64::NEG_INFINITY);
                below.upper.fill(f64::INFINITY);
                below.damping = 0.0;
            }
            let residual = certificate(&above, &solution.x);
            (residual > proven(problem, solution, by))
                .then(|| format!("certificate {residual:.1e} above level {level}"))
        }
        status => Some(format!("{status:?}")),
    }
}

/// Bytes, one after the other; zeros behind the last.
struct Bytes<'a>(std::slice::Iter<'a, u8>);

impl Bytes<'_> {
    fn next(&mut self) -> usize {
        self.0.next().map_or(0, |b| usize::from(*b))
    }

    fn of<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.next() % choices.len()]
    }
}

const COEFFICIENTS: [f64; 16] =
    [0.0, 0.0, 0.0, 1.0, 1.0, -1.0, 2.0, -2.0, 0.5, 3.0, -3.0, 1e-16, -3e-16, 0.3, -0.7, 1.1];
const BOUNDS: [f64; 8] = [0.0, 0.0, 1.0, -1.0, 2.0, -3.0, 0.25, 1e-16];
const WEIGHTS: [f64; 6] = [1.0, 1.0, 1.0, 0.0, 100.0, 0.01];
const DAMPINGS: [f64; 8] = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.1, 1.0];

/// Hierarchies of up to six variables and four levels, of one shape, each with bounds of its own.
pub fn problems(data: &[u8]) -> Vec<Problem> {
    let mut bytes = Bytes(data.iter());
    let n = 1 + bytes.next() % 6;
    let levels = 1 + bytes.next() % 4;
    let shapes: Vec<LevelShape> = (0..levels)
        .map(|_| {
            let (rows, hard) = (1 + bytes.next() % 6, bytes.next() % 5 == 4);
            LevelShape { rows, hard, damping: if hard { 0.0 } else { bytes.of(&DAMPINGS) } }
        })
        .collect();
    let mut first = Problem::new(n, &shapes);
    for level in &mut first.levels {
        for i in 0..level.rows() {
            level.row_mut(i).iter_mut().for_each(|a| *a = bytes.of(&COEFFICIENTS));
            level.weight[i] = bytes.of(&WEIGHTS);
        }
        if bytes.next() % 2 == 1 {
            level.fix(0..level.rows());
        }
    }
    let mut with_bounds = || {
        let mut problem = first.clone();
        for level in &mut problem.levels {
            for i in 0..level.rows() {
                let (kind, bound) = (bytes.next() % 4, bytes.of(&BOUNDS));
                (level.lower[i], level.upper[i]) = match kind {
                    0 => (bound, bound),
                    1 => (f64::NEG_INFINITY, bound),
                    2 => (bound, f64::INFINITY),
                    _ => (bound, bound + 1.0),
                };
            }
        }
        problem
    };
    (0..3).map(|_| with_bounds()).collect()
}

/// Solves hierarchies from any bytes, from nothing and from the one before, exact and smooth. Panics where an answer of the exact
/// solver is called optimal without a proof, or where there is none.
pub fn check(data: &[u8]) {
    let problems = problems(data);
    let mut warm = ActiveSet::new(&problems[0]);
    let mut smooth = Smooth::new(&problems[0], hierarq_solver::Backend::ActiveSet);
    let mut solution = Solution::new(&problems[0]);
    for problem in &problems {
        for (how, solver) in [("cold", &mut ActiveSet::new(problem)), ("warm", &mut warm)] {
            solver.solve(problem, &mut solution);
            if let Some(wrong) = wrong(problem, &solution) {
                panic!("{how}: {wrong}\n{problem:?}");
            }
        }
        smooth.solve(problem, &mut solution);
        // Rows of damping are of size one: beside them rows of rounding size are rows of zeros.
        let coefficients = problem.levels.iter().flat_map(|l| (0..l.rows()).flat_map(|i| l.row(i)));
        if coefficients.fold(0.0_f64, |most, a| most.max(a.abs())) < 0.1 {
            continue;
        }
        assert!(!matches!(solution.status, Status::Failed { .. }), "smooth: {:?}\n{problem:?}", solution.status);
    }
}
