//! Compiled programs.

use std::sync::Arc;

use compiler::Compiled;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use runs::project;
use runtime::program::{CompiledFile, MissionProgram};

use crate::batch::Batch;
use crate::controller::Controller;
use crate::mission::Mission;
use crate::robot::Robot;

/// A compiled spec: data that nothing changes.
#[pyclass(frozen, module = "hierarq")]
pub(crate) struct Program {
    /// The spec, as the user named it.
    pub spec: String,
    /// The program of the robot; `None` for a spec with missions alone.
    pub program: Option<Arc<runtime::Program>>,
    /// The missions.
    pub missions: Arc<Vec<MissionProgram>>,
}

/// Error of something that cannot be done with the values that were given.
pub(crate) fn refused(message: impl ToString) -> PyErr {
    PyValueError::new_err(message.to_string())
}

impl Program {
    pub(crate) fn new(spec: String, compiled: Compiled) -> Program {
        Program { spec, program: compiled.program.map(Arc::new), missions: Arc::new(compiled.missions) }
    }

    /// The program of the robot.
    ///
    /// # Errors
    /// The spec has missions alone.
    pub(crate) fn of_robot(&self) -> PyResult<&Arc<runtime::Program>> {
        self.program.as_ref().ok_or_else(|| refused(format!("`{}` declares missions and no robot", self.spec)))
    }
}

#[pymethods]
impl Program {
    /// Name of the spec.
    #[getter]
    fn name(&self) -> String {
        self.program.as_ref().map_or_else(|| self.spec.clone(), |p| p.name.clone())
    }

    /// Time between two ticks (s).
    #[getter]
    fn period(&self) -> PyResult<f64> {
        Ok(self.of_robot()?.robot.period)
    }

    /// Duration of its run (s).
    #[getter]
    fn duration(&self) -> PyResult<f64> {
        Ok(self.of_robot()?.run.duration)
    }

    /// Signals that the host sends: name, type, and the number of numbers of a value.
    #[getter]
    fn signals(&self) -> PyResult<Vec<(String, String, usize)>> {
        let all = self.of_robot()?.interface.signals.iter().filter(|s| !s.is_variable());
        Ok(all.map(|s| (s.name.clone(), s.kind.clone(), s.sent())).collect())
    }

    /// Names of the events.
    #[getter]
    fn events(&self) -> PyResult<Vec<String>> {
        Ok(self.of_robot()?.interface.events.clone())
    }

    /// Names of the stacks.
    #[getter]
    fn stacks(&self) -> PyResult<Vec<String>> {
        Ok(self.of_robot()?.stacks.iter().map(|s| s.name.clone()).collect())
    }

    /// Paths of the states of the machine; empty without one.
    #[getter]
    fn states(&self) -> Vec<String> {
        let machine = self.program.as_ref().and_then(|p| p.machine.as_ref());
        machine.into_iter().flat_map(|m| &m.states[1..]).map(|s| s.name.clone()).collect()
    }

    /// Names of the scenarios.
    #[getter]
    fn scenarios(&self) -> Vec<String> {
        let all = runs::scenario_runner::scenarios(self.program.as_deref(), &self.missions);
        all.map(|found| found.name().to_string()).collect()
    }

    /// Names of the missions.
    #[getter]
    fn missions(&self) -> Vec<String> {
        self.missions.iter().map(|m| m.name.clone()).collect()
    }

    /// The robot.
    #[getter]
    fn robot(&self) -> PyResult<Robot> {
        Ok(Robot::new(self.of_robot()?.clone()))
    }

    /// The compiled program, in the format of `hierarq compile --format json`.
    fn to_json(&self, py: Python<'_>) -> PyResult<String> {
        let program = self.program.as_deref();
        let text = || {
            let stopping = program.map(runtime::stopping::of_stacks);
            CompiledFile::to_json_with(&self.name(), program, &self.missions, stopping)
        };
        py.detach(text).map_err(refused)
    }

    /// A new controller, of the run of the spec or of the stack that is named. `interval` is the time (s) between two calls of its `step`, where
    /// they carry times.
    #[pyo3(signature = (stack = None, *, interval = None))]
    fn controller(&self, py: Python<'_>, stack: Option<&str>, interval: Option<f64>) -> PyResult<Controller> {
        Controller::new(py, self.of_robot()?.clone(), stack, interval)
    }

    /// Controllers of `n` robots that are stepped at once, in as many `threads` as there are processors unless told.
    #[pyo3(signature = (n, threads = None))]
    fn batch(&self, py: Python<'_>, n: usize, threads: Option<usize>) -> PyResult<Batch> {
        Batch::new(py, self.of_robot()?, n, threads)
    }

    /// A mission under way, planned, at its start. Members that are `reporting` end their work when they say so; `seed` draws the true durations
    /// of the others, which are as planned without it.
    #[pyo3(signature = (name = None, *, reporting = Vec::new(), seed = None))]
    fn mission(
        &self,
        py: Python<'_>,
        name: Option<&str>,
        reporting: Vec<String>,
        seed: Option<u64>,
    ) -> PyResult<Mission> {
        let chosen = project::mission(&self.missions, name).map_err(|e| refused(format!("{}: {e}", self.spec)))?;
        Mission::new(py, chosen, &reporting, seed)
    }

    fn __repr__(&self) -> String {
        format!("<hierarq.Program `{}` of {}>", self.name(), self.spec)
    }
}
