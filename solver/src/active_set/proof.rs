//! Verification of the answer of a search before it is returned.
//!
//! * **Balance.** The gradient of each level that is not met, computed from the slacks at the final point, is balanced
//!   by the rows that are fixed above the level and by those held against it, the latter with the right sign. The check
//!   uses the directions of the search, so that it costs one projection per level.
//! * **Doubt.** A rank, a sign or a residual was decided by a number that is neither clearly rounding nor clearly
//!   larger: another threshold would have decided otherwise.
//!
//! If the balance fails, or if there is a doubt, the certificate decides, which is independent of the search.
//!
//! Entries of 1e-6 next to 1 have products of 1e-12 and cause such numbers; ordinary robots have them near singular
//! configurations.

use super::frame::is_near;
use super::kernels::{axpy, combine, dot, norm};
use super::relaxed::Relaxed;
use super::rows::weight;
use crate::certificate::{Certifier, Claim};
use crate::problem::Problem;
use crate::solution::{LevelStatus, Solution};

/// Maximum relative imbalance of an answer that needs no certificate.
const BALANCED: f64 = 1e-9;

/// Workspace of the verification.
#[derive(Clone, Debug)]
pub(crate) struct Proof {
    gradient: Vec<f64>,
    coefficient: Vec<f64>,
    certifier: Certifier,
    /// Number of certificates that were computed.
    pub(crate) asked: u64,
    /// Level at which the last unproven answer is farthest from an optimum.
    pub(crate) missed: usize,
}

impl Proof {
    pub(crate) fn new(problem: &Problem, stride: usize) -> Self {
        Proof {
            gradient: vec![0.0; stride],
            coefficient: vec![0.0; problem.n],
            certifier: Certifier::new(problem),
            asked: 0,
            missed: 0,
        }
    }

    /// Returns true if the final point of a search has the claimed property; `solution` contains the slacks of the
    /// levels there.
    #[inline(always)]
    pub(crate) fn holds(&mut self, relaxed: &Relaxed, problem: &Problem, solution: &Solution, claim: Claim) -> bool {
        !self.is_doubtful(relaxed, problem, solution) || self.certifies(relaxed, problem, claim)
    }

    fn is_doubtful(&mut self, relaxed: &Relaxed, problem: &Problem, solution: &Solution) -> bool {
        let levels = relaxed.levels;
        let own = relaxed.working_set.own.iter().take(levels);
        relaxed.frame.doubt
            || own
                .chain(relaxed.working_set.active.iter().take(levels + 1))
                .flatten()
                .any(|e| is_near(e.value, e.noise))
            || !(0..levels).all(|l| {
                solution.levels[l].status == LevelStatus::Met || self.is_balanced(relaxed, problem, solution, l)
            })
    }

    /// Returns true if the certificate proves the claim.
    #[cold]
    fn certifies(&mut self, relaxed: &Relaxed, problem: &Problem, claim: Claim) -> bool {
        self.asked += 1;
        let x = &relaxed.frame.x[..problem.n];
        let look = self.certifier.look(problem, claim, x);
        self.missed = look.level;
        look.proves(x)
    }

    /// Returns true if the rows above level `l` balance its gradient.
    fn is_balanced(&mut self, relaxed: &Relaxed, problem: &Problem, solution: &Solution, l: usize) -> bool {
        let (level, slacks) = (&problem.levels[l], &solution.levels[l].slack);
        let (stride, norms) = (relaxed.stride, relaxed.rows.norms(l).each);
        let (mut square, mut scale) = (0.0, level.damping.sqrt());
        self.gradient.fill(0.0);
        for (i, &slack) in slacks.iter().enumerate() {
            let w = weight(level, i);
            if slack != 0.0 && w != 0.0 {
                axpy(w * slack, &level.padded()[i * stride..(i + 1) * stride], &mut self.gradient);
                square += w * slack * slack;
                scale = scale.max(w.sqrt() * norms[i]);
            }
        }
        if level.damping > 0.0 {
            axpy(level.damping, &relaxed.frame.x, &mut self.gradient);
            square += level.damping * dot(&relaxed.frame.x, &relaxed.frame.x);
        }
        self.imbalance(relaxed, l) <= BALANCED * scale * (1.0 + square.sqrt())
    }

    /// Returns the imbalance at stage `s`: the norm of the gradient outside the rows fixed before the stage and those
    /// held against it, or the largest force of the wrong sign among the latter if that is larger.
    fn imbalance(&mut self, relaxed: &Relaxed, s: usize) -> f64 {
        let from = relaxed.mark[s];
        let until = from + relaxed.working_set.active[s].len();
        let Some(frame) = relaxed.frame.first(until) else { return 0.0 };
        let Proof { gradient, coefficient, .. } = self;
        for (c, q) in coefficient.iter_mut().zip(frame.chunks_exact(relaxed.stride.max(1))) {
            *c = -dot(q, gradient);
        }
        combine(&coefficient[..until], frame, gradient);
        let mut most = norm(gradient);
        // Multipliers of the active rows, from the last one on.
        for j in (from..until).rev() {
            let later = (j + 1..until).map(|i| relaxed.lower[i * relaxed.n + j] * coefficient[i]).sum::<f64>();
            let rest = coefficient[j] - later;
            most = most.max(-rest);
            coefficient[j] = rest / relaxed.lower[j * relaxed.n + j];
        }
        most
    }
}
