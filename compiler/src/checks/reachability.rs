//! Targets and limits outside of the range of their value: a cosine of 2, a place farther away than the links can
//! reach. Reports proven cases only, see [`crate::analysis::value_ranges`].

use std::collections::{BTreeMap, BTreeSet};

use dsl::{Diagnostic, Span};
use runtime::program::{Op, Program};
use stdlib_tasks::bound::Bound;
use stdlib_tasks::dimension::{Dimension, LENGTH};
use stdlib_tasks::expression::Leaf;

use crate::analysis::value_ranges::{RangeContext, Ranges};
use crate::expr::{Graph, Interval, Kind, Typed};
use crate::source_map::SourceMap;
use crate::units::{shown, shown_range};

/// Tolerance for rounding and for decimals that were left out.
const SLIP: f64 = 1e-6;

/// Tolerance for the length of directions, which are often written with three decimals.
const LENGTH_SLIP: f64 = 0.01;

/// Tasks of a program that belong to a stack.
pub(crate) fn in_stacks(program: &Program) -> BTreeSet<usize> {
    program.stacks.iter().flat_map(|s| &s.levels).flat_map(|l| &l.members).map(|m| m.task).collect()
}

/// Reports limits of `keep` that no joint positions satisfy.
pub(crate) fn limits(context: &RangeContext, program: &Program, places: &SourceMap, diagnostics: &mut Vec<Diagnostic>) {
    for task in in_stacks(program).into_iter().filter_map(|i| places.tasks.get(i)) {
        let Some(value) = task.operands.get("value") else { continue };
        for (param, side) in task.operands.iter().filter(|(p, _)| ["min", "max"].contains(p)) {
            let ranges = ranges(context, value, side);
            let at = task.spans.get(*param).copied().unwrap_or(task.span);
            diagnostics.extend(limit(&ranges, value, side, *param == "min", at));
        }
    }
}

/// Warns of targets of `track` that no joint positions reach, except for tasks that already have a warning (`told`).
pub(crate) fn targets(
    context: &RangeContext,
    program: &Program,
    places: &SourceMap,
    told: &mut BTreeSet<usize>,
    diagnostics: &mut Vec<Diagnostic>,
) {
    let open: Vec<usize> = in_stacks(program).difference(told).copied().collect();
    for (index, task) in open.into_iter().filter_map(|i| Some((i, places.tasks.get(i)?))) {
        let operands = task.operands.get("value").zip(task.operands.get("target"));
        let Some((value, goal)) = operands.filter(|(v, _)| v.kind != Kind::Rotation) else { continue };
        // Another check reports targets of a single joint, by the joint's name.
        if joint(context, value) && constant(context.graph, goal).is_some() {
            continue;
        }
        let at = task.spans.get("target").copied().unwrap_or(task.span);
        // For a trajectory, the goal is checked.
        let goal = &Typed { nodes: context.graph.goal(&goal.nodes), ..goal.clone() };
        if let Some(d) = target(&mut ranges(context, value, goal), context.graph, value, goal, at) {
            told.insert(index);
            diagnostics.push(d);
        }
    }
}

/// Warns of target positions of frames that no joint positions reach, except for tasks that already have a warning (`told`).
pub(crate) fn frames(
    context: &RangeContext,
    program: &Program,
    places: &SourceMap,
    told: &mut BTreeSet<usize>,
    diagnostics: &mut Vec<Diagnostic>,
) {
    let open: Vec<usize> = in_stacks(program).difference(told).copied().collect();
    for index in open {
        let params = &program.tasks[index].params;
        let (Some(Bound::Frame(name, link)), Some(Bound::Value(slot))) = (params.get("frame"), params.get("position"))
        else {
            continue;
        };
        let Some(own) = context.origin(*link) else { continue };
        // For a trajectory, the goal is checked.
        let nodes = context.graph.goal(context.table.placed.get(slot.at..slot.at + slot.len).unwrap_or_default());
        let goal = Ranges::new(context, &nodes, &BTreeMap::new()).ball(&nodes);
        let away = (own.centre - goal.centre).norm() - goal.radius - own.radius;
        if away > SLIP * (1.0 + own.radius) {
            let at = places.tasks[index].spans.get("position").copied().unwrap_or(places.tasks[index].span);
            told.insert(index);
            let text = format!("`{name}` cannot reach this position");
            let c = own.centre.map(|x| runtime::text::number((x * 1e3).round() / 1e3));
            let within = shown((own.radius * 1e4).round() * 1e-4, LENGTH);
            let is = format!("{} too far away", shown((away * 1e4).ceil() * 1e-4, LENGTH));
            diagnostics.push(
                Diagnostic::warning("HQ0520", at, text)
                    .here(is)
                    .note(format!(
                        "its origin stays within {within} of [{}, {}, {}] m at all joint positions",
                        c.x, c.y, c.z
                    ))
                    .help("choose a position that can be reached; positions are those in the world, in m"),
            );
        }
    }
}

fn ranges<'a>(context: &'a RangeContext<'a>, a: &Typed, b: &Typed) -> Ranges<'a> {
    let roots: Vec<usize> = a.nodes.iter().chain(&b.nodes).copied().collect();
    Ranges::new(context, &roots, &BTreeMap::new())
}

