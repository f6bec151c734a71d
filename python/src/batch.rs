//! Many robots with one program, stepped at once in threads: the form of environments for learning.

use std::sync::{Arc, Mutex, PoisonError};

use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use runtime::Observation;

use crate::controller::{alone, prepared};
use crate::inputs::signal;
use crate::program::refused;

/// Largest number of robots.
const MOST: usize = 1_000_000;

/// Shares of the robots for each thread: the last ones to end keep the other threads idle for a part of a share only.
const SHARES: usize = 8;

/// A robot of a batch.
struct Member {
    controller: runtime::Controller,
    /// Number of ticks since its restart.
    ticks: u32,
}

/// Robots with one program, each with a controller of its own.
#[pyclass(frozen, module = "hierarq")]
pub(crate) struct Batch {
    program: Arc<runtime::Program>,
    n: usize,
    threads: usize,
    core: Mutex<Core>,
}

/// The part of a batch that a step changes.
struct Core {
    members: Vec<Member>,
    velocity: Vec<f64>,
    position: Vec<f64>,
    faults: Vec<bool>,
}

/// Values of a signal for all robots: its index, and `n` rows of `width` numbers.
struct Rows {
    signal: usize,
    width: usize,
    values: Vec<f64>,
}

impl Batch {
    pub(crate) fn new(
        py: Python<'_>,
        program: &Arc<runtime::Program>,
        n: usize,
        threads: Option<usize>,
    ) -> PyResult<Batch> {
        if n == 0 || n > MOST || threads == Some(0) {
            return Err(refused(format!("a batch has 1 to {MOST} robots and at least one thread")));
        }
        let threads = threads.unwrap_or_else(mission::parallel::threads).min(n);
        let one = || prepared(program, None).map(|controller| Member { controller, ticks: 0 });
        let members: PyResult<Vec<Member>> = py.detach(|| (0..n).map(|_| one()).collect());
        let (nq, nv) = (program.robot.model.nq(), program.robot.model.nv());
        Ok(Batch {
            n,
            threads,
            core: Mutex::new(Core {
                members: members?,
                velocity: vec![0.0; n * nv],
                position: vec![0.0; n * nq],
                faults: vec![false; n],
            }),
            program: program.clone(),
        })
    }

    /// The numbers of an array of the shape `[n, width]`, or `[n]` for a width of one.
    fn rows(&self, what: &str, value: &Bound<'_, PyAny>, width: usize) -> PyResult<Vec<f64>> {
        let n = self.n;
        let array: PyReadonlyArrayDyn<'_, f64> = value.extract().map_err(|_| {
            PyValueError::new_err(format!("{what} must be an array of float64 with the shape [{n}, {width}]"))
        })?;
        let shape = array.shape();
        if shape != [n, width] && !(width == 1 && shape == [n]) {
            return Err(PyValueError::new_err(format!("{what} has the shape {shape:?}, and [{n}, {width}] is needed")));
        }
        Ok(match array.as_slice() {
            Ok(all) => all.to_vec(),
            Err(_) => array.as_array().iter().copied().collect(),
        })
    }
}

/// A share of the robots that a thread steps at once.
struct Share<'a> {
    /// Index of the first one.
    first: usize,
    members: &'a mut [Member],
    velocity: &'a mut [f64],
    position: &'a mut [f64],
    faults: &'a mut [bool],
}

impl Share<'_> {
    fn step(self, model: &robot::Model, period: f64, told: &[Rows]) {
        let (nq, nv) = (model.nq(), model.nv());
        let Share { first, members, velocity, position, faults } = self;
        for (i, member) in members.iter_mut().enumerate() {
            let time = f64::from(member.ticks) * period;
            for rows in told {
                let at = (first + i) * rows.width;
                member.controller.signals().set(rows.signal, &rows.values[at..at + rows.width], time);
            }
            let (q, v) = (&mut position[i * nq..(i + 1) * nq], &mut velocity[i * nv..(i + 1) * nv]);
            let command = member.controller.step(&Observation { time, q });
            v.copy_from_slice(command.velocity);
            q.copy_from_slice(command.position);
            faults[i] = command.fault.is_some();
            member.ticks = member.ticks.saturating_add(1);
        }
    }
}

