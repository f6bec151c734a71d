//! Functions of numbers, and the interpolation of values of any kind.

use dsl::Span;
use runtime::program::Op;
use stdlib_tasks::dimension::{ANGLE, Dimension, NONE};
use stdlib_tasks::expression::ROUNDING;

use super::super::arguments::{CallError, angle, number, quantity};
use super::super::ops::{self, additive};
use super::super::{Graph, Kind, Typed, choices, poses};
use super::{Family, Function, Same};

/// Common part of the entries.
const NUMBERS: Function = Function::of(Family::Numbers);

pub(super) static SIN: Function = Function {
    name: "sin",
    form: "sin(angle)",
    takes: "an angle or a bare number",
    gives: "a number",
    angles: &[0],
    apply: |g, args, span| {
        let a = angle(g, args, 0)?;
        Ok(Typed::scalar(g.push(Op::Sin(a)), NONE, span))
    },
    ..NUMBERS
};

pub(super) static COS: Function = Function {
    name: "cos",
    form: "cos(angle)",
    takes: "an angle or a bare number",
    gives: "a number",
    angles: &[0],
    apply: |g, args, span| {
        let a = angle(g, args, 0)?;
        Ok(Typed::scalar(g.push(Op::Cos(a)), NONE, span))
    },
    ..NUMBERS
};

pub(super) static TAN: Function = Function {
    name: "tan",
    form: "tan(angle)",
    takes: "an angle or a bare number",
    gives: "a number",
    angles: &[0],
    apply: |g, args, span| {
        let a = angle(g, args, 0)?;
        let (s, c) = (g.push(Op::Sin(a)), g.push(Op::Cos(a)));
        Ok(Typed::scalar(g.push(Op::Div(s, c)), NONE, span))
    },
    ..NUMBERS
};

pub(super) static EXP: Function = Function {
    name: "exp",
    form: "exp(number)",
    takes: "a bare number",
    gives: "a number",
    apply: |g, args, span| {
        let a = number(args, 0)?;
        Ok(Typed::scalar(g.push(Op::Exp(a)), NONE, span))
    },
    ..NUMBERS
};

pub(super) static LOG: Function = Function {
    name: "log",
    form: "log(number)",
    takes: "a bare number above zero",
    gives: "its natural logarithm",
    apply: |g, args, span| {
        let a = number(args, 0)?;
        if g.constant(a).is_some_and(|x| x <= 0.0) {
            return Err(CallError::Undefined("the logarithm of zero or of a negative number does not exist"));
        }
        Ok(Typed::scalar(g.push(Op::Log(a)), NONE, span))
    },
    ..NUMBERS
};

pub(super) static SQRT: Function = Function {
    name: "sqrt",
    form: "sqrt(x)",
    takes: "a quantity whose unit is a square",
    gives: "the root, with its unit",
    apply: |g, args, span| {
        let a = quantity(args, 0)?;
        let d = a.dimension;
        if d.m % 2 != 0 || d.kg % 2 != 0 || d.s % 2 != 0 || d.rad % 2 != 0 {
            return Err(CallError::Argument {
                index: 0,
                wanted: "a number whose unit is a square, such as m^2".into(),
            });
        }
        if g.constant(a.nodes[0]).is_some_and(|x| x < 0.0) {
            return Err(CallError::Undefined("the square root of a negative number does not exist"));
        }
        let half = Dimension { m: d.m / 2, kg: d.kg / 2, s: d.s / 2, rad: d.rad / 2 };
        Ok(Typed::scalar(g.push(Op::Sqrt(a.nodes[0])), half, span))
    },
    ..NUMBERS
};

pub(super) static ABS: Function = Function {
    name: "abs",
    form: "abs(x)",
    takes: "a quantity",
    gives: "its absolute value, with its unit",
    apply: |g, args, span| {
        let a = quantity(args, 0)?;
        Ok(Typed::scalar(g.push(Op::Abs(a.nodes[0])), a.dimension, span))
    },
    ..NUMBERS
};

/// The least or the greatest argument.
fn extreme(g: &mut Graph, args: &[Typed], op: fn(usize, usize) -> Op, span: Span) -> Result<Typed, CallError> {
    let mut best = quantity(args, 0)?.clone();
    for i in 1..args.len() {
        quantity(args, i)?;
        best = additive(g, &best, &args[i], op, span).map_err(|_| CallError::Different { first: 0, second: i })?;
    }
    Ok(Typed { bare: false, ..best })
}

pub(super) static MIN: Function = Function {
    name: "min",
    form: "min(x, y, ..)",
    takes: "2 to 16 quantities of one unit",
    gives: "the least, with its unit",
    arity: 2..=16,
    same: Same::All,
    apply: |g, args, span| extreme(g, args, Op::Min, span),
    ..NUMBERS
};

pub(super) static MAX: Function = Function {
    name: "max",
    form: "max(x, y, ..)",
    takes: "2 to 16 quantities of one unit",
    gives: "the greatest, with its unit",
    arity: 2..=16,
    same: Same::All,
    apply: |g, args, span| extreme(g, args, Op::Max, span),
    ..NUMBERS
};

