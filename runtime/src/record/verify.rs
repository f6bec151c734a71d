//! A second opinion: every tick's problem is solved again by the other backend, and its answer is
//! put to the certificate: that of the problem in which damped levels ask for what they reached.

use serde::Serialize;
use solver::{HierarchicalSolver, Smooth, Solution, Status, certificate};

use crate::controller::{Controller, Stage};
use crate::program::Program;
use crate::simulate::{Recorder, Tick};

/// Two answers that differ by more are two answers, in rad/s or m/s. It happens close to singular configurations, where a
/// direction moves a task by about 1e-9 of its size: one solver may count it, the other not.
pub const DIFFERENT: f64 = 1e-6;

/// A residual of the certificate above this is no proof of optimality.
pub const UNPROVEN: f64 = 1e-6;

/// What a second solver said of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verification {
    /// The backend that solved everything again.
    pub backend: &'static str,
    /// Ticks that were compared.
    pub ticks: usize,
    /// Ticks at which the second backend found no answer; they count in nothing else.
    pub failed: usize,
    /// Ticks at which a joint velocity differs by more than [`DIFFERENT`].
    pub different: usize,
    /// The largest difference of a joint velocity, in rad/s or m/s.
    pub max_difference: f64,
    /// When it was seen, in s.
    pub at_s: f64,
    /// The largest residual of the optimality certificate at the run's own answers.
    pub max_certificate: f64,
}

/// Solves every tick a second time.
pub struct Verifier {
    /// For each stage.
    solvers: Vec<(Smooth, Solution)>,
    /// The visit to a stack that was seen last.
    visit: Option<u64>,
    so_far: Verification,
}

impl Verifier {
    /// For a run of this program.
    pub fn new(program: &Program, controller: &Controller) -> Self {
        let other = program.run.solver.other();
        let solver = |s: &Stage| (s.other_solver(program), Solution::new(s.problem()));
        Verifier {
            solvers: controller.stages().iter().map(solver).collect(),
            visit: None,
            so_far: Verification {
                backend: other.name(),
                ticks: 0,
                failed: 0,
                different: 0,
                max_difference: 0.0,
                at_s: 0.0,
                max_certificate: 0.0,
            },
        }
    }

    /// The comparison so far.
    pub fn result(&self) -> &Verification {
        &self.so_far
    }
}

impl Recorder for Verifier {
    fn tick(&mut self, tick: &Tick) -> std::io::Result<()> {
        if tick.fault.is_some() || tick.solution.status != Status::Optimal {
            return Ok(());
        }
        let (solver, solution) = &mut self.solvers[tick.stage];
        let visit = Some(tick.controller.visit());
        if std::mem::replace(&mut self.visit, visit) != visit {
            solver.forget();
        }
        solver.solve(tick.problem, solution);
        let v = &mut self.so_far;
        let settled = tick.controller.stages()[tick.stage].settled();
        v.max_certificate = v.max_certificate.max(certificate(settled, &tick.solution.x));
        if solution.status != Status::Optimal {
            v.failed += 1;
            return Ok(());
        }
        v.ticks += 1;
        let both = tick.solution.x.iter().zip(&solution.x);
        let difference = both.fold(0.0_f64, |d, (a, b)| d.max((a - b).abs()));
        v.different += usize::from(difference > DIFFERENT);
        if difference > v.max_difference {
            (v.max_difference, v.at_s) = (difference, tick.time);
        }
        Ok(())
    }
}
