//! The planner's program below levels with limits.
//!
//! The one-row program ([`OneRowProgram`]) assumes that nothing is above the task. With limits above, it may ask for a
//! motion that the hierarchy then withholds, and with it the rate of the field. Therefore the limits
//! `lower <= A v <= upper` belong to the program. With the velocity `v` among the unknowns it is a hierarchy again:
//!
//! ```text
//! 1..   the levels above the task, as they are, and the box of u_c, u_a
//! then  J v - eta u_c - Psi u_a = K e - T de                          the task, on the path that the inputs choose
//! then  |v| <= v_max                                                  of each joint, as far as the task lets it
//! then  g . v >= need                                                 the field
//! last  min q_c (u_c - 1)^2 + sum q_a u_a^2 + q_n |N (v - k_n g)|^2
//! ```
//!
//! `N v` is the internal motion `N u_n` of the one-row program, and `need` is the rate that the weights of that program
//! let it reach. If neither limits nor speeds are active and nothing is damped, the two have the same optimum. The
//! hierarchy of the controller, which contains the task's rows at these inputs and `v` below them, has no other
//! solution than this `v`: it meets the levels above, nothing meets the task better at these inputs, and the rest is
//! met exactly. Levels between the task and the planner are not taken into account; the rate that they withhold is
//! reported as withheld.
//!
//! The task is above the field here, as in the hierarchy, so that its inputs give way before its rows do: the clock
//! slows if limits hold the task back. This is requested only while the field falls short of its demand.

use solver::{Backend, HierarchicalSolver, Level, LevelShape, Problem, Smooth, Solution, Status};

use crate::safety::decomposition::{Decomposition, Push, TaskRows, axpy, dot};
use crate::safety::one_row::OneRowProgram;

/// Violation above which a row counts as broken, in its own unit per second.
const BROKEN: f64 = 1e-9;

/// Remaining length of a column of N, orthogonal to others, up to which it depends on them.
const NOTHING: f64 = 1e-6;

/// Returns true if a velocity violates a row of the levels above.
pub(super) fn breaks(above: &[Level], v: &[f64]) -> bool {
    above.iter().any(|level| {
        (0..level.rows()).any(|i| {
            let (lower, upper) = (level.lower[i], level.upper[i]);
            if lower == f64::NEG_INFINITY && upper == f64::INFINITY {
                return false;
            }
            let speed = dot(level.row(i), v);
            speed < lower - BROKEN || speed > upper + BROKEN
        })
    })
}

/// Rows of a task in a level.
#[derive(Clone, Copy, Debug)]
pub struct TaskLevel<'a> {
    /// Level of the task.
    pub level: &'a Level,
    /// Index of the task's first row in the level.
    pub first: usize,
}

/// Curvature of the rows of a program; see [`Level::set_curvature`].
#[derive(Clone, Copy, Debug)]
pub struct RowCurvature<'a> {
    /// Levels above the task.
    pub above: &'a [Level],
    /// Rows of the task.
    pub task: TaskLevel<'a>,
    /// Curvature of the field, one number for each degree of freedom.
    pub field: &'a [f64],
    /// True for each level down to the task's that is never damped.
    pub exact: &'a [bool],
    /// Factor on the curvatures of these levels.
    pub part: f64,
}

/// Creates the solver of such a program: smooth except for the speeds, which are limits of variables. The last level
/// must be smooth as well; otherwise it spends motion of almost no benefit, in either direction, on a slightly faster
/// clock.
fn solver(problem: &Problem) -> Smooth {
    Smooth::new(problem, Backend::ActiveSet).with_exact(problem.levels.len() - 3)
}

/// Inputs of the program at a tick.
pub(super) struct LimitedInputs<'a> {
    /// Levels above the task.
    pub above: &'a [Level],
    /// Rows of the task.
    pub task: TaskRows<'a>,
    /// Effect of the deviation inputs on them.
    pub pushes: &'a [Push],
    /// T de
    pub springs: &'a [f64],
    /// g
    pub gradient: &'a [f64],
    /// Smallest `g . v` that is requested.
    pub need: f64,
    /// One-row program of this tick: weights, nominal values and boxes of u_c, u_a, u_n.
    pub program: &'a OneRowProgram,
    /// Factorisation of this tick, for N.
    pub parts: &'a Decomposition,
}

