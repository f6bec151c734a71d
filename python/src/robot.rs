//! The robot of a program: names, limits, kinematics.

use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::DMatrix;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use robot::{Data, LinkId};

use crate::inputs::{check_length, numbers, unknown};
use crate::program::refused;

/// The robot of a program.
#[pyclass(frozen, module = "hierarq")]
pub(crate) struct Robot {
    program: Arc<runtime::Program>,
    /// Poses of the links at a configuration, overwritten by each question.
    data: Mutex<Data>,
    names: Vec<String>,
}

impl Robot {
    pub(crate) fn new(program: Arc<runtime::Program>) -> Robot {
        let data = Mutex::new(Data::new(&program.robot.model));
        Robot { data, names: program.robot.q_names(), program }
    }

    fn link(&self, name: &str) -> PyResult<LinkId> {
        let model = &self.program.robot.model;
        let names = || model.links.iter().map(|l| l.name.as_str());
        model.link(name).ok_or_else(|| refused(unknown("link", name, names)))
    }

    /// Answers a question at a configuration.
    fn at<R>(&self, q: &Bound<'_, PyAny>, answer: impl FnOnce(&Data) -> R) -> PyResult<R> {
        let all = numbers("q", q, <[f64]>::to_vec)?;
        check_length("q", all.len(), &self.names)?;
        let mut data = self.data.lock().unwrap_or_else(PoisonError::into_inner);
        self.program.robot.model.forward(&all, &mut data);
        Ok(answer(&data))
    }
}

#[pymethods]
impl Robot {
    /// Name in the URDF.
    #[getter]
    fn name(&self) -> &str {
        &self.program.robot.model.name
    }

    /// Length of a configuration.
    #[getter]
    fn nq(&self) -> usize {
        self.program.robot.model.nq()
    }

    /// Length of a velocity: the number of degrees of freedom.
    #[getter]
    fn nv(&self) -> usize {
        self.program.robot.model.nv()
    }

    /// Names of the numbers of a configuration.
    #[getter]
    fn q_names(&self) -> Vec<String> {
        self.names.clone()
    }

    /// Names of the degrees of freedom.
    #[getter]
    fn v_names(&self) -> Vec<String> {
        self.program.robot.model.dofs.iter().map(|d| d.name.clone()).collect()
    }

    /// Names of the links.
    #[getter]
    fn links(&self) -> Vec<String> {
        self.program.robot.model.links.iter().map(|l| l.name.clone()).collect()
    }

    /// The home configuration, shape `[nq]`.
    #[getter]
    fn home<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.program.robot.home)
    }

    /// Lower limits of the degrees of freedom, shape `[nv]`, in rad or m.
    #[getter]
    fn lower<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.program.robot.model.dofs.iter().map(|d| d.lower))
    }

    /// Upper limits of the degrees of freedom, shape `[nv]`, in rad or m.
    #[getter]
    fn upper<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.program.robot.model.dofs.iter().map(|d| d.upper))
    }

    /// Speed limits, shape `[nv]`, in rad/s or m/s.
    #[getter]
    fn max_velocity<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.program.robot.model.dofs.iter().map(|d| d.velocity))
    }

    /// A link's pose in the world at a configuration, as a homogeneous matrix of the shape `[4, 4]`.
    fn pose<'py>(&self, py: Python<'py>, q: &Bound<'py, PyAny>, link: &str) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let id = self.link(link)?;
        let pose = self.at(q, |data| data.pose(id).to_homogeneous())?;
        PyArray1::from_iter(py, pose.transpose().iter().copied()).reshape([4, 4])
    }

    /// Jacobian of a link's origin at a configuration, shape `[6, nv]`: three linear rows, then three angular ones, along the axes of the world.
    fn jacobian<'py>(&self, py: Python<'py>, q: &Bound<'py, PyAny>, link: &str) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let id = self.link(link)?;
        let (model, nv) = (&self.program.robot.model, self.nv());
        let rows = self.at(q, |data| {
            let mut rows = DMatrix::zeros(6, nv);
            data.jacobian(model, id, &data.position(id).clone_owned(), &mut rows);
            rows
        })?;
        PyArray1::from_iter(py, rows.transpose().iter().copied()).reshape([6, nv])
    }

    /// Indices of the numbers of a configuration in a list of joints of a driver: `q = driver_positions[robot.order(driver_names)]`.
    fn order<'py>(&self, py: Python<'py>, names: Vec<String>) -> PyResult<Bound<'py, PyArray1<usize>>> {
        let mut order = Vec::with_capacity(self.names.len());
        for wanted in &self.names {
            let known = || names.iter().map(String::as_str);
            let place = names.iter().position(|n| n == wanted);
            order.push(place.ok_or_else(|| {
                refused(format!("the list lacks a joint of the robot: {}", unknown("joint", wanted, known)))
            })?);
        }
        Ok(PyArray1::from_vec(py, order))
    }

    fn __repr__(&self) -> String {
        format!("<hierarq.Robot `{}` with {} degrees of freedom>", self.name(), self.nv())
    }
}
