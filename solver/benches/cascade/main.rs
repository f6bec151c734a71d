//! Times the solvers on generated ticks that drift slowly, each warm from the one before unless
//! it says cold.
//!
//! The problem of the thesis's controller (thesis 3.5.1) has 20 variables, 38 two-sided limits,
//! 48 one-sided safety rows and 20 equalities of rank 14. `CALM`: no inequality stops anything.
//! `PRESSED`: wishes several times the limits, so that limits are reached and levels conflict.
//! Then the same kind of problem with other numbers of variables, rows and levels.

mod textbook;

use divan::Bencher;
use hierarq_solver::{ActiveSet, ClarabelCascade, HierarchicalSolver, LevelShape, Problem, Solution};

const CALM: f64 = 0.02;
const PRESSED: f64 = 2.0;
const TICKS: usize = 400;

fn main() {
    divan::main();
}

/// Smooth pseudo-random numbers: tick `t` of signal `k`.
fn signal(k: usize, t: usize) -> f64 {
    let phase = (k as f64 * 12.9898).sin() * 43758.5453;
    (phase + 0.01 * t as f64 * (1.0 + phase.fract().abs())).sin()
}

/// Size of a problem: variables, two-sided limits, safety rows, equalities, and over how many
/// levels each of the last two is spread.
#[derive(Clone, Copy)]
struct Size {
    n: usize,
    limits: usize,
    safety: usize,
    equalities: usize,
    levels: usize,
}

const THESIS: Size = Size { n: 20, limits: 38, safety: 48, equalities: 20, levels: 3 };

fn tick(size: Size, t: usize, wish: f64) -> Problem {
    let Size { n, limits, safety, equalities, levels } = size;
    let shape = |rows| LevelShape { rows, hard: false, damping: 0.0 };
    let tasks = levels - 2;
    let share = |k: usize| equalities / tasks + usize::from(k < equalities % tasks);
    let shapes: Vec<LevelShape> = [limits, safety].into_iter().chain((0..tasks).map(share)).map(shape).collect();
    let mut problem = Problem::new(n, &shapes);
    let mut row = vec![0.0; n];
    for i in 0..limits {
        row.fill(0.0);
        row[i % n] = 1.0;
        let wide = 1.0 + 0.5 * signal(i, t);
        problem.levels[0].set(i, &row, -wide, wide);
    }
    for i in 0..safety {
        row.iter_mut().enumerate().for_each(|(j, r)| *r = signal(1000 + i * n + j, t));
        let room = 0.6 + 0.5 * signal(300_000 + i, t);
        problem.levels[1].set(i, &row, -room, f64::INFINITY);
    }
    // Seven tenths of the equalities are independent: two arms and a base leave freedom.
    let rank = (7 * equalities).div_ceil(10);
    let mut e = 0;
    for k in 0..tasks {
        for i in 0..share(k) {
            row.iter_mut().enumerate().for_each(|(j, r)| {
                let own = signal(500_000 + (e % rank) * n + j, t);
                *r = if e < rank { own } else { own - signal(500_000 + (e + 1 - rank) * n + j, t) };
            });
            let goal = wish * signal(900_000 + e, t);
            problem.levels[2 + k].set(i, &row, goal, goal);
            e += 1;
        }
    }
    problem
}

fn run(bencher: Bencher, size: Size, wish: f64, mut solver: impl HierarchicalSolver) {
    let ticks: Vec<Problem> = (0..TICKS).map(|t| tick(size, t, wish)).collect();
    let mut solution = Solution::new(&ticks[0]);
    let mut t = 0;
    bencher.bench_local(|| {
        solver.solve(&ticks[t % TICKS], &mut solution);
        t += 1;
        solution.x[0]
    });
}

fn active_set(size: Size, warm: bool) -> ActiveSet {
    ActiveSet::new(&tick(size, 0, CALM)).with_warm_start(warm)
}

mod thesis {
    use super::*;

    const WISHES: [f64; 2] = [CALM, PRESSED];

    #[divan::bench(args = WISHES)]
    fn active_set_warm(bencher: Bencher, wish: f64) {
        run(bencher, THESIS, wish, active_set(THESIS, true));
    }

    #[divan::bench(args = WISHES)]
    fn active_set_cold(bencher: Bencher, wish: f64) {
        run(bencher, THESIS, wish, active_set(THESIS, false));
    }

    #[divan::bench(args = WISHES)]
    fn reference_cascade(bencher: Bencher, wish: f64) {
        run(bencher, THESIS, wish, ClarabelCascade::new(&tick(THESIS, 0, CALM)));
    }

    /// One quadratic program in the point and all slacks for every level, by Clarabel.
    #[divan::bench(args = WISHES, sample_count = 30, sample_size = 1)]
    fn textbook_cascade(bencher: Bencher, wish: f64) {
        run(bencher, THESIS, wish, textbook::Textbook);
    }

    /// One quadratic program by Clarabel for every level, in what the levels above leave free.
    #[divan::bench(args = WISHES, sample_count = 30, sample_size = 1)]
    fn clarabel_every_level(bencher: Bencher, wish: f64) {
        run(bencher, THESIS, wish, ClarabelCascade::new(&tick(THESIS, 0, CALM)).with_search_first(false));
    }
}

mod scaling {
    use super::*;

    /// All row counts in proportion to the variables.
    #[divan::bench(args = [7, 19, 40, 80], consts = [false, true])]
    fn variables<const PRESS: bool>(bencher: Bencher, n: usize) {
        let size = Size { n, limits: 2 * n, safety: 5 * n / 2, equalities: n, levels: 3 };
        run(bencher, size, if PRESS { PRESSED } else { CALM }, active_set(size, true));
    }

    #[divan::bench(args = [20, 50, 100, 200, 400], consts = [false, true])]
    fn safety_rows<const PRESS: bool>(bencher: Bencher, safety: usize) {
        let size = Size { safety, ..THESIS };
        run(bencher, size, if PRESS { PRESSED } else { CALM }, active_set(size, true));
    }

    #[divan::bench(args = [3, 4, 5, 6], consts = [false, true])]
    fn levels<const PRESS: bool>(bencher: Bencher, levels: usize) {
        let size = Size { levels, ..THESIS };
        run(bencher, size, if PRESS { PRESSED } else { CALM }, active_set(size, true));
    }
}
