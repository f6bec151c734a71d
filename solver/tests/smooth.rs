//! Smooth levels: what can be met is met exactly, what cannot is damped without a jump, levels below keep their freedom
//! and take next to nothing from those above, and both backends agree.

use crate::common;

use common::{Dice, Taste, WILD, hierarchy};
use hierarq_solver::{
    ActiveSet, Backend, ClarabelCascade, HierarchicalSolver, LevelShape, LevelStatus, Problem, Smooth, Solution,
    Status, certificate, smooth,
};
use proptest::prelude::*;

/// Two-link arm: links of 0.4 and 0.3 m, angles from the x axis; the tip's position and its Jacobian.
fn tip(q: &[f64; 2]) -> ([f64; 2], [[f64; 2]; 2]) {
    let (a, b) = (q[0], q[0] + q[1]);
    let p = [0.4 * a.cos() + 0.3 * b.cos(), 0.4 * a.sin() + 0.3 * b.sin()];
    let second = [-0.3 * b.sin(), 0.3 * b.cos()];
    (p, [[-p[1], second[0]], [p[0], second[1]]])
}

/// Bounds of the second derivatives of both rows: levers of 0.7 and 0.3 m, over 0.04 s.
fn curvature(rows: usize) -> Vec<f64> {
    (0..rows).flat_map(|_| [0.04 * (0.7 + 0.3), 0.04 * (0.3 + 0.3)]).collect()
}

/// A hierarchy of speed limits, the tip to a target at 2 /s, and a posture at 2 /s.
fn arm(curved: bool) -> Problem {
    let shape = |rows, hard| LevelShape { rows, hard, damping: 0.0 };
    let mut problem = Problem::new(2, &[shape(2, true), shape(2, false), shape(2, false)]);
    for j in 0..2 {
        problem.levels[0].row_mut(j)[j] = 1.0;
        (problem.levels[0].lower[j], problem.levels[0].upper[j]) = (-2.0, 2.0);
        problem.levels[2].row_mut(j)[j] = 1.0;
    }
    if curved {
        problem.levels[1].set_curvature(curvature(2));
    }
    problem
}

fn ask(problem: &mut Problem, q: &[f64; 2], target: [f64; 2], posture: [f64; 2]) {
    let (p, jacobian) = tip(q);
    for i in 0..2 {
        let wanted = 2.0 * (target[i] - p[i]);
        problem.levels[1].set(i, &jacobian[i], wanted, wanted);
        let wanted = 2.0 * (posture[i] - q[i]);
        (problem.levels[2].lower[i], problem.levels[2].upper[i]) = (wanted, wanted);
    }
}

/// Velocities of a closed loop of ten seconds, and where it ends.
fn closed_loop(
    solver: &mut dyn HierarchicalSolver,
    curved: bool,
    target: [f64; 2],
    period: f64,
) -> (Vec<[f64; 2]>, [f64; 2]) {
    let mut problem = arm(curved);
    let mut solution = Solution::new(&problem);
    let (mut q, mut all) = ([0.3, 1.2], Vec::new());
    for _ in 0..(10.0 / period) as usize {
        ask(&mut problem, &q, target, [0.3, 1.2]);
        solver.solve(&problem, &mut solution);
        assert_eq!(solution.status, Status::Optimal);
        let v = [solution.x[0], solution.x[1]];
        q = [q[0] + period * v[0], q[1] + period * v[1]];
        all.push(v);
    }
    (all, q)
}

/// Number of times that a velocity reverses from more than 0.02 rad/s.
fn turns(velocities: &[[f64; 2]]) -> usize {
    let turned = |w: &[[f64; 2]]| (0..2).any(|j| w[0][j] * w[1][j] < 0.0 && (w[0][j] - w[1][j]).abs() > 0.02);
    velocities.windows(2).filter(|w| turned(w)).count()
}

#[test]
fn a_stretched_arm_comes_to_rest_at_the_nearest_point() {
    let fresh =
        |problem: &Problem, period: f64| Smooth::new(problem, Backend::ActiveSet).with_fading((-period / 0.1).exp());
    for period in [0.001, 0.002, 0.01, 0.02] {
        for (x, y) in [(1.5, 0.0), (0.72, 0.0), (0.0, 3.0), (-0.5, -0.55)] {
            let (velocities, q) = closed_loop(&mut fresh(&arm(true), period), true, [x, y], period);
            assert!(turns(&velocities) <= 2, "{} turns at ({x}, {y}), {period} s", turns(&velocities));
            // The nearest point is at 0.7 m, in the direction of the target.
            let (p, far) = (tip(&q).0, f64::hypot(x, y));
            let nearest = [0.7 * x / far, 0.7 * y / far];
            assert!(f64::hypot(p[0] - nearest[0], p[1] - nearest[1]) < 1e-3, "{p:?} is not {nearest:?}, {period} s");
            let last = velocities.last().expect("there are ticks");
            assert!(last.iter().all(|v| v.abs() < 1e-3), "at rest: {last:?}");
        }
    }
    // Without damping it is the chattering that this is about.
    let problem = arm(false);
    let (velocities, _) = closed_loop(&mut ActiveSet::new(&problem), false, [1.5, 0.0], 0.002);
    assert!(turns(&velocities) > 1000, "{}", turns(&velocities));
}

