//! Physics of the simulated robot: masses, drives and contacts, which a library computes. The runtime knows only what it has to
//! ask; the crate for physics provides the rest to the process.

use std::sync::OnceLock;

use crate::program::{Program, ScenarioProgram};

/// A robot with masses and drives.
pub trait Physics: Send {
    /// Name and version of the library, for reports.
    fn name(&self) -> &str;

    /// Moves for a period (s) under a constant velocity command, `nv` numbers. In the configuration `q`, `nq` numbers, the
    /// base has moved already; the joints are those before the period, and become those after it.
    ///
    /// # Errors
    /// The simulation has diverged, in words for the user.
    fn advance(&mut self, q: &mut [f64], command: &[f64], period: f64) -> Result<(), String>;
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
    make(program, scenario).map(Some)
}
