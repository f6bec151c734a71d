//! Verification: the problem of every tick, in which damped levels ask for the values that they reached, and the problem of
//! each damped level are solved again by the other backend. The optimality certificate is evaluated at the answers of the run
//! itself and, where the other backend's differ, at those too: it says which of the two is off.

use serde::Serialize;
use solver::{Backend, HierarchicalSolver, Problem, Solution, Status, certificate};

use crate::controller::{Controller, StackController};
use crate::program::Program;
use crate::tick::{Recorder, Tick};

/// Difference above which two answers count as different, in rad/s or m/s. It occurs close to singular configurations,
/// where a direction moves a task by about 1e-9 of its size: one solver may count it, the other not.
pub const DIFFERENT: f64 = 1e-6;

/// Residual of the certificate above which optimality counts as unproven.
pub const UNPROVEN: f64 = 1e-6;

/// Comparison of a run with a second solver.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verification {
    /// Name of the backend that solved everything again.
    pub backend: &'static str,
    /// Ticks that were compared.
    pub ticks: usize,
    /// Ticks at which the second backend found no answer; they are excluded from the other figures.
    pub failed: usize,
    /// Ticks at which a joint velocity differs by more than [`DIFFERENT`].
    pub different: usize,
    /// Largest difference of a joint velocity, in rad/s or m/s.
    pub max_difference: f64,
    /// Time of the largest difference, in s.
    pub at_s: f64,
    /// Largest residual of the optimality certificate at the run's own answers.
    pub max_certificate: f64,
    /// Largest residual at the second backend's answers, of the ticks at which they differ; 0 if none does.
    pub other_certificate: f64,
}

/// An answer beside that of the other backend.
struct Comparison {
    /// Largest difference of an entry; `None` if the other backend found no answer.
    difference: Option<f64>,
    /// Residual of the certificate at the answer.
    own: f64,
    /// The same at the answer of the other backend, if the two differ.
    other: f64,
}

/// A solver of the other backend, with its answer.
struct Second {
    solver: Box<dyn HierarchicalSolver + Send>,
    solution: Solution,
}

impl Second {
    fn new(backend: Backend, problem: &Problem) -> Second {
        Second { solver: backend.solver(problem), solution: Solution::new(problem) }
    }

    /// Compares an answer with its own.
    fn compare(&mut self, problem: &Problem, x: &[f64]) -> Comparison {
        self.solver.solve(problem, &mut self.solution);
        let both = x.iter().zip(&self.solution.x);
        let difference =
            (self.solution.status == Status::Optimal).then(|| both.fold(0.0_f64, |d, (a, b)| d.max((a - b).abs())));
        let other = match difference {
            Some(d) if d > DIFFERENT => certificate(problem, &self.solution.x),
            _ => 0.0,
        };
        Comparison { difference, own: certificate(problem, x), other }
    }
}

/// Solves every tick a second time: the problem of the tick and, if levels were damped, those of the damped levels.
pub struct Verifier {
    other: Backend,
    /// For each stack, the solver of its problem, and for each level the solver of the damped level once it is needed.
    stacks: Vec<(Second, Vec<Option<Second>>)>,
    so_far: Verification,
}

impl Verifier {
    /// Prepares for a run of this program.
    pub fn new(program: &Program, controller: &Controller) -> Self {
        let other = program.run.solver.other();
        let stack = |s: &StackController| {
            let levels = s.problem().levels.iter().map(|_| None).collect();
            (Second::new(other, s.problem()), levels)
        };
        Verifier {
            other,
            stacks: controller.stacks().iter().map(stack).collect(),
            so_far: Verification {
                backend: other.name(),
                ticks: 0,
                failed: 0,
                different: 0,
                max_difference: 0.0,
                at_s: 0.0,
                max_certificate: 0.0,
                other_certificate: 0.0,
            },
        }
    }

    /// Comparison so far.
    pub fn result(&self) -> &Verification {
        &self.so_far
    }
}

impl Recorder for Verifier {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        if tick.is_still() || tick.solution.status != Status::Optimal {
            return Ok(());
        }
        let (second, levels) = &mut self.stacks[tick.stack];
        let stack = &tick.controller.stacks()[tick.stack];
        // A slower velocity than that of the hierarchy is no optimum, nor is one on the way to rest.
        if stack.is_slowed() || stack.is_stopping() {
            return Ok(());
        }
        let v = &mut self.so_far;
        let whole = second.compare(stack.settled(), &tick.solution.x);
        let mut difference = whole.difference;
        let mut count = |c: &Comparison| {
            v.max_certificate = v.max_certificate.max(c.own);
            v.other_certificate = v.other_certificate.max(c.other);
        };
        count(&whole);
        for (level, problem, solution) in stack.solver().damped() {
            let second = levels[level].get_or_insert_with(|| Second::new(self.other, problem));
            let of_level = second.compare(problem, &solution.x);
            count(&of_level);
            difference = difference.zip(of_level.difference).map(|(a, b)| a.max(b));
        }
        let Some(difference) = difference else {
            v.failed += 1;
            return Ok(());
        };
        v.ticks += 1;
        v.different += usize::from(difference > DIFFERENT);
        if difference > v.max_difference {
            (v.max_difference, v.at_s) = (difference, tick.time);
        }
        Ok(())
    }
}