#[test]
fn a_level_that_is_not_to_be_damped_is_exact() {
    let problem = arm(true);
    let mut exact = Smooth::new(&problem, Backend::ActiveSet).with_exact(1).with_exact(2);
    let (velocities, _) = closed_loop(&mut exact, true, [1.5, 0.0], 0.002);
    assert_eq!(velocities, closed_loop(&mut ActiveSet::new(&problem), true, [1.5, 0.0], 0.002).0);
}

/// Two levels that ask the tip and the elbow for what cannot be: the one above does not give way by more than the slack.
#[test]
fn a_level_below_a_damped_one_takes_next_to_nothing_from_it() {
    let mut problem = arm(true);
    ask(&mut problem, &[0.0, 0.02], [2.0, 0.3], [0.0, 1.5]);
    let mut solution = Solution::new(&problem);
    Smooth::new(&problem, Backend::ActiveSet).solve(&problem, &mut solution);
    let with: Vec<f64> = solution.levels[1].slack.clone();
    let mut alone = problem.clone();
    alone.levels[2].clear();
    let mut of_alone = Solution::new(&alone);
    Smooth::new(&alone, Backend::ActiveSet).solve(&alone, &mut of_alone);
    assert_eq!(of_alone.levels[1].status, LevelStatus::Relaxed);
    for (a, b) in with.iter().zip(&of_alone.levels[1].slack) {
        assert!((a - b).abs() <= 2.0 * smooth::SLACK, "{a} and {b}");
    }
}

/// Levels below a damped level use the freedom that it does not need, with damping by hand too.
#[test]
fn a_posture_below_a_damped_level_moves() {
    for damping in [0.0, 0.1] {
        let shape = |rows, damping| LevelShape { rows, hard: false, damping };
        let mut problem = Problem::new(3, &[shape(2, damping), shape(3, 0.0)]);
        problem.levels[0].set(0, &[1.0, 1.0, 0.0], 1.0, 1.0);
        problem.levels[0].set(1, &[1.0, 1.0, 0.0], 2.0, 2.0);
        problem.levels[0].set_curvature(vec![0.1, 0.1, 0.0, 0.1, 0.1, 0.0]);
        for j in 0..3 {
            problem.levels[1].row_mut(j)[j] = 1.0;
            (problem.levels[1].lower[j], problem.levels[1].upper[j]) = (0.5, 0.5);
        }
        let mut solution = Solution::new(&problem);
        Smooth::new(&problem, Backend::ActiveSet).solve(&problem, &mut solution);
        // But for the least damping that every variable has, a millionth of the greatest.
        assert!((solution.x[2] - 0.5).abs() < 0.5e-6, "the third variable is free: {:?}", solution.x);
        // The residuals of the rows and the damping balance: (x + y) (1 + D/2) = 1.5, with D of what remains, 0.5 each.
        let d = if damping > 0.0 { damping } else { 0.1 * 0.5_f64.hypot(0.5) };
        let sum = 3.0 / (2.0 + 0.5 * d);
        assert!((solution.x[0] + solution.x[1] - sum).abs() < 2.0 * smooth::SLACK, "{:?}, {sum}", solution.x);
    }
}

/// A curved row `x + y = 1` above a posture (0.6, -0.6, 1) for (x, y, z): 0.5 of each of x and y remain, and the row bears them.
fn posture_below(curvature: f64) -> Problem {
    let shape = |rows| LevelShape { rows, hard: false, damping: 0.0 };
    let mut problem = Problem::new(3, &[shape(1), shape(3)]);
    problem.levels[0].set(0, &[1.0, 1.0, 0.0], 1.0, 1.0);
    problem.levels[0].set_curvature(vec![curvature, curvature, 0.0]);
    for (j, asks) in [0.6, -0.6, 1.0].into_iter().enumerate() {
        problem.levels[1].row_mut(j)[j] = 1.0;
        (problem.levels[1].lower[j], problem.levels[1].upper[j]) = (asks, asks);
    }
    problem
}

