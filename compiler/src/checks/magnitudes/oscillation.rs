//! Warns of oscillations that the controller cannot sample: from half of its rate on, their samples are those of a slower
//! oscillation.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use dsl::Diagnostic;
use runtime::program::Op;
use stdlib_tasks::dimension::RATE;

use crate::checks::reachability::in_stacks;
use crate::checks::{Checked, place};
use crate::expr::Graph;
use crate::units::shown;

/// Rounding of frequencies.
const SLIP: f64 = 1e-9;

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let period = c.program.robot.period;
    let mut slopes = BTreeMap::new();
    for task in in_stacks(c.program) {
        for (param, bound) in &c.program.tasks[task].params {
            let placed = &c.context.table.placed;
            let slots = bound.slots();
            let nodes: Vec<usize> =
                slots.iter().flat_map(|s| placed.get(s.at..s.at + s.len).unwrap_or_default()).copied().collect();
            let fastest = c.context.needed(&nodes).into_iter().filter_map(|node| match c.context.graph.ops()[node] {
                Op::Sin(a) | Op::Cos(a) => slope(c.context.graph, a, &mut slopes).map(f64::abs),
                _ => None,
            });
            let Some(fastest) = fastest.filter(|w| *w >= PI / period * (1.0 - SLIP)).max_by(f64::total_cmp) else {
                continue;
            };
            let written = c.places.tasks[task].numbers.iter().find(|n| n.written && slots.contains(&n.slot));
            let at = written.map_or_else(|| place(c.places, task, param), |n| n.span);
            if out.iter().any(|d| d.code == "HQ0549" && d.primary.span == at) {
                continue;
            }
            out.push(
                Diagnostic::warning("HQ0549", at, "the controller is too slow for this oscillation")
                    .here(shown(digits(fastest / TAU), RATE))
                    .label(c.places.rate, format!("{} ticks per second", runtime::text::number(digits(1.0 / period))))
                    .note(
                        "from half of the rate on, the samples are those of a slower oscillation; at the rate itself every tick has the \
                         same phase",
                    )
                    .help("stay well below a tenth of the rate, where an oscillation has ten ticks, or raise the rate"),
            );
        }
    }
}

/// Constant time derivative of a node, if it is linear in time.
fn slope(graph: &Graph, node: usize, known: &mut BTreeMap<usize, Option<f64>>) -> Option<f64> {
    // Operands come first, so that no deep recursion is needed.
    let mut open = vec![node];
    while let Some(&n) = open.last() {
        let missing: Vec<usize> =
            graph.ops()[n].operands().into_iter().flatten().filter(|o| !known.contains_key(o)).collect();
        if missing.is_empty() {
            open.pop();
            known.insert(n, own_slope(graph, n, known));
        } else {
            open.extend(missing);
        }
    }
    known.get(&node).copied().flatten()
}

fn own_slope(graph: &Graph, node: usize, known: &BTreeMap<usize, Option<f64>>) -> Option<f64> {
    let of = |n: usize| known.get(&n).copied().flatten();
    match graph.ops()[node] {
        Op::Const(_) | Op::Input(_) => Some(0.0),
        Op::T | Op::Time => Some(1.0),
        Op::Add(a, b) => Some(of(a)? + of(b)?),
        Op::Sub(a, b) => Some(of(a)? - of(b)?),
        Op::Neg(a) => Some(-of(a)?),
        Op::Mul(a, b) => match (graph.constant(a), graph.constant(b)) {
            (Some(x), _) => Some(x * of(b)?),
            (_, Some(x)) => Some(x * of(a)?),
            _ => None,
        },
        Op::Div(a, b) => Some(of(a)? / graph.constant(b)?),
        _ => None,
    }
}

/// A number without the rounding of a conversion.
fn digits(x: f64) -> f64 {
    format!("{x:.4e}").parse().unwrap_or(x)
}
