//! Predicates, the atoms of expectations: numbers that are positive if a condition holds, computed from measures of the
//! scenario and from expressions.

use std::collections::BTreeSet;

use dsl::Diagnostic;
use dsl::tree::{BinaryOp, Value, ValueKind};
use runtime::program::Unit;
use runtime::program::{Op, Predicate, PredicateTable};
use stdlib_tasks::dimension::NONE;

use crate::binding::{Table, whole};
use crate::expr::{Graph, Kind, Lowering, Scope, Typed};

/// Returns the node of a measure. Measures follow the `width` numbers of the table of signals.
pub(super) fn measure<M: PartialEq>(graph: &mut Graph, width: usize, measures: &mut Vec<M>, wanted: M) -> usize {
    let k = measures.iter().position(|m| *m == wanted).unwrap_or_else(|| {
        measures.push(wanted);
        measures.len() - 1
    });
    graph.push(Op::Signal(width + k))
}

/// Lowers a predicate to a number with its unit. A comparison becomes the difference of its sides, positive if true.
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
        diagnostics.push(d.here(is).help("compare it: write for instance `.. >= 0 m` after it"));
        return None;
    }
    let ValueKind::Binary(op, left, right) = &value.kind else { return Some((whole.nodes[0], Unit::Truth)) };
    if !op.value.compares() {
        return Some((whole.nodes[0], Unit::Truth));
    }
    // Mistakes in the sides were reported with the whole comparison.
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

/// Marks the number as [`Unit::Mixed`] if it depends on nodes whose sign alone is meaningful.
pub(super) fn mixed(graph: &Graph, (node, unit): (usize, Unit), of: &BTreeSet<usize>) -> (usize, Unit) {
    let mixed = matches!(unit, Unit::Quantity(_)) && !of.is_empty() && {
        let (_, index) = graph.extract(&[node]);
        of.iter().any(|n| index.contains_key(n))
    };
    (node, if mixed { Unit::Mixed } else { unit })
}

/// Graph of a predicate's nodes.
#[derive(Clone, Copy)]
pub(super) struct Graphs<'g> {
    /// The graph.
    pub graph: &'g Graph,
    /// Leaves of the robot's state in the graph.
    pub table: &'g Table,
    /// Width of the table of signals.
    pub width: usize,
}

/// Extracts the predicate of a node, over a table with the measures in `used` only, to which new ones are appended.
/// Returns `None` if the node depends on something that this table does not contain.
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
