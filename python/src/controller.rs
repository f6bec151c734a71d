//! Controllers, stepped from Python.

use std::sync::{Arc, Mutex, MutexGuard, TryLockError};

use numpy::PyArray1;
use pyo3::exceptions::{PyRuntimeError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use runtime::Observation;

use crate::command::{Command, Layout};
use crate::inputs::{check_length, numbers, tell, unknown};
use crate::program::refused;

/// A program made ready, with its state between ticks.
#[pyclass(frozen, module = "hierarq")]
pub(crate) struct Controller {
    program: Arc<runtime::Program>,
    layout: Arc<Layout>,
    /// Names of the numbers of a configuration.
    names: Vec<String>,
    /// Time between two calls that the host has told (s).
    interval: Option<f64>,
    core: Mutex<Core>,
}

/// The part of a controller that a tick changes.
struct Core {
    controller: runtime::Controller,
    /// Time that the host gave last (s), or 0, and the number of ticks since then. A sum of periods would drift from the times of a
    /// run, which are multiples of the period.
    base: f64,
    ticks: u32,
    /// True before the first tick.
    is_new: bool,
    q: Vec<f64>,
}

/// Locks a value that only one thread may use at a time.
///
/// # Errors
/// Another thread uses it: waiting for it would hold up the interpreter, which that thread may need.
pub(crate) fn alone<'m, T>(mutex: &'m Mutex<T>, what: &str) -> PyResult<MutexGuard<'m, T>> {
    match mutex.try_lock() {
        Ok(guard) => Ok(guard),
        Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
        Err(TryLockError::WouldBlock) => {
            Err(PyRuntimeError::new_err(format!("this {what} is in use by another thread: give each thread its own")))
        }
    }
}

/// The controller of a program, of its run or of one of its stacks.
pub(crate) fn prepared(program: &runtime::Program, stack: Option<&str>) -> PyResult<runtime::Controller> {
    match stack {
        None => runtime::Controller::new(program).map_err(refused),
        Some(name) => {
            let names = || program.stacks.iter().map(|s| s.name.as_str());
            let index = names().position(|n| n == name).ok_or_else(|| refused(unknown("stack", name, names)))?;
            runtime::Controller::for_stack(program, index).map_err(refused)
        }
    }
}

impl Controller {
    pub(crate) fn new(
        py: Python<'_>,
        program: Arc<runtime::Program>,
        stack: Option<&str>,
        interval: Option<f64>,
    ) -> PyResult<Controller> {
        if interval.is_some_and(|i| !(i.is_finite() && i > 0.0)) {
            return Err(refused("`interval` is the time between two calls: a positive, finite number of seconds"));
        }
        let deadline = program.robot.deadline;
        if let Some(interval) = interval.filter(|i| *i > deadline) {
            let text = format!(
                "`interval` is {interval} s, and each call would be later than the robot's `deadline` of {deadline} s"
            );
            return Err(refused(text));
        }
        let controller = py.detach(|| prepared(&program, stack))?;
        Ok(Controller {
            layout: Arc::new(Layout::new(&controller)),
            names: program.robot.q_names(),
            core: Mutex::new(Core {
                controller,
                base: 0.0,
                ticks: 0,
                is_new: true,
                q: vec![0.0; program.robot.model.nq()],
            }),
            interval,
            program,
        })
    }
}

