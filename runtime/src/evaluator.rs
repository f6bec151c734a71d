//! A stack made ready to run: kinematics, parameter values and tasks, which together fill the hierarchical problem.
//!
//! The controller has one for its reference configuration; where the simulated robot is not perfect, the monitors have
//! another for the true one.

use std::collections::BTreeSet;
use std::ops::Range;

use robot::{Data, Model};
use solver::{LevelShape, Problem};
use stdlib_tasks::dimension::Dimension;
use stdlib_tasks::expression::Evaluation;
use stdlib_tasks::task::{BuildError, Context, Measure, Nature, RowInfo, Rows, State, Task, TaskFault};

use crate::coasting::Coasting;
use crate::fault::Fault;
use crate::planning::{self, Now, Planning};
use crate::program::{Capture, CaptureSource, Program, ProgramError, StackProgram, TaskProgram, Times};
use crate::safety::{Field, SafetyPlanner};
use crate::values::ValueTable;
use crate::velocity;

/// A task of the stack, and where its numbers stand.
#[derive(Clone, Debug)]
pub struct Member {
    /// The task's name.
    pub name: String,
    /// Its type.
    pub kind: &'static str,
    /// Target or limit.
    pub nature: Nature,
    /// Index of its level.
    pub level: usize,
    /// Its rows in that level.
    pub rows: Range<usize>,
    /// What the rows are called.
    pub row_info: Vec<RowInfo>,
    /// Its place in [`Evaluator::margins`]; empty for targets.
    pub margins: Range<usize>,
    /// Its place in [`Evaluator::measures`]; empty for limits.
    pub measures: Range<usize>,
    /// What the measures are called.
    pub measure_info: Vec<Measure>,
    /// Index of the task in the program.
    pub program_index: usize,
    /// True where the coefficients of the rows never change.
    pub constant: bool,
    /// Places of its parameters in the table of values.
    pub slots: Vec<usize>,
    /// For each row, whether it was proven to have no say while joints stand inside their limits; empty where none was.
    pub idle: Vec<bool>,
}

impl Member {
    /// The dimension that all rows share, if they do.
    pub fn dimension(&self) -> Option<Dimension> {
        let first = self.row_info.first()?.dimension;
        self.row_info.iter().all(|r| r.dimension == first).then_some(first)
    }
}

/// What is the case outside of the robot at a tick.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a> {
    /// The clocks.
    pub times: Times,
    /// The table of signals.
    pub signals: &'a [f64],
    /// The velocity that the reference moved with since the last tick, `nv` numbers.
    pub velocity: &'a [f64],
}

/// A robot that stands, no signal, and variables as they are at the start: a moment for those who look at a stack without running it.
#[derive(Clone, Debug)]
pub struct Rest {
    signals: Vec<f64>,
    velocity: Vec<f64>,
}

impl Rest {
    /// For a program.
    pub fn new(program: &Program) -> Rest {
        Rest { signals: program.interface.absent(), velocity: vec![0.0; program.robot.model.nv()] }
    }

    /// The moment at which the clocks show these times.
    pub fn at(&self, times: Times) -> Moment<'_> {
        Moment { times, signals: &self.signals, velocity: &self.velocity }
    }
}

/// A capture that the stack needs, made ready.
struct Captured {
    /// The numbers that it fills.
    inputs: Range<usize>,
    source: Source,
}

enum Source {
    /// A value of a task of the stack, by its place among the members.
    Task(usize, String),
    /// How fast one of so many numbers moves.
    Velocity(usize, String, usize),
    State(Evaluation),
}

/// A stack made ready to run.
pub struct Evaluator {
    model: Model,
    data: Data,
    values: ValueTable,
    captures: Vec<Captured>,
    tasks: Vec<Box<dyn Task>>,
    members: Vec<Member>,
    locked: Vec<usize>,
    coasting: Coasting,
    margins: Vec<f64>,
    measures: Vec<f64>,
    undefined: Vec<bool>,
    /// Safety planners of the stack.
    planners: Vec<Planning>,
    led: Led,
    /// Signals that must be present.
    needs: Vec<usize>,
    /// Room for a configuration beside the one that is looked at.
    beside: Vec<f64>,
    /// Where joints must stand for idle rows to be idle: index in the configuration, lowest, highest position.
    limits: Vec<(usize, f64, f64)>,
}

