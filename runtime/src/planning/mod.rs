//! Safety planner in a stack: the rows of the protected task, the planner's decision, and its application to both
//! tasks.
//!
//! The parameters of a protected task have a table of their own, which is evaluated at the planner's clock `c` instead
//! of the time; rates in this table are d/dc. At a tick the task writes its rows three times: with zero rates, which
//! yields `K e` towards the safe target, and its Jacobian; with the rates of the clock, which yields `eta` as the
//! difference; and last for the hierarchy. Rows are affine in the rates for every type of task, so nothing here depends
//! on the type.

mod curvature;
mod settings;

use std::collections::BTreeSet;
use std::ops::Range;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use robot::{Data, Model};
use solver::Level;
use stdlib_tasks::bound::Slot;
use stdlib_tasks::expression::Evaluation;
use stdlib_tasks::task::{Rows, State, Task, TaskFault};

use crate::fault::Fault;
use crate::program::{Program, Times};
use crate::safety::{Field, Frame, HumanPoint, RowCurvature, SafetyError, SafetyPlanner, TaskLevel, TaskRows, Tick};
use crate::signals::SignalValue;
use crate::values::ValueTable;
pub use settings::deviates;
pub(crate) use settings::{Protection, TaskIndex, planner_of, planners, protected_by};

/// Source of a direction.
enum Along {
    Gradient,
    Slot(usize),
    State(Box<Evaluation>),
}

/// Deviation of a parameter.
struct Deviated {
    slot: Slot,
    along: Along,
}

/// Safety planner of a stack, prepared for execution.
pub(crate) struct Planning {
    /// Index of the planner's task in the program.
    pub program_index: usize,
    /// Indices of the planner's task and of the protected one among the stack's tasks.
    pub guard: usize,
    pub task: usize,
    field: Field,
    points: Vec<[usize; 3]>,
    people: Vec<HumanPoint>,
    /// Parameters of the protected task.
    pub values: ValueTable,
    /// Their indices in the table of values.
    pub places: Vec<usize>,
    /// Their rates along the clock.
    along_clock: Vec<f64>,
    /// Time at which the stack was entered.
    entered: Times,
    planner: SafetyPlanner,
    evasive: bool,
    threshold: usize,
    deviated: Vec<Deviated>,
    frames: Vec<Frame>,
    probe: Probe,
    locked: Vec<usize>,
    /// Values that the rows of the protected task are set to.
    pub wanted: Vec<f64>,
    /// Velocity of the null space, `nv` numbers.
    pub internal: Vec<f64>,
    /// Signals that store its outputs.
    signals: [Option<usize>; 5],
}

/// Storage for the rows of a task in a trial evaluation.
struct Probe {
    rows: usize,
    nv: usize,
    still: Vec<f64>,
    jacobian: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    measures: Vec<f64>,
    feedback: Vec<f64>,
    eta: Vec<f64>,
    /// Rows that the task left free.
    free: Vec<bool>,
}

impl Probe {
    fn new(task: &dyn Task, nv: usize, values: usize) -> Probe {
        let m = task.rows().len();
        Probe {
            rows: m,
            nv,
            still: vec![0.0; values],
            jacobian: vec![0.0; m * nv],
            lower: vec![0.0; m],
            upper: vec![0.0; m],
            measures: vec![0.0; task.measures().len()],
            feedback: vec![0.0; m],
            eta: vec![0.0; m],
            free: vec![false; m],
        }
    }

    /// Evaluates the task; `lower` then contains the right-hand sides of its equalities.
    fn ask(&mut self, task: &mut dyn Task, state: &State) -> Result<(), TaskFault> {
        self.jacobian.fill(0.0);
        self.lower.fill(f64::NEG_INFINITY);
        self.upper.fill(f64::INFINITY);
        let mut undefined = false;
        let mut rows = Rows {
            jacobian: &mut self.jacobian,
            stride: self.nv,
            lower: &mut self.lower,
            upper: &mut self.upper,
            margins: &mut [],
            measures: &mut self.measures,
            undefined: &mut undefined,
            idle: &[],
            trial: true,
        };
        task.update(state, &mut rows)
    }

    /// Writes the Jacobian of rows that always concern a single degree of freedom.
    fn constant(&mut self, task: &dyn Task) {
        for (row, dof) in task.degrees_of_freedom().into_iter().flatten().enumerate() {
            if let Some(x) = self.jacobian.get_mut(row * self.nv + dof) {
                *x = 1.0;
            }
        }
    }
}

/// State of the robot at a tick, for the planner.
pub(crate) struct RobotState<'a> {
    pub model: &'a Model,
    pub data: &'a Data,
    pub q: &'a [f64],
    pub velocity: &'a [f64],
    pub stack_velocity: &'a [f64],
}

fn quaternion(q: &[f64]) -> Quaternion<f64> {
    match *q {
        [w, x, y, z] => Quaternion::new(w, x, y, z),
        _ => Quaternion::identity(),
    }
}

