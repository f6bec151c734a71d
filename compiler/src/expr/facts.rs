//! What is known of the numbers of a vector or quaternion together, and is lost when each is looked at by itself: that a
//! turned vector keeps its length, that the parts of a sum stay near their centres.

/// How some nodes of a graph belong together.
#[derive(Clone, Debug, PartialEq)]
pub enum Fact {
    /// A vector is the first of two plus so many times the second.
    Sum(Vec<usize>, Vec<usize>, f64),
    /// A vector is another one times a number.
    Scaled(Vec<usize>, usize),
    /// The length is that of another: a vector that is turned, a quaternion that is inverted.
    Turned(Vec<usize>),
    /// The length is the product of two lengths: of quaternions.
    Product(Vec<usize>, Vec<usize>),
    /// The length is at most the product of two lengths: a dot or cross product.
    AtMost(Vec<usize>, Vec<usize>),
    /// The length is 1, or 0.
    Direction,
}

/// Nodes, and what is known of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Known {
    /// The numbers of the vector or quaternion; one for a dot product.
    pub nodes: Vec<usize>,
    /// What is known.
    pub fact: Fact,
}

impl Fact {
    /// The nodes that it speaks of beside those that it is known of.
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