/// What an evaluator takes over from that of the controller, where it looks at another configuration: what the controller's
/// planners decided.
#[derive(Default)]
struct Led {
    /// Places of the table of values that planners work out, with their value and rate.
    values: Vec<(usize, f64, f64)>,
    /// It takes them over.
    on: bool,
}

/// How far beyond its limit a joint may stand and still count as inside, in rad or m: the reference ends a tick on the
/// limit only up to rounding. Proofs of idle rows reach as far.
pub const LIMIT_TOLERANCE: f64 = 1e-6;

/// A task of a stack, built.
pub struct Built {
    /// The task, or why there is none.
    pub task: Result<Box<dyn Task>, BuildError>,
    /// The largest speed of each degree of freedom that it was told, in rad/s or m/s.
    pub speed: Vec<f64>,
}

/// Builds the tasks of a stack, one for each member in the order of levels. A task is told the speed limits that hold
/// whatever it does: those of tasks on hard levels down to its own. A soft level gives way, a lower one comes after, and
/// the robot's own limits bound the command but not the reference that the levels move.
pub fn build_tasks(
    model: &Model,
    period: f64,
    values: &[f64],
    tasks: &[TaskProgram],
    stack: &StackProgram,
) -> Vec<Built> {
    let one = |task: &TaskProgram, speed: &[f64]| match stdlib_tasks::find(&task.kind) {
        Some(kind) => (kind.build)(&task.params, &Context { model, values, period, speed }),
        None => Err(BuildError::new("", format!("there is no task type `{}`", task.kind))),
    };
    let mut speed = vec![f64::INFINITY; model.nv()];
    for &dof in &stack.locked {
        speed[dof] = 0.0;
    }
    let mut built = Vec::new();
    for level in &stack.levels {
        let members = level.members.iter().map(|m| &tasks[m.task]);
        if level.hard {
            let limits: Vec<(usize, f64)> = members
                .clone()
                .filter_map(|t| one(t, &speed).ok())
                .flat_map(|task| task.speed_limits(values))
                .collect();
            for (dof, limit) in limits {
                speed[dof] = speed[dof].min(limit);
            }
        }
        built.extend(members.map(|t| Built { task: one(t, &speed), speed: speed.clone() }));
    }
    built
}

/// Numbers this close to zero are zero: products of them would be denormal, which processors handle far more slowly.
const TINY: f64 = 1e-150;

fn flush(numbers: &mut [f64]) {
    for x in numbers {
        *x = if x.abs() < TINY { 0.0 } else { *x };
    }
}

/// The places of the table of values that some tasks read: those of other stacks are not worked out, and are nobody's
/// fault.
fn places<'p>(tasks: impl Iterator<Item = &'p TaskProgram>) -> BTreeSet<usize> {
    let slots = tasks.flat_map(|t| t.params.values()).flat_map(|b| b.slots());
    slots.flat_map(|s| s.at..s.at + s.len).collect()
}

/// A capture made ready; none where it belongs to a task of another stack.
fn ready(capture: &Capture, model: &Model, members: &[Member]) -> Option<Captured> {
    let source = match &capture.source {
        CaptureSource::Task(index, name) => {
            Source::Task(members.iter().position(|m| m.program_index == *index)?, name.clone())
        }
        CaptureSource::Velocity(index, name, width) => {
            Source::Velocity(members.iter().position(|m| m.program_index == *index)?, name.clone(), *width)
        }
        CaptureSource::State(e) => Source::State(Evaluation::new(e, model)),
    };
    Some(Captured { inputs: capture.at..capture.at + capture.len, source })
}

/// The position limits of joints, with the tolerance for standing on one.
fn limits(model: &Model) -> Vec<(usize, f64, f64)> {
    let limited = model.dofs.iter().filter(|d| d.lower.is_finite() || d.upper.is_finite());
    limited.filter_map(|d| Some((d.q_index?, d.lower - LIMIT_TOLERANCE, d.upper + LIMIT_TOLERANCE))).collect()
}

/// Writes the coefficients of rows that never change, once for all ticks.
fn write_constant(task: &dyn Task, member: &Member, locked: &[usize], problem: &mut Problem) {
    let Some(dofs) = task.degrees_of_freedom() else { return };
    let level = &mut problem.levels[member.level];
    for (row, dof) in member.rows.clone().zip(dofs) {
        if !locked.contains(&dof) {
            level.row_mut(row)[dof] = 1.0;
        }
    }
    level.fix(member.rows.clone());
}

