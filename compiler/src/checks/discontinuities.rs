//! Warns of values, targets and limits that are discontinuous where a comparison inside them changes its result.
//!
//! A comparison `a < b` changes at `a = b`. There, the range of the whole expression is computed with the comparison
//! true and with it false. If the two ranges are disjoint, the expression jumps. Expressions that agree at the change,
//! such as `if(x > 0, x, -x)`, are continuous.

use std::collections::BTreeMap;

use dsl::{Diagnostic, Span};
use runtime::program::{Op, Program};

use crate::analysis::value_ranges::{RangeContext, Ranges};
use crate::checks::reachability::in_stacks;
use crate::expr::{Interval, Kind, Typed};
use crate::source_map::SourceMap;
use crate::units::shown;

/// Maximum number of comparisons examined per parameter.
const COMPARISONS: usize = 16;

/// Jumps below this size are attributed to rounding.
const SLIP: f64 = 1e-6;

/// Warns of every discontinuous parameter, once.
pub(crate) fn check(context: &RangeContext, program: &Program, places: &SourceMap, diagnostics: &mut Vec<Diagnostic>) {
    let mut told: Vec<Span> = Vec::new();
    for i in in_stacks(program) {
        let Some(task) = places.tasks.get(i) else { continue };
        for (param, typed) in &task.operands {
            let at = task.spans.get(*param).copied().unwrap_or(task.span);
            let Some(jump) = jump(context, typed).filter(|_| !told.contains(&at)) else { continue };
            told.push(at);
            let size = if jump.is_finite() && typed.kind != Kind::Rotation {
                format!("by {}{}", if jump.exact { "" } else { "at least " }, shown(jump.size, typed.dimension))
            } else {
                "when its condition turns over".to_string()
            };
            diagnostics.push(
                Diagnostic::warning("HQ0521", at, format!("`{param}` jumps {size}"))
                    .note("a jump causes a jolt: within one tick the velocity changes by the jump times the gain")
                    .help(
                        "go over smoothly: `lerp(a, b, smoothstep(x))`, where x rises from 0 to 1, such as `(t - 1 s)/(0.5 s)`",
                    ),
            );
        }
    }
}

/// Lower bound of a jump; `exact` if the jump has this size.
struct Jump {
    size: f64,
    exact: bool,
}

impl Jump {
    fn is_finite(&self) -> bool {
        self.size.is_finite()
    }
}

/// Largest proven jump of a value.
fn jump(context: &RangeContext, typed: &Typed) -> Option<Jump> {
    let graph = context.graph;
    let compares = |n: &usize| matches!(graph.ops()[*n], Op::Less(..) | Op::LessEqual(..));
    let comparisons: Vec<usize> = context.needed(&typed.nodes).into_iter().filter(compares).take(COMPARISONS).collect();
    if comparisons.is_empty() {
        return None;
    }
    let all = Ranges::new(context, &typed.nodes, &BTreeMap::new());
    let turns = |n: &usize| all.at(*n).low < all.at(*n).high;
    let jumps = comparisons.into_iter().filter(turns).filter_map(|node| {
        let (Op::Less(a, b) | Op::LessEqual(a, b)) = graph.ops()[node] else { return None };
        // At `a = b` the common value is in the ranges of both.
        let equal = all.at(a).meet(all.at(b));
        let mut pins = BTreeMap::from([(a, equal), (b, equal)]);
        let mut side = |truth: f64| {
            pins.insert(node, Interval::point(truth));
            let ranges = Ranges::new(context, &typed.nodes, &pins);
            typed.nodes.iter().map(|&n| ranges.at(n)).collect::<Vec<_>>()
        };
        let (yes, no) = (side(1.0), side(-1.0));
        let apart = |(y, n): (&Interval, &Interval)| {
            let ends = [y.low, y.high, n.low, n.high].into_iter().filter(|x| x.is_finite());
            let size = ends.fold(0.0, |s: f64, x| s.max(x.abs()));
            let exact = y.high - y.low < SLIP && n.high - n.low < SLIP;
            (y.gap(*n) > SLIP * (1.0 + size)).then_some(Jump { size: y.gap(*n), exact })
        };
        yes.iter().zip(&no).filter_map(apart).max_by(|a, b| a.size.total_cmp(&b.size))
    });
    jumps.max_by(|a, b| a.size.total_cmp(&b.size))
}
