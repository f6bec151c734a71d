//! The functions of the language.

use runtime::program::Op;
use stdlib_tasks::dimension::{Dimension, NONE};

use super::ops::{self, additive, cross, dot, quaternion_product, turn};
use super::{Graph, Kind, Typed};
use dsl::Span;

/// A function of the language, for messages.
#[derive(Debug)]
pub struct Function {
    /// Its name.
    pub name: &'static str,
    /// How a call looks.
    pub form: &'static str,
    /// How many arguments it takes.
    pub arity: std::ops::RangeInclusive<usize>,
}

/// All of them.
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
    Function { name: "rpy", form: "rpy(roll, pitch, yaw)", arity: 3..=3 },
    Function { name: "axis_angle", form: "axis_angle(vector, angle)", arity: 2..=2 },
    Function { name: "quaternion", form: "quaternion(w, x, y, z)", arity: 4..=4 },
];

/// True where argument `index` of a function is an angle.
pub(super) fn is_angle(name: &str, index: usize) -> bool {
    matches!((name, index), ("sin" | "cos" | "tan" | "rpy", _) | ("axis_angle", 1))
}

/// The number of arguments of a function, from the first, that have one unit.
pub(super) fn alike(name: &str, count: usize) -> usize {
    match name {
        "min" | "max" | "clamp" => count,
        "lerp" => count.min(2),
        _ => 0,
    }
}

/// Why a call has no meaning.
pub(super) enum CallError {
    /// Argument `index` should be `wanted`.
    Argument { index: usize, wanted: String },
    /// Two arguments should have one dimension.
    Different { first: usize, second: usize },
    /// A value that is not defined, whatever time it is.
    Undefined(&'static str),
}

/// Applies a function to as many arguments as its arity asks for.
pub(super) fn call(g: &mut Graph, name: &str, args: &[Typed], span: Span) -> Result<Typed, CallError> {
    let scalar = |nodes: usize, dimension: Dimension| Typed {
        kind: Kind::Scalar,
        dimension,
        nodes: vec![nodes],
        bare: false,
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
        "lerp" => {
            let s = number(args, 2)?;
            let step = additive(g, &args[1], &args[0], Op::Sub, span)
                .map_err(|_| CallError::Different { first: 0, second: 1 })?;
            let nodes: Vec<usize> = (args[0].nodes.iter().zip(&step.nodes))
                .map(|(&from, &by)| {
                    let part = g.push(Op::Mul(by, s));
                    g.push(Op::Add(from, part))
                })
                .collect();
            Ok(Typed { nodes, bare: false, ..step })
        }
        "smoothstep" => {
            // x^2 (3 - 2 x) for x held within 0 and 1
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
            if name == "dot" {
                let node = dot(g, &a.nodes, &b.nodes);
                return Ok(scalar(node, dimension));
            }
            let nodes = cross(g, &a.nodes, &b.nodes);
            Ok(Typed { kind: Kind::Vector, dimension, nodes, bare: false, span })
        }
        "rpy" => {
            // R = R_z(yaw) R_y(pitch) R_x(roll), as in URDF
            let (roll, pitch, yaw) = (angle(g, args, 0)?, angle(g, args, 1)?, angle(g, args, 2)?);
            let (x, y, z) = (turn(g, 0, roll), turn(g, 1, pitch), turn(g, 2, yaw));
            let zy = quaternion_product(g, &z, &y);
            let nodes = quaternion_product(g, &zy, &x);
            Ok(Typed { kind: Kind::Rotation, dimension: NONE, nodes, bare: false, span })
        }
        "axis_angle" => {
            let (axis, a) = (vector(args, 0)?, angle(g, args, 1)?);
            let square = dot(g, &axis.nodes, &axis.nodes);
            if g.constant(square).is_some_and(|x| x < 1e-24) {
                return Err(CallError::Undefined("the axis has no direction: all its numbers are zero"));
            }
            let length = g.push(Op::Sqrt(square));
            let half = g.number(0.5);
            let half = g.push(Op::Mul(half, a));
            let (c, s) = (g.push(Op::Cos(half)), g.push(Op::Sin(half)));
            let s = g.push(Op::Div(s, length));
            let nodes =
                [c].into_iter().chain(axis.nodes.iter().map(|&n| g.push(Op::Mul(n, s))).collect::<Vec<_>>()).collect();
            Ok(Typed { kind: Kind::Rotation, dimension: NONE, nodes, bare: false, span })
        }
        _ => {
            // quaternion(w, x, y, z), brought to unit length
            let nodes: Vec<usize> = (0..4).map(|i| number(args, i)).collect::<Result<_, _>>()?;
            let square = dot(g, &nodes, &nodes);
            if g.constant(square).is_some_and(|x| x < 1e-24) {
                return Err(CallError::Undefined("a quaternion of zeros is no orientation"));
            }
            let length = g.push(Op::Sqrt(square));
            let nodes = nodes.iter().map(|&n| g.push(Op::Div(n, length))).collect();
            Ok(Typed { kind: Kind::Rotation, dimension: NONE, nodes, bare: false, span })
        }
    }
}

fn one(args: &[Typed], index: usize) -> Result<&Typed, CallError> {
    if args[index].kind == Kind::Scalar {
        Ok(&args[index])
    } else {
        Err(CallError::Argument { index, wanted: "a number".into() })
    }
}

fn vector(args: &[Typed], index: usize) -> Result<&Typed, CallError> {
    if args[index].kind == Kind::Vector {
        Ok(&args[index])
    } else {
        Err(CallError::Argument { index, wanted: "a vector".into() })
    }
}

/// A bare number.
fn number(args: &[Typed], index: usize) -> Result<usize, CallError> {
    let a = one(args, index)?;
    if a.dimension == NONE {
        Ok(a.nodes[0])
    } else {
        Err(CallError::Argument { index, wanted: "a bare number".into() })
    }
}

/// An angle, or a bare number that stands for radians.
fn angle(g: &Graph, args: &[Typed], index: usize) -> Result<usize, CallError> {
    let a = one(args, index)?;
    if a.dimension.is_number() || ops::is_zero(g, a) {
        Ok(a.nodes[0])
    } else {
        Err(CallError::Argument { index, wanted: "an angle".into() })
    }
}
