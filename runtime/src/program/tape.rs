//! Expressions as a flat list of operations on numbers, each reading earlier results.
//!
//! The compiler writes the operations of a value and those of its exact time derivative into one tape, with common
//! parts shared. Evaluating is one pass over the list; nothing is allocated.

use serde::{Deserialize, Serialize};

/// An operation; operands are indices of earlier operations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Op {
    /// A number.
    Const(f64),
    /// Time since the stack became active, in s.
    T,
    /// Time since the start of the run, in s.
    Time,
    /// A captured value.
    Input(usize),
    /// a + b
    Add(usize, usize),
    /// a - b
    Sub(usize, usize),
    /// a b
    Mul(usize, usize),
    /// a / b
    Div(usize, usize),
    /// -a
    Neg(usize),
    /// sin a
    Sin(usize),
    /// cos a
    Cos(usize),
    /// exp a
    Exp(usize),
    /// The natural logarithm of a
    Log(usize),
    /// The square root of a
    Sqrt(usize),
    /// |a|
    Abs(usize),
    /// a to an integer power
    Powi(usize, i32),
    /// The smaller one
    Min(usize, usize),
    /// The larger one
    Max(usize, usize),
    /// `if a >= 0 then b else c`
    Select(usize, usize, usize),
}

/// Where a result goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Output {
    /// Place in the table of values.
    pub at: usize,
    /// Operation that holds the value.
    pub value: usize,
    /// Operation that holds its time derivative.
    pub rate: usize,
}

/// A list of operations and where their results go.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tape {
    /// Operations, operands before users.
    pub ops: Vec<Op>,
    /// Results.
    pub outputs: Vec<Output>,
    /// Number of captured values.
    pub inputs: usize,
}

/// The two clocks of an expression, in s.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Times {
    /// Since the stack became active.
    pub t: f64,
    /// Since the start of the run.
    pub time: f64,
}

impl Tape {
    /// Evaluates all operations into `registers` (as many as operations) and writes the outputs into the tables of
    /// values and rates. The tape has passed [`super::Program::check`].
    pub fn evaluate(&self, times: Times, inputs: &[f64], registers: &mut [f64], values: &mut [f64], rates: &mut [f64]) {
        for (i, op) in self.ops.iter().enumerate() {
            let r = &*registers;
            registers[i] = match *op {
                Op::Const(x) => x,
                Op::T => times.t,
                Op::Time => times.time,
                Op::Input(k) => inputs[k],
                Op::Add(a, b) => r[a] + r[b],
                Op::Sub(a, b) => r[a] - r[b],
                Op::Mul(a, b) => r[a] * r[b],
                Op::Div(a, b) => r[a] / r[b],
                Op::Neg(a) => -r[a],
                Op::Sin(a) => r[a].sin(),
                Op::Cos(a) => r[a].cos(),
                Op::Exp(a) => r[a].exp(),
                Op::Log(a) => r[a].ln(),
                Op::Sqrt(a) => r[a].sqrt(),
                Op::Abs(a) => r[a].abs(),
                Op::Powi(a, n) => r[a].powi(n),
                Op::Min(a, b) => {
                    if r[b] < r[a] {
                        r[b]
                    } else {
                        r[a]
                    }
                }
                Op::Max(a, b) => {
                    if r[b] > r[a] {
                        r[b]
                    } else {
                        r[a]
                    }
                }
                Op::Select(a, b, c) => {
                    if r[a] >= 0.0 {
                        r[b]
                    } else {
                        r[c]
                    }
                }
            };
        }
        for o in &self.outputs {
            values[o.at] = registers[o.value];
            rates[o.at] = registers[o.rate];
        }
    }
}

impl Op {
    /// The operations that it reads.
    pub fn operands(&self) -> [Option<usize>; 3] {
        match *self {
            Op::Const(_) | Op::T | Op::Time | Op::Input(_) => [None; 3],
            Op::Neg(a)
            | Op::Sin(a)
            | Op::Cos(a)
            | Op::Exp(a)
            | Op::Log(a)
            | Op::Sqrt(a)
            | Op::Abs(a)
            | Op::Powi(a, _) => [Some(a), None, None],
            Op::Add(a, b) | Op::Sub(a, b) | Op::Mul(a, b) | Op::Div(a, b) | Op::Min(a, b) | Op::Max(a, b) => {
                [Some(a), Some(b), None]
            }
            Op::Select(a, b, c) => [Some(a), Some(b), Some(c)],
        }
    }
}
