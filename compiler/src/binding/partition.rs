//! Extracts an expression of the robot's state from the graph, cut at the nodes that depend on time alone.

use std::collections::{BTreeMap, BTreeSet};

use runtime::program::Op;
use stdlib_tasks::dimension::{Dimension, NONE};
use stdlib_tasks::expression::{Expression, Leaf};

use super::Table;
use crate::expr::{Graph, Kind, Typed};

/// Extracts the expression of a typed value. Its inputs are the nodes that depend on time or on captured values, and
/// not on the state.
pub(super) fn partition(graph: &Graph, table: &Table, typed: &Typed) -> Expression {
    // Operands precede their users, so no later node needs the last open node.
    let mut open: BTreeSet<usize> = typed.nodes.iter().copied().collect();
    let mut needed = BTreeSet::new();
    while let Some(i) = open.pop_last() {
        needed.insert(i);
        if graph.is_state(i) {
            open.extend(graph.reads(i));
        }
    }
    let dimension = if typed.kind == Kind::Rotation { NONE } else { typed.dimension };
    let mut e = Expression { ops: vec![], inputs: vec![], leaves: vec![], outputs: vec![], dimension };
    let mut index: BTreeMap<usize, usize> = BTreeMap::new();
    let mut states: BTreeMap<usize, usize> = BTreeMap::new();
    for i in needed {
        let op = match graph.ops()[i] {
            Op::Const(x) => Op::Const(x),
            Op::State(k) => Op::State(state_number(table, k, &mut states, &mut e.leaves, &index)),
            op if graph.is_state(i) => op.renumber(|a| index[&a]),
            _ => {
                e.inputs.push(i);
                Op::Input(e.inputs.len() - 1)
            }
        };
        e.ops.push(op);
        index.insert(i, e.ops.len() - 1);
    }
    e.outputs = typed.nodes.iter().map(|n| index[n]).collect();
    e
}

/// Extracts the expression of one number without a cut. `input` returns the place of an operation that is outside of
/// the robot's state; the result is `None` if it has no place.
pub(crate) fn whole(
    graph: &Graph,
    table: &Table,
    (node, dimension): (usize, Dimension),
    mut input: impl FnMut(Op) -> Option<usize>,
) -> Option<Expression> {
    let (ops, index) = graph.extract(&[node]);
    let mut e = Expression { ops: vec![], inputs: vec![], leaves: vec![], outputs: vec![index[&node]], dimension };
    let mut states: BTreeMap<usize, usize> = BTreeMap::new();
    for op in ops {
        let op = match op {
            Op::State(k) => Op::State(state_number(table, k, &mut states, &mut e.leaves, &index)),
            Op::T | Op::Time | Op::Input(_) | Op::Signal(_) | Op::Trajectory(_) => {
                e.inputs.push(input(op)?);
                Op::Input(e.inputs.len() - 1)
            }
            op => op,
        };
        e.ops.push(op);
    }
    Some(e)
}

/// Returns the number within one expression of number `k` of the robot's state. `index` maps the nodes that a leaf
/// reads to operations of that expression.
fn state_number(
    table: &Table,
    k: usize,
    states: &mut BTreeMap<usize, usize>,
    leaves: &mut Vec<Leaf>,
    index: &BTreeMap<usize, usize>,
) -> usize {
    if !states.contains_key(&k)
        && let Some((at, leaf)) = table.leaf_of(k)
    {
        let first = leaves.iter().map(Leaf::width).sum::<usize>();
        states.extend((0..leaf.width()).map(|i| (at + i, first + i)));
        leaves.push(leaf.renumber(|n| index.get(&n).copied().unwrap_or(0)));
    }
    states.get(&k).copied().unwrap_or(0)
}
