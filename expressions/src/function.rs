//! A function of a few numbers, its arguments, as operations of which [`Op::Input`] reads an argument.

use serde::{Deserialize, Serialize};

use crate::op::Op;

/// Largest number of operations of a function.
pub const MAX_OPERATIONS: usize = 128;

/// Values of the operations of a function.
#[derive(Clone, Debug)]
pub struct Registers([f64; MAX_OPERATIONS]);

impl Registers {
    /// Evaluates the operations of a function, at most [`MAX_OPERATIONS`]. What does not exist is NaN.
    pub fn of(ops: &[Op], arguments: &[f64]) -> Registers {
        let mut registers = [f64::NAN; MAX_OPERATIONS];
        for (i, op) in ops.iter().enumerate().take(MAX_OPERATIONS) {
            let argument = |leaf| match leaf {
                Op::Input(k) => arguments.get(k).copied().unwrap_or(f64::NAN),
                _ => f64::NAN,
            };
            registers[i] = op.value(|a| registers.get(a).copied().unwrap_or(f64::NAN), argument);
        }
        Registers(registers)
    }

    /// Returns the value of an operation.
    pub fn get(&self, operation: usize) -> f64 {
        self.0.get(operation).copied().unwrap_or(f64::NAN)
    }
}

/// Checks the operations of a function with this number of arguments, and that its results exist.
///
/// # Errors
/// Description of the first error.
pub fn check(ops: &[Op], arguments: usize, results: &[usize]) -> Result<(), &'static str> {
    let ensure = |good: bool, message| if good { Ok(()) } else { Err(message) };
    ensure(ops.len() <= MAX_OPERATIONS, "a function has too many operations")?;
    for (i, op) in ops.iter().enumerate() {
        ensure(op.operands().iter().flatten().all(|&o| o < i), "an operation reads one that comes later")?;
        let good = match op {
            Op::Input(k) => *k < arguments,
            Op::T | Op::Time | Op::State(_) | Op::Signal(_) | Op::Trajectory(_) => false,
            _ => true,
        };
        ensure(good, "a function reads something else than its arguments")?;
    }
    ensure(results.iter().all(|&result| result < ops.len()), "a result of a function points nowhere")
}

/// A function with one result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Function {
    /// Operations, operands before users; at most [`MAX_OPERATIONS`].
    pub ops: Vec<Op>,
    /// Operation that computes the result.
    pub result: usize,
    /// The expression as it is written, for people.
    pub text: String,
}

impl Function {
    /// Returns true if its value may depend on an argument.
    pub fn uses(&self, argument: usize) -> bool {
        self.ops.contains(&Op::Input(argument))
    }

    /// Returns the function that has this value everywhere.
    pub fn constant(x: f64) -> Function {
        Function { ops: vec![Op::Const(x)], result: 0, text: String::new() }
    }

    /// Returns its value if it is the same everywhere.
    pub fn as_constant(&self) -> Option<f64> {
        match self.ops.get(self.result) {
            Some(Op::Const(x)) => Some(*x),
            _ => None,
        }
    }

    /// Evaluates the function.
    pub fn evaluate(&self, arguments: &[f64]) -> f64 {
        Registers::of(&self.ops, arguments).get(self.result)
    }

    /// Checks the function, which was read from a file.
    ///
    /// # Errors
    /// Description of the first error.
    pub fn check(&self, arguments: usize) -> Result<(), &'static str> {
        check(&self.ops, arguments, &[self.result])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_function_is_evaluated() {
        // 3 exp(-d) + away.x
        let ops =
            vec![Op::Input(0), Op::Neg(0), Op::Exp(1), Op::Const(3.0), Op::Mul(3, 2), Op::Input(1), Op::Add(4, 5)];
        let f = Function { ops, result: 6, text: String::new() };
        assert_eq!(f.check(2), Ok(()));
        for [d, x] in [[0.0, 0.0], [0.4, -2.0], [7.0, 1.5]] {
            assert!((f.evaluate(&[d, x]) - (3.0 * f64::exp(-d) + x)).abs() < 1e-15);
        }
        assert!(f.evaluate(&[1.0]).is_nan(), "an argument is missing");
        assert_eq!((f.as_constant(), Function::constant(2.0).as_constant()), (None, Some(2.0)));
    }

    #[test]
    fn an_edited_function_is_refused() {
        let of = |ops: Vec<Op>, result| Function { ops, result, text: String::new() }.check(2).is_err();
        assert!(of(vec![Op::Neg(0)], 0));
        assert!(of(vec![Op::Time], 0));
        assert!(of(vec![Op::Input(2)], 0));
        assert!(of(vec![Op::Input(0)], 1));
        assert!(of(vec![Op::Input(0); MAX_OPERATIONS + 1], 0));
    }
}