#[test]
fn a_posture_is_damped_alike_as_rows_and_as_bounds() {
    let mut open = posture_below(4.0);
    let mut fixed = open.clone();
    fixed.levels[1].fix(0..3);
    for problem in [&mut open, &mut fixed] {
        problem.levels[1].weight[1] = 2.0;
    }
    let solved = |problem: &Problem| {
        let mut solver = Smooth::new(problem, Backend::ActiveSet);
        let mut solution = Solution::new(problem);
        solver.solve(problem, &mut solution);
        assert!(solver.is_damped(1));
        solution.x
    };
    let (a, b) = (solved(&open), solved(&fixed));
    assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-9), "{a:?} and {b:?}");
    // The least (x - 0.6)^2 + 2 (y + 0.6)^2 + D_x x^2 + D_y y^2 with x + y = 1. Without D the row bears 2/3.
    let bears = 4.0 * 2.0 / 3.0;
    let (dx, dy) = (bears - 0.1, bears - 0.2);
    let x = (0.6 + 2.0 * 1.6 + dy) / (3.0 + dx + dy);
    assert!((a[0] - x).abs() < 1e-5 && (a[0] + a[1] - 1.0).abs() < 1e-9, "{a:?}, {x}");
}

#[test]
fn a_posture_stiffer_than_its_damping_is_exact() {
    let solved = |curvature: f64| {
        let problem = posture_below(curvature);
        let mut solver = Smooth::new(&problem, Backend::ActiveSet);
        let (mut solution, mut exact) = (Solution::new(&problem), Solution::new(&problem));
        solver.solve(&problem, &mut solution);
        ActiveSet::new(&problem).solve(&problem, &mut exact);
        (solver.is_damped(1), solution.x == exact.x)
    };
    // The row bears 0.5: the damping is half the curvature, and a tenth of the weights is the limit.
    assert_eq!(solved(0.19), (false, true));
    assert_eq!(solved(0.21), (true, false));
}

const CALM: Taste = Taste { dependent: 0.3, ..WILD };

/// Random bounds of second derivatives on the soft levels.
fn curved(seed: u64) -> Problem {
    let mut dice = Dice(seed);
    let mut problem = hierarchy(&mut dice, CALM);
    let n = problem.n;
    for level in problem.levels.iter_mut().filter(|l| !l.hard) {
        level.damping = 0.0;
        level.set_curvature((0..level.rows() * n).map(|_| 0.05 * dice.unit().abs()).collect());
    }
    problem
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// The answer is the exact optimum of the settled problem, and of the problem itself where all levels can be met.
    #[test]
    fn what_can_be_met_is_met_exactly(seed: u64) {
        let problem = curved(seed);
        let (mut exact, mut solution) = (Solution::new(&problem), Solution::new(&problem));
        ActiveSet::new(&problem).solve(&problem, &mut exact);
        let mut solver = Smooth::new(&problem, Backend::ActiveSet);
        solver.solve(&problem, &mut solution);
        prop_assert_eq!(solution.status == Status::Optimal, exact.status == Status::Optimal);
        if exact.status != Status::Optimal {
            return Ok(());
        }
        let size = 1.0 + solution.x.iter().map(|x| x * x).sum::<f64>().sqrt();
        match solver.settled() {
            None => prop_assert_eq!(&solution.x, &exact.x),
            Some(settled) => prop_assert!(certificate(settled, &solution.x) < 1e-7 * size),
        }
        // Damping takes from what a level reaches and never gives, and never touches the first level that can be met.
        let first = (0..problem.levels.len()).find(|l| solver.is_damped(*l)).unwrap_or(problem.levels.len());
        for l in 0..first {
            prop_assert!((solution.levels[l].violation - exact.levels[l].violation).abs() < 1e-7 * size);
        }
        if first < problem.levels.len() {
            prop_assert!(solution.levels[first].violation > exact.levels[first].violation - 1e-7 * size);
        }
    }

    /// A solver that shares nothing finds the same for every problem that was solved on the way.
    #[test]
    fn both_backends_agree(seed: u64) {
        let problem = curved(seed);
        let mut solution = Solution::new(&problem);
        let mut solver = Smooth::new(&problem, Backend::ActiveSet);
        solver.solve(&problem, &mut solution);
        if solution.status != Status::Optimal {
            return Ok(());
        }
        let last = std::iter::once((solver.settled().unwrap_or(&problem), &solution.x));
        for (problem, x) in last.chain(solver.damped().map(|(_, problem, solution)| (problem, &solution.x))) {
            let mut other = Solution::new(problem);
            ClarabelCascade::new(problem).solve(problem, &mut other);
            prop_assert_eq!(other.status, Status::Optimal);
            let size = 1.0 + x.iter().map(|x| x * x).sum::<f64>().sqrt();
            let far = x.iter().zip(&other.x).fold(0.0_f64, |d, (a, b)| d.max((a - b).abs()));
            prop_assert!(far < 1e-6 * size, "{}", far);
        }
    }
}