impl Evaluator {
    /// Makes a stack of a checked program ready, together with the problem that it fills.
    ///
    /// # Errors
    /// A task cannot be built, which a compiled program excludes.
    pub fn new(program: &Program, stack: usize) -> Result<(Evaluator, Problem), ProgramError> {
        Evaluator::of(program, &program.stacks[stack], None)
    }

    /// One task of a stack by itself, built as the stack has it. Its problem has the stack's levels, but for the rows of
    /// other tasks.
    ///
    /// # Errors
    /// The task cannot be built, which a compiled program excludes.
    pub fn alone(program: &Program, stack: &StackProgram, task: usize) -> Result<(Evaluator, Problem), ProgramError> {
        Evaluator::of(program, stack, Some(task))
    }

    fn of(
        program: &Program,
        stack_program: &StackProgram,
        only: Option<usize>,
    ) -> Result<(Evaluator, Problem), ProgramError> {
        let wanted = |task: usize| only.is_none_or(|o| o == task);
        let model = program.robot.model.clone();
        let built = build_tasks(&model, program.robot.period, &program.values.initial, &program.tasks, stack_program);
        let speeds: Vec<Vec<f64>> = built.iter().map(|b| b.speed.clone()).collect();
        let (mut tasks, mut members, mut shapes) = (Vec::new(), Vec::new(), Vec::new());
        let (mut margins, mut measures) = (0, 0);
        let mut built = built.into_iter();
        for (level, l) in stack_program.levels.iter().enumerate() {
            let mut rows = 0;
            for m in &l.members {
                let p = &program.tasks[m.task];
                let place = format!("tasks[{}]", m.task);
                let failed = |e: BuildError| crate::program::error(&place, e.message);
                let Some(Built { task, .. }) = built.next() else { continue };
                if !wanted(m.task) {
                    continue;
                }
                let task = task.map_err(failed)?;
                let Some(kind) = stdlib_tasks::find(&p.kind) else { continue };
                let (row_info, measure_info) = (task.rows(), task.measures());
                let limits = if kind.nature == Nature::Limit { row_info.len() } else { 0 };
                let mut idle = if m.idle.is_empty() { Vec::new() } else { vec![false; row_info.len()] };
                for i in &m.idle {
                    match idle.get_mut(i.row) {
                        Some(is) => *is = true,
                        None => return Err(crate::program::error(&place, "an idle row does not exist".to_string())),
                    }
                }
                members.push(Member {
                    name: p.name.clone(),
                    kind: kind.name,
                    nature: kind.nature,
                    level,
                    rows: rows..rows + row_info.len(),
                    margins: margins..margins + limits,
                    measures: measures..measures + measure_info.len(),
                    row_info,
                    measure_info,
                    program_index: m.task,
                    slots: places(std::iter::once(p)).into_iter().collect(),
                    constant: task.degrees_of_freedom().is_some(),
                    idle,
                });
                if let Some(last) = members.last() {
                    rows = last.rows.end;
                    margins = last.margins.end;
                    measures = last.measures.end;
                }
                tasks.push(task);
            }
            shapes.push(LevelShape { rows, hard: l.hard, damping: l.damping });
        }
        let mut problem = Problem::new(model.nv(), &shapes);
        let weights = stack_program.levels.iter().flat_map(|l| &l.members).filter(|m| wanted(m.task)).map(|m| m.weight);
        for (member, weight) in members.iter().zip(weights) {
            problem.levels[member.level].weight[member.rows.clone()].fill(weight);
        }
        for (member, task) in members.iter().zip(&tasks) {
            write_constant(task.as_ref(), member, &stack_program.locked, &mut problem);
        }
        let mut coasting = Coasting::new(&problem, &stack_program.locked);
        members.iter().zip(&tasks).for_each(|(member, task)| coasting.fix(member, task.as_ref()));
        let planned = planning::planners(program, stack_program);
        let mut wanted = places(members.iter().map(|m| &program.tasks[m.program_index]));
        let mut led = Led::default();
        for m in members.iter().filter(|m| planning::planner_of(program, m.program_index).is_some()) {
            led.values.extend(m.slots.iter().map(|&at| (at, 0.0, 0.0)));
        }
        let mut planners = Vec::new();
        for (guard, protected) in planned.iter().filter(|_| only.is_none()) {
            let at = |index: usize| members.iter().position(|m: &Member| m.program_index == index);
            let (Some(g), Some(t)) = (at(*guard), at(*protected)) else { continue };
            let both = ((g, *guard), (t, *protected));
            let speed = speeds.get(g).map_or(&[][..], Vec::as_slice);
            let planner = Planning::new(program, stack_program, both, tasks[t].as_mut(), speed)?;
            wanted.retain(|at| planner.places.binary_search(at).is_err());
            wanted.extend(Planning::reads(program, *guard));
            planners.push(planner);
        }
        let values = ValueTable::new(&program.values, &wanted, &program.interface);
        let tables = || std::iter::once(&values).chain(planners.iter().map(|p| &p.values));
        let needed = |c: &&Capture| (c.at..c.at + c.len).any(|k| tables().any(|t| t.is_read(k)));
        let needs: BTreeSet<usize> = tables().flat_map(|t| t.needs().iter().copied()).collect();
        let evaluator = Evaluator {
            data: Data::new(&model),
            captures: program
                .values
                .captures
                .iter()
                .filter(needed)
                .filter_map(|c| ready(c, &model, &members))
                .collect(),
            needs: needs.into_iter().collect(),
            led,
            values,
            planners,
            undefined: vec![false; tasks.len()],
            tasks,
            members,
            coasting,
            locked: stack_program.locked.clone(),
            margins: vec![f64::INFINITY; margins],
            measures: vec![0.0; measures],
            limits: limits(&model),
            beside: vec![0.0; model.nq()],
            model,
        };
        Ok((evaluator, problem))
    }

