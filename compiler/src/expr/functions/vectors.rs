//! Functions of vectors.

use runtime::program::Op;
use stdlib_tasks::dimension::{ANGLE, Dimension, NONE};

use super::super::arguments::{CallError, vector};
use super::super::ops::{cross, dot};
use super::super::vector_bounds::VectorBound;
use super::super::{Axes, Kind, Typed};
use super::{Family, Function};

/// Common part of the entries.
const VECTORS: Function = Function::of(Family::Vectors);

pub(super) static NORM: Function = Function {
    name: "norm",
    form: "norm(vector)",
    takes: "a vector",
    gives: "its length, with its unit",
    apply: |g, args, span| {
        let a = vector(args, 0)?;
        let square = dot(g, &a.nodes, &a.nodes);
        Ok(Typed::scalar(g.push(Op::Sqrt(square)), a.dimension, span))
    },
    ..VECTORS
};

/// Factors of a product of two vectors.
struct Factors<'t> {
    first: &'t Typed,
    second: &'t Typed,
    /// Dimension of the product.
    dimension: Dimension,
    /// Axes of both.
    axes: Axes,
}

fn factors(args: &[Typed]) -> Result<Factors<'_>, CallError> {
    let (first, second) = (vector(args, 0)?, vector(args, 1)?);
    let Some(dimension) = first.dimension.times(second.dimension) else {
        return Err(CallError::Undefined("the unit of this product has exponents beyond anything meant"));
    };
    let axes = first.axes.joined(&second.axes).ok_or(CallError::Axes { first: 0, second: 1 })?;
    Ok(Factors { first, second, dimension, axes })
}

pub(super) static DOT: Function = Function {
    name: "dot",
    form: "dot(vector, vector)",
    takes: "two vectors",
    gives: "a number",
    arity: 2..=2,
    apply: |g, args, span| {
        let of = factors(args)?;
        Ok(Typed::scalar(dot(g, &of.first.nodes, &of.second.nodes), of.dimension, span))
    },
    ..VECTORS
};

pub(super) static CROSS: Function = Function {
    name: "cross",
    form: "cross(vector, vector)",
    takes: "two vectors",
    gives: "a vector",
    arity: 2..=2,
    apply: |g, args, span| {
        let of = factors(args)?;
        let nodes = cross(g, &of.first.nodes, &of.second.nodes);
        let (kind, dimension) = (Kind::Vector, of.dimension);
        Ok(Typed { kind, dimension, nodes, bare: false, axes: of.axes.derived(), span })
    },
    ..VECTORS
};

pub(super) static ANGLE_BETWEEN: Function = Function {
    name: "angle_between",
    form: "angle_between(vector, vector)",
    takes: "two vectors of any length",
    gives: "the angle between them, from 0 to pi; 0 if one of them is zero",
    arity: 2..=2,
    apply: |g, args, span| {
        let of = factors(args)?;
        let normal = cross(g, &of.first.nodes, &of.second.nodes);
        let square = dot(g, &normal, &normal);
        let (sine, cosine) = (g.push(Op::Sqrt(square)), dot(g, &of.first.nodes, &of.second.nodes));
        Ok(Typed::scalar(g.push(Op::Atan2(sine, cosine)), ANGLE, span))
    },
    ..VECTORS
};

pub(super) static NORMALIZE: Function = Function {
    name: "normalize",
    form: "normalize(vector)",
    takes: "a vector",
    gives: "the vector of length 1, without a unit; zero for the zero vector",
    apply: |g, args, span| {
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
        g.note(&nodes, VectorBound::Direction);
        Ok(Typed { kind: Kind::Vector, dimension: NONE, nodes, bare: false, axes: a.axes.derived(), span })
    },
    ..VECTORS
};