fn write(q: Quaternion<f64>, out: &mut [f64]) {
    out.copy_from_slice(&[q.w, q.i, q.j, q.k]);
}

impl Planning {
    /// Passes curvatures to the planner: of the rows of the levels above the protected task, of its own rows, and of the
    /// field, estimated from the ends of its segments at random configurations.
    /// `exact` marks the levels down to the task's that are never damped. `horizon` is the time in s over which second
    /// derivatives count in the levels.
    pub fn set_curvature(&mut self, model: &Model, above: &[Level], task: TaskLevel, exact: &[bool], horizon: f64) {
        // The shortest time, since distance from people has priority over smoothness.
        let least = 0.5 * self.planner.period();
        let field = curvature::curvature_of_field(&mut self.field, model, &self.locked, least);
        self.planner.set_curvature(&RowCurvature { above, task, field: &field, exact, part: least / horizon });
    }

    /// Indices of the stack's table of values that the planner itself reads.
    pub fn reads(program: &Program, planner: usize) -> BTreeSet<usize> {
        let field = settings::field_of(program, planner).and_then(|f| program.fields.get(f));
        field.iter().flat_map(|f| f.points.iter().flatten().copied()).collect()
    }

    /// Restarts at the entry of the stack.
    pub fn enter(&mut self, times: Times, inputs: &[f64]) {
        self.entered = times;
        self.planner.restart(0.0);
        self.internal.fill(0.0);
        self.values.restart();
        self.values.inputs.copy_from_slice(inputs);
        for d in &mut self.deviated {
            if let Along::State(direction) = &mut d.along {
                direction.forget();
            }
        }
    }

    /// Goes on where the same planner of another stack is. Never allocates.
    pub fn take_over(&mut self, from: &mut Planning) {
        self.entered = from.entered;
        self.planner.take_over(&mut from.planner);
        self.internal.copy_from_slice(&from.internal);
        std::mem::swap(&mut self.values, &mut from.values);
        std::mem::swap(&mut self.deviated, &mut from.deviated);
    }

    /// Evaluates the protected task's parameters at the planner's clock and writes them to the stack's table.
    pub fn evaluate(&mut self, signals: &[f64], current: &mut [f64], rates: &mut [f64]) {
        let c = self.planner.clock();
        self.values.evaluate(Times { t: self.entered.t + c, time: self.entered.time + c }, signals);
        for &at in &self.places {
            current[at] = self.values.current[at];
            rates[at] = self.values.rates[at];
        }
    }

    /// Reads the people's points and evaluates the protected task. The task's values become those of the safe target.
    pub fn see(
        &mut self,
        task: &mut dyn Task,
        now: &RobotState,
        current: &mut [f64],
        rates: &mut [f64],
    ) -> Result<(), Fault> {
        let guard = Fault::NotFinite { member: self.guard, row: 0 };
        for (person, places) in self.people.iter_mut().zip(&self.points) {
            person.position = Vector3::from(places.map(|at| current[at]));
            person.velocity = Vector3::from(places.map(|at| rates[at]));
        }
        self.field.update(now.model, now.data, &self.people).map_err(|_| guard)?;
        self.deviate(now, current, rates).ok_or(guard)?;
        let member = self.task;
        let failed = |f: TaskFault| match f {
            TaskFault::NotFinite { row } => Fault::NotFinite { member, row },
            TaskFault::Overlap { row } => Fault::Overlap { member, row },
            TaskFault::Gain { .. } => Fault::Gain { member },
            TaskFault::Crossed { row } => Fault::Crossed { member, row },
        };
        let RobotState { model, data, q, velocity, stack_velocity } = *now;
        let p = &mut self.probe;
        let moving = State { model, data, q, values: current, rates, velocity, stack_velocity };
        p.ask(task, &moving).map_err(failed)?;
        p.eta.copy_from_slice(&p.lower);
        let still = std::mem::take(&mut p.still);
        let asked = p.ask(task, &State { rates: &still, ..moving });
        p.still = still;
        asked.map_err(failed)?;
        p.constant(task);
        for i in 0..p.rows {
            p.free[i] = !(p.lower[i].is_finite() && p.upper[i].is_finite());
            (p.feedback[i], p.eta[i]) = if p.free[i] { (0.0, 0.0) } else { (p.lower[i], p.eta[i] - p.lower[i]) };
            let row = &mut p.jacobian[i * p.nv..(i + 1) * p.nv];
            if p.free[i] {
                row.fill(0.0);
            }
            self.locked.iter().for_each(|&dof| row[dof] = 0.0);
        }
        self.along_clock.clear();
        self.along_clock.extend(self.places.iter().map(|&at| rates[at]));
        Ok(())
    }

    /// Decides about this tick after [`Planning::see`]. The rows of the levels above must have been written.
    pub fn decide(&mut self, above: &[Level], current: &[f64], rates: &mut [f64]) -> Result<(), Fault> {
        self.ask(above, current, rates, |planner, tick| planner.decide(tick).map(|()| true)).map(drop)
    }

