//! Locked joints that still move when their stack is entered.
//!
//! The problem of a stack has zero columns for its locked joints. While such a joint comes to rest, its motion still
//! contributes to the rows of hard levels, so its coefficients are stored here for the problem of the blended velocity.
//! The stack's own solution treats the joint as stationary, so a row that depends on locked joints alone does not
//! constrain it.

use solver::{Level, Problem};
use stdlib_tasks::task::Task;

use crate::evaluator::Member;

/// Coefficients and bounds stored at a tick. Nothing here allocates after [`LockedJointMotion::new`].
pub(crate) struct LockedJointMotion {
    /// True while a locked joint still moves.
    pub on: bool,
    locked: Vec<usize>,
    /// Index of each level's first row among the rows of all levels.
    first: Vec<usize>,
    /// Coefficients of the locked joints, for each row of all levels.
    columns: Vec<f64>,
    /// Coefficients that are 1 at every tick: the row, and the index into `locked`.
    fixed: Vec<(usize, usize)>,
    /// Bounds of each row that `free` removed from the problem.
    bounds: Vec<Option<(f64, f64)>>,
}

impl LockedJointMotion {
    /// Allocates the storage for a problem whose stack locks these degrees of freedom.
    pub fn new(problem: &Problem, locked: &[usize]) -> LockedJointMotion {
        let mut rows = 0;
        let mut first = Vec::with_capacity(problem.levels.len());
        for level in &problem.levels {
            first.push(rows);
            rows += level.rows();
        }
        let kept = if locked.is_empty() { 0 } else { rows };
        LockedJointMotion {
            on: false,
            locked: locked.to_vec(),
            first,
            columns: vec![0.0; kept * locked.len()],
            fixed: Vec::new(),
            bounds: vec![None; kept],
        }
    }

    /// Records the coefficients of a task whose rows never change.
    pub fn fix(&mut self, member: &Member, task: &dyn Task) {
        let first = self.first[member.level] + member.rows.start;
        for (row, dof) in task.degrees_of_freedom().unwrap_or_default().into_iter().enumerate() {
            let joint = self.locked.iter().position(|l| *l == dof);
            self.fixed.extend(joint.map(|k| (first + row, k)));
        }
    }

    /// Begins a tick: resets the coefficients to the constant ones and clears the bounds.
    pub fn begin(&mut self) {
        if self.on {
            self.columns.fill(0.0);
            self.bounds.fill(None);
            for &(row, k) in &self.fixed {
                self.columns[row * self.locked.len() + k] = 1.0;
            }
        }
    }

    /// Stores the coefficients of a task's rows. Those of constant rows were recorded by `fix`.
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

    /// Removes and stores the bounds of a task's rows that depend on locked joints alone.
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

    /// Restores the stored coefficients and bounds of a level. Rows that depend on locked joints alone are restored
    /// only if `alone` is true.
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