#[pymethods]
impl Batch {
    /// Executes one tick of each robot, and returns their velocities, shape `[n, nv]`.
    ///
    /// `q` has the shape `[n, nq]`; `signals` maps names to arrays of the shape `[n, width]`. The time of each robot counts from its restart.
    #[pyo3(signature = (q, *, signals = None))]
    fn step<'py>(
        &self,
        py: Python<'py>,
        q: &Bound<'py, PyAny>,
        signals: Option<&Bound<'py, PyDict>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let model = &self.program.robot.model;
        let (nq, nv) = (model.nq(), model.nv());
        let q = self.rows("q", q, nq)?;
        let mut told = Vec::new();
        for (name, value) in signals.into_iter().flat_map(|d| d.iter()) {
            let name: String = name.extract()?;
            let index = signal(&self.program.interface, &name)?;
            let width = self.program.interface.signals[index].sent();
            told.push(Rows { signal: index, width, values: self.rows(&format!("signal `{name}`"), &value, width)? });
        }
        let mut core = alone(&self.core, "batch")?;
        let Core { members, velocity, position, faults } = &mut *core;
        position.copy_from_slice(&q);
        let size = self.n.div_ceil(SHARES * self.threads);
        let numbers = velocity.chunks_mut(size * nv).zip(position.chunks_mut(size * nq));
        let robots = members.chunks_mut(size).zip(faults.chunks_mut(size));
        let share = |(part, ((members, faults), (velocity, position)))| Share {
            first: part * size,
            members,
            velocity,
            position,
            faults,
        };
        let shares: Vec<Share<'_>> = robots.zip(numbers).enumerate().map(share).collect();
        let (shares, period, told) = (Mutex::new(shares.into_iter()), self.program.robot.period, &told);
        let next = || shares.lock().unwrap_or_else(PoisonError::into_inner).next();
        let work = || {
            while let Some(share) = next() {
                share.step(model, period, told);
            }
        };
        py.detach(|| {
            std::thread::scope(|scope| {
                for _ in 1..self.threads {
                    scope.spawn(work);
                }
                // This thread works too: for one of them, none is started.
                work();
            });
        });
        PyArray1::from_slice(py, velocity).reshape([self.n, nv])
    }

    /// The configurations of the last step, each integrated with its velocity over one period, shape `[n, nq]`.
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let core = alone(&self.core, "batch")?;
        PyArray1::from_slice(py, &core.position).reshape([self.n, self.program.robot.model.nq()])
    }

    /// True for each robot that a fault stopped at the last step, shape `[n]`.
    #[getter]
    fn faulted<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<bool>>> {
        Ok(PyArray1::from_slice(py, &alone(&self.core, "batch")?.faults))
    }

    /// Path of a robot's active state.
    fn state(&self, index: usize) -> PyResult<String> {
        let core = alone(&self.core, "batch")?;
        let member = core.members.get(index).ok_or_else(|| self.no_such(index))?;
        Ok(member.controller.state().to_string())
    }

    /// Lets these robots begin anew, by default all.
    #[pyo3(signature = (indices = None))]
    fn restart(&self, indices: Option<Vec<usize>>) -> PyResult<()> {
        let all = indices.unwrap_or_else(|| (0..self.n).collect());
        if let Some(&wrong) = all.iter().find(|&&i| i >= self.n) {
            return Err(self.no_such(wrong));
        }
        let mut core = alone(&self.core, "batch")?;
        for i in all {
            core.members[i].controller.restart();
            core.members[i].ticks = 0;
        }
        Ok(())
    }

    fn __len__(&self) -> usize {
        self.n
    }
}

impl Batch {
    fn no_such(&self, index: usize) -> PyErr {
        refused(format!("there is no robot {index}: the batch has {}, from 0", self.n))
    }
}
