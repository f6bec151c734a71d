//! Shared by the tasks that a spec writes as expressions: gains that may depend on the state, names of rows, the value
//! that `initial(value)` captures.

use std::cell::RefCell;

use crate::closest_points::SeparationError;
use crate::dimension::Dimension;
use crate::expression::Term;
use crate::params::Operand;
use crate::task::{BuildError, Context, State, TaskFault};

/// A gain in 1/s.
pub struct Gain {
    term: Term,
    /// Largest gain that does not overshoot within one period.
    max: f64,
}

impl Gain {
    /// Creates a gain from an operand of one number.
    ///
    /// # Errors
    /// The operand has several numbers.
    pub fn new(operand: &Operand, ctx: &Context) -> Result<Self, BuildError> {
        if operand.len() != 1 {
            return Err(BuildError::new("gain", "`gain` is one number"));
        }
        Ok(Gain { term: Term::new(operand, ctx.model), max: (1.0 + 1e-12) / ctx.period })
    }

    /// Its value if it depends on time alone; empty otherwise.
    pub fn constant(&self, values: &[f64]) -> Vec<f64> {
        match self.term {
            Term::Slot(at, _) => values.get(at).copied().into_iter().collect(),
            Term::State(_) => Vec::new(),
        }
    }

    /// Forgets the directions between parts that were last valid.
    pub fn forget(&mut self) {
        self.term.forget();
    }

    /// Computes its value of this tick.
    ///
    /// # Errors
    /// It depends on the state and is not a valid gain here. The controller checks a gain that depends on time alone.
    pub fn forward(&mut self, state: &State) -> Result<(), TaskFault> {
        self.term.forward(state).map_err(fault)?;
        let good = !self.term.is_state() || (0.0..=self.max).contains(&self.of(state));
        if good { Ok(()) } else { Err(TaskFault::Gain { row: 0 }) }
    }

    /// Its value, after [`Gain::forward`].
    pub fn of(&self, state: &State) -> f64 {
        self.term.value(state, 0)
    }
}

/// Fault of an expression that has no value.
pub fn fault(no: SeparationError) -> TaskFault {
    match no {
        SeparationError::NotFinite => TaskFault::NotFinite { row: 0 },
        SeparationError::Overlap => TaskFault::Overlap { row: 0 },
    }
}

/// Names of the rows of a value with so many numbers.
pub fn row_names(len: usize) -> &'static [&'static str] {
    match len {
        1 => &["value"],
        3 => &["x", "y", "z"],
        _ => &["rx", "ry", "rz"],
    }
}

/// Dimension of a value that is an expression of the state; `None` for an orientation or a pose.
pub fn dimension(value: &Operand) -> Option<Dimension> {
    match value {
        Operand::Expression(e) if !matches!(e.outputs.len(), 4 | 7) => Some(e.dimension),
        _ => None,
    }
}

/// Writes the value of a term, as `initial(value)` captures it; false if it has none.
pub fn current_value(term: &RefCell<Term>, state: &State, out: &mut [f64]) -> bool {
    let Ok(mut term) = term.try_borrow_mut() else { return false };
    if term.forward(state).is_err() {
        return false;
    }
    for (i, x) in out.iter_mut().enumerate().take(term.len()) {
        *x = term.value(state, i);
    }
    true
}
