//! The simulated robot: a velocity-controlled mechanism that moves on its configuration manifold.
//!
//! It follows a velocity command within the speeds of its joints and stops at their mechanical limits. It can be made
//! imperfect: a first-order lag of the actuators, speeds and accelerations that they cannot exceed, and Gaussian noise
//! on the measured positions, seeded and reproducible.

use rand_distr::{Distribution, Normal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use robot::Model;

use crate::physics::{self, Around, Drives, Physics, PlantRecord};
use crate::program::{Program, ProgramError, ScenarioProgram};

/// A simulated robot.
pub struct SimulatedRobot {
    model: Model,
    period: f64,
    lag: f64,
    speed: f64,
    acceleration: f64,
    noise: Option<(Normal<f64>, Pcg64)>,
    q: Vec<f64>,
    v: Vec<f64>,
    mean: Vec<f64>,
    measured: Vec<f64>,
    /// Position that its drives were told last.
    told: Vec<f64>,
    /// Physics that moves the joints, if the robot has masses and drives.
    physics: Option<Box<dyn Physics>>,
    plant: Option<PlantRecord>,
    /// Reason why it moves no more.
    failure: Option<String>,
}

impl SimulatedRobot {
    /// The robot of a run, at rest in the home configuration of a checked program, with masses and drives if the run has a
    /// plant. The scenario is that of the program, for the true places of obstacles.
    ///
    /// # Errors
    /// The run has a plant, and there is no physics.
    pub fn of_run(program: &Program, scenario: Option<&ScenarioProgram>) -> Result<SimulatedRobot, ProgramError> {
        let physics = physics::make(program, scenario).map_err(|text| crate::program::error("", text))?;
        let settings = program.run.simulator.plant.as_ref();
        let plant = physics.as_deref().zip(settings).map(|(physics, settings)| PlantRecord::new(physics, settings));
        Ok(SimulatedRobot { physics, plant, ..SimulatedRobot::new(program) })
    }

    /// A robot without masses, at rest in the home configuration of a checked program.
    pub fn new(program: &Program) -> SimulatedRobot {
        let model = program.robot.model.clone();
        let s = &program.run.simulator;
        let noise = (s.noise > 0.0).then(|| Normal::new(0.0, s.noise).ok()).flatten();
        SimulatedRobot {
            period: program.robot.period,
            lag: s.lag,
            speed: s.speed.unwrap_or(f64::INFINITY),
            acceleration: s.acceleration.unwrap_or(f64::INFINITY),
            noise: noise.map(|n| (n, Pcg64::seed_from_u64(s.seed))),
            q: program.robot.home.clone(),
            v: vec![0.0; model.nv()],
            mean: vec![0.0; model.nv()],
            measured: program.robot.home.clone(),
            told: program.robot.home.clone(),
            physics: None,
            plant: None,
            failure: None,
            model,
        }
    }

    /// True configuration.
    pub fn q(&self) -> &[f64] {
        &self.q
    }

    /// Returns true if the robot follows commands exactly and its measurements are exact.
    pub fn is_perfect(&self) -> bool {
        self.physics.is_none()
            && self.lag == 0.0
            && self.speed == f64::INFINITY
            && self.acceleration == f64::INFINITY
            && self.noise.is_none()
    }

    /// The physics that moves it; `None` for a robot without masses.
    pub fn plant(&self) -> Option<&PlantRecord> {
        self.plant.as_ref()
    }

    /// Reason why the robot moves no more: its simulation has diverged.
    pub fn failure(&self) -> Option<&str> {
        self.failure.as_deref()
    }

    /// Measured configuration: joints with noise, the base without. One whose simulation has diverged measures nothing.
    pub fn measure(&mut self) -> &[f64] {
        if self.failure.is_some() {
            self.measured.fill(f64::NAN);
            return &self.measured;
        }
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

    /// Moves for one period under a constant velocity command, where nobody and nothing that moves is near. Drives of positions are told its
    /// integral.
    pub fn apply(&mut self, command: &[f64]) {
        let mut position = std::mem::take(&mut self.told);
        self.model.integrate(&mut position, command, self.period);
        self.move_by(Drives { velocity: command, position: &position }, None);
        self.told = position;
    }

    /// Moves for one period as it is told, among people and obstacles as they are now.
    pub fn apply_among(&mut self, drives: Drives, around: &Around) {
        self.told.copy_from_slice(drives.position);
        self.move_by(drives, Some(around));
    }

    fn move_by(&mut self, drives: Drives, around: Option<&Around>) {
        let command = drives.velocity;
        let t = self.period;
        if self.failure.is_some() {
            return;
        }
        if let Some(physics) = &mut self.physics {
            for (i, d) in self.model.dofs.iter().enumerate() {
                // The base moves as it is commanded.
                self.mean[i] = if d.q_index.is_none() { command[i].clamp(-d.velocity, d.velocity) } else { 0.0 };
            }
            self.model.integrate(&mut self.q, &self.mean, t);
            self.failure = physics.advance(&mut self.q, drives, t, around).err();
            return;
        }
        for (i, d) in self.model.dofs.iter().enumerate() {
            let most = d.velocity.min(self.speed);
            let wanted = command[i].clamp(-most, most);
            (self.mean[i], self.v[i]) = follow(self.v[i], wanted, t, self.lag, self.acceleration);
        }
        self.model.integrate(&mut self.q, &self.mean, t);
        for d in &self.model.dofs {
            if let Some(i) = d.q_index {
                self.q[i] = self.q[i].clamp(d.lower, d.upper);
            }
        }
    }
}

/// Mean velocity of an actuator over a time, and its velocity at the end: `lag v' = wanted - v`, as far as `|v'|` stays
/// within `most`. Without a lag, the velocity goes to the wanted one as fast as `most` allows.
fn follow(v: f64, wanted: f64, time: f64, lag: f64, most: f64) -> (f64, f64) {
    let behind = v - wanted;
    // First the acceleration is at its limit, until the lag demands no more than that.
    let ramp = if most.is_finite() { ((behind.abs() - most * lag) / most).clamp(0.0, time) } else { 0.0 };
    let slope = if ramp > 0.0 { most * behind.signum() } else { 0.0 };
    let rest = behind - slope * ramp;
    let left = time - ramp;
    let decay = if lag > 0.0 {
        (-left / lag).exp()
    } else if left > 0.0 {
        0.0
    } else {
        1.0
    };
    let way = (behind - 0.5 * slope * ramp) * ramp + rest * lag * (1.0 - decay);
    (wanted + way / time, wanted + rest * decay)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Reference for `follow`: small steps.
    fn in_small_steps(mut v: f64, wanted: f64, time: f64, lag: f64, most: f64) -> (f64, f64) {
        let steps = 200_000;
        let dt = time / f64::from(steps);
        let mut way = 0.0;
        for _ in 0..steps {
            let before = v;
            let pull = if lag > 0.0 { (wanted - v) / lag } else { (wanted - v) / dt };
            v += pull.clamp(-most, most) * dt;
            way += 0.5 * (before + v) * dt;
        }
        (way / time, v)
    }

    #[test]
    fn an_actuator_follows_as_its_equation_says() {
        for (v, wanted) in [(0.0, 1.0), (0.5, -0.5), (1.0, 0.98), (0.3, 0.3), (-1.0, 1.0)] {
            for lag in [0.0, 0.004, 0.05] {
                for most in [0.5, 5.0, 50.0, 1e4] {
                    let (mean, end) = follow(v, wanted, 0.01, lag, most);
                    let (m, e) = in_small_steps(v, wanted, 0.01, lag, most);
                    assert!(
                        (mean - m).abs() < 1e-4 && (end - e).abs() < 1e-4,
                        "{v} {wanted} {lag} {most}: {mean} {m}, {end} {e}"
                    );
                }
            }
        }
        assert_eq!(follow(0.2, 1.0, 0.01, 0.0, f64::INFINITY), (1.0, 1.0));
    }

    proptest! {
        #[test]
        fn an_actuator_neither_overshoots_nor_exceeds_its_acceleration(
            v in -5.0..5.0_f64,
            wanted in -5.0..5.0_f64,
            lag in prop_oneof![Just(0.0), 1e-4..0.2_f64],
            most in prop_oneof![Just(f64::INFINITY), 1e-3..1e3_f64],
        ) {
            let (mean, end) = follow(v, wanted, 0.01, lag, most);
            let (low, high) = (v.min(wanted) - 1e-12, v.max(wanted) + 1e-12);
            prop_assert!((low..=high).contains(&end) && (low..=high).contains(&mean));
            prop_assert!((end - v).abs() <= most * 0.01 * (1.0 + 1e-12) + 1e-15);
        }
    }
}
