//! Operations on typed expressions and their dimensions: sums, products, quaternions.

use runtime::program::Op;
use stdlib_tasks::dimension::{Dimension, NONE};

use super::vector_bounds::VectorBound;
use super::{Graph, Kind, Typed, poses};
use dsl::Span;

/// Mismatch of two operands.
pub(super) enum Mismatch {
    /// The operator is not defined for these kinds.
    Kinds,
    /// The operator is not defined for these dimensions.
    Dimensions,
    /// The exponents of the units are too large.
    TooLarge,
    /// The axes are incompatible.
    Axes,
}

fn zip(g: &mut Graph, a: &[usize], b: &[usize], op: fn(usize, usize) -> Op) -> Vec<usize> {
    a.iter().zip(b).map(|(&a, &b)| g.push(op(a, b))).collect()
}

/// True for an expression that is the constant zero, which is compatible with every dimension.
pub(super) fn is_zero(g: &Graph, x: &Typed) -> bool {
    !matches!(x.kind, Kind::Rotation | Kind::Pose | Kind::Truth)
        && x.dimension == NONE
        && x.nodes.iter().all(|&n| g.constant(n) == Some(0.0))
}

/// Dimension of the sum of both, if they may be added.
pub(super) fn joined(g: &Graph, a: &Typed, b: &Typed) -> Option<Dimension> {
    if is_zero(g, a) {
        Some(b.dimension)
    } else if is_zero(g, b) {
        Some(a.dimension)
    } else if a.dimension.accepts(b.dimension) {
        Some(a.dimension.join(b.dimension))
    } else {
        None
    }
}

/// Lowers `a + b` or `a - b`, or another componentwise operation on operands of equal dimension.
pub(super) fn additive(
    g: &mut Graph,
    a: &Typed,
    b: &Typed,
    op: fn(usize, usize) -> Op,
    span: Span,
) -> Result<Typed, Mismatch> {
    if a.kind != b.kind || matches!(a.kind, Kind::Rotation | Kind::Pose | Kind::Truth) {
        return Err(Mismatch::Kinds);
    }
    let dimension = joined(g, a, b).ok_or(Mismatch::Dimensions)?;
    let sign = if matches!(op(0, 0), Op::Sub(..)) { -1.0 } else { 1.0 };
    let axes = a.axes.sum(&b.axes, sign).ok_or(Mismatch::Axes)?;
    let nodes = zip(g, &a.nodes, &b.nodes, op);
    if a.kind == Kind::Vector && matches!(op(0, 0), Op::Add(..) | Op::Sub(..)) {
        g.note(&nodes, VectorBound::Sum(a.nodes.clone(), b.nodes.clone(), sign));
    }
    Ok(Typed { kind: a.kind, dimension, nodes, bare: a.bare && b.bare, axes, span })
}

/// Lowers `a * b`: numbers, a number and a vector, two orientations, an orientation and a vector that it rotates, a
/// pose and a pose or a point in its frame.
pub(super) fn multiply(g: &mut Graph, a: &Typed, b: &Typed, span: Span) -> Result<Typed, Mismatch> {
    let dimension = a.dimension.times(b.dimension).ok_or(Mismatch::TooLarge)?;
    let bare = a.bare && b.bare;
    let (kind, axes, nodes) = match (a.kind, b.kind) {
        (Kind::Scalar, Kind::Scalar | Kind::Vector) => {
            let axes = b.axes.scaled(g.constant(a.nodes[0]));
            (b.kind, axes, b.nodes.iter().map(|&n| g.push(Op::Mul(a.nodes[0], n))).collect())
        }
        (Kind::Vector, Kind::Scalar) => {
            let axes = a.axes.scaled(g.constant(b.nodes[0]));
            (Kind::Vector, axes, a.nodes.iter().map(|&n| g.push(Op::Mul(n, b.nodes[0]))).collect())
        }
        (Kind::Rotation, Kind::Rotation | Kind::Vector) => {
            let axes = a.axes.product(&b.axes).ok_or(Mismatch::Axes)?;
            let turned = if b.kind == Kind::Vector { rotate } else { quaternion_product };
            (b.kind, axes, turned(g, &a.nodes, &b.nodes))
        }
        (Kind::Pose, Kind::Pose | Kind::Vector) => return poses::product(g, a, b, span),
        _ => return Err(Mismatch::Kinds),
    };
    match (a.kind, b.kind) {
        (Kind::Scalar, Kind::Vector) => g.note(&nodes, VectorBound::Scaled(b.nodes.clone(), a.nodes[0])),
        (Kind::Vector, Kind::Scalar) => g.note(&nodes, VectorBound::Scaled(a.nodes.clone(), b.nodes[0])),
        _ => {}
    }
    Ok(Typed { kind, dimension, nodes, bare, axes, span })
}

