//! Warns of runs of a stack that end before a target of it is at the end of its way.
//!
//! A way in time is a share of time that is limited from above, as in `smoothstep(t/(10 s))`: behind its end the target
//! stands still.

use std::collections::{BTreeMap, BTreeSet};

use dsl::Diagnostic;
use runtime::program::{Op, Subject};
use stdlib_tasks::dimension::TIME;
use stdlib_tasks::task::RowKind;

use super::{Checked, place, readings};
use crate::expr::Graph;
use crate::units::shown;

/// Share of the way that may be missing: the end of a smooth step is flat.
const MISSING: f64 = 0.05;

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let Subject::Stack(stack) = c.program.run.subject else { return };
    let Some((run, _)) = c.expanded.runs.first() else { return };
    let scenarios = c.program.scenarios.iter().filter(|s| s.run.subject == c.program.run.subject);
    let longest = scenarios.map(|s| s.run.duration).fold(c.program.run.duration, f64::max);
    let Some(duration) = run.body.get("duration") else { return };
    for member in c.program.stacks[stack].levels.iter().flat_map(|l| &l.members) {
        let Some(own) = c.places.tasks.get(member.task).filter(|t| t.kind.row_kind == RowKind::Equality) else {
            continue;
        };
        for (param, bound) in c.program.tasks[member.task].params.iter().filter(|(name, _)| *name != "gain") {
            let slots = bound.slots().into_iter();
            let nodes: Vec<usize> = slots
                .flat_map(|s| c.context.table.placed.get(s.at..s.at + s.len).unwrap_or_default())
                .chain(own.operands.get(param.as_str()).into_iter().flat_map(|t| &t.nodes))
                .copied()
                .collect();
            let ends = way_ends(c.context.graph, &c.context.needed(&nodes));
            let Some(end) = ends.into_iter().reduce(f64::max) else { continue };
            let at = place(c.places, member.task, param);
            if longest >= end * (1.0 - MISSING) || out.iter().any(|d| d.code == "HQ0614" && d.primary.span == at) {
                continue;
            }
            let text = format!("the run ends before the target of `{}` does", c.program.tasks[member.task].name);
            out.push(
                Diagnostic::warning("HQ0614", at, text)
                    .here(format!("at its end after {}", shown(end, TIME)))
                    .label(readings::entry(duration), "the run ends here")
                    .note("the robot stops on its way")
                    .help("let the run last longer, or the motion shorter"),
            );
        }
    }
}

/// Number that is linear in the time since the entry of the stack.
#[derive(Clone, Copy)]
struct Linear {
    offset: f64,
    slope: f64,
}

/// Times at which shares of time among some nodes, in order, come to their upper ends.
fn way_ends(graph: &Graph, nodes: &BTreeSet<usize>) -> Vec<f64> {
    let mut known: BTreeMap<usize, Linear> = BTreeMap::new();
    let mut ends = Vec::new();
    for &node in nodes {
        let linear = |n: usize| known.get(&n).copied();
        let scaled = |n: usize, by: f64| linear(n).map(|l| Linear { offset: l.offset * by, slope: l.slope * by });
        let own = match graph.ops()[node] {
            Op::Const(x) => Some(Linear { offset: x, slope: 0.0 }),
            // A run of one stack enters it at its start.
            Op::T | Op::Time => Some(Linear { offset: 0.0, slope: 1.0 }),
            Op::Add(a, b) => {
                linear(a).zip(linear(b)).map(|(a, b)| Linear { offset: a.offset + b.offset, slope: a.slope + b.slope })
            }
            Op::Sub(a, b) => {
                linear(a).zip(linear(b)).map(|(a, b)| Linear { offset: a.offset - b.offset, slope: a.slope - b.slope })
            }
            Op::Neg(a) => scaled(a, -1.0),
            Op::Mul(a, b) => match (graph.constant(a), graph.constant(b)) {
                (Some(x), _) => scaled(b, x),
                (_, Some(x)) => scaled(a, x),
                _ => None,
            },
            Op::Div(a, b) => graph.constant(b).and_then(|x| scaled(a, 1.0 / x)),
            // A lower end of a share moves its start, not its end.
            Op::Max(a, b) => [(a, b), (b, a)].into_iter().find_map(|(rising, end)| {
                graph.constant(end)?;
                linear(rising).filter(|l| l.slope > 0.0)
            }),
            Op::Min(a, b) => {
                let end = [(a, b), (b, a)].into_iter().find_map(|(rising, end)| {
                    let (end, l) = (graph.constant(end)?, linear(rising).filter(|l| l.slope > 0.0)?);
                    Some((end - l.offset) / l.slope)
                });
                ends.extend(end.filter(|t| t.is_finite() && *t > 0.0));
                None
            }
            _ => None,
        };
        known.extend(own.map(|l| (node, l)));
    }
    ends
}
