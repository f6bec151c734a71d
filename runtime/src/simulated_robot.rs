//! The simulated robot: a velocity-controlled mechanism that moves on its configuration manifold.
//!
//! It follows a command within the speeds of its joints, stops at their mechanical limits, and may be made imperfect: a
//! first-order lag of the actuators and Gaussian noise on the measured positions, seeded and reproducible.

use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use robot::Model;

use crate::program::Program;

/// A simulated robot.
pub struct SimulatedRobot {
    model: Model,
    period: f64,
    lag: f64,
    noise: Option<(Normal<f64>, Pcg64)>,
    q: Vec<f64>,
    v: Vec<f64>,
    mean: Vec<f64>,
    measured: Vec<f64>,
}

impl SimulatedRobot {
    /// A robot at rest in the home configuration of a checked program.
    pub fn new(program: &Program) -> SimulatedRobot {
        let model = program.robot.model.clone();
        let s = &program.run.simulator;
        let noise = (s.noise > 0.0).then(|| Normal::new(0.0, s.noise).ok()).flatten();
        SimulatedRobot {
            period: program.robot.period,
            lag: s.lag,
            noise: noise.map(|n| (n, Pcg64::seed_from_u64(s.seed))),
            q: program.robot.home.clone(),
            v: vec![0.0; model.nv()],
            mean: vec![0.0; model.nv()],
            measured: program.robot.home.clone(),
            model,
        }
    }

    /// The true configuration.
    pub fn q(&self) -> &[f64] {
        &self.q
    }

    /// True where the robot does exactly what it is told, so that what is measured is what is.
    pub fn is_perfect(&self) -> bool {
        self.lag == 0.0 && self.noise.is_none()
    }

    /// The configuration as the sensors report it: joints with noise, the base without.
    pub fn measure(&mut self) -> &[f64] {
        self.measured.copy_from_slice(&self.q);
        if let Some((normal, rng)) = &mut self.noise {
            for d in &self.model.dofs {
                if let Some(i) = d.q_index {
                    self.measured[i] += normal.sample(rng);
                }
            }
        }
        &self.measured
    }

    /// Moves for one period under a constant velocity command.
    pub fn apply(&mut self, command: &[f64]) {
        let t = self.period;
        let decay = if self.lag > 0.0 { (-t / self.lag).exp() } else { 0.0 };
        for (i, d) in self.model.dofs.iter().enumerate() {
            let wanted = command[i].clamp(-d.velocity, d.velocity);
            let behind = self.v[i] - wanted;
            self.mean[i] = if self.lag > 0.0 { wanted + behind * self.lag * (1.0 - decay) / t } else { wanted };
            self.v[i] = wanted + behind * decay;
        }
        self.model.integrate(&mut self.q, &self.mean, t);
        for d in &self.model.dofs {
            if let Some(i) = d.q_index {
                self.q[i] = self.q[i].clamp(d.lower, d.upper);
            }
        }
    }
}