    /// Passes the velocity `x`, which the hierarchy computed from the decision, to the planner. Returns true if the
    /// planner decided again.
    pub fn reconsider(
        &mut self,
        above: &[Level],
        x: &[f64],
        current: &[f64],
        rates: &mut [f64],
    ) -> Result<bool, Fault> {
        self.ask(above, current, rates, |planner, tick| planner.reconsider(tick, x))
    }

    /// Calls the planner and applies its decision, if there is one.
    fn ask(
        &mut self,
        above: &[Level],
        current: &[f64],
        rates: &mut [f64],
        decide: impl FnOnce(&mut SafetyPlanner, &Tick) -> Result<bool, SafetyError>,
    ) -> Result<bool, Fault> {
        let p = &self.probe;
        let rows = TaskRows { jacobian: &p.jacobian, stride: p.nv, eta: &p.eta, feedback: &p.feedback };
        let tick = Tick {
            field: &self.field,
            threshold: current[self.threshold],
            threshold_rate: rates[self.threshold],
            task: rows,
            frames: &self.frames,
            above,
        };
        let decided = decide(&mut self.planner, &tick).map_err(|_| Fault::NotFinite { member: self.guard, row: 0 })?;
        if !decided {
            return Ok(false);
        }
        let plan = self.planner.plan();
        let velocity = if self.evasive { &plan.velocity } else { &plan.u_n };
        self.internal.copy_from_slice(velocity);
        self.locked.iter().for_each(|&dof| self.internal[dof] = 0.0);
        for (i, wanted) in self.wanted.iter_mut().enumerate() {
            let row = &p.jacobian[i * p.nv..(i + 1) * p.nv];
            *wanted = match self.evasive {
                true => row.iter().zip(&self.internal).map(|(j, v)| j * v).sum(),
                false => plan.rate[i] + p.feedback[i],
            };
        }
        for (&at, rate) in self.places.iter().zip(&self.along_clock) {
            rates[at] = rate * plan.u_c;
        }
        Ok(true)
    }

    /// Replaces the nominal target by the safe one and computes directions. Returns `None` if a direction is undefined.
    fn deviate(&mut self, now: &RobotState, current: &mut [f64], rates: &mut [f64]) -> Option<()> {
        for (d, frame) in self.deviated.iter_mut().zip(&mut self.frames) {
            frame.direction = match &mut d.along {
                Along::Gradient => Vector3::zeros(),
                Along::Slot(at) => Vector3::new(current[*at], current[*at + 1], current[*at + 2]),
                Along::State(e) => {
                    let state = State {
                        model: now.model,
                        data: now.data,
                        q: now.q,
                        values: current,
                        rates,
                        velocity: now.velocity,
                        stack_velocity: now.stack_velocity,
                    };
                    e.forward(&state).ok()?;
                    Vector3::new(e.value(0), e.value(1), e.value(2))
                }
            };
        }
        for (i, (d, frame)) in self.deviated.iter().zip(&mut self.frames).enumerate() {
            let range: Range<usize> = d.slot.at..d.slot.at + d.slot.len;
            let value = &mut current[range.clone()];
            if d.slot.len == 4 {
                let turn = self.planner.turn(i).into_inner();
                let nominal = quaternion(value);
                frame.rotation = UnitQuaternion::try_new(nominal, 1e-9)?;
                write(frame.rotation.into_inner() * turn, value);
                let rate = quaternion(&rates[range.clone()]) * turn / nominal.norm();
                write(rate, &mut rates[range]);
            } else {
                value.iter_mut().zip(self.planner.offset(i).iter()).for_each(|(x, o)| *x += o);
            }
        }
        Some(())
    }

    /// Returns true if the planner decides about row `i` of the protected task.
    pub fn decides(&self, i: usize) -> bool {
        !self.probe.free.get(i).copied().unwrap_or(true)
    }

    /// Advances the clock and the deviations by a part of a period.
    pub fn advance(&mut self, part: f64) {
        self.planner.advance(part);
    }

    /// Outputs at this tick, in which the robot moves with `v`, `nv` numbers.
    pub fn outputs(&self, v: &[f64]) -> impl Iterator<Item = SignalValue> {
        let plan = self.planner.plan();
        let sizes = self.deviated.iter().enumerate().map(|(i, d)| match d.slot.len {
            4 => self.planner.turn(i).angle(),
            _ => self.planner.offset(i).norm(),
        });
        let withheld = (plan.field_rate - self.field.rate(v)).max(0.0);
        let numbers = [plan.u_c, sizes.fold(0.0, f64::max), plan.outcome.slack, withheld, self.field.value()];
        self.signals.into_iter().zip(numbers).filter_map(|(s, value)| Some(SignalValue { signal: s?, value }))
    }

    /// The planner itself.
    pub fn planner(&self) -> &SafetyPlanner {
        &self.planner
    }

    /// Field as of the last tick.
    pub fn field(&self) -> &Field {
        &self.field
    }
}
