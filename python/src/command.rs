//! The outcome of a tick.

use std::sync::Arc;

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use runtime::Member;
use solver::{Active, LevelStatus};
use stdlib_tasks::task::RowKind;

/// The tasks and levels of the stacks of a controller, the same at each tick.
pub(crate) struct Layout {
    stacks: Vec<Stack>,
}

struct Stack {
    members: Vec<Member>,
    levels: Vec<Level>,
    locked: usize,
}

struct Level {
    name: String,
    hard: bool,
    /// Index of its first row among the rows of all levels.
    first: usize,
}

impl Layout {
    /// Collects the tasks and levels of a controller.
    pub(crate) fn new(controller: &runtime::Controller) -> Layout {
        let stack = |s: &runtime::controller::StackController| {
            let mut first = 0;
            let levels = s.level_names().iter().zip(&s.problem().levels).map(|(name, l)| {
                let level = Level { name: name.clone(), hard: l.hard, first };
                first += l.rows();
                level
            });
            let levels = levels.collect();
            Stack { levels, members: s.evaluator().members().to_vec(), locked: s.evaluator().locked().len() }
        };
        Layout { stacks: controller.stacks().iter().map(stack).collect() }
    }
}

/// A level at a tick.
struct Outcome {
    status: LevelStatus,
    violation: f64,
    freedom: usize,
}

/// Velocity and state after a tick, and the numbers that explain them, in SI units. Later ticks do not change them.
#[pyclass(frozen, module = "hierarq")]
pub(crate) struct Command {
    layout: Arc<Layout>,
    /// Index of the stack that ran.
    stack: usize,
    time: f64,
    velocity: Vec<f64>,
    position: Vec<f64>,
    state: String,
    fault: Option<(&'static str, String)>,
    late: bool,
    at_rest: bool,
    blending: bool,
    ended: bool,
    halted: bool,
    requests: Vec<(String, Vec<String>, bool)>,
    margins: Vec<f64>,
    errors: Vec<f64>,
    active: Vec<Active>,
    levels: Vec<Outcome>,
}

impl Command {
    /// Steps a controller, and copies what a host may ask for.
    pub(crate) fn step(
        layout: &Arc<Layout>,
        controller: &mut runtime::Controller,
        observation: &runtime::Observation,
    ) -> Command {
        let command = controller.step(observation);
        let (velocity, position) = (command.velocity.to_vec(), command.position.to_vec());
        let (fault, late, at_rest) = (command.fault, command.late, command.at_rest);
        let requests = command.requests.to_vec();
        let evaluator = controller.measured();
        let (margins, errors) = (evaluator.margins().to_vec(), evaluator.measures().to_vec());
        let solution = controller.solution();
        let requests = requests.iter().filter_map(|r| {
            let action = controller.action(r)?;
            Some((action.verb.clone(), action.arguments.clone(), r.begin))
        });
        Command {
            layout: layout.clone(),
            stack: controller.active_stack(),
            time: observation.time,
            position,
            state: controller.state().to_string(),
            fault: fault.map(|f| (f.kind().word(), controller.describe(&f))),
            late,
            at_rest,
            blending: controller.is_blending(),
            ended: controller.is_final(),
            halted: controller.is_halted(),
            requests: requests.collect(),
            margins,
            errors,
            active: solution.levels.iter().flat_map(|l| l.active.iter().copied()).collect(),
            levels: solution
                .levels
                .iter()
                .map(|l| Outcome { status: l.status, violation: l.violation, freedom: l.freedom })
                .collect(),
            velocity,
        }
    }

    fn of(&self) -> &Stack {
        &self.layout.stacks[self.stack]
    }

    /// The tasks that ran and are limits, or targets.
    fn members(&self, kind: RowKind) -> impl Iterator<Item = &Member> {
        self.of().members.iter().filter(move |m| m.row_kind == kind)
    }
}

#[pymethods]
impl Command {
    /// Time of the tick (s).
    #[getter]
    fn time(&self) -> f64 {
        self.time
    }

