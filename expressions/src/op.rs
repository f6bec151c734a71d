//! One operation of an expression: its operands, its value, and its derivative in each operand.
//!
//! Truth values are the numbers 1 and -1. If a function has no derivative, the one of the branch that determines the
//! value is used. If the derivative is infinite (the root at 0, the arcs at -1 and 1), zero is used.

use serde::{Deserialize, Serialize};

/// Largest excess beyond -1 and 1 of the argument of an arc function that counts as rounding error.
pub const ROUNDING: f64 = 1e-12;

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
    /// An input: a captured value, or a value of the table of values.
    Input(usize),
    /// A number of the robot's present state.
    State(usize),
    /// A number of the table of signals: the presence of one (1 or -1), or a part of its value.
    Signal(usize),
    /// A number of the trajectories: a part of the value of one, or of its time derivative.
    Trajectory(usize),
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
    /// The angle within -pi/2 and pi/2 whose sine is a
    Asin(usize),
    /// The angle within 0 and pi whose cosine is a
    Acos(usize),
    /// The angle of the point (b, a) of the plane, within -pi and pi; 0 for (0, 0)
    Atan2(usize, usize),
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
    /// `if a < b then 1 else -1`
    Less(usize, usize),
    /// `if a <= b then 1 else -1`
    LessEqual(usize, usize),
    /// `if a >= 0 then b else c`
    Select(usize, usize, usize),
}

/// 1 for `yes`, -1 for `no`, or NaN for neither.
fn truth(yes: bool, no: bool) -> f64 {
    match (yes, no) {
        (true, _) => 1.0,
        (_, true) => -1.0,
        _ => f64::NAN,
    }
}

/// Argument of an arc function, clamped if it exceeds the range by rounding.
fn within_one(x: f64) -> f64 {
    if x.abs() <= 1.0 + ROUNDING { x.clamp(-1.0, 1.0) } else { x }
}

impl Op {
    /// Operations that it reads.
    #[inline]
    pub fn operands(&self) -> [Option<usize>; 3] {
        match *self {
            Op::Const(_) | Op::T | Op::Time | Op::Input(_) | Op::State(_) | Op::Signal(_) | Op::Trajectory(_) => {
                [None; 3]
            }
            Op::Neg(a)
            | Op::Sin(a)
            | Op::Cos(a)
            | Op::Asin(a)
            | Op::Acos(a)
            | Op::Exp(a)
            | Op::Log(a)
            | Op::Sqrt(a)
            | Op::Abs(a)
            | Op::Powi(a, _) => [Some(a), None, None],
            Op::Add(a, b)
            | Op::Sub(a, b)
            | Op::Mul(a, b)
            | Op::Div(a, b)
            | Op::Atan2(a, b)
            | Op::Min(a, b)
            | Op::Max(a, b)
            | Op::Less(a, b)
            | Op::LessEqual(a, b) => [Some(a), Some(b), None],
            Op::Select(a, b, c) => [Some(a), Some(b), Some(c)],
        }
    }

    /// The same operation on other operands: `f` returns the new index of each old one.
    pub fn renumber(self, f: impl Fn(usize) -> usize) -> Op {
        match self {
            Op::Const(_) | Op::T | Op::Time | Op::Input(_) | Op::State(_) | Op::Signal(_) | Op::Trajectory(_) => self,
            Op::Neg(a) => Op::Neg(f(a)),
            Op::Sin(a) => Op::Sin(f(a)),
            Op::Cos(a) => Op::Cos(f(a)),
            Op::Asin(a) => Op::Asin(f(a)),
            Op::Acos(a) => Op::Acos(f(a)),
            Op::Exp(a) => Op::Exp(f(a)),
            Op::Log(a) => Op::Log(f(a)),
            Op::Sqrt(a) => Op::Sqrt(f(a)),
            Op::Abs(a) => Op::Abs(f(a)),
            Op::Powi(a, n) => Op::Powi(f(a), n),
            Op::Add(a, b) => Op::Add(f(a), f(b)),
            Op::Sub(a, b) => Op::Sub(f(a), f(b)),
            Op::Mul(a, b) => Op::Mul(f(a), f(b)),
            Op::Div(a, b) => Op::Div(f(a), f(b)),
            Op::Atan2(a, b) => Op::Atan2(f(a), f(b)),
            Op::Min(a, b) => Op::Min(f(a), f(b)),
            Op::Max(a, b) => Op::Max(f(a), f(b)),
            Op::Less(a, b) => Op::Less(f(a), f(b)),
            Op::LessEqual(a, b) => Op::LessEqual(f(a), f(b)),
            Op::Select(a, b, c) => Op::Select(f(a), f(b), f(c)),
        }
    }