/// True if the value is a joint's position and nothing else.
fn joint(context: &RangeContext, value: &Typed) -> bool {
    match value.nodes[..] {
        [node] => match context.graph.ops()[node] {
            Op::State(k) => matches!(context.table.leaf_of(k), Some((_, Leaf::Joint(_)))),
            _ => false,
        },
        _ => false,
    }
}

/// The numbers of a constant value.
fn constant(graph: &Graph, value: &Typed) -> Option<Vec<f64>> {
    value.nodes.iter().map(|&n| graph.constant(n)).collect()
}

/// True if two ranges are disjoint by more than rounding.
fn apart(a: Interval, b: Interval) -> bool {
    let ends = [a.low, a.high, b.low, b.high].into_iter().filter(|x| x.is_finite());
    a.gap(b) > SLIP * (1.0 + ends.fold(0.0, |s: f64, x| s.max(x.abs())))
}

/// Names a part of the value: `x of this value`, or `this value`.
fn part(value: &Typed, i: usize) -> String {
    match (value.kind, ["x", "y", "z"].get(i)) {
        (Kind::Vector, Some(name)) => format!("{name} of this value"),
        _ => "this value".to_string(),
    }
}

/// Describes a range.
pub(super) fn between(range: Interval, dimension: Dimension) -> String {
    match (range.low.is_finite(), range.high.is_finite()) {
        (true, true) if range.high - range.low <= SLIP * (1.0 + range.size()) => shown(range.low, dimension),
        (true, true) => format!("from {}", shown_range(range.low, range.high, dimension)),
        (true, false) => format!("{} or more", shown(range.low, dimension)),
        _ => format!("{} or less", shown(range.high, dimension)),
    }
}

fn warning(at: Span, text: String, value: &Typed, is: String) -> Diagnostic {
    Diagnostic::warning("HQ0520", at, text).label(value.span, is).note(
        "this holds at all joint positions within the limits: the task pulls the robot and never reaches its target",
    )
}

fn target(ranges: &mut Ranges, graph: &Graph, value: &Typed, target: &Typed, at: Span) -> Option<Diagnostic> {
    let dimension = value.dimension;
    let pairs = value.nodes.iter().zip(&target.nodes).enumerate();
    let far = |(i, (&v, &t)): (usize, (&usize, &usize))| {
        let (v, t) = (ranges.at(v), ranges.at(t));
        apart(v, t).then_some((i, v, t))
    };
    if let Some((i, can, wanted)) = pairs.into_iter().find_map(far) {
        let goal = match constant(graph, target).and_then(|c| c.get(i).copied()) {
            Some(x) => shown(x, dimension),
            None => format!("the target, {}", between(wanted, dimension)),
        };
        let text = format!("{} cannot get to {goal}", part(value, i));
        let d = warning(at, text, value, format!("it is {}", between(can, dimension)));
        return Some(d.help("choose a target that can be reached"));
    }
    if value.kind != Kind::Vector {
        return None;
    }
    let (own, goal) = (ranges.ball(&value.nodes), ranges.ball(&target.nodes));
    let away = (own.centre - goal.centre).norm() - goal.radius;
    if away > own.radius + SLIP * (1.0 + own.radius) {
        let c = own.centre.map(|x| runtime::text::number((x * 1e3).round() / 1e3));
        let behind = if dimension == LENGTH { " m" } else { "" };
        let is = format!("within {} of [{}, {}, {}]{behind}", shown(own.radius, dimension), c.x, c.y, c.z);
        let text = format!("this value cannot reach the target, {} away", shown(away, dimension));
        return Some(warning(at, text, value, is).help("choose a target that can be reached"));
    }
    let (own, goal) = (ranges.length(&value.nodes), ranges.length(&target.nodes));
    if own.gap(goal) > LENGTH_SLIP * (own.smallest() + goal.smallest()) {
        let text = format!("this value cannot reach the target, whose length is {}", between(goal, dimension));
        let d = warning(at, text, value, format!("its length is {}", between(own, dimension)));
        let direction = own.gap(Interval::point(1.0)).abs() < SLIP && own.high - own.low < SLIP;
        return Some(d.help(match direction {
            true => "for a direction write `normalize([x, y, z])`",
            false => "choose a target that can be reached",
        }));
    }
    None
}

fn limit(ranges: &Ranges, value: &Typed, side: &Typed, least: bool, at: Span) -> Option<Diagnostic> {
    let pairs = value.nodes.iter().zip(&side.nodes).enumerate();
    let beyond = |(i, (&v, &s)): (usize, (&usize, &usize))| {
        let (v, s) = (ranges.at(v), ranges.at(s));
        let crossed = if least { v.high < s.low } else { v.low > s.high };
        (crossed && apart(v, s)).then_some((i, v, s))
    };
    let (i, can, wanted) = pairs.into_iter().find_map(beyond)?;
    let (word, end) = if least { ("large", wanted.low) } else { ("small", wanted.high) };
    let text = format!("{} is never as {word} as {}", part(value, i), shown(end, value.dimension));
    let is = format!("it is {}", between(can, value.dimension));
    Some(
        Diagnostic::error("HQ0520", at, text)
            .label(value.span, is)
            .note("this holds at all joint positions within the limits: the limit cannot be kept")
            .help(if least { "choose a smaller limit" } else { "choose a larger limit" }),
    )
}
