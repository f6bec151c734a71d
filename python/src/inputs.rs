//! Values from Python: arrays and sequences of numbers, and what a host tells a controller by name.

use std::borrow::Cow;

use compiler::names::{list, suggest};
use numpy::{PyReadonlyArray1, PyReadonlyArrayDyn};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict};
use runtime::Signals;
use runtime::program::{Interface, SignalProgram};

/// Largest number of names in a message.
const NAMES: usize = 12;

/// The numbers of an array or a sequence, without a copy if it is a contiguous array of `float64`. The array must not be
/// changed by another thread meanwhile.
pub(crate) fn numbers<R>(what: &str, value: &Bound<'_, PyAny>, use_: impl FnOnce(&[f64]) -> R) -> PyResult<R> {
    if let Ok(array) = value.extract::<PyReadonlyArray1<'_, f64>>() {
        return Ok(match array.as_slice() {
            Ok(all) => use_(all),
            Err(_) => use_(&array.as_array().to_vec()),
        });
    }
    if let Ok(array) = value.extract::<PyReadonlyArrayDyn<'_, f64>>() {
        let shape = array.as_array().shape().to_vec();
        return Err(PyValueError::new_err(format!("{what} has the shape {shape:?}, and one dimension is needed")));
    }
    let all: Vec<f64> = value.extract().map_err(|_| {
        let kind = value.get_type().name().map_or_else(|_| "it".to_string(), |n| n.to_string());
        PyTypeError::new_err(format!("{what} must be an array or a sequence of numbers, not `{kind}`"))
    })?;
    Ok(use_(&all))
}

/// Checks the length of a configuration.
///
/// # Errors
/// It is another one; the message has the names of the numbers.
pub(crate) fn check_length(what: &str, found: usize, names: &[String]) -> PyResult<()> {
    if found == names.len() {
        return Ok(());
    }
    let all = list(names.iter().map(String::as_str), 2 * NAMES);
    Err(PyValueError::new_err(format!("{what} has {found} numbers, and the robot has {}: {all}", names.len())))
}

/// Passes values and events to a controller at a time (s). Nothing is passed if one of them is wrong.
///
/// # Errors
/// A name or a value is wrong.
pub(crate) fn tell(
    to: &mut Signals,
    signals: Option<&Bound<'_, PyDict>>,
    events: Option<&Bound<'_, PyAny>>,
    time: f64,
) -> PyResult<()> {
    let mut values: Vec<(usize, Option<Cow<'_, [f64]>>)> = Vec::new();
    for (name, value) in signals.into_iter().flat_map(|d| d.iter()) {
        let name: String = name.extract()?;
        let index = signal(to.interface(), &name)?;
        let s = &to.interface().signals[index];
        values.push((index, if value.is_none() { None } else { Some(Cow::Owned(value_of(s, &value)?)) }));
    }
    let mut raised = Vec::new();
    if let Some(events) = events {
        // A single name would be read as the sequence of its letters.
        let names: Vec<String> = events.extract::<String>().map(|one| vec![one]).or_else(|_| events.extract())?;
        for name in names {
            raised.push(event(to.interface(), &name)?);
        }
    }
    for (index, value) in values {
        match value {
            Some(value) => {
                to.set(index, &value, time);
            }
            None => to.clear(index),
        }
    }
    for index in raised {
        to.raise(index);
    }
    Ok(())
}

/// The numbers of a signal's value.
fn value_of(s: &SignalProgram, value: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let what = format!("signal `{}`", s.name);
    if s.kind == "flag" {
        let truth = value.cast::<PyBool>().map(|b| b.is_true()).or_else(|_| value.is_truthy());
        return Ok(vec![if truth? { 1.0 } else { -1.0 }]);
    }
    let all = match value.extract::<f64>() {
        Ok(one) => vec![one],
        Err(_) => numbers(&what, value, <[f64]>::to_vec)?,
    };
    if all.len() == s.sent() {
        return Ok(all);
    }
    let form = match (s.kind.as_str(), s.sent()) {
        ("point", 3) => ": x, y, z in m".to_string(),
        ("point", _) => ": x, y, z in m, then the velocity in m/s".to_string(),
        ("orientation", _) => ": a quaternion w, x, y, z".to_string(),
        ("pose", 7) => ": x, y, z in m, then a quaternion w, x, y, z".to_string(),
        ("pose", _) => {
            ": x, y, z in m, a quaternion w, x, y, z, the velocity in m/s, and the angular one in rad/s".into()
        }
        ("wrench", _) => ": the force in N, then the moment in Nm".to_string(),
        _ => String::new(),
    };
    Err(PyValueError::new_err(format!(
        "{what} is given {} numbers, and a value of the type `{}` has {}{form}",
        all.len(),
        s.kind,
        s.sent()
    )))
}

/// Index of a signal that the host may set.
pub(crate) fn signal(interface: &Interface, name: &str) -> PyResult<usize> {
    let own = |s: &&SignalProgram| !s.is_variable();
    if let Some(index) = interface.signal(name) {
        if own(&&interface.signals[index]) {
            return Ok(index);
        }
        return Err(PyValueError::new_err(format!("`{name}` is set by the program, and not by the host")));
    }
    if interface.event(name).is_some() {
        return Err(PyValueError::new_err(format!("`{name}` is an event: name it in `events`")));
    }
    let names = || interface.signals.iter().filter(own).map(|s| s.name.as_str());
    Err(PyValueError::new_err(unknown("signal", name, names)))
}

fn event(interface: &Interface, name: &str) -> PyResult<usize> {
    let names = || interface.events.iter().map(String::as_str);
    interface.event(name).ok_or_else(|| PyValueError::new_err(unknown("event", name, names)))
}

/// Message about a name that does not exist.
pub(crate) fn unknown<'n, I: Iterator<Item = &'n str>>(what: &str, name: &str, names: impl Fn() -> I) -> String {
    let help = match suggest(name, names()) {
        Some(near) => format!("did you mean `{near}`?"),
        None if names().next().is_none() => "there is none".to_string(),
        None => format!("there are {}", list(names(), NAMES)),
    };
    format!("there is no {what} `{name}`: {help}")
}
