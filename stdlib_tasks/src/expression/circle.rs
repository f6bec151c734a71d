//! Angles on the circle: numbers whose whole turns mean nothing.
//!
//! The position of a continuous joint without limits is one, and so is an `atan2`, which jumps by a turn where its point
//! crosses the seam, `y = 0` with `x < 0`. A sum with such an angle is one too. Other functions of an `atan2` jump by other
//! amounts, except for those that are the same on both sides of the seam: sine, cosine, absolute value, even powers.

use robot::Model;

use super::{Expression, Leaf, Op};

/// Behaviour of a number under whole turns of the angles that it is made of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Turning {
    /// A number that does not jump.
    Steady,
    /// The position of a joint on the circle, or a sum with one: it does not jump, and whole turns mean nothing.
    OnCircle,
    /// A sum with an `atan2`: it jumps by whole turns, which mean nothing.
    JumpsByTurns,
    /// It jumps by something else than whole turns.
    Jumps,
}

impl Turning {
    /// Returns true for an angle whose whole turns mean nothing.
    pub fn is_angle_on_circle(self) -> bool {
        matches!(self, Turning::OnCircle | Turning::JumpsByTurns)
    }
}

/// What is known of an operation.
#[derive(Clone, Copy)]
struct Known {
    turning: Turning,
    /// True if its value cannot be negative.
    never_negative: bool,
    /// True for an `atan2` with either sign, which has the same size on both sides of its seam.
    plain: bool,
}

impl Expression {
    /// Behaviour of the value under whole turns; of several numbers, that of the worst.
    pub fn turning(&self, model: &Model) -> Turning {
        let mut known: Vec<Known> = Vec::with_capacity(self.ops.len());
        for op in &self.ops {
            let next = self.look(*op, &known, model);
            known.push(next);
        }
        let of = |&o: &usize| known.get(o).map_or(Turning::Steady, |k| k.turning);
        self.outputs.iter().map(of).max().unwrap_or(Turning::Steady)
    }

    fn look(&self, op: Op, known: &[Known], model: &Model) -> Known {
        let steady = Known { turning: Turning::Steady, never_negative: false, plain: false };
        let of = |o: usize| known.get(o).copied().unwrap_or(steady);
        let worst = op.operands().iter().flatten().map(|&o| of(o).turning).max().unwrap_or(Turning::Steady);
        // What a function makes of its operands: whole turns of a joint are a number like any other.
        let through = if worst < Turning::JumpsByTurns { Turning::Steady } else { Turning::Jumps };
        // What is the same at both sides of a seam does not jump.
        let even = |a: usize| if of(a).plain && worst < Turning::Jumps { Turning::Steady } else { through };
        let factor = |o: usize| match self.ops.get(o) {
            Some(Op::Const(x)) => x.fract() == 0.0 && *x != 0.0,
            _ => false,
        };
        let turning = match op {
            Op::State(k) => match self.joint_of(k) {
                Some(dof) if model.is_on_circle(dof) => Turning::OnCircle,
                _ => Turning::Steady,
            },
            Op::Atan2(y, x) if worst < Turning::JumpsByTurns => {
                if of(y).never_negative || of(x).never_negative {
                    Turning::Steady
                } else {
                    Turning::JumpsByTurns
                }
            }
            Op::Add(..) | Op::Sub(..) | Op::Neg(_) => worst,
            Op::Mul(a, b) if factor(a) || factor(b) => worst,
            Op::Mul(a, b) if a == b => even(a),
            Op::Sin(_) | Op::Cos(_) if worst < Turning::Jumps => Turning::Steady,
            Op::Abs(a) => even(a),
            Op::Powi(a, n) if n % 2 == 0 => even(a),
            Op::Select(_, a, b) => of(a).turning.max(of(b).turning),
            _ => through,
        };
        let never_negative = match op {
            Op::Const(x) => x >= 0.0,
            Op::Sqrt(_) | Op::Abs(_) | Op::Exp(_) | Op::Acos(_) => true,
            Op::Powi(_, n) if n % 2 == 0 => true,
            Op::Powi(a, _) => of(a).never_negative,
            Op::Mul(a, b) => a == b || (of(a).never_negative && of(b).never_negative),
            Op::Add(a, b) | Op::Div(a, b) | Op::Min(a, b) => of(a).never_negative && of(b).never_negative,
            Op::Max(a, b) => of(a).never_negative || of(b).never_negative,
            Op::Select(_, a, b) => of(a).never_negative && of(b).never_negative,
            _ => false,
        };
        let plain = match op {
            Op::Atan2(..) => true,
            Op::Neg(a) => of(a).plain,
            _ => false,
        };
        Known { turning, never_negative, plain }
    }

    /// Degree of freedom whose position is number `k` of the leaves.
    fn joint_of(&self, k: usize) -> Option<usize> {
        match self.leaf_of(k) {
            Some(Leaf::Joint(dof)) => Some(*dof),
            _ => None,
        }
    }
}