#[pymethods]
impl Controller {
    /// Executes one tick and returns the command until the next one.
    ///
    /// `q` is the measured configuration, shape `[nq]`, in rad or m, in the order of `robot.q_names`. `t` is the time (s) since the
    /// start of the controller, by default one period after the last call. With `t`, calls may come at any rate: the motion is the same. The robot
    /// then stands still until the second call, which tells the time between two, unless the controller was made with `interval`. `signals` maps names to values in SI units, each received now: a
    /// number, a truth value, an array, or `None` for a signal that has become absent. `humans` maps people to points and those to positions
    /// (m). `events` are names of events that occurred. `enabled` tells whether the robot takes commands, until told again: while it does not, the
    /// reference stays with it, and afterwards it stands until `resume`.
    ///
    /// Names and lengths that are wrong raise `ValueError`, and nothing happens. Everything else that is wrong, such as numbers that are not
    /// finite or a time that goes back, is a fault of the controller: the velocity is zero.
    #[pyo3(signature = (q, *, t = None, enabled = None, signals = None, humans = None, events = None))]
    #[allow(clippy::too_many_arguments, reason = "keywords in Python")]
    fn step(
        &self,
        py: Python<'_>,
        q: &Bound<'_, PyAny>,
        t: Option<f64>,
        enabled: Option<bool>,
        signals: Option<&Bound<'_, PyDict>>,
        humans: Option<&Bound<'_, PyDict>>,
        events: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Command> {
        let mut core = alone(&self.core, "controller")?;
        let Core { controller, base, ticks, is_new, q: own } = &mut *core;
        let found = numbers("q", q, |all| {
            if all.len() == own.len() {
                own.copy_from_slice(all);
            }
            all.len()
        })?;
        check_length("q", found, &self.names)?;
        let time = t.unwrap_or(*base + f64::from(*ticks) * self.program.robot.period);
        if let Some(humans) = humans {
            tell(controller.signals(), Some(&points(py, humans)?), None, time)?;
        }
        if signals.is_some() || events.is_some() {
            tell(controller.signals(), signals, events, time)?;
        }
        if std::mem::replace(is_new, false) {
            // Without times, calls come once a period; with them, the time between two calls is the host's.
            controller.called_every(self.interval.or(t.is_none().then_some(self.program.robot.period)));
        }
        if let Some(enabled) = enabled {
            controller.set_enabled(enabled);
        }
        if let Some(t) = t {
            (*base, *ticks) = (t, 0);
        }
        *ticks = ticks.saturating_add(1);
        Ok(py.detach(|| Command::step(&self.layout, controller, &Observation { time, q: own })))
    }

    /// Begins anew: the next tick is the first one, at time 0 unless told.
    fn restart(&self) -> PyResult<()> {
        let mut core = alone(&self.core, "controller")?;
        core.controller.restart();
        (core.base, core.ticks, core.is_new) = (0.0, 0, true);
        Ok(())
    }

    /// Brings the robot to rest within its limits, where it stands until `resume`: call `step` until its command is `at_rest`.
    fn stop(&self) -> PyResult<()> {
        alone(&self.core, "controller")?.controller.stop();
        Ok(())
    }

    /// Lets a robot go on that was stopped, or that takes commands again: from where it is, from rest.
    fn resume(&self) -> PyResult<()> {
        alone(&self.core, "controller")?.controller.resume();
        Ok(())
    }

    /// Tells that the bases are elsewhere in the next observation, because they were localised anew: the reference moves with them. Without
    /// this, a reading that no base can have reached is the fault `jump`.
    fn relocated(&self) -> PyResult<()> {
        alone(&self.core, "controller")?.controller.relocated();
        Ok(())
    }

    /// Path of the innermost active state; empty without a machine.
    #[getter]
    fn state(&self) -> PyResult<String> {
        Ok(alone(&self.core, "controller")?.controller.state().to_string())
    }

    /// True if the machine has ended.
    #[getter]
    fn is_final(&self) -> PyResult<bool> {
        Ok(alone(&self.core, "controller")?.controller.is_final())
    }

    /// True if a fault keeps the robot still until `restart`.
    #[getter]
    fn is_halted(&self) -> PyResult<bool> {
        Ok(alone(&self.core, "controller")?.controller.is_halted())
    }

    /// Time between two ticks (s).
    #[getter]
    fn period(&self) -> f64 {
        self.program.robot.period
    }

    /// Mean rate of the calls (Hz), faults of time left out; `None` before the second one.
    #[getter]
    fn measured_rate(&self) -> PyResult<Option<f64>> {
        Ok(alone(&self.core, "controller")?.controller.intervals().rate())
    }

    /// The configuration that the robot should have at the next tick, shape `[nq]`.
    #[getter]
    fn reference<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(PyArray1::from_slice(py, alone(&self.core, "controller")?.controller.reference()))
    }

    /// The value of a signal or a variable at the last tick, in SI units; `None` if it is absent.
    fn value<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let names = || self.program.interface.signals.iter().map(|s| s.name.as_str());
        let index = self.program.interface.signal(name).ok_or_else(|| refused(unknown("signal", name, names)))?;
        let mut core = alone(&self.core, "controller")?;
        let signals = core.controller.signals();
        Ok(signals.is_present(index).then(|| PyArray1::from_slice(py, signals.value(index))))
    }

    fn __repr__(&self) -> String {
        format!("<hierarq.Controller of `{}`>", self.program.name)
    }
}

/// The points of people as signals: `{"worker": {"hand": [..]}}` is the signal `worker.hand`.
fn points<'py>(py: Python<'py>, humans: &Bound<'py, PyDict>) -> PyResult<Bound<'py, PyDict>> {
    let signals = PyDict::new(py);
    for (name, of) in humans.iter() {
        let of = of.cast::<PyDict>().map_err(|_| {
            PyTypeError::new_err(format!(
                "the points of `{name}` must be a dict: {{\"{name}\": {{\"hand\": [x, y, z]}}}}"
            ))
        })?;
        for (point, value) in of.iter() {
            signals.set_item(format!("{name}.{point}"), value)?;
        }
    }
    Ok(signals)
}