/// Solution of the program.
#[derive(Clone, Copy, Debug)]
pub(super) struct LimitedSolution<'a> {
    /// Velocity of each degree of freedom.
    pub velocity: &'a [f64],
    /// u_c, u_a
    pub inputs: &'a [f64],
    /// True if the field's demand cannot be met.
    pub damped: bool,
}

/// The program with its storage. Unknowns: the velocity, then u_c, then u_a.
pub(super) struct LimitedProgram {
    dofs: usize,
    inputs: usize,
    rows: usize,
    problem: Problem,
    solution: Solution,
    solver: Smooth,
    /// A column of N, and working storage.
    column: Vec<f64>,
    basis: Vec<f64>,
    nothing: Vec<f64>,
}

impl LimitedProgram {
    /// Creates the program for a task of `rows` rows with `k` deviation inputs on a robot with `dofs` degrees of
    /// freedom, below these levels.
    pub fn new(rows: usize, k: usize, dofs: usize, above: &[LevelShape]) -> LimitedProgram {
        let soft = |rows| LevelShape { rows, hard: false, damping: 0.0 };
        let inputs = 1 + k;
        let mut shapes = vec![LevelShape { rows: inputs, hard: true, damping: 0.0 }];
        shapes.extend(above);
        shapes.extend([soft(rows), soft(dofs), soft(1), soft(inputs + dofs)]);
        let mut problem = Problem::new(dofs + inputs, &shapes);
        let last = shapes.len() - 1;
        for i in 0..inputs {
            problem.levels[0].row_mut(i)[dofs + i] = 1.0;
            problem.levels[last].row_mut(i)[dofs + i] = 1.0;
        }
        for i in 0..dofs {
            problem.levels[last - 2].row_mut(i)[i] = 1.0;
        }
        problem.levels[0].fix(0..inputs);
        problem.levels[last - 2].fix(0..dofs);
        problem.levels[last].fix(0..inputs);
        LimitedProgram {
            dofs,
            inputs,
            rows,
            solution: Solution::new(&problem),
            solver: solver(&problem),
            problem,
            column: vec![0.0; dofs],
            basis: vec![0.0; dofs * dofs],
            nothing: vec![0.0; rows],
        }
    }

    /// Sets the curvature of the rows. Levels that cannot be met are then damped like those of the controller.
    pub fn set_curvature(&mut self, given: &RowCurvature) {
        let (width, rows) = (self.dofs + self.inputs, self.rows);
        let TaskLevel { level: task, first } = given.task;
        let copy = |level: &mut Level, part: f64, from: &mut dyn Iterator<Item = &[f64]>| {
            let mut curvature = vec![0.0; level.rows() * width];
            for (to, from) in curvature.chunks_exact_mut(width).zip(from) {
                to.iter_mut().zip(from).for_each(|(to, c)| *to = part * c);
            }
            level.set_curvature(curvature);
        };
        let levels = &mut self.problem.levels[1..];
        for (to, from) in levels.iter_mut().zip(given.above) {
            copy(to, given.part, &mut (0..from.rows()).map(|i| from.curvature(i)));
        }
        if let [.., to, _, of_field, _] = levels {
            copy(to, given.part, &mut (first..first + rows).map(|i| task.curvature(i)));
            copy(of_field, 1.0, &mut std::iter::once(given.field));
        }
        let exact = given.exact.iter().enumerate().filter(|(_, exact)| **exact);
        self.solver = exact.fold(solver(&self.problem), |solver, (k, _)| solver.with_exact(1 + k));
    }

    /// Returns true if the curvature of the rows was set.
    pub fn has_curvature(&self) -> bool {
        self.problem.levels.iter().any(Level::is_curved)
    }

    /// Returns true if the task could not be met, and was damped, at the last solve.
    pub fn is_task_damped(&self) -> bool {
        self.solver.is_damped(self.problem.levels.len() - 4)
    }

    /// Resets the memory of the solver.
    pub fn forget(&mut self) {
        self.solver.forget();
    }

