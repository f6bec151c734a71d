//! What the machine does itself: it sets variables and tares sensors.
//!
//! At a tick the actions of the states that are left and entered are done one after another, in that order. Each sees the
//! table of signals as those before it left it; so does the stack that runs at the same tick. Triggers see it at the next.

use robot::{Data, Model};
use stdlib_tasks::expression::{Evaluation, Expression};
use stdlib_tasks::task::State;

use crate::fault::Fault;
use crate::program::{OwnAction, Program, Times};
use crate::signals::Signals;
use crate::values::ValueTable;

/// An action of the controller itself, made ready.
pub(super) enum Own {
    Set { variable: usize, optional: bool, value: Box<Assigned> },
    Clear(usize),
    Tare(usize),
}

/// The value that a variable is set to, made ready.
pub(super) struct Assigned {
    values: ValueTable,
    expression: Evaluation,
    /// Whether it reads what the robot does.
    state: bool,
    numbers: Vec<f64>,
}

/// What is known at the tick of an action.
#[derive(Clone, Copy)]
pub(super) struct Present<'a> {
    /// The observed configuration, which may be of no use.
    pub q: &'a [f64],
    /// The velocity that the reference moved with since the last tick.
    pub velocity: &'a [f64],
    /// The time of the tick, in s.
    pub time: f64,
}

impl Own {
    /// Makes a checked action ready.
    pub fn new(program: &Program, action: &OwnAction) -> Own {
        match action {
            OwnAction::Set { variable, value } => Own::Set {
                variable: *variable,
                optional: program.interface.signals[*variable].optional,
                value: Box::new(Assigned::new(program, value)),
            },
            OwnAction::Clear(variable) => Own::Clear(*variable),
            OwnAction::Tare(signal) => Own::Tare(*signal),
        }
    }

    /// Does it; `entered` is when the state was entered in which it stands. Never allocates.
    ///
    /// # Errors
    /// A signal that it needs is absent, or a variable that is never absent was to be set to what is not finite. Nothing
    /// is changed then.
    pub fn act(
        &mut self,
        signals: &mut Signals,
        (model, data): (&Model, &mut Data),
        now: Present,
        entered: f64,
    ) -> Result<(), Fault> {
        match self {
            Own::Set { variable, optional, value } => {
                let found = value.evaluate(signals.table(), (model, data), now, entered);
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
            Own::Clear(variable) => signals.forget(*variable),
            Own::Tare(signal) => {
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

    /// The numbers, which need not be finite.
    fn evaluate(
        &mut self,
        signals: &[f64],
        (model, data): (&Model, &mut Data),
        now: Present,
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
