//! The least parts of expectations: numbers that say by how much something is true, of what is measured while a scenario
//! runs and of what expressions know anyway.

use dsl::Diagnostic;
use dsl::tree::{BinaryOp, Value, ValueKind};
use runtime::expect::formula::Unit;
use runtime::program::{Measure, Op, Predicate, PredicateTable, Program};
use stdlib_tasks::dimension::NONE;

use super::watch::Watch;
use crate::binding::{Table, whole};
use crate::expr::{Graph, Kind, Lowering, Typed};

/// The number of a measure in the graph.
pub(super) fn measure(graph: &mut Graph, program: &Program, measures: &mut Vec<Measure>, wanted: Measure) -> usize {
    let k = measures.iter().position(|m| *m == wanted).unwrap_or_else(|| {
        measures.push(wanted);
        measures.len() - 1
    });
    graph.push(Op::Signal(program.interface.width() + k))
}

/// A number and what it is: of a comparison the difference of its sides, positive where it holds.
pub(super) fn number(
    value: &Value,
    graph: &mut Graph,
    scope: &mut Watch,
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
    let mixed = !scope.mixed.is_empty() && {
        let (_, index) = graph.extract(&[node]);
        scope.mixed.iter().any(|n| index.contains_key(n))
    };
    Some((node, if mixed { Unit::Mixed } else { Unit::Quantity(dimension) }))
}

/// A predicate of a node; `used` are the measures that predicates read, in the order of their numbers.
pub(super) fn predicate(
    (node, unit): (usize, Unit),
    (graph, table): (&Graph, &Table),
    (program, measures): (&Program, &[Measure]),
    used: &mut Vec<Measure>,
) -> Option<Predicate> {
    let width = program.interface.width();
    let layout = PredicateTable { signals: width, measures: 0 };
    let dimension = if let Unit::Quantity(d) = unit { d } else { NONE };
    let value = whole(graph, table, (node, dimension), |op| match op {
        Op::T => Some(PredicateTable::T),
        Op::Time => Some(PredicateTable::TIME),
        Op::Signal(k) if k < width => Some(layout.signal(k)),
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
