//! Actions that the controller performs itself: setting variables and taring sensors.
//!
//! At a tick, the actions of the states that are exited and entered are performed one after another, in that order.
//! Each one reads the table of signals as the previous ones left it, and so does the stack that runs at the same tick.
//! Triggers read the table at the next tick.

use robot::{Data, Model};
use stdlib_tasks::expression::{Evaluation, Expression};
use stdlib_tasks::task::State;

use crate::fault::Fault;
use crate::program::{MachineAction, Program, Times};
use crate::signals::Signals;
use crate::values::ValueTable;

/// Prepared action of the controller itself.
pub(super) enum ReadyAction {
    Set { variable: usize, optional: bool, value: Box<Assigned> },
    Clear(usize),
    Tare(usize),
}

/// Prepared expression of the value that a variable is set to.
pub(super) struct Assigned {
    values: ValueTable,
    expression: Evaluation,
    /// True if it reads the state of the robot.
    state: bool,
    numbers: Vec<f64>,
}

/// Model of the robot, with storage for its kinematics at a configuration.
pub(super) struct Kinematics<'a> {
    pub model: &'a Model,
    pub data: &'a mut Data,
}

/// State of the robot at the tick of an action.
#[derive(Clone, Copy)]
pub(super) struct ObservedState<'a> {
    /// Observed configuration, which may be unusable.
    pub q: &'a [f64],
    /// Velocity of the reference since the last tick.
    pub velocity: &'a [f64],
    /// Time of the tick (s).
    pub time: f64,
}

impl ReadyAction {
    /// Prepares a checked action.
    pub fn new(program: &Program, action: &MachineAction) -> ReadyAction {
        match action {
            MachineAction::Set { variable, value } => ReadyAction::Set {
                variable: *variable,
                optional: program.interface.signals[*variable].optional,
                value: Box::new(Assigned::new(program, value)),
            },
            MachineAction::Clear(variable) => ReadyAction::Clear(*variable),
            MachineAction::Tare(signal) => ReadyAction::Tare(*signal),
        }
    }

    /// Performs the action; `entered` is the time at which its state was entered (s). Never allocates.
    ///
    /// # Errors
    /// A signal that the action needs is absent, or a variable that is never absent would get a value that is not
    /// finite. The variable or bias is then unchanged.
    pub fn act(
        &mut self,
        signals: &mut Signals,
        kinematics: Kinematics,
        now: ObservedState,
        entered: f64,
    ) -> Result<(), Fault> {
        match self {
            ReadyAction::Set { variable, optional, value } => {
                let found = value.evaluate(signals.table(), kinematics, now, entered);
                let failed = match found {
                    Ok(numbers) if signals.assign(*variable, numbers) => return Ok(()),
                    Ok(_) => Fault::Variable { signal: *variable },
                    Err(fault) => fault,
                };
                if !*optional {
                    return Err(failed);
                }
                signals.forget(*variable);
            }
            ReadyAction::Clear(variable) => signals.forget(*variable),
            ReadyAction::Tare(signal) => {
                if !signals.tare(*signal) {
                    return Err(Fault::Stale { signal: *signal });
                }
            }
        }
        Ok(())
    }
}

impl Assigned {
    fn new(program: &Program, value: &Expression) -> Assigned {
        let wanted = value.inputs.iter().copied().collect();
        Assigned {
            values: ValueTable::new(&program.values, &wanted, &program.interface),
            expression: Evaluation::new(value, &program.robot.model),
            state: !value.leaves.is_empty(),
            numbers: vec![f64::NAN; value.outputs.len()],
        }
    }

    /// Computes the numbers, which may not be finite.
    fn evaluate(
        &mut self,
        signals: &[f64],
        Kinematics { model, data }: Kinematics,
        now: ObservedState,
        entered: f64,
    ) -> Result<&[f64], Fault> {
        let Assigned { values, expression, state, numbers } = self;
        numbers.fill(f64::NAN);
        values.evaluate(Times { t: now.time - entered, time: now.time }, signals);
        if let Some(signal) = values.absent(signals) {
            return Err(Fault::Stale { signal });
        }
        if *state {
            if now.q.len() != model.nq() || !now.q.iter().all(|x| x.is_finite()) {
                return Ok(numbers);
            }
            model.forward(now.q, data);
        }
        let ValueTable { current, rates, .. } = values;
        let velocity = now.velocity;
        let at = State { model, data, q: now.q, values: current, rates, velocity, stack_velocity: velocity };
        if expression.forward(&at).is_ok() {
            numbers.iter_mut().enumerate().for_each(|(i, x)| *x = expression.value(i));
        }
        Ok(numbers)
    }
}
