//! Random hierarchies, and the oracle for those of equalities: the null-space recursion.

pub mod judged;

use hierarq_solver::{ClarabelCascade, HierarchicalSolver, LevelShape, Problem, Solution};
use nalgebra::{DMatrix, DVector};

/// A small generator of numbers (SplitMix64), so that a failing case is one seed.
pub struct Dice(pub u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in [-1, 1).
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// 0..n
    pub fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < 2.0 * p - 1.0
    }
}

/// 1 + |x|: what the rounding errors of a solution are measured against. A hierarchy that is nearly dependent has
/// solutions and violations in the thousands.
pub fn size(x: &[f64]) -> f64 {
    1.0 + x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Parameters of random hierarchies.
#[derive(Clone, Copy)]
pub struct Taste {
    pub variables: usize,
    pub levels: usize,
    pub rows: usize,
    pub equalities: f64,
    /// Rows that are combinations of earlier rows, or zero.
    pub dependent: f64,
    /// Rows are scaled by 10^-s .. 10^s.
    pub decades: f64,
    pub weights: bool,
    /// Small whole numbers everywhere: rows that meet in one point, bounds that just touch.
    pub ties: bool,
}

/// Dependent rows, contradictions and weights.
pub const WILD: Taste = Taste {
    variables: 12,
    levels: 4,
    rows: 14,
    equalities: 0.25,
    dependent: 0.2,
    decades: 0.0,
    weights: true,
    ties: false,
};

/// A random hierarchy with bounds that often contradict each other.
pub fn hierarchy(dice: &mut Dice, taste: Taste) -> Problem {
    let n = 1 + dice.below(taste.variables);
    let shapes: Vec<LevelShape> = (0..1 + dice.below(taste.levels))
        .map(|_| LevelShape { rows: 1 + dice.below(taste.rows), hard: false, damping: 0.0 })
        .collect();
    let mut problem = Problem::new(n, &shapes);
    let mut earlier: Vec<Vec<f64>> = Vec::new();
    for level in &mut problem.levels {
        let decades = taste.decades * dice.unit();
        for i in 0..level.rows() {
            let mut row: Vec<f64> = (0..n).map(|_| dice.unit()).collect();
            if dice.chance(taste.dependent) {
                match dice.below(4) {
                    0 => row.fill(0.0),
                    1 => row.iter_mut().skip(1).for_each(|r| *r = 0.0),
                    _ if earlier.is_empty() => {}
                    _ => {
                        let a = &earlier[dice.below(earlier.len())];
                        let b = &earlier[dice.below(earlier.len())];
                        row = a.iter().zip(b).map(|(a, b)| a - 0.5 * b).collect();
                    }
                }
            }
            if taste.ties {
                row.iter_mut().for_each(|r| *r = (1.4 * *r).round());
            }
            earlier.push(row.clone());
            let scale = 10_f64.powf(decades + 0.3 * taste.decades * dice.unit());
            row.iter_mut().for_each(|r| *r *= scale);
            let whole = |x: f64| if taste.ties { (1.5 * x).round() } else { x };
            let center = whole(dice.unit());
            let (lower, upper) = if dice.chance(taste.equalities) {
                (center, center)
            } else {
                let width = whole(dice.unit().abs());
                match dice.below(3) {
                    0 => (center - width, center + width),
                    1 => (f64::NEG_INFINITY, center),
                    _ => (center, f64::INFINITY),
                }
            };
            level.set(i, &row, lower * scale, upper * scale);
            if taste.weights {
                level.weight[i] = 10_f64.powf(dice.unit());
            }
        }
    }
    problem
}

pub fn solve(problem: &Problem) -> Solution {
    let mut solution = Solution::new(problem);
    ClarabelCascade::new(problem).solve(problem, &mut solution);
    solution
}

/// `A^+`, from the eigenvalues of `A A^T`; `None` if a singular value is neither zero nor well
/// away from it, so that the rank is anybody's guess.
fn pseudo_inverse(a: &DMatrix<f64>) -> Option<DMatrix<f64>> {
    let eigen = (a * a.transpose()).symmetric_eigen();
    let mut inverse = eigen.eigenvalues.clone();
    for e in inverse.iter_mut() {
        *e = match *e {
            e if e.abs() < 1e-12 => 0.0,
            e if e > 1e-3 => 1.0 / e,
            _ => return None,
        };
    }
    let u = &eigen.eigenvectors;
    Some(a.transpose() * u * DMatrix::from_diagonal(&inverse) * u.transpose())
}

/// The hierarchy of equalities `A_k x = b_k` by null-space projection, thesis (2.11):
/// `x += (A_k N)^+ (b_k - A_k x)`, `N -= (A_k N)^+ A_k N`, from `x = start`.
pub fn recursion(start: &[f64], levels: &[(DMatrix<f64>, DVector<f64>)]) -> Option<DVector<f64>> {
    let n = start.len();
    let mut x = DVector::from_column_slice(start);
    let mut null = DMatrix::identity(n, n);
    for (a, b) in levels {
        if a.nrows() == 0 {
            continue;
        }
        let projected = a * &null;
        let inverse = pseudo_inverse(&projected)?;
        let rest = b - a * &x;
        x += &null * (&inverse * rest);
        null -= &inverse * &projected;
    }
    Some(x)
}

/// The given rows of a level as a weighted system with the given targets.
pub fn system(problem: &Problem, l: usize, rows: &[(usize, f64)]) -> (DMatrix<f64>, DVector<f64>) {
    let level = &problem.levels[l];
    let weight = |i: usize| level.weight[i].sqrt();
    let a = DMatrix::from_fn(rows.len(), problem.n, |r, c| weight(rows[r].0) * level.entry(rows[r].0, c));
    let b = DVector::from_fn(rows.len(), |r, _| weight(rows[r].0) * rows[r].1);
    (a, b)
}

/// The same problem with the rows of every level in reverse order.
pub fn turned(problem: &Problem) -> Problem {
    let mut turned = problem.clone();
    for (to, from) in turned.levels.iter_mut().zip(&problem.levels) {
        let m = from.rows();
        for i in 0..m {
            to.set(i, from.row(m - 1 - i), from.lower[m - 1 - i], from.upper[m - 1 - i]);
            to.weight[i] = from.weight[m - 1 - i];
        }
    }
    turned
}
