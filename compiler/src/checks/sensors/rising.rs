//! Comparisons of a condition that a rising force makes true: `norm(ft.force) > 8 N`.

use runtime::program::Op;

use crate::checks::Checked;

/// A force or a moment above a constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rising {
    /// Index of the wrench.
    pub signal: usize,
    /// True for a moment.
    pub moment: bool,
    /// The constant, in N or N m.
    pub threshold: f64,
}

/// Largest depth of a condition that is read.
const DEPTH: usize = 32;

/// Comparisons of a condition, joined by `and` and `or`, that a rising force makes true.
pub(super) fn comparisons(c: &Checked, node: usize) -> Vec<Rising> {
    let mut found = Vec::new();
    read(c, node, DEPTH, &mut found);
    found
}

fn read(c: &Checked, node: usize, depth: usize, found: &mut Vec<Rising>) {
    let graph = c.context.graph;
    let Some(depth) = depth.checked_sub(1) else { return };
    let mut above = |threshold: usize, value: usize| {
        if let (Some(threshold), Some(Part { signal, moment })) = (graph.constant(threshold), size(c, value, depth)) {
            found.push(Rising { signal, moment, threshold });
        }
    };
    match graph.ops()[node] {
        Op::Less(a, b) | Op::LessEqual(a, b) => above(a, b),
        Op::Neg(inner) => {
            if let Op::Less(a, b) | Op::LessEqual(a, b) = graph.ops()[inner] {
                above(b, a);
            }
        }
        Op::Select(a, b, d) if d == a || b == a => {
            read(c, a, depth, found);
            read(c, if d == a { b } else { d }, depth, found);
        }
        _ => {}
    }
}

/// A force or a moment of a wrench.
#[derive(Clone, Copy, PartialEq)]
struct Part {
    signal: usize,
    moment: bool,
}

/// The force or moment that a node is the size of: a number, its magnitude, or a norm.
fn size(c: &Checked, node: usize, depth: usize) -> Option<Part> {
    let graph = c.context.graph;
    let depth = depth.checked_sub(1)?;
    match graph.ops()[node] {
        Op::Signal(k) => {
            let signal = c.program.interface.signal_of(k)?;
            let s =
                c.program.interface.signals.get(signal).filter(|s| s.kind == "wrench" && k > s.at && k <= s.at + 6)?;
            Some(Part { signal, moment: k > s.at + 3 })
        }
        Op::Abs(a) | Op::Neg(a) | Op::Sqrt(a) => size(c, a, depth),
        Op::Add(a, b) => size(c, a, depth).filter(|a| size(c, b, depth) == Some(*a)),
        // The square inside a norm.
        Op::Mul(a, b) if a == b => size(c, a, depth),
        Op::Powi(a, 2) => size(c, a, depth),
        _ => None,
    }
}
