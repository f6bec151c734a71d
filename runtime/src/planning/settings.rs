//! Construction of a safety planner from its bound parameters.

use std::collections::BTreeSet;

use nalgebra::Vector3;
use robot::{Data, Model};
use solver::LevelShape;
use stdlib_tasks::bound::{Bound, BoundParams, Slot};
use stdlib_tasks::expression::Evaluation;
use stdlib_tasks::kinds::safety_planner::{DeviationParams, Internal, OUTPUTS, Params, Scaling};
use stdlib_tasks::params::{Input, Operand};
use stdlib_tasks::task::{State, Task};

use super::{Along, Deviated, Planning, Probe};
use crate::program::{Program, ProgramError, StackProgram, TaskProgram, Times, error};
use crate::safety::{
    Damping, Deviation, DeviationKind, Direction, Frame, HumanPoint, PlannerSettings, SafetyPlanner, Strategy, Weights,
};
use crate::values::ValueTable;

/// Name of the task type.
const KIND: &str = "safety_planner";

/// Task that a planner protects; `None` for a task of another type.
pub(crate) fn protected_by(task: &TaskProgram) -> Option<usize> {
    if task.kind != KIND {
        return None;
    }
    match task.params.get("task") {
        Some(Bound::Task(protected)) => Some(*protected),
        _ => None,
    }
}

/// Field of a planner.
pub(super) fn field_of(program: &Program, planner: usize) -> Option<usize> {
    match program.tasks.get(planner)?.params.get("field") {
        Some(Bound::Field(field)) => Some(*field),
        _ => None,
    }
}

/// A planner's task and the task that it protects.
#[derive(Clone, Copy)]
pub(crate) struct Protection<I> {
    /// The planner's task.
    pub guard: I,
    /// The protected task.
    pub task: I,
}

/// Indices of a task.
#[derive(Clone, Copy)]
pub(crate) struct TaskIndex {
    /// Among the tasks of the stack.
    pub member: usize,
    /// Among those of the program.
    pub program: usize,
}

/// Planners of a stack with the tasks that they protect, by their indices in the program.
pub(crate) fn planners(program: &Program, stack: &StackProgram) -> Vec<Protection<usize>> {
    let members = || stack.levels.iter().flat_map(|l| &l.members).map(|m| m.task);
    let one = |guard| Some(Protection { guard, task: protected_by(program.tasks.get(guard)?)? });
    members().filter_map(one).filter(|p| members().any(|m| m == p.task)).collect()
}

/// Planner that protects a task in any stack.
pub(crate) fn planner_of(program: &Program, task: usize) -> Option<usize> {
    program.tasks.iter().position(|t| protected_by(t) == Some(task))
}

/// Collects the deviations of a planner: the path of each parameter, with the parameters of its deviation.
fn deviations(bound: &BoundParams, path: &str, out: &mut Vec<(String, BoundParams)>) {
    for (name, b) in bound {
        let Bound::Group(group) = b else { continue };
        let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
        if DeviationParams::is_one(group) {
            out.push((path, group.clone()));
        } else {
            deviations(group, &path, out);
        }
    }
}

/// Finds a bound parameter by its path.
fn at_path<'b>(params: &'b BoundParams, path: &str) -> Option<&'b Bound> {
    let (first, rest) = path.split_once('.').map_or((path, None), |(a, b)| (a, Some(b)));
    match (params.get(first)?, rest) {
        (found, None) => Some(found),
        (Bound::Group(group), Some(rest)) => at_path(group, rest),
        _ => None,
    }
}

/// First of the three rows that follow the rate of a parameter one to one; `None` if there are no such rows.
pub fn deviates(model: &Model, home: &[f64], values: &[f64], task: &mut dyn Task, slot: Slot) -> Option<usize> {
    // Such a task remembers the motion of the nominal path, not that of the path with deviations.
    if task.remembers_target() {
        return None;
    }
    let mut data = Data::new(model);
    model.forward(home, &mut data);
    let mut values = values.to_vec();
    let numbers = values.get_mut(slot.at..slot.at + slot.len)?;
    if slot.len == 4 {
        numbers.copy_from_slice(&[1.0, 0.0, 0.0, 0.0]);
    } else if slot.len != 3 {
        return None;
    }
    let velocity = vec![0.0; model.nv()];
    let mut probe = Probe::new(task, model.nv(), values.len());
    let mut ask = |k: Option<usize>| {
        let mut rates = vec![0.0; values.len()];
        match k {
            // q' = (0, w) q / 2, and q is the identity.
            Some(k) if slot.len == 4 => rates[slot.at + 1 + k] = 0.5,
            Some(k) => rates[slot.at + k] = 1.0,
            None => {}
        }
        let (velocity, stack_velocity) = (&velocity, &velocity);
        let state = State { model, data: &data, q: home, values: &values, rates: &rates, velocity, stack_velocity };
        probe.ask(task, &state).ok().map(|()| probe.lower.clone())
    };
    let still = ask(None)?;
    let mut first = None;
    for k in 0..3 {
        let moved = ask(Some(k))?;
        // Other rows may be NaN here; rows that follow the rate are finite.
        let change = |i: usize| moved[i] - still[i];
        let changed: Vec<usize> = (0..moved.len()).filter(|&i| change(i).abs() > 1e-9).collect();
        let [row] = changed[..] else { return None };
        if (change(row) - 1.0).abs() > 1e-9 || row != *first.get_or_insert(row) + k {
            return None;
        }
    }
    first
}