    /// The robot.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Kinematics at the last configuration.
    pub fn data(&self) -> &Data {
        &self.data
    }

    /// The tasks, in the order of levels.
    pub fn members(&self) -> &[Member] {
        &self.members
    }

    /// Degrees of freedom that the stack keeps still.
    pub fn locked(&self) -> &[usize] {
        &self.locked
    }

    /// `h` of every row of every limit.
    pub fn margins(&self) -> &[f64] {
        &self.margins
    }

    /// Every error of every target; NaN where it is undefined.
    pub fn measures(&self) -> &[f64] {
        &self.measures
    }

    /// For each task, whether a row was undefined at the last tick and left free.
    pub fn undefined(&self) -> &[bool] {
        &self.undefined
    }

    /// Whether a task took something from the robot when the stack was entered, beside its parameters.
    pub fn remembers_entry(&self, member: usize) -> bool {
        self.tasks.get(member).is_some_and(|t| t.remembers_entry())
    }

    /// What each row of a task keeps in reserve against sampling in time; empty where its limit cannot bend.
    pub fn reserve(&self, member: usize) -> Vec<f64> {
        self.tasks.get(member).map(|t| t.reserve()).unwrap_or_default()
    }

    /// What each row of a task can lose to sampling in time; empty where its limit cannot bend.
    pub fn sampled_loss(&self, member: usize) -> Vec<f64> {
        self.tasks.get(member).map(|t| t.sampled_loss()).unwrap_or_default()
    }

    /// The value of a parameter at the last tick.
    pub fn value(&self, at: usize) -> Option<f64> {
        self.values.current.get(at).copied()
    }

    /// Whether the value of a parameter has come to where it is going: it does not move, and a trajectory that it follows
    /// from stands at its goal.
    pub fn is_settled(&self, at: usize) -> bool {
        self.rate(at).is_none_or(|r| r == 0.0)
            && self.values.is_settled(at)
            && self.planners.iter().all(|p| p.values.is_settled(at))
    }

    /// How fast the value of a parameter changed at the last tick, per second.
    pub fn rate(&self, at: usize) -> Option<f64> {
        self.values.rates.get(at).copied()
    }

    /// Signals that must be present for the stack to run.
    pub fn needs(&self) -> &[usize] {
        &self.needs
    }

    /// Takes over what the planners of another evaluator of the same robot decided at this tick, that of the controller:
    /// for the next update, and for good. Never allocates.
    pub fn follow(&mut self, leader: &Evaluator) {
        self.led.on = true;
        for (at, value, rate) in &mut self.led.values {
            if let (Some(x), Some(r)) = (leader.value(*at), leader.rate(*at)) {
                (*value, *rate) = (x, r);
            }
        }
        for planner in &leader.planners {
            let mine = self.members.iter().position(|m| m.program_index == planner.program_index);
            if let Some(task) = mine.and_then(|i| self.tasks.get_mut(i)) {
                task.decided(&planner.internal);
            }
        }
    }