    /// Solves the program. Returns `None` if the levels above cannot be met, or have another shape. Never allocates.
    pub fn solve(&mut self, now: &LimitedInputs) -> Option<LimitedSolution<'_>> {
        let (n, m, inputs) = (self.dofs, self.rows, self.inputs);
        let levels = &mut self.problem.levels;
        let fits = |from: &Level, to: &Level| from.columns() == n && from.rows() == to.rows() && from.hard == to.hard;
        if levels.len() != now.above.len() + 5 || !now.above.iter().zip(&levels[1..]).all(|(a, b)| fits(a, b)) {
            return None;
        }
        let program = now.program;
        levels[0].lower.copy_from_slice(&program.lower[..inputs]);
        levels[0].upper.copy_from_slice(&program.upper[..inputs]);
        for (from, to) in now.above.iter().zip(&mut levels[1..]) {
            to.copy_from(from);
        }
        let [.., task, speeds, field, last] = &mut levels[..] else { return None };
        for i in 0..m {
            let row = task.row_mut(i);
            row[..n].copy_from_slice(now.task.row(i, n));
            row[n] = -now.task.eta[i];
            row[n + 1..n + inputs].fill(0.0);
            for (k, push) in now.pushes.iter().enumerate() {
                if let Some(along) = i.checked_sub(push.row).filter(|d| *d < 3) {
                    row[n + 1 + k] = -push.along[along];
                }
            }
            let wanted = now.task.feedback[i] - now.springs[i];
            (task.lower[i], task.upper[i]) = (wanted, wanted);
        }
        field.row_mut(0)[..n].copy_from_slice(now.gradient);
        field.lower[0] = now.need;
        for i in 0..inputs {
            (last.lower[i], last.upper[i]) = (program.nominal[i], program.nominal[i]);
            last.weight[i] = program.weight[i];
        }
        for i in 0..n {
            let fastest = program.upper[inputs + i];
            (speeds.lower[i], speeds.upper[i]) = (-fastest, fastest);
        }
        // N is symmetric, and a projector of rank n - m if nothing is damped: an orthonormal basis of its columns then
        // replaces N, with fewer rows.
        let rank = if now.parts.damped == 0.0 { n.saturating_sub(m) } else { n };
        let mut found = 0;
        for i in 0..n {
            if found == rank {
                break;
            }
            self.column.fill(0.0);
            self.column[i] = 1.0;
            self.nothing.fill(0.0);
            now.parts.law(&now.task, &mut self.nothing, &mut self.column);
            if rank < n && !self.normalise(found) {
                continue;
            }
            self.basis[found * n..(found + 1) * n].copy_from_slice(&self.column);
            found += 1;
        }
        let last = self.problem.levels.last_mut()?;
        for (i, row) in self.basis[..found * n].chunks_exact(n.max(1)).enumerate() {
            let at = inputs + i;
            last.row_mut(at)[..n].copy_from_slice(row);
            let nominal = dot(row, &program.nominal[inputs..]);
            (last.lower[at], last.upper[at]) = (nominal, nominal);
            last.weight[at] = program.weight[inputs + i];
        }
        (inputs + found..last.rows()).for_each(|i| last.leave_out(i));
        self.solver.solve(&self.problem, &mut self.solution);
        let damped = self.solver.is_damped(self.problem.levels.len() - 2);
        let (velocity, inputs) = self.solution.x.split_at(n);
        (self.solution.status == Status::Optimal).then_some(LimitedSolution { velocity, inputs, damped })
    }

    /// Makes the column orthogonal to the first `found` rows of the basis, and scales it to unit length. Returns false
    /// if almost nothing of it is left.
    fn normalise(&mut self, found: usize) -> bool {
        let n = self.dofs;
        // Twice is enough (Kahan, Parlett).
        for _ in 0..2 {
            for row in self.basis[..found * n].chunks_exact(n) {
                let along = dot(row, &self.column);
                axpy(-along, row, &mut self.column);
            }
        }
        let left = dot(&self.column, &self.column).sqrt();
        self.column.iter_mut().for_each(|x| *x /= left);
        left > NOTHING
    }
}
