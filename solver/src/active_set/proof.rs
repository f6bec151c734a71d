//! Whether the answer of a search is the optimum: looked at before it is given away.
//!
//! * **Balance.** The gradient of each level that is not met, from the slacks at the final point, is balanced by the rows that are fixed
//!   above the level and by those held against it, these with the right sign. It takes the directions that the search ended with, so
//!   that it costs one projection a level.
//! * **Doubt.** A rank, a sign or a residual was decided by a number that is neither clearly rounding nor clearly more: another
//!   threshold would have decided otherwise.
//!
//! Where the balance is missed, or in doubt, the certificate has the last word, which knows nothing of the search.
//!
//! Entries of 1e-6 beside 1 meet in products of 1e-12 and make such numbers; ordinary robots have them near singular configurations.

use super::frame::is_near;
use super::kernels::{axpy, combine, dot, norm};
use super::relaxed::Relaxed;
use super::rows::weight;
use crate::certificate::{Certifier, Claim};
use crate::problem::Problem;
use crate::solution::{LevelStatus, Solution};

/// An imbalance above this makes the certificate worth asking.
const BALANCED: f64 = 1e-9;

/// The storage of a look.
#[derive(Clone, Debug)]
pub(crate) struct Proof {
    gradient: Vec<f64>,
    coefficient: Vec<f64>,
    certifier: Certifier,
    /// How many certificates were asked for.
    pub(crate) asked: u64,
    /// The level at which the last answer that was not proven is farthest from an optimum.
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

    /// Whether the point of a search that has ended is what it is said to be; `solution` holds the slacks of the levels there.
    #[inline(always)]
    pub(crate) fn holds(&mut self, relaxed: &Relaxed, problem: &Problem, solution: &Solution, claim: Claim) -> bool {
        !self.is_doubtful(relaxed, problem, solution) || self.certifies(relaxed, problem, claim)
    }

    fn is_doubtful(&mut self, relaxed: &Relaxed, problem: &Problem, solution: &Solution) -> bool {
        let levels = relaxed.levels;
        let own = relaxed.stages.own.iter().take(levels);
        relaxed.frame.doubt
            || own.chain(relaxed.stages.held.iter().take(levels + 1)).flatten().any(|e| is_near(e.value, e.noise))
            || !(0..levels).all(|l| {
                solution.levels[l].status == LevelStatus::Met || self.is_balanced(relaxed, problem, solution, l)
            })
    }

    /// Asks the certificate.
    #[cold]
    fn certifies(&mut self, relaxed: &Relaxed, problem: &Problem, claim: Claim) -> bool {
        self.asked += 1;
        let x = &relaxed.frame.x[..problem.n];
        let look = self.certifier.look(problem, claim, x);
        self.missed = look.level;
        look.proves(x)
    }

    /// Whether the rows above level `l` balance its gradient.
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

    /// What of the gradient is left when the rows fixed before stage `s` and those held against it have taken what they can, these
    /// with the right sign.
    fn imbalance(&mut self, relaxed: &Relaxed, s: usize) -> f64 {
        let from = relaxed.mark[s];
        let until = from + relaxed.stages.held[s].len();
        let Some(frame) = relaxed.frame.first(until) else { return 0.0 };
        let Proof { gradient, coefficient, .. } = self;
        for (c, q) in coefficient.iter_mut().zip(frame.chunks_exact(relaxed.stride.max(1))) {
            *c = -dot(q, gradient);
        }
        combine(&coefficient[..until], frame, gradient);
        let mut most = norm(gradient);
        // Multipliers of the rows held, from the last one on.
        for j in (from..until).rev() {
            let later = (j + 1..until).map(|i| relaxed.lower[i * relaxed.n + j] * coefficient[i]).sum::<f64>();
            let rest = coefficient[j] - later;
            most = most.max(-rest);
            coefficient[j] = rest / relaxed.lower[j * relaxed.n + j];
        }
        most
    }
}
