//! Limits on hard levels that look ahead, instead of keeping a constant reserve against sampling in time.
//!
//! A row `J v >= d_min' - φ h` keeps a margin to first order. The velocity v is constant for the period T, and a curved margin h
//! loses `T²/2 v^T H v` more, with H its second derivative. This loss is known exactly once v is: it is the margin at the
//! configuration to which v leads. Whenever it is below zero there, the row asks for what is missing, s, and the problem is
//! solved again:
//!
//! ```text
//! h(q + T v) = -s < 0     =>     J v'  >=  J v + s/T
//! ```
//!
//! The loss changes little from v to v', by a factor of the order of T times the joints' speeds in each round, so that few
//! rounds suffice. If the rows with these demands contradict each other, or [`ROUNDS`] do not suffice, the robot moves with
//! the first answer, but more slowly, `α v` with the largest `α <= 1` found that loses nothing: the loss is a quadratic
//! function of α and the margin a linear one, so that a positive α exists for positive margins. Rows that a robot at rest
//! does not meet, such as limits of accelerations, may forbid to be so slow. The hard level then cannot be met. Source: ours.

use solver::{Level, LevelStatus, Problem, Solution, Status};

use crate::evaluator::{Ahead, Evaluator, ShortRow};
use crate::fault::Fault;
use crate::program::StackProgram;

/// Most rounds in which the problem of a tick is solved again.
const ROUNDS: usize = 5;

/// Halvings of the interval in which the slower velocity is searched.
const HALVINGS: usize = 12;

/// Lower bound of a row as its task wrote it.
struct Written {
    level: usize,
    row: usize,
    lower: f64,
}

/// Limits of a stack that look ahead.
pub(super) struct LookAhead {
    ahead: Ahead,
    /// Bounds that were raised at this tick.
    written: Vec<Written>,
    /// Answer to the problem without raised bounds.
    first: Vec<f64>,
    /// Rows whose margins would be too small.
    short: Vec<ShortRow>,
    /// True if the robot moves more slowly at this tick than the hierarchy asks for.
    pub slowed: bool,
}

/// Tick that is looked at.
#[derive(Clone, Copy)]
pub(super) struct At<'t> {
    pub evaluator: &'t Evaluator,
    /// Configuration of the evaluator's last update.
    pub q: &'t [f64],
    /// Number of levels of the problem above those of the stack.
    pub above: usize,
}

impl LookAhead {
    /// Prepares for a stack.
    pub fn new(evaluator: &Evaluator, stack: &StackProgram, period: f64) -> LookAhead {
        let hard: Vec<bool> = stack.levels.iter().map(|l| l.hard).collect();
        let rows: usize = evaluator.members().iter().map(|m| m.rows.len()).sum();
        let nv = evaluator.model().nv();
        LookAhead {
            ahead: Ahead::new(evaluator, &hard, period),
            written: Vec::with_capacity(rows),
            first: vec![0.0; nv],
            short: Vec::with_capacity(rows),
            slowed: false,
        }
    }

    /// Changes the answer of a problem until no limit is passed before the next tick. `solve` solves the problem again.
    /// The problem keeps the bounds that were raised, so that its answer is the final one. Never allocates.
    ///
    /// # Errors
    /// No velocity was found that meets the hard levels.
    pub fn hold(
        &mut self,
        at: At,
        problem: &mut Problem,
        solution: &mut Solution,
        mut solve: impl FnMut(&Problem, &mut Solution),
    ) -> Result<(), Fault> {
        self.slowed = false;
        if self.ahead.is_idle() || solution.status != Status::Optimal {
            return Ok(());
        }
        self.written.clear();
        self.first.copy_from_slice(&solution.x);
        for _ in 0..ROUNDS {
            if !self.raise(at, &solution.x, problem) {
                return Ok(());
            }
            solve(problem, solution);
            match solution.status {
                Status::Optimal => {}
                Status::OutOfTime { .. } => return Ok(()),
                _ => return self.slow_down(at, problem, solution),
            }
        }
        if self.is_short(at, &solution.x, problem) {
            return self.slow_down(at, problem, solution);
        }
        Ok(())
    }

    /// Raises the bounds of rows whose margins would be too small. Returns false if there are none.
    fn raise(&mut self, at: At, v: &[f64], problem: &mut Problem) -> bool {
        let LookAhead { ahead, written, short, .. } = self;
        let levels = &mut problem.levels[at.above..];
        ahead.look(at.evaluator, at.q, v, levels, short);
        for &ShortRow { level, row, rate } in short.iter() {
            let problem_level: &mut Level = &mut levels[level];
            if !written.iter().any(|w| w.level == level && w.row == row) {
                written.push(Written { level, row, lower: problem_level.lower[row] });
            }
            let reached: f64 = problem_level.row(row).iter().zip(v).map(|(a, v)| a * v).sum();
            problem_level.lower[row] = reached + rate;
        }
        !short.is_empty()
    }

    fn is_short(&mut self, at: At, v: &[f64], problem: &Problem) -> bool {
        let LookAhead { ahead, short, .. } = self;
        ahead.look(at.evaluator, at.q, v, &problem.levels[at.above..], short);
        !short.is_empty()
    }

    /// Scales the first answer down until nothing is lost.
    fn slow_down(&mut self, at: At, problem: &mut Problem, solution: &mut Solution) -> Result<(), Fault> {
        for Written { level, row, lower } in self.written.drain(..) {
            problem.levels[at.above + level].lower[row] = lower;
        }
        let (mut good, mut bad) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let part = 0.5 * (good + bad);
            solution.x.iter_mut().zip(&self.first).for_each(|(x, v)| *x = part * v);
            match self.is_short(at, &solution.x, problem) {
                true => bad = part,
                false => good = part,
            }
        }
        solution.x.iter_mut().zip(&self.first).for_each(|(x, v)| *x = good * v);
        solution.measure(problem);
        solution.status = Status::Optimal;
        self.slowed = true;
        let unmet = |k: &usize| problem.levels[*k].hard && solution.levels[*k].status != LevelStatus::Met;
        match (0..problem.levels.len()).find(unmet) {
            Some(level) => {
                solution.status = Status::Infeasible { level };
                Err(Fault::Infeasible { level: level.saturating_sub(at.above) })
            }
            None => Ok(()),
        }
    }
}
