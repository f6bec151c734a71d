//! Functions that construct orientations: unit quaternions `w x y z`.

use dsl::Span;
use runtime::program::Op;
use stdlib_tasks::dimension::NONE;

use super::functions::{CallError, angle, number, vector};
use super::ops::{conjugate, dot, quaternion_product, turn};
use super::{Axes, Graph, Kind, Typed};

/// Sine of half an angle below which `slerp` interpolates linearly.
const SMALL: f64 = 1e-9;

/// Applies a function; the number of arguments is within its arity.
pub(super) fn call(g: &mut Graph, name: &str, args: &[Typed], span: Span) -> Result<Typed, CallError> {
    let mut axes = Axes::default();
    let nodes = match name {
        "rpy" => {
            // R = R_z(yaw) R_y(pitch) R_x(roll), as in URDF
            let (roll, pitch, yaw) = (angle(g, args, 0)?, angle(g, args, 1)?, angle(g, args, 2)?);
            let (x, y, z) = (turn(g, 0, roll), turn(g, 1, pitch), turn(g, 2, yaw));
            let zy = quaternion_product(g, &z, &y);
            quaternion_product(g, &zy, &x)
        }
        "axis_angle" => {
            let (axis, a) = (vector(args, 0)?, angle(g, args, 1)?);
            let square = dot(g, &axis.nodes, &axis.nodes);
            if g.constant(square).is_some_and(|x| x < 1e-24) {
                return Err(CallError::Undefined("the axis has no direction: all its numbers are zero"));
            }
            axes = Axes::orientation(axis.axes.to.clone(), axis.axes.to.clone());
            let length = g.push(Op::Sqrt(square));
            let half = g.number(0.5);
            let half = g.push(Op::Mul(half, a));
            let (c, s) = (g.push(Op::Cos(half)), g.push(Op::Sin(half)));
            let s = g.push(Op::Div(s, length));
            [c].into_iter().chain(axis.nodes.iter().map(|&n| g.push(Op::Mul(n, s))).collect::<Vec<_>>()).collect()
        }
        "inverse" => {
            let q = rotation(args, 0)?;
            axes = Axes::orientation(args[0].axes.to.clone(), args[0].axes.from.clone());
            conjugate(g, q)
        }
        "slerp" => {
            let (from, to, share) = (rotation(args, 0)?, rotation(args, 1)?, number(args, 2)?);
            axes = args[0].axes.joined(&args[1].axes).ok_or(CallError::Axes { first: 0, second: 1 })?;
            slerp(g, from, to, share)
        }
        _ => {
            // quaternion(w, x, y, z), normalised
            let nodes: Vec<usize> = (0..4).map(|i| number(args, i)).collect::<Result<_, _>>()?;
            let square = dot(g, &nodes, &nodes);
            if g.constant(square).is_some_and(|x| x < 1e-24) {
                return Err(CallError::Undefined("a quaternion of zeros is no orientation"));
            }
            let length = g.push(Op::Sqrt(square));
            nodes.iter().map(|&n| g.push(Op::Div(n, length))).collect()
        }
    };
    Ok(Typed { kind: Kind::Rotation, dimension: NONE, nodes, bare: false, axes, span })
}

/// Computes `from exp(share log(from⁻¹ to))` along the shorter arc. With `from⁻¹ to = ±(c, v)`, `c >= 0`, half of the
/// angle is `atan2(|v|, c)`, which is well conditioned for all rotations.
pub(super) fn slerp(g: &mut Graph, from: &[usize], to: &[usize], share: usize) -> Vec<usize> {
    let back = conjugate(g, from);
    let between = quaternion_product(g, &back, to);
    let (one, minus_one) = (g.number(1.0), g.number(-1.0));
    let sign = g.push(Op::Select(between[0], one, minus_one));
    let between: Vec<usize> = between.iter().map(|&n| g.push(Op::Mul(sign, n))).collect();
    let square = dot(g, &between[1..], &between[1..]);
    let sine = g.push(Op::Sqrt(square));
    let half = g.push(Op::Atan2(sine, between[0]));
    let part = g.push(Op::Mul(share, half));
    let (c, s) = (g.push(Op::Cos(part)), g.push(Op::Sin(part)));
    // sin(share half) / sin(half), whose limit for small angles is the share
    let scale = g.push(Op::Div(s, sine));
    let small = g.number(SMALL);
    let over = g.push(Op::Sub(sine, small));
    let scale = g.push(Op::Select(over, scale, share));
    let turn: Vec<usize> =
        [c].into_iter().chain(between[1..].iter().map(|&n| g.push(Op::Mul(scale, n))).collect::<Vec<_>>()).collect();
    quaternion_product(g, from, &turn)
}

pub(super) fn rotation(args: &[Typed], index: usize) -> Result<&[usize], CallError> {
    match args.get(index) {
        Some(a) if a.kind == Kind::Rotation => Ok(&a.nodes),
        _ => Err(CallError::Argument { index, wanted: "an orientation".into() }),
    }
}
