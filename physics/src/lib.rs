//! The robot of a compiled program in the physics of [MuJoCo](https://mujoco.org): masses, gravity, drives that push with
//! limited torques, friction, a payload, and contacts with obstacles and people.
//!
//! [`room`] is what is around the robot, [`mjcf`] writes a MuJoCo model of both, [`library`] finds MuJoCo at run time and calls
//! it, and [`plant`] is what the simulated robot of the runtime moves by. [`provide`] makes it available to every run of this
//! process.

pub mod geometry;
pub mod library;
pub mod mjcf;
pub mod overlaps;
pub mod plant;
pub mod room;

use runtime::physics::Physics;
use runtime::program::{Program, ScenarioProgram};

/// Makes the physics available to every run of this process.
pub fn provide() {
    runtime::physics::provide(make);
}

/// Makes the physical robot of a program whose run asks for one.
///
/// # Errors
/// MuJoCo is not installed, or refuses the robot, in words for the user.
pub fn make(program: &Program, scenario: Option<&ScenarioProgram>) -> Result<Box<dyn Physics>, String> {
    let plant = plant::Plant::new(program, scenario).map_err(|e| e.to_string())?;
    Ok(Box::new(plant))
}
