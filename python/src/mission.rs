//! Missions under way: a host lets time pass, tells what happens, and asks for the plan again.

use std::sync::Mutex;

use mission::kind::Form;
use mission::kind::pages::{Client, JournalSink, MissionSession, Refusal, Request, ServeSettings, Session};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use runtime::program::MissionProgram;
use serde_json::{Value, json};
use views::gantt;

use crate::controller::alone;
use crate::inputs::unknown;
use crate::program::refused;

/// A mission under way, with its plan. Times are in s since its start.
#[pyclass(frozen, module = "hierarq")]
pub(crate) struct Mission {
    name: String,
    session: Mutex<MissionSession>,
}

/// An activity of a plan.
#[derive(IntoPyObject)]
struct Activity {
    /// Name of the member.
    member: String,
    /// Name of the activity.
    activity: &'static str,
    /// The work that it belongs to.
    title: String,
    /// Start (s).
    start: f64,
    /// End (s).
    end: f64,
    /// Mean speed of a motion (m/s).
    speed: Option<f64>,
}

impl Mission {
    /// Plans a mission and stands at its start.
    ///
    /// # Errors
    /// There is no such member, or no plan.
    pub(crate) fn new(
        py: Python<'_>,
        program: &MissionProgram,
        reporting: &[String],
        seed: Option<u64>,
    ) -> PyResult<Mission> {
        let of: &dyn mission::kind::Mission = &*program.kind;
        let reporting = reporting.iter().map(|name| member(of, name)).collect::<PyResult<Vec<usize>>>()?;
        let settings = ServeSettings { sampled: seed, reporting, nodes: None };
        let session = py.detach(|| MissionSession::new(of, &settings)).map_err(refused)?;
        Ok(Mission { name: program.name.clone(), session: Mutex::new(session) })
    }

    /// Passes a request on, without the interpreter: the plan may be made anew.
    fn handle(&self, py: Python<'_>, request: &Request) -> PyResult<String> {
        let mut guard = alone(&self.session, "mission")?;
        let session = &mut *guard;
        let reply = py.detach(|| session.handle(request, true, &mut JournalSink::replay()));
        reply.map_err(|why| match why {
            Refusal::Invalid(why) | Refusal::NotNow(why) => refused(why),
        })
    }
}

/// Index of a member.
fn member(of: &dyn mission::kind::Mission, name: &str) -> PyResult<usize> {
    let members = of.members();
    let names = || members.iter().map(|m| m.name);
    names().position(|n| n == name).ok_or_else(|| refused(unknown("member", name, names)))
}

/// A dict as JSON.
fn data(py: Python<'_>, value: &Bound<'_, PyAny>) -> PyResult<Value> {
    let text: String = py.import("json")?.call_method1("dumps", (value,))?.extract()?;
    serde_json::from_str(&text).map_err(refused)
}

/// JSON as a value of Python.
fn told<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (value.to_string(),))
}

