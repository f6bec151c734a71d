//! The functions of the language.

use runtime::program::Op;
use stdlib_tasks::dimension::{ANGLE, Dimension, NONE};
use stdlib_tasks::expression::ROUNDING;

use super::facts::Fact;
use super::ops::{self, additive, cross, dot};
use super::{Axes, Graph, Kind, Typed, choices, poses, rotations};
use dsl::Span;

/// A function of the language, with its properties for messages.
#[derive(Debug)]
pub struct Function {
    /// Name.
    pub name: &'static str,
    /// Syntax of a call.
    pub form: &'static str,
    /// Number of arguments.
    pub arity: std::ops::RangeInclusive<usize>,
}

/// All functions.
pub static FUNCTIONS: &[Function] = &[
    Function { name: "sin", form: "sin(angle)", arity: 1..=1 },
    Function { name: "cos", form: "cos(angle)", arity: 1..=1 },
    Function { name: "tan", form: "tan(angle)", arity: 1..=1 },
    Function { name: "exp", form: "exp(number)", arity: 1..=1 },
    Function { name: "log", form: "log(number)", arity: 1..=1 },
    Function { name: "sqrt", form: "sqrt(x)", arity: 1..=1 },
    Function { name: "abs", form: "abs(x)", arity: 1..=1 },
    Function { name: "min", form: "min(x, y, ..)", arity: 2..=16 },
    Function { name: "max", form: "max(x, y, ..)", arity: 2..=16 },
    Function { name: "clamp", form: "clamp(x, low, high)", arity: 3..=3 },
    Function { name: "lerp", form: "lerp(from, to, share)", arity: 3..=3 },
    Function { name: "smoothstep", form: "smoothstep(share)", arity: 1..=1 },
    Function { name: "norm", form: "norm(vector)", arity: 1..=1 },
    Function { name: "dot", form: "dot(vector, vector)", arity: 2..=2 },
    Function { name: "cross", form: "cross(vector, vector)", arity: 2..=2 },
    Function { name: "normalize", form: "normalize(vector)", arity: 1..=1 },
    Function { name: "asin", form: "asin(number)", arity: 1..=1 },
    Function { name: "acos", form: "acos(number)", arity: 1..=1 },
    Function { name: "atan2", form: "atan2(y, x)", arity: 2..=2 },
    Function { name: "if", form: "if(condition, value, other value)", arity: 3..=3 },
    Function { name: "rpy", form: "rpy(roll, pitch, yaw)", arity: 3..=3 },
    Function { name: "axis_angle", form: "axis_angle(vector, angle)", arity: 2..=2 },
    Function { name: "quaternion", form: "quaternion(w, x, y, z)", arity: 4..=4 },
    Function { name: "inverse", form: "inverse(orientation or pose)", arity: 1..=1 },
    Function { name: "pose", form: "pose([x, y, z] m, orientation)", arity: 2..=2 },
    Function { name: "slerp", form: "slerp(from, to, share)", arity: 3..=3 },
];

/// True if argument `index` of a function is an angle.
pub(super) fn is_angle(name: &str, index: usize) -> bool {
    matches!((name, index), ("sin" | "cos" | "tan" | "rpy", _) | ("axis_angle", 1))
}

/// Arguments of a function that must have the same dimension.
pub(super) fn alike(name: &str, count: usize) -> std::ops::Range<usize> {
    match name {
        "min" | "max" | "clamp" | "atan2" => 0..count,
        "lerp" => 0..count.min(2),
        "if" => count.min(1)..count,
        _ => 0..0,
    }
}

