//! Facts about the numbers of a vector or quaternion as a whole, which intervals of single numbers lose: a rotated
//! vector keeps its length, a sum is near the sum of the centres.

/// Relation between some nodes of a graph.
#[derive(Clone, Debug, PartialEq)]
pub enum Fact {
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

/// Nodes with a fact about them.
#[derive(Clone, Debug, PartialEq)]
pub struct Known {
    /// Nodes of the vector or quaternion; one node for a dot product.
    pub nodes: Vec<usize>,
    /// The fact.
    pub fact: Fact,
}

impl Fact {
    /// Nodes that the fact depends on.
    pub fn operands(&self) -> impl Iterator<Item = usize> {
        let (a, b): (&[usize], &[usize]) = match self {
            Fact::Sum(a, b, _) | Fact::Product(a, b) | Fact::AtMost(a, b) => (a, b),
            Fact::Scaled(a, by) => (a, std::slice::from_ref(by)),
            Fact::Turned(a) => (a, &[]),
            Fact::Direction => (&[], &[]),
        };
        a.iter().chain(b).copied()
    }
}