impl Planning {
    /// Prepares a planner of a stack. `speed` contains the speed limits above the planner, `above` the shapes of the
    /// levels above the protected task.
    ///
    /// # Errors
    /// Its settings are invalid, which a compiled program excludes.
    pub fn new(
        program: &Program,
        stack: &StackProgram,
        Protection { guard, task }: Protection<TaskIndex>,
        protected: &mut dyn Task,
        speed: &[f64],
        above: &[LevelShape],
    ) -> Result<Planning, ProgramError> {
        let model = &program.robot.model;
        let place = format!("tasks[{}]", guard.program);
        let bad = |text: String| error(&place, text);
        let bound = &program.tasks[guard.program].params;
        let params = Params::from_bound(bound).map_err(|e| bad(format!("`{}` has another form", e.param)))?;
        let form = |e: stdlib_tasks::params::WrongForm| bad(format!("`{}` has another form", e.param));
        let scaling = Scaling::from_bound(&params.scaling).map_err(form)?;
        let internal = Internal::from_bound(&params.internal).map_err(form)?;
        let program_field = program.fields.get(params.field.0).ok_or_else(|| bad("there is no such field".into()))?;
        let field = program_field.field(model).map_err(|e| bad(e.to_string()))?;
        let values = &program.values.initial;
        let number = |input: Input<1>| input.of(values)[0];
        let mut list = Vec::new();
        if let Some(deviate) = &params.deviate {
            deviations(deviate, "", &mut list);
        }
        let target = &program.tasks[task.program].params;
        let (mut deviated, mut settings) = (Vec::new(), Vec::new());
        for (path, group) in &list {
            let d = DeviationParams::from_bound(group).ok_or_else(|| bad(format!("`{path}` has another form")))?;
            let Some(Bound::Value(slot)) = at_path(target, path) else {
                return Err(bad(format!("`{path}` is no parameter that can deviate")));
            };
            let row = deviates(model, &program.robot.home, values, protected, *slot)
                .ok_or_else(|| bad(format!("the rows of the task do not follow `{path}` one to one")))?;
            let along = match d.along {
                None => Along::Gradient,
                Some(Operand::Slot(slot)) if slot.len == 3 => Along::Slot(slot.at),
                Some(Operand::Expression(e)) if e.outputs.len() == 3 => {
                    Along::State(Box::new(Evaluation::new(&e, model)))
                }
                Some(_) => return Err(bad(format!("the direction of `{path}` is no vector"))),
            };
            let fastest = number(d.speed);
            settings.push(Deviation {
                kind: if slot.len == 4 { DeviationKind::Orientation } else { DeviationKind::Position },
                row,
                stiffness: number(d.back),
                speed: [-fastest, fastest],
                reach: d.most.map(number),
                direction: if matches!(along, Along::Gradient) { Direction::Gradient } else { Direction::Given },
                weight: number(d.weight),
            });
            deviated.push(Deviated { slot: *slot, along });
        }
        let mut internal_speed: Vec<f64> =
            model.dofs.iter().zip(speed).map(|(d, s)| d.velocity.min(*s).max(0.0)).collect();
        stack.locked.iter().for_each(|&dof| internal_speed[dof] = 0.0);
        let strategy = match params.method.as_str() {
            "planner" => Strategy::Program,
            "evasive" => Strategy::Evasive { band: number(params.epsilon) },
            "stop" => Strategy::Stop,
            other => return Err(bad(format!("there is no method `{other}`"))),
        };
        let probe = Probe::new(protected, model.nv(), values.len());
        let count = deviated.len();
        let weights =
            Weights { clock: number(scaling.weight), internal: number(internal.weight), slack: number(params.relax) };
        let settings = PlannerSettings {
            period: program.robot.period,
            gain: number(params.gain),
            internal_gain: number(internal.gain),
            internal_speed,
            weights,
            deviations: settings,
            damping: Damping::default(),
            strategy,
        };
        let planner = SafetyPlanner::new(settings, probe.rows, model.nv(), above).map_err(|e| bad(e.to_string()))?;
        let places: BTreeSet<usize> =
            target.values().flat_map(|b| b.slots()).flat_map(|s| s.at..s.at + s.len).collect();
        let name = &program.tasks[guard.program].name;
        Ok(Planning {
            program_index: guard.program,
            guard: guard.member,
            task: task.member,
            people: vec![HumanPoint::at_rest(Vector3::zeros()); program_field.points.len()],
            points: program_field.points.clone(),
            field,
            values: ValueTable::new(&program.values, &places, &program.interface),
            along_clock: Vec::with_capacity(places.len()),
            places: places.into_iter().collect(),
            entered: Times::default(),
            planner,
            evasive: matches!(strategy, Strategy::Evasive { .. }),
            threshold: params.min.at,
            deviated,
            frames: vec![Frame::default(); count],
            locked: stack.locked.clone(),
            wanted: vec![0.0; probe.rows],
            probe,
            internal: vec![0.0; model.nv()],
            signals: OUTPUTS.map(|t| program.interface.signal(&format!("{name}.{}", t.name))),
        })
    }
}
