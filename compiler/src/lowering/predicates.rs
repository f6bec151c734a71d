//! The least parts of expectations: numbers that say by how much something is true, of what is measured while a scenario
//! runs and of what expressions know anyway.

use std::collections::BTreeSet;

use dsl::Diagnostic;
use dsl::tree::{BinaryOp, Value, ValueKind};
use runtime::program::Unit;
use runtime::program::{Op, Predicate, PredicateTable};
use stdlib_tasks::dimension::NONE;

use crate::binding::{Table, whole};
use crate::expr::{Graph, Kind, Lowering, Scope, Typed};

/// The number of a measure in the graph; `width` is that of the table of signals, behind which measures stand.
pub(super) fn measure<M: PartialEq>(graph: &mut Graph, width: usize, measures: &mut Vec<M>, wanted: M) -> usize {
    let k = measures.iter().position(|m| *m == wanted).unwrap_or_else(|| {
        measures.push(wanted);
        measures.len() - 1
    });
    graph.push(Op::Signal(width + k))
}

/// A number and what it is: of a comparison the difference of its sides, positive where it holds.
pub(super) fn number(
    value: &Value,
    graph: &mut Graph,
    scope: &mut dyn Scope,
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<(usize, Unit)> {
    let mut lower = |value: &Value, diagnostics: &mut Vec<Diagnostic>| {
        Lowering { graph: &mut *graph, scope: &mut *scope, diagnostics }.value(value).ok()
    };
    let whole = lower(value, diagnostics)?;
    if whole.kind != Kind::Truth {
        let is = whole.kind.describe();
        let d = Diagnostic::error("HQ0304", value.span, format!("an expectation is true or false, and this is {is}"));
        diagnostics.push(d.here(is).help("compare it: write for instance `.. >= 0 m` behind it"));
        return None;
    }
    let ValueKind::Binary(op, left, right) = &value.kind else { return Some((whole.nodes[0], Unit::Truth)) };
    if !op.value.compares() {
        return Some((whole.nodes[0], Unit::Truth));
    }
    // What is to be said of the sides was said of the whole.
    let mut said = Vec::new();
    let (a, b) = (lower(left, &mut said)?, lower(right, &mut said)?);
    let (more, less) = match op.value {
        BinaryOp::Less | BinaryOp::LessEqual => (&b, &a),
        _ => (&a, &b),
    };
    let node = graph.push(Op::Sub(more.nodes[0], less.nodes[0]));
    let is_zero = |t: &Typed| graph.constant(t.nodes[0]) == Some(0.0) && t.dimension == NONE;
    let dimension = match (is_zero(&a) || a.bare, is_zero(&b) || b.bare) {
        (true, _) => b.dimension,
        (_, true) => a.dimension,
        _ => a.dimension.join(b.dimension),
    };
    Some((node, Unit::Quantity(dimension)))
}

/// The same number where it is made of what only the sign means something of.
pub(super) fn mixed(graph: &Graph, (node, unit): (usize, Unit), of: &BTreeSet<usize>) -> (usize, Unit) {
    let mixed = matches!(unit, Unit::Quantity(_)) && !of.is_empty() && {
        let (_, index) = graph.extract(&[node]);
        of.iter().any(|n| index.contains_key(n))
    };
    (node, if mixed { Unit::Mixed } else { unit })
}

/// What nodes stand in.
#[derive(Clone, Copy)]
pub(super) struct Graphs<'g> {
    /// The graph.
    pub graph: &'g Graph,
    /// The robot's state in it.
    pub table: &'g Table,
    /// Numbers of the table of signals.
    pub width: usize,
}

/// A predicate of a node, over a table without the measures; `used` are those that predicates read, in the order of
/// their numbers. `None` where something stands in it that the table has not.
pub(super) fn predicate<M: Clone + PartialEq>(
    (node, unit): (usize, Unit),
    Graphs { graph, table, width }: Graphs,
    layout: PredicateTable,
    (measures, used): (&[M], &mut Vec<M>),
) -> Option<Predicate> {
    let dimension = if let Unit::Quantity(d) = unit { d } else { NONE };
    let value = whole(graph, table, (node, dimension), |op| match op {
        Op::T => Some(PredicateTable::T),
        Op::Time => Some(PredicateTable::TIME),
        Op::Signal(k) if k < width => (k < layout.signals).then(|| layout.signal(k)),
        Op::Signal(k) => {
            let wanted = measures.get(k - width)?;
            let at = used.iter().position(|m| m == wanted).unwrap_or_else(|| {
                used.push(wanted.clone());
                used.len() - 1
            });
            Some(layout.measure(at))
        }
        _ => None,
    })?;
    Some(Predicate { value, unit })
}