pub(super) static CLAMP: Function = Function {
    name: "clamp",
    form: "clamp(x, low, high)",
    takes: "three quantities of one unit",
    gives: "x within low and high, with its unit",
    arity: 3..=3,
    same: Same::All,
    apply: |g, args, span| {
        let (x, low, high) = (quantity(args, 0)?, quantity(args, 1)?, quantity(args, 2)?);
        if let (Some(low), Some(high)) = (g.constant(low.nodes[0]), g.constant(high.nodes[0]))
            && low > high
        {
            return Err(CallError::Undefined("the lower end of `clamp` is above its upper end"));
        }
        let at_least = additive(g, x, low, Op::Max, span).map_err(|_| CallError::Different { first: 0, second: 1 })?;
        let within =
            additive(g, &at_least, high, Op::Min, span).map_err(|_| CallError::Different { first: 0, second: 2 })?;
        Ok(Typed { bare: false, ..within })
    },
    ..NUMBERS
};

pub(super) static LERP: Function = Function {
    name: "lerp",
    form: "lerp(from, to, share)",
    takes: "two numbers or vectors of one unit, or two poses, and a bare number",
    gives: "`from + share (to - from)`; of poses, `lerp` of the positions and `slerp` of the orientations",
    arity: 3..=3,
    same: Same::FirstTwo,
    apply: |g, args, span| {
        if args[..2].iter().any(|a| a.kind == Kind::Pose) {
            return poses::between(g, args, span);
        }
        let s = number(args, 2)?;
        let axes = args[0].axes.joined(&args[1].axes).ok_or(CallError::Axes { first: 0, second: 1 })?;
        let step =
            additive(g, &args[1], &args[0], Op::Sub, span).map_err(|_| CallError::Different { first: 0, second: 1 })?;
        let nodes: Vec<usize> = (args[0].nodes.iter().zip(&step.nodes))
            .map(|(&from, &by)| {
                let part = g.push(Op::Mul(by, s));
                g.push(Op::Add(from, part))
            })
            .collect();
        Ok(Typed { nodes, bare: false, axes, ..step })
    },
    ..NUMBERS
};

pub(super) static SMOOTHSTEP: Function = Function {
    name: "smoothstep",
    form: "smoothstep(share)",
    takes: "a bare number x",
    gives: "`x²(3 - 2x)` for x within 0 and 1; 0 below, 1 above",
    apply: |g, args, span| {
        let x = number(args, 0)?;
        let (zero, one, two, three) = (g.number(0.0), g.number(1.0), g.number(2.0), g.number(3.0));
        let x = g.push(Op::Max(x, zero));
        let x = g.push(Op::Min(x, one));
        let twice = g.push(Op::Mul(two, x));
        let rest = g.push(Op::Sub(three, twice));
        let square = g.push(Op::Powi(x, 2));
        Ok(Typed::scalar(g.push(Op::Mul(square, rest)), NONE, span))
    },
    ..NUMBERS
};

/// The argument of `asin` or `acos`.
fn sine(g: &Graph, args: &[Typed]) -> Result<usize, CallError> {
    let a = number(args, 0)?;
    if g.constant(a).is_some_and(|x| x.abs() > 1.0 + ROUNDING) {
        return Err(CallError::Undefined("no angle has a sine or cosine beyond -1 and 1"));
    }
    Ok(a)
}

pub(super) static ASIN: Function = Function {
    name: "asin",
    form: "asin(number)",
    takes: "a bare number from -1 to 1",
    gives: "an angle from -pi/2 to pi/2",
    apply: |g, args, span| {
        let a = sine(g, args)?;
        Ok(Typed::scalar(g.push(Op::Asin(a)), ANGLE, span))
    },
    ..NUMBERS
};

pub(super) static ACOS: Function = Function {
    name: "acos",
    form: "acos(number)",
    takes: "a bare number from -1 to 1",
    gives: "an angle from 0 to pi",
    apply: |g, args, span| {
        let a = sine(g, args)?;
        Ok(Typed::scalar(g.push(Op::Acos(a)), ANGLE, span))
    },
    ..NUMBERS
};

pub(super) static ATAN2: Function = Function {
    name: "atan2",
    form: "atan2(y, x)",
    takes: "two quantities of one unit",
    gives: "the angle of the point (x, y), from -pi to pi; it jumps by a turn at y = 0 with x < 0, which `track` passes by the nearest turn, and of which limits are warned (`HQ0528`)",
    arity: 2..=2,
    same: Same::All,
    apply: |g, args, span| {
        let (y, x) = (quantity(args, 0)?, quantity(args, 1)?);
        ops::joined(g, y, x).ok_or(CallError::Different { first: 0, second: 1 })?;
        Ok(Typed::scalar(g.push(Op::Atan2(y.nodes[0], x.nodes[0])), ANGLE, span))
    },
    ..NUMBERS
};

pub(super) static IF: Function = Function {
    name: "if",
    form: "if(condition, value, other value)",
    takes: "a truth value, and two values of one kind and unit",
    gives: "the first value if the condition holds, else the other one",
    arity: 3..=3,
    same: Same::AfterFirst,
    apply: choices::choose,
    ..NUMBERS
};
