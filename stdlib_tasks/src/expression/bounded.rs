//! Parts of a value that a bound of the value bounds one by one: if the smallest of several distances is at least a
//! metre, each of them is.

use std::collections::BTreeSet;

use super::{Expression, Leaf, Op};
use crate::slot::Slot;

/// Side on which a value is bounded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum BoundedSide {
    /// It has a smallest value.
    Below,
    /// It has a largest value.
    Above,
}

impl BoundedSide {
    fn other(self) -> BoundedSide {
        match self {
            BoundedSide::Below => BoundedSide::Above,
            BoundedSide::Above => BoundedSide::Below,
        }
    }
}

/// A part of a value that a bound of the value bounds by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct BoundedPart {
    /// Side on which the part is bounded.
    pub side: BoundedSide,
    /// The quantity that the part is, if it is a single one.
    pub leaf: Option<usize>,
    /// All quantities of the state on which it depends, by their indices in the expression.
    pub leaves: BTreeSet<usize>,
    /// Entries of the table of values on which it depends.
    pub slots: Vec<Slot>,
    /// True for a root, an absolute value or an even power: a size, such as a distance.
    pub is_size: bool,
}

/// Returns the parts of a value that is bounded on a side. A sum of several quantities is one part.
pub fn bounded_parts(e: &Expression, side: BoundedSide) -> Vec<BoundedPart> {
    let mut stateful: Vec<bool> = Vec::with_capacity(e.ops.len());
    for op in &e.ops {
        let reads = op.operands().into_iter().flatten().any(|a| stateful.get(a) == Some(&true));
        stateful.push(reads || matches!(op, Op::State(_)));
    }
    let walk = Walk { e, stateful };
    e.outputs.iter().flat_map(|&o| walk.parts(o, side)).collect()
}

struct Walk<'e> {
    e: &'e Expression,
    /// For each operation, true if it depends on the robot's state.
    stateful: Vec<bool>,
}

impl Walk<'_> {
    fn parts(&self, root: usize, side: BoundedSide) -> Vec<BoundedPart> {
        let mut found = Vec::new();
        let mut seen = BTreeSet::new();
        let mut open = vec![(root, side)];
        while let Some((at, side)) = open.pop() {
            let is_stateful = |a: usize| self.stateful.get(a) == Some(&true);
            if !is_stateful(at) || !seen.insert((at, side)) {
                continue;
            }
            let Some(op) = self.e.ops.get(at) else { continue };
            match *op {
                Op::Neg(a) => open.push((a, side.other())),
                Op::Add(a, b) if !is_stateful(a) || !is_stateful(b) => open.extend([(a, side), (b, side)]),
                Op::Sub(a, b) if !is_stateful(a) || !is_stateful(b) => open.extend([(a, side), (b, side.other())]),
                Op::Mul(a, b) | Op::Div(a, b) => match (self.sign(a), self.sign(b), *op) {
                    (Some(positive), None, Op::Mul(..)) => open.push((b, if positive { side } else { side.other() })),
                    (None, Some(positive), _) => open.push((a, if positive { side } else { side.other() })),
                    _ => found.push(self.part(at, side)),
                },
                Op::Min(a, b) | Op::Max(a, b) => {
                    // The smallest of several values bounds each of them from below, but none from above.
                    let each =
                        matches!((*op, side), (Op::Min(..), BoundedSide::Below) | (Op::Max(..), BoundedSide::Above));
                    if each || !is_stateful(a) || !is_stateful(b) {
                        open.extend([(b, side), (a, side)]);
                    }
                }
                Op::Select(_, a, b) => found.extend(self.chosen(a, b, side)),
                _ => found.push(self.part(at, side)),
            }
        }
        found
    }

    /// Parts of both values of a choice; of one value, if the other one does not depend on the state.
    fn chosen(&self, a: usize, b: usize, side: BoundedSide) -> Vec<BoundedPart> {
        let (mut of_a, mut of_b) = (self.parts(a, side), self.parts(b, side));
        if self.stateful.get(a) == Some(&true) && self.stateful.get(b) == Some(&true) {
            of_a.retain(|p| of_b.iter().any(|o| o.leaves == p.leaves && o.side == p.side));
            return of_a;
        }
        of_a.append(&mut of_b);
        of_a
    }

    /// True for a positive constant, false for a negative one.
    fn sign(&self, at: usize) -> Option<bool> {
        match self.e.ops.get(at) {
            Some(Op::Const(x)) if *x != 0.0 => Some(*x > 0.0),
            _ => None,
        }
    }

    /// The operation itself as a part.
    fn part(&self, root: usize, side: BoundedSide) -> BoundedPart {
        let (mut leaves, mut inputs, mut seen) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
        let mut open = vec![root];
        while let Some(at) = open.pop() {
            if !seen.insert(at) {
                continue;
            }
            match self.e.ops.get(at) {
                Some(Op::State(k)) => {
                    if let Some((i, leaf)) = self.leaf(*k) {
                        leaves.insert(i);
                        open.extend(leaf.reads().iter().flatten());
                    }
                }
                Some(Op::Input(k)) => inputs.extend(self.e.inputs.get(*k).copied()),
                Some(op) => open.extend(op.operands().into_iter().flatten()),
                None => {}
            }
        }
        let leaf = match self.e.ops.get(root) {
            Some(Op::State(k)) => self.leaf(*k).filter(|(_, leaf)| leaf.width() == 1).map(|(i, _)| i),
            _ => None,
        };
        let is_size = match self.e.ops.get(root) {
            Some(Op::Sqrt(_) | Op::Abs(_)) => true,
            Some(Op::Powi(_, n)) => n % 2 == 0,
            _ => false,
        };
        let slots = inputs.into_iter().map(|at| Slot { at, len: 1 }).collect();
        BoundedPart { side, leaf, leaves, slots, is_size }
    }

    /// The quantity that a number of the state belongs to, with its index.
    fn leaf(&self, number: usize) -> Option<(usize, &Leaf)> {
        let mut end = 0;
        self.e.leaves.iter().enumerate().find(|(_, leaf)| {
            end += leaf.width();
            number < end
        })
    }
}
