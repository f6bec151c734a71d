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

/// Prepares a capture; `None` if it belongs to a task of another stack.
pub(super) fn ready(capture: &Capture, model: &Model, members: &[Member]) -> Option<Captured> {
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

impl Evaluator {
    /// Enters the stack at a configuration: captures the values of `initial(..)`. Never allocates.
    pub fn enter(&mut self, q: &[f64], tick: TickInputs) {
        self.values.inputs.fill(0.0);
        self.values.restart();
        for p in &mut self.planners {
            p.enter(tick.times, &self.values.inputs);
        }
        self.kinematics(q, tick);
        self.capture(q, tick);
        self.capture_velocities(q, tick);
        self.values.restart();
        for p in &mut self.planners {
            p.enter(tick.times, &self.values.inputs);
        }
        self.kinematics(q, tick);
        let Evaluator { model, data, values, tasks, .. } = self;
        let ValueTable { current, rates, .. } = values;
        let TickInputs { velocity, stack_velocity, .. } = tick;
        let state = State { model, data, q, values: current, rates, velocity, stack_velocity };
        for task in tasks {
            task.enter(&state);
        }
    }

    /// Notifies the tasks that the velocity blends from that of another stack.
    pub fn hand_over(&mut self) {
        self.tasks.iter_mut().for_each(|task| task.hand_over());
    }

    /// Captures all values at the configuration whose kinematics are known. Undefined values become NaN.
    fn capture(&mut self, q: &[f64], tick: TickInputs) {
        let Evaluator { model, data, values, captures, tasks, .. } = self;
        let ValueTable { current, rates, inputs, .. } = values;
        let TickInputs { velocity, stack_velocity, .. } = tick;
        let state = State { model, data, q, values: current, rates, velocity, stack_velocity };
        for capture in captures {
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
        let Evaluator { model, data, values, captures, tasks, beside, .. } = self;
        let ValueTable { current, rates, inputs, .. } = values;
        for capture in captures.iter() {
            let Source::Velocity(member, name, width) = &capture.source else { continue };
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