    /// Moves clocks and deviations of planners on by a period, as they were decided. Never allocates.
    pub(crate) fn advance(&mut self) {
        self.planners.iter_mut().for_each(Planning::advance);
    }

    /// The safety planners of the stack, each with its field, as of the last tick.
    pub fn safety(&self) -> impl Iterator<Item = (&SafetyPlanner, &Field)> {
        self.planners.iter().map(|p| (p.planner(), p.field()))
    }

    /// The field of the safety planner that a task of the program is, at the last tick.
    pub fn field_of(&self, task: usize) -> Option<&Field> {
        self.planners.iter().find(|p| p.program_index == task).map(|p| p.field())
    }

    /// The planners of the stack.
    pub(crate) fn planners(&self) -> &[Planning] {
        &self.planners
    }

    /// Enters the stack at a configuration: captures what `initial(..)` asks for. Never allocates.
    pub fn enter(&mut self, q: &[f64], moment: Moment) {
        self.values.inputs.fill(0.0);
        self.values.restart();
        for p in &mut self.planners {
            p.enter(moment.times, &self.values.inputs);
        }
        self.kinematics(q, moment);
        self.capture(q, moment);
        self.capture_velocities(q, moment);
        self.values.restart();
        for p in &mut self.planners {
            p.enter(moment.times, &self.values.inputs);
        }
        self.kinematics(q, moment);
        let Evaluator { model, data, values, tasks, .. } = self;
        let ValueTable { current, rates, .. } = values;
        let state = State { model, data, q, values: current, rates, velocity: moment.velocity };
        for task in tasks {
            task.enter(&state);
        }
    }

    /// Captures all values at the configuration whose kinematics are known. What has no value becomes NaN.
    fn capture(&mut self, q: &[f64], moment: Moment) {
        let Evaluator { model, data, values, captures, tasks, .. } = self;
        let ValueTable { current, rates, inputs, .. } = values;
        let state = State { model, data, q, values: current, rates, velocity: moment.velocity };
        for capture in captures {
            let out = &mut inputs[capture.inputs.clone()];
            match &mut capture.source {
                Source::Task(member, name) => {
                    tasks[*member].actual(name, &state, out);
                }
                Source::Velocity(..) => {}
                Source::State(expression) => {
                    expression.forget();
                    let found = expression.forward(&state).is_ok();
                    for (i, x) in out.iter_mut().enumerate() {
                        *x = if found { expression.value(i) } else { f64::NAN };
                    }
                }
            }
        }
    }

    /// Captures how fast values of tasks move: by central differences along the velocity.
    fn capture_velocities(&mut self, q: &[f64], moment: Moment) {
        let Evaluator { model, data, values, captures, tasks, beside, .. } = self;
        let ValueTable { current, rates, inputs, .. } = values;
        for capture in captures.iter() {
            let Source::Velocity(member, name, width) = &capture.source else { continue };
            let mut sides = [[0.0; 7]; 2];
            for (numbers, h) in sides.iter_mut().zip([-velocity::STEP, velocity::STEP]) {
                beside.copy_from_slice(q);
                model.integrate(beside, moment.velocity, h);
                model.forward(beside, data);
                let state = State { model, data, q: beside, values: current, rates, velocity: moment.velocity };
                tasks[*member].actual(name, &state, &mut numbers[..*width]);
            }
            let [before, after] = &sides;
            velocity::between(&before[..*width], &after[..*width], &mut inputs[capture.inputs.clone()]);
        }
    }

    fn kinematics(&mut self, q: &[f64], moment: Moment) {
        self.model.forward(q, &mut self.data);
        self.values.evaluate(moment.times, moment.signals);
        let ValueTable { current, rates, .. } = &mut self.values;
        for p in &mut self.planners {
            p.evaluate(moment.signals, current, rates);
        }
        for &(at, value, rate) in self.led.values.iter().filter(|_| self.led.on) {
            (current[at], rates[at]) = (value, rate);
        }
    }

