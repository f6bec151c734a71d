//! Parts of a value that a bound bounds one by one: signs, sums, choices, the smallest and the largest.

use hierarq_stdlib_tasks::bound::Slot;
use hierarq_stdlib_tasks::dimension::LENGTH;
use hierarq_stdlib_tasks::expression::{BoundedSide, Expression, Leaf, Op, bounded_parts};

/// An expression over the joints 0, 1, .. of the last operation.
fn expression(joints: usize, ops: Vec<Op>) -> Expression {
    let outputs = vec![ops.len() - 1];
    let leaves = (0..joints).map(Leaf::Joint).collect();
    Expression { ops, inputs: vec![7], leaves, outputs, dimension: LENGTH }
}

fn found(e: &Expression, side: BoundedSide) -> Vec<(Option<usize>, BoundedSide)> {
    let mut all: Vec<_> = bounded_parts(e, side).into_iter().map(|p| (p.leaf, p.side)).collect();
    all.sort_unstable();
    all
}

#[test]
fn the_smallest_bounds_each_from_below_and_none_from_above() {
    let e = expression(3, vec![Op::State(0), Op::State(1), Op::State(2), Op::Min(0, 1), Op::Min(3, 2)]);
    let below = BoundedSide::Below;
    assert_eq!(found(&e, below), [(Some(0), below), (Some(1), below), (Some(2), below)]);
    assert_eq!(found(&e, BoundedSide::Above), []);
}

#[test]
fn a_sign_turns_the_side() {
    let e = expression(1, vec![Op::State(0), Op::Const(-2.0), Op::Mul(0, 1), Op::Input(0), Op::Add(2, 3)]);
    assert_eq!(found(&e, BoundedSide::Below), [(Some(0), BoundedSide::Above)]);
    let e = expression(1, vec![Op::Input(0), Op::State(0), Op::Sub(0, 1), Op::Neg(2)]);
    assert_eq!(found(&e, BoundedSide::Below), [(Some(0), BoundedSide::Below)]);
}

#[test]
fn a_sum_is_one_part_and_reads_the_table() {
    let e = expression(2, vec![Op::State(0), Op::State(1), Op::Add(0, 1), Op::Input(0), Op::Mul(2, 3)]);
    let parts = bounded_parts(&e, BoundedSide::Below);
    assert_eq!(parts.len(), 1);
    assert_eq!((parts[0].leaf, parts[0].leaves.len()), (None, 2));
    assert_eq!(parts[0].slots, [Slot { at: 7, len: 1 }]);
}

#[test]
fn a_choice_bounds_the_parts_of_both_values() {
    let choice = |a, b| vec![Op::State(0), Op::State(1), Op::Const(1.0), Op::Input(0), Op::Select(3, a, b)];
    let below = BoundedSide::Below;
    assert_eq!(found(&expression(2, choice(0, 2)), below), [(Some(0), below)]);
    assert_eq!(found(&expression(2, choice(0, 1)), below), []);
    assert_eq!(found(&expression(2, choice(0, 0)), below), [(Some(0), below)]);
}

/// A chain as long as expressions can be takes no stack.
#[test]
fn shared_operations_are_walked_once() {
    let mut ops = vec![Op::State(0)];
    ops.extend((0..10_000).map(|i| Op::Min(i, i)));
    assert_eq!(found(&expression(1, ops), BoundedSide::Below).len(), 1);
}