/// Error of a call.
pub(super) enum CallError {
    /// Argument `index` must be `wanted`.
    Argument { index: usize, wanted: String },
    /// Two arguments must have the same dimension.
    Different { first: usize, second: usize },
    /// Two arguments must be expressed in the same axes.
    Axes { first: usize, second: usize },
    /// The value is undefined at all times.
    Undefined(&'static str),
}

/// Applies a function; the number of arguments is within its arity.
pub(super) fn call(g: &mut Graph, name: &str, args: &[Typed], span: Span) -> Result<Typed, CallError> {
    let scalar = |nodes: usize, dimension: Dimension| Typed {
        kind: Kind::Scalar,
        dimension,
        nodes: vec![nodes],
        bare: false,
        axes: Axes::default(),
        span,
    };
    match name {
        "sin" | "cos" | "tan" => {
            let a = angle(g, args, 0)?;
            let node = match name {
                "sin" => g.push(Op::Sin(a)),
                "cos" => g.push(Op::Cos(a)),
                _ => {
                    let (s, c) = (g.push(Op::Sin(a)), g.push(Op::Cos(a)));
                    g.push(Op::Div(s, c))
                }
            };
            Ok(scalar(node, NONE))
        }
        "exp" | "log" => {
            let a = number(args, 0)?;
            if name == "log" && g.constant(a).is_some_and(|x| x <= 0.0) {
                return Err(CallError::Undefined("the logarithm of zero or of a negative number does not exist"));
            }
            let node = g.push(if name == "exp" { Op::Exp(a) } else { Op::Log(a) });
            Ok(scalar(node, NONE))
        }
        "sqrt" => {
            let a = one(args, 0)?;
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
            let node = g.push(Op::Sqrt(a.nodes[0]));
            Ok(scalar(node, half))
        }
        "abs" => {
            let a = one(args, 0)?;
            let node = g.push(Op::Abs(a.nodes[0]));
            Ok(scalar(node, a.dimension))
        }
        "min" | "max" => {
            let op = if name == "min" { Op::Min } else { Op::Max };
            let mut best = one(args, 0)?.clone();
            for i in 1..args.len() {
                one(args, i)?;
                best =
                    additive(g, &best, &args[i], op, span).map_err(|_| CallError::Different { first: 0, second: i })?;
            }
            Ok(Typed { bare: false, ..best })
        }
        "clamp" => {
            let (x, low, high) = (one(args, 0)?, one(args, 1)?, one(args, 2)?);
            if let (Some(low), Some(high)) = (g.constant(low.nodes[0]), g.constant(high.nodes[0]))
                && low > high
            {
                return Err(CallError::Undefined("the lower end of `clamp` is above its upper end"));
            }
            let at_least =
                additive(g, x, low, Op::Max, span).map_err(|_| CallError::Different { first: 0, second: 1 })?;
            let within = additive(g, &at_least, high, Op::Min, span)
                .map_err(|_| CallError::Different { first: 0, second: 2 })?;
            Ok(Typed { bare: false, ..within })
        }
        "lerp" if args[..2].iter().any(|a| a.kind == Kind::Pose) => poses::between(g, args, span),
        "inverse" if args[0].kind == Kind::Pose => Ok(poses::inverse(g, &args[0], span)),
        "pose" => poses::make(g, args, span),
        "lerp" => {
            let s = number(args, 2)?;
            let axes = args[0].axes.joined(&args[1].axes).ok_or(CallError::Axes { first: 0, second: 1 })?;
            let step = additive(g, &args[1], &args[0], Op::Sub, span)
                .map_err(|_| CallError::Different { first: 0, second: 1 })?;
            let nodes: Vec<usize> = (args[0].nodes.iter().zip(&step.nodes))
                .map(|(&from, &by)| {
                    let part = g.push(Op::Mul(by, s));
                    g.push(Op::Add(from, part))
                })
                .collect();
            Ok(Typed { nodes, bare: false, axes, ..step })
        }
        "smoothstep" => {
            // x^2 (3 - 2 x) for x clamped to 0..1
            let x = number(args, 0)?;
            let (zero, one, two, three) = (g.number(0.0), g.number(1.0), g.number(2.0), g.number(3.0));
            let x = g.push(Op::Max(x, zero));
            let x = g.push(Op::Min(x, one));
            let twice = g.push(Op::Mul(two, x));
            let rest = g.push(Op::Sub(three, twice));
            let square = g.push(Op::Powi(x, 2));
            let node = g.push(Op::Mul(square, rest));
            Ok(scalar(node, NONE))
        }
        "norm" => {
            let a = vector(args, 0)?;
            let square = dot(g, &a.nodes, &a.nodes);
            let node = g.push(Op::Sqrt(square));
            Ok(scalar(node, a.dimension))
        }
        "dot" | "cross" => {
            let (a, b) = (vector(args, 0)?, vector(args, 1)?);
            let Some(dimension) = a.dimension.times(b.dimension) else {
                return Err(CallError::Undefined("the unit of this product has exponents beyond anything meant"));
            };
            let axes = a.axes.joined(&b.axes).ok_or(CallError::Axes { first: 0, second: 1 })?;
            if name == "dot" {
                let node = dot(g, &a.nodes, &b.nodes);
                return Ok(scalar(node, dimension));
            }
            let nodes = cross(g, &a.nodes, &b.nodes);
            Ok(Typed { kind: Kind::Vector, dimension, nodes, bare: false, axes: axes.derived(), span })
        }
        "normalize" => {
            // v / |v|, and zero for the zero vector
            let a = vector(args, 0)?;
            let square = dot(g, &a.nodes, &a.nodes);
            if g.constant(square) == Some(0.0) {
                return Err(CallError::Undefined("a vector of zeros has no direction"));
            }
            let length = g.push(Op::Sqrt(square));
            let part = |&n: &usize| {
                let share = g.push(Op::Div(n, length));
                g.zero_unless_positive(length, share)
            };
            let nodes: Vec<usize> = a.nodes.iter().map(part).collect();
            g.note(&nodes, Fact::Direction);
            Ok(Typed { kind: Kind::Vector, dimension: NONE, nodes, bare: false, axes: a.axes.derived(), span })
        }
        "asin" | "acos" => {
            let a = number(args, 0)?;
            if g.constant(a).is_some_and(|x| x.abs() > 1.0 + ROUNDING) {
                return Err(CallError::Undefined("no angle has a sine or cosine beyond -1 and 1"));
            }
            let node = g.push(if name == "asin" { Op::Asin(a) } else { Op::Acos(a) });
            Ok(scalar(node, ANGLE))
        }
        "atan2" => {
            let (y, x) = (one(args, 0)?, one(args, 1)?);
            ops::joined(g, y, x).ok_or(CallError::Different { first: 0, second: 1 })?;
            let node = g.push(Op::Atan2(y.nodes[0], x.nodes[0]));
            Ok(scalar(node, ANGLE))
        }
        "if" => choices::choose(g, args, span),
        _ => rotations::call(g, name, args, span),
    }
}

pub(super) fn one(args: &[Typed], index: usize) -> Result<&Typed, CallError> {
    if args[index].kind == Kind::Scalar {
        Ok(&args[index])
    } else {
        Err(CallError::Argument { index, wanted: "a number".into() })
    }
}

pub(super) fn vector(args: &[Typed], index: usize) -> Result<&Typed, CallError> {
    if args[index].kind == Kind::Vector {
        Ok(&args[index])
    } else {
        Err(CallError::Argument { index, wanted: "a vector".into() })
    }
}

/// A bare number as argument.
pub(super) fn number(args: &[Typed], index: usize) -> Result<usize, CallError> {
    let a = one(args, index)?;
    if a.dimension == NONE {
        Ok(a.nodes[0])
    } else {
        Err(CallError::Argument { index, wanted: "a bare number".into() })
    }
}

/// An angle, or a bare number in radians, as argument.
pub(super) fn angle(g: &Graph, args: &[Typed], index: usize) -> Result<usize, CallError> {
    let a = one(args, index)?;
    if a.dimension.is_number() || ops::is_zero(g, a) {
        Ok(a.nodes[0])
    } else {
        Err(CallError::Argument { index, wanted: "an angle".into() })
    }
}
