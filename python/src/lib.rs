//! Hierarq for Python: the extension module `hierarq._hierarq`, which the package `hierarq` wraps.
//!
//! Specs are checked and compiled by the compiler of the command line, and controllers are [`runtime::Controller`]: nothing is computed
//! here. Arrays of NumPy enter and leave, in SI units, and the interpreter is released while something is computed.

mod batch;
mod command;
mod controller;
mod inputs;
mod interruption;
mod mission;
mod program;
mod reading;
mod robot;
mod simulation;
mod sweep;

use pyo3::prelude::*;

#[pymodule]
mod _hierarq {
    /// Runs with a `plant` find their physics.
    #[pymodule_init]
    fn init(_module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        physics::provide();
        Ok(())
    }

    #[pymodule_export]
    use super::batch::Batch;
    #[pymodule_export]
    use super::command::Command;
    #[pymodule_export]
    use super::controller::Controller;
    #[pymodule_export]
    use super::mission::Mission;
    #[pymodule_export]
    use super::program::Program;
    #[pymodule_export]
    use super::reading::compile;
    #[pymodule_export]
    use super::robot::Robot;
    #[pymodule_export]
    use super::simulation::{plan, simulate, test};
    #[pymodule_export]
    use super::sweep::{merged, sweep, sweep_runs};
}