/// Lowers `a / b` with a number as divisor.
pub(super) fn divide(g: &mut Graph, a: &Typed, b: &Typed, span: Span) -> Result<Typed, Mismatch> {
    if b.kind != Kind::Scalar || matches!(a.kind, Kind::Rotation | Kind::Pose | Kind::Truth) {
        return Err(Mismatch::Kinds);
    }
    let inverse = b.dimension.power(-1).ok_or(Mismatch::TooLarge)?;
    let dimension = a.dimension.times(inverse).ok_or(Mismatch::TooLarge)?;
    let axes = a.axes.scaled(g.constant(b.nodes[0]).map(f64::recip));
    let nodes: Vec<usize> = a.nodes.iter().map(|&n| g.push(Op::Div(n, b.nodes[0]))).collect();
    if let Some(x) = g.constant(b.nodes[0]).filter(|_| a.kind == Kind::Vector) {
        let factor = g.number(1.0 / x);
        g.note(&nodes, VectorBound::Scaled(a.nodes.clone(), factor));
    }
    Ok(Typed { kind: a.kind, dimension, nodes, bare: a.bare && b.bare, axes, span })
}

/// Hamilton product of two quaternions `w x y z`.
pub(super) fn quaternion_product(g: &mut Graph, p: &[usize], q: &[usize]) -> Vec<usize> {
    // rows of w, x, y, z: (index of p, index of q, sign)
    let table: [[(usize, usize, bool); 4]; 4] = [
        [(0, 0, true), (1, 1, false), (2, 2, false), (3, 3, false)],
        [(0, 1, true), (1, 0, true), (2, 3, true), (3, 2, false)],
        [(0, 2, true), (1, 3, false), (2, 0, true), (3, 1, true)],
        [(0, 3, true), (1, 2, true), (2, 1, false), (3, 0, true)],
    ];
    let mut nodes = Vec::with_capacity(4);
    for row in table {
        let mut sum = g.number(0.0);
        for (i, j, plus) in row {
            let product = g.push(Op::Mul(p[i], q[j]));
            sum = g.push(if plus { Op::Add(sum, product) } else { Op::Sub(sum, product) });
        }
        nodes.push(sum);
    }
    g.note(&nodes, VectorBound::Product(p.to_vec(), q.to_vec()));
    nodes
}

/// Quaternion of the inverse rotation.
pub(super) fn conjugate(g: &mut Graph, q: &[usize]) -> Vec<usize> {
    let nodes: Vec<usize> = q.iter().enumerate().map(|(i, &n)| if i == 0 { n } else { g.push(Op::Neg(n)) }).collect();
    g.note(&nodes, VectorBound::Turned(q.to_vec()));
    nodes
}

/// Rotates a vector by a unit quaternion.
pub(super) fn rotate(g: &mut Graph, q: &[usize], v: &[usize]) -> Vec<usize> {
    let zero = g.number(0.0);
    let inverse = conjugate(g, q);
    let pure = [zero, v[0], v[1], v[2]];
    let half = quaternion_product(g, q, &pure);
    let turned = quaternion_product(g, &half, &inverse)[1..].to_vec();
    g.note(&turned, VectorBound::Turned(v.to_vec()));
    turned
}

/// Dot product of two vectors, as a node.
pub(super) fn dot(g: &mut Graph, a: &[usize], b: &[usize]) -> usize {
    let mut sum = g.number(0.0);
    for (&a, &b) in a.iter().zip(b) {
        let product = g.push(Op::Mul(a, b));
        sum = g.push(Op::Add(sum, product));
    }
    g.note(&[sum], VectorBound::AtMost(a.to_vec(), b.to_vec()));
    sum
}

/// Cross product of two vectors.
pub(super) fn cross(g: &mut Graph, a: &[usize], b: &[usize]) -> Vec<usize> {
    let part = |&(i, j): &(usize, usize)| {
        let (plus, minus) = (g.push(Op::Mul(a[i], b[j])), g.push(Op::Mul(a[j], b[i])));
        g.push(Op::Sub(plus, minus))
    };
    let nodes: Vec<usize> = [(1, 2), (2, 0), (0, 1)].iter().map(part).collect();
    g.note(&nodes, VectorBound::AtMost(a.to_vec(), b.to_vec()));
    nodes
}

/// Quaternion of a rotation by `angle` about the unit axis `axis` (0 x, 1 y, 2 z).
pub(super) fn turn(g: &mut Graph, axis: usize, angle: usize) -> Vec<usize> {
    let half = g.number(0.5);
    let half = g.push(Op::Mul(half, angle));
    let (c, s, zero) = (g.push(Op::Cos(half)), g.push(Op::Sin(half)), g.number(0.0));
    let mut q = vec![c, zero, zero, zero];
    q[axis + 1] = s;
    q
}