    /// Computes its value from those of its operands (`r`) and of inputs (`leaf`, called for `T`, `Time`, `Input`,
    /// `State`, `Signal` and `Trajectory`).
    #[inline]
    pub fn value(self, r: impl Fn(usize) -> f64, leaf: impl Fn(Op) -> f64) -> f64 {
        match self {
            Op::Const(x) => x,
            Op::T | Op::Time | Op::Input(_) | Op::State(_) | Op::Signal(_) | Op::Trajectory(_) => leaf(self),
            Op::Add(a, b) => r(a) + r(b),
            Op::Sub(a, b) => r(a) - r(b),
            Op::Mul(a, b) => r(a) * r(b),
            Op::Div(a, b) => r(a) / r(b),
            Op::Neg(a) => -r(a),
            Op::Sin(a) => r(a).sin(),
            Op::Cos(a) => r(a).cos(),
            Op::Asin(a) => within_one(r(a)).asin(),
            Op::Acos(a) => within_one(r(a)).acos(),
            Op::Atan2(a, b) => r(a).atan2(r(b)),
            Op::Exp(a) => r(a).exp(),
            Op::Log(a) => r(a).ln(),
            Op::Sqrt(a) => r(a).sqrt(),
            Op::Abs(a) => r(a).abs(),
            Op::Powi(a, n) => r(a).powi(n),
            Op::Min(a, b) => {
                if r(b) < r(a) {
                    r(b)
                } else {
                    r(a)
                }
            }
            Op::Max(a, b) => {
                if r(b) > r(a) {
                    r(b)
                } else {
                    r(a)
                }
            }
            Op::Less(a, b) => truth(r(a) < r(b), r(a) >= r(b)),
            Op::LessEqual(a, b) => truth(r(a) <= r(b), r(a) > r(b)),
            Op::Select(a, b, c) => {
                let test = r(a);
                if test >= 0.0 {
                    r(b)
                } else if test < 0.0 {
                    r(c)
                } else {
                    f64::NAN
                }
            }
        }
    }

    /// One step of the reverse sweep: adds the contributions of its own adjoint `g`, which is not zero, to the
    /// `adjoints` of its operands. `own` is its value, `r` contains those of the operations before it. A missing
    /// operand is left out.
    #[inline]
    pub fn pull(self, g: f64, own: f64, r: &[f64], adjoints: &mut [f64]) {
        let at = |a: usize| r.get(a).copied().unwrap_or(f64::NAN);
        let mut add = |a: usize, x: f64| {
            if let Some(adjoint) = adjoints.get_mut(a) {
                *adjoint += x;
            }
        };
        match self {
            Op::Const(_)
            | Op::T
            | Op::Time
            | Op::Input(_)
            | Op::State(_)
            | Op::Signal(_)
            | Op::Trajectory(_)
            | Op::Less(..)
            | Op::LessEqual(..) => {}
            Op::Add(a, b) => {
                add(a, g);
                add(b, g);
            }
            Op::Sub(a, b) => {
                add(a, g);
                add(b, -g);
            }
            Op::Mul(a, b) => {
                add(a, g * at(b));
                add(b, g * at(a));
            }
            Op::Div(a, b) => {
                let share = g / at(b);
                add(a, share);
                add(b, -share * own);
            }
            Op::Neg(a) => add(a, -g),
            Op::Sin(a) => add(a, g * at(a).cos()),
            Op::Cos(a) => add(a, -g * at(a).sin()),
            Op::Asin(a) => add(a, g * arc_slope(at(a))),
            Op::Acos(a) => add(a, -g * arc_slope(at(a))),
            Op::Atan2(a, b) => {
                let (y, x) = (at(a), at(b));
                let square = x * x + y * y;
                if square != 0.0 {
                    add(a, g * x / square);
                    add(b, -g * y / square);
                }
            }
            Op::Exp(a) => add(a, g * own),
            Op::Log(a) => add(a, g / at(a)),
            Op::Sqrt(a) => {
                if own != 0.0 {
                    add(a, g / (2.0 * own));
                }
            }
            Op::Abs(a) => add(a, if at(a) >= 0.0 { g } else { -g }),
            Op::Powi(a, n) => add(a, g * f64::from(n) * at(a).powi(n.saturating_sub(1))),
            Op::Min(a, b) => add(if at(b) < at(a) { b } else { a }, g),
            Op::Max(a, b) => add(if at(b) > at(a) { b } else { a }, g),
            Op::Select(a, b, c) => add(if at(a) >= 0.0 { b } else { c }, g),
        }
    }
}

/// `1/sqrt(1 - x²)`, or zero if that is infinite.
fn arc_slope(x: f64) -> f64 {
    let rest = 1.0 - x * x;
    if rest <= 0.0 { 0.0 } else { 1.0 / rest.sqrt() }
}
