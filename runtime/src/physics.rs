//! Physics of the simulated robot: masses, drives and contacts, which a library computes. The runtime knows only what it has to
//! ask; the crate for physics provides the rest to the process.

use std::sync::OnceLock;

use serde::Serialize;

use crate::program::{Actuators, PlantProgram, Program, ScenarioProgram};

/// The surroundings of a robot at a tick.
#[derive(Clone, Copy, Debug)]
pub struct Around<'a> {
    /// Time since the start of the run (s).
    pub time: f64,
    /// Table of signals, with the true motion of people and of what is tracked.
    pub signals: &'a [f64],
}

/// The physics that moved the robot of a run, for reports.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PlantRecord {
    /// Name and version of the library.
    pub engine: String,
    /// Time step, in s.
    pub step_s: f64,
    /// Quantity that the drives followed.
    pub actuators: Actuators,
    /// Time constant of the drives, in s.
    pub response_s: f64,
}

impl PlantRecord {
    pub(crate) fn new(physics: &dyn Physics, settings: &PlantProgram) -> PlantRecord {
        PlantRecord {
            engine: physics.name().to_string(),
            step_s: physics.step(),
            actuators: settings.actuators,
            response_s: settings.response,
        }
    }

    /// A sentence for people.
    pub fn describe(&self) -> String {
        let drives = match self.actuators {
            Actuators::Velocity => "velocities",
            Actuators::Position => "positions",
        };
        let ms = |s: f64| format!("{} ms", (s * 1e6).round() / 1e3);
        let (engine, step, response) = (&self.engine, ms(self.step_s), ms(self.response_s));
        format!("{engine} moved the robot, in steps of {step}, by drives of {drives} with a response of {response}")
    }
}

/// What drives are told until the next tick.
#[derive(Clone, Copy, Debug)]
pub struct Drives<'a> {
    /// Velocity, `nv` numbers.
    pub velocity: &'a [f64],
    /// Configuration to be reached at the next tick, `nq` numbers.
    pub position: &'a [f64],
}

/// A robot with masses and drives.
pub trait Physics: Send {
    /// Name and version of the library, for reports.
    fn name(&self) -> &str;

    /// Its time step (s).
    fn step(&self) -> f64;

    /// Moves for a period (s) under a constant velocity command, or on a straight way to the position that is told. In the configuration `q`, `nq` numbers, the
    /// base has moved already; the joints are those before the period, and become those after it. Without `around`,
    /// nobody and nothing that moves is there.
    ///
    /// # Errors
    /// The simulation has diverged, in words for the user.
    fn advance(&mut self, q: &mut [f64], drives: Drives, period: f64, around: Option<&Around>) -> Result<(), String>;
}

/// Makes the physical robot of a program whose run asks for one, or says why there is none.
pub type Make = fn(&Program, Option<&ScenarioProgram>) -> Result<Box<dyn Physics>, String>;

static MAKE: OnceLock<Make> = OnceLock::new();

/// Makes physics available to every run of this process. The first one that is provided stays.
pub fn provide(make: Make) {
    let _ = MAKE.set(make);
}

/// Makes the physical robot of a program; `None` if its run asks for none.
///
/// # Errors
/// This process has no physics, or the robot cannot be made.
pub(crate) fn make(program: &Program, scenario: Option<&ScenarioProgram>) -> Result<Option<Box<dyn Physics>>, String> {
    if program.run.simulator.plant.is_none() {
        return Ok(None);
    }
    let Some(make) = MAKE.get() else {
        return Err(
            "this run has a `plant`, and this program was built without physics: `cargo build --release --features \
                    physics` builds one with it"
                .to_string(),
        );
    };
    make(program, scenario).map(Some).map_err(|why| format!("this run has a `plant`, and {why}"))
}
