//! Bounds of a vector or quaternion as a whole, which intervals of single numbers lose: a rotated vector keeps its
//! length, a sum is near the sum of the centres.

/// Relation between nodes of a graph that bounds a vector.
#[derive(Clone, Debug, PartialEq)]
pub enum VectorBound {
    /// The vector is the first vector plus a factor times the second.
    Sum(Vec<usize>, Vec<usize>, f64),
    /// The vector is another one times a number.
    Scaled(Vec<usize>, usize),
    /// The length is that of another one: a rotated vector, an inverted quaternion.
    Turned(Vec<usize>),
    /// The length is the product of two lengths: a product of quaternions.
    Product(Vec<usize>, Vec<usize>),
    /// The length is at most the product of two lengths: a dot or cross product.
    AtMost(Vec<usize>, Vec<usize>),
    /// The length is 1 or 0.
    Direction,
}

/// Nodes with their bound.
#[derive(Clone, Debug, PartialEq)]
pub struct Known {
    /// Nodes of the vector or quaternion; one node for a dot product.
    pub nodes: Vec<usize>,
    /// Their bound.
    pub bound: VectorBound,
}

impl VectorBound {
    /// Nodes that the bound depends on.
    pub fn operands(&self) -> impl Iterator<Item = usize> {
        let (a, b): (&[usize], &[usize]) = match self {
            VectorBound::Sum(a, b, _) | VectorBound::Product(a, b) | VectorBound::AtMost(a, b) => (a, b),
            VectorBound::Scaled(a, by) => (a, std::slice::from_ref(by)),
            VectorBound::Turned(a) => (a, &[]),
            VectorBound::Direction => (&[], &[]),
        };
        a.iter().chain(b).copied()
    }
}