    /// Velocity to command, shape `[nv]`, in rad/s or m/s; always finite.
    #[getter]
    fn velocity<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.velocity)
    }

    /// Configuration to be reached at the next call, shape `[nq]`, in rad or m: what a position servo is sent; always finite.
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.position)
    }

    /// Path of the active state; empty without a machine.
    #[getter]
    fn state(&self) -> &str {
        &self.state
    }

    /// Kind of the fault at this tick, or of that which keeps the robot still: `stale`, `infeasible`, ..; `None` without one.
    #[getter]
    fn fault(&self) -> Option<&'static str> {
        self.fault.as_ref().map(|f| f.0)
    }

    /// The fault in words.
    #[getter]
    fn fault_text(&self) -> Option<&str> {
        self.fault.as_ref().map(|f| f.1.as_str())
    }

    /// True if the tick's budget was spent before the hierarchy was solved.
    #[getter]
    fn late(&self) -> bool {
        self.late
    }

    /// True if the robot is told to stand: a host that ends may stop calling.
    #[getter]
    fn at_rest(&self) -> bool {
        self.at_rest
    }

    /// True while the velocity blends from one stack to another.
    #[getter]
    fn is_blending(&self) -> bool {
        self.blending
    }

    /// True if the machine has ended.
    #[getter]
    fn is_final(&self) -> bool {
        self.ended
    }

    /// True if a fault keeps the robot still until a restart.
    #[getter]
    fn is_halted(&self) -> bool {
        self.halted
    }

    /// Actions to begin (`True`) and to cancel: verb, arguments, begin.
    #[getter]
    fn requests(&self) -> Vec<(String, Vec<String>, bool)> {
        self.requests.clone()
    }

    /// The margins of all limits, one number for each row, in the unit of the row: negative if the limit is passed, where the robot is measured; NaN at a fault of what they are computed from.
    #[getter]
    fn margins<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        for m in self.members(RowKind::Inequality) {
            out.set_item(&m.name, PyArray1::from_slice(py, &self.margins[m.margins.clone()]))?;
        }
        Ok(out)
    }

    /// The errors of all targets where the robot is measured, in m or rad; NaN at a fault of what they are computed from.
    #[getter]
    fn errors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let out = PyDict::new(py);
        for m in self.members(RowKind::Equality) {
            out.set_item(&m.name, PyArray1::from_slice(py, &self.errors[m.measures.clone()]))?;
        }
        Ok(out)
    }

    /// Rows at a bound: task, row, and `lower`, `upper` or `violated`, at the reference.
    #[getter]
    fn active(&self) -> Vec<(String, String, &'static str)> {
        let mut out = Vec::new();
        for m in self.of().members.iter() {
            let first = self.of().levels[m.level].first + m.rows.start;
            for (info, active) in m.row_info.iter().zip(self.active.get(first..).unwrap_or(&[])) {
                if let Some(word) = bound(*active) {
                    out.push((m.name.clone(), info.name.clone(), word));
                }
            }
        }
        out
    }

    /// The levels: name, hard, status, violation (weighted norm of what it lacks, in the rows' units), and the degrees of freedom left below it.
    #[getter]
    fn levels(&self) -> Vec<(String, bool, &'static str, f64, usize)> {
        let all = self.of().levels.iter().zip(&self.levels);
        let locked = self.of().locked;
        let one = |(l, o): (&Level, &Outcome)| {
            (l.name.clone(), l.hard, status(o.status), o.violation, o.freedom.saturating_sub(locked))
        };
        all.map(one).collect()
    }

    fn __repr__(&self) -> String {
        let state = if self.state.is_empty() { String::new() } else { format!(" state=`{}`", self.state) };
        let fault = self.fault.as_ref().map_or(String::new(), |f| format!(" fault=`{}`: {}", f.0, f.1));
        format!("<hierarq.Command t={:.3} s{state}{fault}>", self.time)
    }
}

/// Word for a row at a bound; `None` for one that is free, and for targets that are met.
fn bound(active: Active) -> Option<&'static str> {
    match active {
        Active::Free | Active::Equality => None,
        Active::Lower => Some("lower"),
        Active::Upper => Some("upper"),
        Active::Violated => Some("violated"),
    }
}

fn status(status: LevelStatus) -> &'static str {
    match status {
        LevelStatus::Met => "met",
        LevelStatus::Relaxed => "relaxed",
        LevelStatus::Infeasible => "infeasible",
        LevelStatus::NotSolved => "not_solved",
    }
}
