//! Functions that construct orientations, unit quaternions `w x y z`, and poses.

use dsl::Span;
use runtime::program::Op;
use stdlib_tasks::dimension::NONE;

use super::super::arguments::{CallError, angle, number, orientation, vector};
use super::super::ops::{conjugate, dot, quaternion_product, turn};
use super::super::{Axes, Graph, Kind, Typed, poses};
use super::{Family, Function};

/// Sine of half an angle below which `slerp` interpolates linearly.
const SMALL: f64 = 1e-9;

/// Square of a length below which a constant vector has no direction.
const NO_DIRECTION: f64 = 1e-24;

/// Common part of the entries.
const ORIENTATIONS: Function = Function::of(Family::Orientations);

fn rotation(nodes: Vec<usize>, axes: Axes, span: Span) -> Typed {
    Typed { kind: Kind::Rotation, dimension: NONE, nodes, bare: false, axes, span }
}

pub(super) static RPY: Function = Function {
    name: "rpy",
    form: "rpy(roll, pitch, yaw)",
    takes: "three angles",
    gives: "`R_z(yaw) R_y(pitch) R_x(roll)`, as in URDF",
    arity: 3..=3,
    angles: &[0, 1, 2],
    apply: |g, args, span| {
        let (roll, pitch, yaw) = (angle(g, args, 0)?, angle(g, args, 1)?, angle(g, args, 2)?);
        let (x, y, z) = (turn(g, 0, roll), turn(g, 1, pitch), turn(g, 2, yaw));
        let zy = quaternion_product(g, &z, &y);
        Ok(rotation(quaternion_product(g, &zy, &x), Axes::default(), span))
    },
    ..ORIENTATIONS
};

pub(super) static AXIS_ANGLE: Function = Function {
    name: "axis_angle",
    form: "axis_angle(vector, angle)",
    takes: "a vector of any length above zero, and an angle",
    gives: "an orientation",
    arity: 2..=2,
    angles: &[1],
    apply: |g, args, span| {
        let (axis, a) = (vector(args, 0)?, angle(g, args, 1)?);
        let square = dot(g, &axis.nodes, &axis.nodes);
        if g.constant(square).is_some_and(|x| x < NO_DIRECTION) {
            return Err(CallError::Undefined("the axis has no direction: all its numbers are zero"));
        }
        let axes = Axes::orientation(axis.axes.to.clone(), axis.axes.to.clone());
        let length = g.push(Op::Sqrt(square));
        let half = g.number(0.5);
        let half = g.push(Op::Mul(half, a));
        let (c, s) = (g.push(Op::Cos(half)), g.push(Op::Sin(half)));
        let s = g.push(Op::Div(s, length));
        let mut nodes = vec![c];
        nodes.extend(axis.nodes.iter().map(|&n| g.push(Op::Mul(n, s))));
        Ok(rotation(nodes, axes, span))
    },
    ..ORIENTATIONS
};

pub(super) static QUATERNION: Function = Function {
    name: "quaternion",
    form: "quaternion(w, x, y, z)",
    takes: "four bare numbers, not all zero",
    gives: "an orientation; normalised to unit length",
    arity: 4..=4,
    apply: |g, args, span| {
        let nodes: Vec<usize> = (0..4).map(|i| number(args, i)).collect::<Result<_, _>>()?;
        let square = dot(g, &nodes, &nodes);
        if g.constant(square).is_some_and(|x| x < NO_DIRECTION) {
            return Err(CallError::Undefined("a quaternion of zeros is no orientation"));
        }
        let length = g.push(Op::Sqrt(square));
        let nodes = nodes.iter().map(|&n| g.push(Op::Div(n, length))).collect();
        Ok(rotation(nodes, Axes::default(), span))
    },
    ..ORIENTATIONS
};

pub(super) static INVERSE: Function = Function {
    name: "inverse",
    form: "inverse(orientation or pose)",
    takes: "an orientation or a pose",
    gives: "its inverse",
    apply: |g, args, span| {
        if args[0].kind == Kind::Pose {
            return Ok(poses::inverse(g, &args[0], span));
        }
        let q = orientation(args, 0)?;
        let axes = Axes::orientation(args[0].axes.to.clone(), args[0].axes.from.clone());
        Ok(rotation(conjugate(g, q), axes, span))
    },
    ..ORIENTATIONS
};

pub(super) static POSE: Function = Function {
    name: "pose",
    form: "pose([x, y, z] m, orientation)",
    takes: "a vector in m, and an orientation",
    gives: "a pose",
    arity: 2..=2,
    apply: |g, args, span| poses::make(g, args, span),
    ..ORIENTATIONS
};

pub(super) static SLERP: Function = Function {
    name: "slerp",
    form: "slerp(from, to, share)",
    takes: "two orientations, and a bare number",
    gives: "the interpolated orientation, along the shorter rotation at a constant rate",
    arity: 3..=3,
    apply: |g, args, span| {
        let (from, to, share) = (orientation(args, 0)?, orientation(args, 1)?, number(args, 2)?);
        let axes = args[0].axes.joined(&args[1].axes).ok_or(CallError::Axes { first: 0, second: 1 })?;
        Ok(rotation(slerp(g, from, to, share), axes, span))
    },
    ..ORIENTATIONS
};

/// Computes `from exp(share log(from⁻¹ to))` along the shorter arc. With `from⁻¹ to = ±(c, v)`, `c >= 0`, half of the
/// angle is `atan2(|v|, c)`, which is well conditioned for all rotations.
pub(in crate::expr) fn slerp(g: &mut Graph, from: &[usize], to: &[usize], share: usize) -> Vec<usize> {
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