    /// Lets planners decide, unless those of another evaluator do.
    fn plan(&mut self, q: &[f64], moment: Moment) -> Result<(), Fault> {
        if self.led.on {
            return Ok(());
        }
        let Evaluator { model, data, values, planners, tasks, .. } = self;
        let ValueTable { current, rates, .. } = values;
        let now = Now { model, data, q, velocity: moment.velocity };
        for p in planners {
            p.values.check(moment.signals)?;
            p.plan(tasks[p.task].as_mut(), &now, (current, rates))?;
            tasks[p.guard].decided(&p.internal);
        }
        Ok(())
    }

    /// Locked joints come to rest at the next update, or stand.
    pub(crate) fn coast(&mut self, coasts: bool) {
        self.coasting.on = coasts;
    }

    /// What was kept back from the rows of locked joints at the last update.
    pub(crate) fn coasting(&self) -> &Coasting {
        &self.coasting
    }

    /// Fills the problem for this tick. Never allocates.
    ///
    /// # Errors
    /// A task could not write its rows.
    pub fn update(&mut self, q: &[f64], moment: Moment, problem: &mut Problem) -> Result<(), Fault> {
        self.kinematics(q, moment);
        self.values.check(moment.signals)?;
        self.plan(q, moment)?;
        let Evaluator {
            model,
            data,
            values,
            tasks,
            members,
            locked,
            coasting,
            margins,
            measures,
            undefined,
            planners,
            led,
            ..
        } = self;
        let ValueTable { current, rates, .. } = values;
        coasting.begin();
        margins.fill(f64::INFINITY);
        let inside = self.limits.iter().all(|&(i, lower, upper)| lower <= q[i] && q[i] <= upper);
        let state = State { model, data, q, values: current, rates, velocity: moment.velocity };
        for (i, (task, m)) in tasks.iter_mut().zip(members.iter()).enumerate() {
            let level = &mut problem.levels[m.level];
            let stride = level.stride();
            let (jacobian, lower, upper) = if m.constant {
                let (lower, upper) = level.bounds_mut(m.rows.clone());
                (&mut [][..], lower, upper)
            } else {
                let (jacobian, lower, upper) = level.block_mut(m.rows.clone());
                jacobian.fill(0.0);
                (jacobian, lower, upper)
            };
            lower.fill(f64::NEG_INFINITY);
            upper.fill(f64::INFINITY);
            undefined[i] = false;
            // The proofs know of locked joints that stand.
            let idle = if inside && !coasting.on { &m.idle[..] } else { &[] };
            let mut rows = Rows {
                jacobian,
                stride,
                lower,
                upper,
                margins: &mut margins[m.margins.clone()],
                measures: &mut measures[m.measures.clone()],
                undefined: &mut undefined[i],
                idle,
            };
            match task.update(&state, &mut rows) {
                Ok(()) => {}
                Err(TaskFault::NotFinite { row }) => return Err(Fault::NotFinite { member: i, row }),
                Err(TaskFault::Overlap { row }) => return Err(Fault::Overlap { member: i, row }),
                Err(TaskFault::Gain { .. }) => return Err(Fault::Gain { member: i }),
                Err(TaskFault::Crossed { row }) => return Err(Fault::Crossed { member: i, row }),
            }
            if let Some(p) = planners.iter().find(|p| p.task == i && !led.on) {
                for (row, wanted) in p.wanted.iter().enumerate().filter(|(row, _)| p.decides(*row)) {
                    rows.equal(row, *wanted);
                }
            }
            flush(rows.jacobian);
            flush(rows.lower);
            flush(rows.upper);
            coasting.keep(m, rows.jacobian, stride);
            if !locked.is_empty() {
                // A robot without a degree of freedom has rows without a coefficient.
                for row in rows.jacobian.chunks_exact_mut(stride.max(1)) {
                    for &dof in locked.iter() {
                        row[dof] = 0.0;
                    }
                }
            }
            coasting.free(m, level);
            for (row, _) in idle.iter().enumerate().filter(|(_, is)| **is) {
                level.leave_out(m.rows.start + row);
            }
        }
        Ok(())
    }

    /// Lets the tasks see the velocity that was chosen. Never allocates.
    pub fn observe(&mut self, q: &[f64], v: &[f64]) {
        let Evaluator { model, data, values, tasks, members, margins, measures, .. } = self;
        let ValueTable { current, rates, .. } = values;
        let state = State { model, data, q, values: current, rates, velocity: v };
        for (task, m) in tasks.iter().zip(members.iter()) {
            task.observe(&state, v, &mut margins[m.margins.clone()], &mut measures[m.measures.clone()]);
        }
    }
}
