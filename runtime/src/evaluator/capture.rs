//! Entry of a stack: the values of `initial(..)` are captured at the configuration of the robot.

use std::ops::Range;

use robot::Model;
use stdlib_tasks::expression::Evaluation;
use stdlib_tasks::task::State;

use super::{Evaluator, Member, TickInputs};
use crate::program::{Capture, CaptureSource};
use crate::values::ValueTable;
use crate::velocity;

/// Prepared capture that the stack needs.
pub(super) struct Captured {
    /// Part of the stack whose values read it.
    part: usize,
    /// Indices of the inputs that it fills.
    inputs: Range<usize>,
    source: Source,
}

enum Source {
    /// Value of a task of the stack: index among the members, and name.
    Task(usize, String),
    /// Rate of such a value, with its number of components.
    Velocity(usize, String, usize),
    State(Evaluation),
}

/// Prepares a capture for a part of a stack; `None` if it belongs to a task of another stack.
pub(super) fn ready(capture: &Capture, model: &Model, members: &[Member], part: usize) -> Option<Captured> {
    let source = match &capture.source {
        CaptureSource::Task(index, name) => {
            Source::Task(members.iter().position(|m| m.program_index == *index)?, name.clone())
        }
        CaptureSource::Velocity(index, name, width) => {
            Source::Velocity(members.iter().position(|m| m.program_index == *index)?, name.clone(), *width)
        }
        CaptureSource::State(e) => Source::State(Evaluation::new(e, model)),
    };
    Some(Captured { part, inputs: capture.at..capture.at + capture.len, source })
}

impl Evaluator {
    /// Enters the stack at a configuration: captures the values of `initial(..)`. Never allocates.
    pub fn enter(&mut self, q: &[f64], tick: TickInputs) {
        self.begin_anew();
        self.enter_fresh(q, tick);
    }

    /// Enters the parts of the stack that do not go on from the stack before, see [`Evaluator::take_over`]. Never
    /// allocates.
    pub(crate) fn enter_fresh(&mut self, q: &[f64], tick: TickInputs) {
        for (table, _) in self.values.iter_mut().zip(&self.fresh).filter(|(_, fresh)| **fresh) {
            table.inputs.fill(0.0);
        }
        self.restart(tick);
        self.kinematics(q, tick);
        self.capture(q, tick);
        self.capture_velocities(q, tick);
        self.restart(tick);
        self.kinematics(q, tick);
        let Evaluator { model, data, values, tasks, members, goes_on, .. } = self;
        let TickInputs { velocity, stack_velocity, .. } = tick;
        for ((task, m), _) in tasks.iter_mut().zip(members).zip(goes_on).filter(|(_, goes_on)| !**goes_on) {
            let ValueTable { current, rates, .. } = &values[m.part()];
            task.enter(&State { model, data, q, values: current, rates, velocity, stack_velocity });
        }
    }

    /// Restarts the trajectories and planners of the parts that are entered.
    fn restart(&mut self, tick: TickInputs) {
        let Evaluator { values, fresh, planners, members, .. } = self;
        for (table, _) in values.iter_mut().zip(fresh.iter()).filter(|(_, fresh)| **fresh) {
            table.restart();
        }
        for p in planners {
            let part = members[p.task].part();
            if fresh[part] {
                p.enter(tick.times, &values[part].inputs);
            }
        }
    }

    /// Notifies the tasks that the velocity blends from that of another stack.
    pub fn hand_over(&mut self) {
        self.tasks.iter_mut().for_each(|task| task.hand_over());
    }

    /// Captures all values at the configuration whose kinematics are known. Undefined values become NaN.
    fn capture(&mut self, q: &[f64], tick: TickInputs) {
        let Evaluator { model, data, values, captures, tasks, fresh, .. } = self;
        let TickInputs { velocity, stack_velocity, .. } = tick;
        for capture in captures.iter_mut().filter(|c| fresh[c.part]) {
            let ValueTable { current, rates, inputs, .. } = &mut values[capture.part];
            let state = State { model, data, q, values: current, rates, velocity, stack_velocity };
            let out = &mut inputs[capture.inputs.clone()];
            match &mut capture.source {
                Source::Task(member, name) => {
                    tasks[*member].current_value(name, &state, out);
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

    /// Captures the rates of task values by central differences along the velocity.
    fn capture_velocities(&mut self, q: &[f64], tick: TickInputs) {
        let Evaluator { model, data, values, captures, tasks, beside, fresh, .. } = self;
        for capture in captures.iter().filter(|c| fresh[c.part]) {
            let Source::Velocity(member, name, width) = &capture.source else { continue };
            let ValueTable { current, rates, inputs, .. } = &mut values[capture.part];
            let mut sides = [[0.0; 7]; 2];
            for (numbers, h) in sides.iter_mut().zip([-velocity::STEP, velocity::STEP]) {
                beside.copy_from_slice(q);
                model.integrate(beside, tick.velocity, h);
                model.forward(beside, data);
                let TickInputs { velocity, stack_velocity, .. } = tick;
                let state = State { model, data, q: beside, values: current, rates, velocity, stack_velocity };
                tasks[*member].current_value(name, &state, &mut numbers[..*width]);
            }
            let [before, after] = &sides;
            velocity::between(&before[..*width], &after[..*width], &mut inputs[capture.inputs.clone()]);
        }
    }
}
