//! Times the reference cascade on generated ticks of the size of the thesis's controller: 20
//! variables; 38 two-sided limits, 48 one-sided safety rows, 20 equalities (thesis 3.5.1).
//! `calm`: no inequality stops anything. `pressed`: wishes several times the limits. Each sample
//! is one solve of a sequence that drifts slowly, warm from the one before.

use divan::Bencher;
use hierarq_solver::{ClarabelCascade, HierarchicalSolver, LevelShape, Problem, Solution};

const N: usize = 20;

fn main() {
    divan::main();
}

/// Smooth pseudo-random numbers: tick `t` of signal `k`.
fn signal(k: usize, t: usize) -> f64 {
    let phase = (k as f64 * 12.9898).sin() * 43758.5453;
    (phase + 0.01 * t as f64 * (1.0 + phase.fract().abs())).sin()
}

fn tick(t: usize, wish: f64) -> Problem {
    let shape = |rows| LevelShape { rows, hard: false, damping: 0.0 };
    let mut problem = Problem::new(N, &[shape(38), shape(48), shape(20)]);
    for i in 0..38 {
        let mut row = [0.0; N];
        row[i % N] = 1.0;
        let wide = 1.0 + 0.5 * signal(i, t);
        problem.levels[0].set(i, &row, -wide, wide);
    }
    for i in 0..48 {
        let row: [f64; N] = std::array::from_fn(|j| signal(1000 + i * N + j, t));
        let room = 0.6 + 0.5 * signal(3000 + i, t);
        problem.levels[1].set(i, &row, -room, f64::INFINITY);
    }
    // 20 equalities of rank 14: two arms and a base leave freedom.
    for i in 0..20 {
        let row: [f64; N] = std::array::from_fn(|j| {
            let own = signal(5000 + (i % 14) * N + j, t);
            if i < 14 { own } else { own - signal(5000 + (i - 13) * N + j, t) }
        });
        let goal = wish * signal(9000 + i, t);
        problem.levels[2].set(i, &row, goal, goal);
    }
    problem
}

fn run(bencher: Bencher, wish: f64, warm: bool) {
    let ticks: Vec<Problem> = (0..400).map(|t| tick(t, wish)).collect();
    let mut solver = ClarabelCascade::new(&ticks[0]);
    let mut solution = Solution::new(&ticks[0]);
    let mut t = 0;
    bencher.bench_local(|| {
        if !warm {
            solver.forget();
        }
        solver.solve(&ticks[t % ticks.len()], &mut solution);
        t += 1;
        solution.x[0]
    });
}

#[divan::bench]
fn calm(bencher: Bencher) {
    run(bencher, 0.02, true);
}

#[divan::bench]
fn pressed_warm(bencher: Bencher) {
    run(bencher, 2.0, true);
}

#[divan::bench]
fn pressed_cold(bencher: Bencher) {
    run(bencher, 2.0, false);
}