#[pymethods]
impl Mission {
    /// Name in the spec.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// Kind: the word of the language, `schedule`.
    #[getter]
    fn kind(&self) -> PyResult<&'static str> {
        Ok(alone(&self.session, "mission")?.mission().kind().name)
    }

    /// Members and their roles.
    #[getter]
    fn members(&self) -> PyResult<Vec<(String, &'static str)>> {
        let session = alone(&self.session, "mission")?;
        Ok(session.mission().members().into_iter().map(|m| (m.name.to_string(), m.role)).collect())
    }

    /// Events that can be told, each with its further keys.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        for event in alone(&self.session, "mission")?.mission().kind().events {
            out.set_item(event.name, event.with.iter().map(|f| f.key).collect::<Vec<_>>())?;
        }
        Ok(out)
    }

    /// Present time (s).
    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(alone(&self.session, "mission")?.time())
    }

    /// Time at which everything was done (s); `None` while something is to be done.
    #[getter]
    fn done(&self) -> PyResult<Option<f64>> {
        Ok(alone(&self.session, "mission")?.execution().done())
    }

    /// Reason why there is no plan for everything any more; `None` if there is one.
    #[getter]
    fn stranded(&self) -> PyResult<Option<String>> {
        Ok(alone(&self.session, "mission")?.execution().stranded())
    }

    /// Activities as they were performed, and those that are to come by the present plan: dicts with `member`, `activity`, `title`, `start`
    /// and `end` (s), and `speed` (m/s).
    #[getter]
    fn activities(&self) -> PyResult<Vec<Activity>> {
        let chart = alone(&self.session, "mission")?.execution().chart();
        let of = |row: mission::chart::Row| {
            let name = row.name;
            row.bars.into_iter().map(move |bar| Activity {
                member: name.clone(),
                activity: bar.style.name,
                title: bar.title,
                start: bar.start,
                end: bar.end,
                speed: bar.speed,
            })
        };
        Ok(chart.rows.into_iter().flat_map(of).collect())
    }

    /// The log: times (s) and sentences.
    #[getter]
    fn log(&self) -> PyResult<Vec<(f64, String)>> {
        let session = alone(&self.session, "mission")?;
        Ok(session.execution().log().into_iter().map(|entry| (entry.time, entry.text)).collect())
    }

    /// Results so far: a dict with the keys of the kind in `hierarq test --json`.
    #[getter]
    fn outcome<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let outcome = alone(&self.session, "mission")?.execution().outcome();
        told(py, &outcome.data)
    }

    /// A measure of the mission, or of a member: a number in SI units, a truth value, or a point (m) of the shape `[3]`.
    #[pyo3(signature = (name, member = None))]
    fn measure<'py>(&self, py: Python<'py>, name: &str, member: Option<&str>) -> PyResult<Bound<'py, PyAny>> {
        let session = alone(&self.session, "mission")?;
        let of = session.mission();
        let index = member.map(|m| self::member(of, m)).transpose()?;
        let role = index.map(|i| of.members()[i].role);
        let all = (of.kind().measures)();
        let names = || all.iter().filter(|m| m.is_of(role)).map(|m| m.name);
        let measure = of.kind().measure(role, name).ok_or_else(|| refused(unknown("measure", name, names)))?;
        let value = session.execution().measure(name, index);
        match measure.form {
            Form::Number(_) => Ok(value[0].into_pyobject(py)?.into_any()),
            Form::Truth => Ok((value[0] > 0.0).into_pyobject(py)?.to_owned().into_any()),
            Form::Point => Ok(PyArray1::from_slice(py, &value).into_any()),
            Form::OfController => Err(refused(format!("`{name}` is of the controller that the member runs"))),
        }
    }

    /// Lets time pass until `to` (s).
    ///
    /// Raises `ValueError` for a time before the present.
    fn advance(&self, py: Python<'_>, to: f64) -> PyResult<()> {
        let mut guard = alone(&self.session, "mission")?;
        let session = &mut *guard;
        let now = session.time();
        if !to.is_finite() || to < now {
            return Err(refused(format!("the mission is at {now} s and cannot go to {to} s")));
        }
        py.detach(|| session.advance(to));
        Ok(())
    }

    /// Tells that something happens now, and returns its effect on the plan as a sentence: `tell("late", "anna", by=30)`. `tell("replan")`
    /// asks for a new plan. Keys are those of the event in scenarios, in SI units.
    ///
    /// Raises `ValueError` if it is no event of this kind, or cannot happen now; nothing has changed then.
    #[pyo3(signature = (event, member = None, **keys))]
    fn tell(
        &self,
        py: Python<'_>,
        event: &str,
        member: Option<&str>,
        keys: Option<&Bound<'_, PyDict>>,
    ) -> PyResult<String> {
        let mut body = match keys {
            Some(keys) => data(py, keys.as_any())?,
            None => json!({}),
        };
        body["what"] = json!(event);
        if let Some(member) = member {
            body["member"] = json!(self::member(alone(&self.session, "mission")?.mission(), member)?);
        }
        self.handle(py, &Request { from: Client::Supervisor, body })
    }

    /// The page of a person who reports, as a dict: its buttons have the requests that make sense now.
    fn page<'py>(&self, py: Python<'py>, member: &str) -> PyResult<Bound<'py, PyAny>> {
        let session = alone(&self.session, "mission")?;
        let index = self::member(session.mission(), member)?;
        match session.data(true).people.get(&index) {
            Some(page) => told(py, &serde_json::to_value(page).map_err(refused)?),
            None => {
                Err(refused(format!("`{member}` does not report: begin the mission with `reporting=[\"{member}\"]`")))
            }
        }
    }

    /// Passes on a request of a person who reports, one of those of `page`, and returns the reply.
    ///
    /// Raises `ValueError` if it makes no sense now; nothing has changed then.
    fn report(&self, py: Python<'_>, member: &str, request: &Bound<'_, PyDict>) -> PyResult<String> {
        let index = self::member(alone(&self.session, "mission")?.mission(), member)?;
        let body = data(py, request.as_any())?;
        self.handle(py, &Request { from: Client::Person(index), body })
    }

    /// The Gantt chart of the present plan as SVG, which notebooks show.
    fn _repr_svg_(&self) -> PyResult<String> {
        Ok(gantt::svg(&alone(&self.session, "mission")?.execution().chart()))
    }

    fn __repr__(&self) -> PyResult<String> {
        Ok(format!("<hierarq.Mission `{}` at {:.1} s>", self.name, self.time()?))
    }
}
