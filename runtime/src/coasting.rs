//! Joints that a stack locks and that still move when it is entered.
//!
//! The columns of locked joints are switched off. While such a joint comes to rest that is not the truth: what hard levels
//! say of its motion is kept back here, for the velocity between. The stack's own solution takes the joint to stand, so a
//! row that speaks of locked joints alone says nothing to it meanwhile.

use solver::{Level, Problem};
use stdlib_tasks::task::Task;

use crate::evaluator::Member;

/// What was kept back at a tick. Nothing here allocates after [`Coasting::new`].
pub(crate) struct Coasting {
    /// Whether a locked joint still moves.
    pub on: bool,
    locked: Vec<usize>,
    /// For each level its first row among all.
    first: Vec<usize>,
    /// For each row of all levels the coefficients of the locked joints.
    columns: Vec<f64>,
    /// Coefficients that are 1 at every tick: the row, and which of the locked joints.
    fixed: Vec<(usize, usize)>,
    /// For each row its bounds, where the problem has lost them.
    bounds: Vec<Option<(f64, f64)>>,
}

impl Coasting {
    /// For a problem whose stack locks these degrees of freedom.
    pub fn new(problem: &Problem, locked: &[usize]) -> Coasting {
        let mut rows = 0;
        let mut first = Vec::with_capacity(problem.levels.len());
        for level in &problem.levels {
            first.push(rows);
            rows += level.rows();
        }
        let kept = if locked.is_empty() { 0 } else { rows };
        Coasting {
            on: false,
            locked: locked.to_vec(),
            first,
            columns: vec![0.0; kept * locked.len()],
            fixed: Vec::new(),
            bounds: vec![None; kept],
        }
    }

    /// Notes a task whose rows never change.
    pub fn fix(&mut self, member: &Member, task: &dyn Task) {
        let first = self.first[member.level] + member.rows.start;
        for (row, dof) in task.degrees_of_freedom().unwrap_or_default().into_iter().enumerate() {
            let joint = self.locked.iter().position(|l| *l == dof);
            self.fixed.extend(joint.map(|k| (first + row, k)));
        }
    }

    /// A tick begins.
    pub fn begin(&mut self) {
        if self.on {
            self.columns.fill(0.0);
            self.bounds.fill(None);
            for &(row, k) in &self.fixed {
                self.columns[row * self.locked.len() + k] = 1.0;
            }
        }
    }

    /// Keeps the coefficients of a task's rows; those of a task whose rows never change were noted.
    pub fn keep(&mut self, member: &Member, jacobian: &[f64], stride: usize) {
        let n = self.locked.len();
        if !self.on || n == 0 || member.constant {
            return;
        }
        let first = self.first[member.level] + member.rows.start;
        let columns = &mut self.columns[first * n..];
        for (kept, row) in columns.chunks_exact_mut(n).zip(jacobian.chunks_exact(stride.max(1))) {
            kept.iter_mut().zip(&self.locked).for_each(|(c, &dof)| *c = row[dof]);
        }
    }

    /// Frees a task's rows that speak of locked joints alone.
    pub fn free(&mut self, member: &Member, level: &mut Level) {
        let n = self.locked.len();
        if !self.on || n == 0 {
            return;
        }
        for row in member.rows.clone() {
            let at = self.first[member.level] + row;
            let speaks = self.columns[at * n..(at + 1) * n].iter().any(|c| *c != 0.0);
            if speaks && level.row(row).iter().all(|a| *a == 0.0) {
                self.bounds[at] = Some((level.lower[row], level.upper[row]));
                (level.lower[row], level.upper[row]) = (f64::NEG_INFINITY, f64::INFINITY);
            }
        }
    }

    /// Gives the rows of a level back what was kept; rows that speak of locked joints alone only if `alone`.
    pub fn give_back(&self, index: usize, alone: bool, level: &mut Level) {
        let n = self.locked.len();
        if !self.on || n == 0 {
            return;
        }
        for row in 0..level.rows() {
            let at = self.first[index] + row;
            let kept = &self.columns[at * n..(at + 1) * n];
            if kept.iter().all(|c| *c == 0.0) {
                continue;
            }
            if self.bounds[at].is_some() && !alone {
                continue;
            }
            let coefficients = level.row_mut(row);
            kept.iter().zip(&self.locked).for_each(|(c, &dof)| coefficients[dof] = *c);
            if let Some(bounds) = self.bounds[at] {
                (level.lower[row], level.upper[row]) = bounds;
            }
        }
    }
}
