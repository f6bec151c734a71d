//! Warns of distances that look kept and are not: a limit that draws the robot towards a person, one that vanishes where the
//! distance is zero, one of the larger of two distances, and a target inside of a kept distance.

use std::collections::{BTreeMap, BTreeSet};

use dsl::{Diagnostic, Span};
use runtime::program::Op;
use stdlib_tasks::dimension::LENGTH;
use stdlib_tasks::task::RowKind;

use super::{Checked, questioned, reachability, readings};
use crate::analysis::value_ranges::Ranges;
use crate::expr::{Interval, Typed};
use crate::units::shown;

/// Difference (m) of a target and a limit that rounding can make.
const SLIP: f64 = 1e-6;

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let limits: Vec<Kept> = reachability::in_stacks(c.program).into_iter().filter_map(|t| Kept::of(c, t)).collect();
    for kept in &limits {
        let found = kept.draws_near(c, &limits).or_else(|| kept.vanishes(c)).or_else(|| kept.larger_of_two(c));
        out.extend(found.filter(|d| !questioned(out, d.primary.span)));
    }
    targets_inside(c, out);
}

/// A limit of one length.
struct Kept<'c> {
    task: usize,
    value: &'c Typed,
    node: usize,
    min: Option<&'c Typed>,
    max: Option<&'c Typed>,
    /// Signals of people's positions that the length reads.
    people: BTreeSet<usize>,
}

impl<'c> Kept<'c> {
    fn of(c: &Checked<'c>, task: usize) -> Option<Kept<'c>> {
        let place = c.places.tasks.get(task).filter(|t| t.kind.row_kind == RowKind::Inequality)?;
        let value = place.operands.get("value").filter(|v| v.dimension == LENGTH)?;
        let [node] = value.nodes[..] else { return None };
        let read = readings::of_nodes(c, &[node]);
        let positions = c.program.interface.humans.iter().flat_map(|h| readings::points(c.program, h));
        let people = positions.flat_map(readings::position).filter(|n| read.contains(n)).collect();
        Some(Kept { task, value, node, min: place.operands.get("min"), max: place.operands.get("max"), people })
    }

    fn name<'p>(&self, c: &Checked<'p>) -> &'p str {
        &c.program.tasks[self.task].name
    }

    /// Span of a side.
    fn at(&self, c: &Checked, side: &str) -> Span {
        let place = &c.places.tasks[self.task];
        place.spans.get(side).copied().unwrap_or(place.span)
    }

    /// A largest distance to a person from whom no limit keeps the robot away.
    fn draws_near(&self, c: &Checked, limits: &[Kept]) -> Option<Diagnostic> {
        if self.people.is_empty() || self.min.is_some() || !is_distance(c, self.node) {
            return None;
        }
        self.max?;
        let away = limits.iter().any(|l| l.min.is_some() && !l.people.is_disjoint(&self.people));
        let protected = readings::limits(c.program)
            .into_iter()
            .any(|(task, read)| limits.iter().all(|l| l.task != task) && !read.is_disjoint(&self.people));
        if away || protected {
            return None;
        }
        let text = format!("`{}` draws the robot towards a person, and nothing keeps it away", self.name(c));
        Some(
            Diagnostic::warning("HQ0563", self.at(c, "max"), text)
                .here("a largest distance")
                .label(self.value.span, "the distance to a person")
                .note("where the person walks away, the robot follows, and it may be at any smaller distance")
                .help("write `min` to keep away; to stay near a person, keep a smallest distance too"),
        )
    }

    /// A smallest distance that is zero or less where the distance is zero.
    fn vanishes(&self, c: &Checked) -> Option<Diagnostic> {
        let min = self.min.filter(|_| is_distance(c, self.node))?;
        let [side] = min.nodes[..] else { return None };
        if c.context.graph.constant(side).is_some() || !c.context.needed(&[side]).contains(&self.node) {
            return None;
        }
        let at_zero = Ranges::new(c.context, &[side], &BTreeMap::from([(self.node, Interval::point(0.0))]));
        if at_zero.at(side).high > 0.0 {
            return None;
        }
        let text = format!("the distance that `{}` keeps vanishes where the distance itself does", self.name(c));
        Some(
            Diagnostic::warning("HQ0564", self.at(c, "min"), text)
                .here("zero at a distance of zero")
                .label(self.value.span, "this distance")
                .note("the limit holds where the parts touch, so it keeps nothing apart")
                .help("let the smallest distance grow as the other comes near, or write a constant"),
        )
    }

    /// A smallest value of the larger of several distances.
    fn larger_of_two(&self, c: &Checked) -> Option<Diagnostic> {
        self.min?;
        let mut parts = Vec::new();
        let mut open = vec![self.node];
        while let Some(node) = open.pop() {
            match c.context.graph.ops()[node] {
                Op::Max(a, b) => open.extend([a, b]),
                _ => parts.push(node),
            }
        }
        if parts.len() < 2 || !parts.iter().all(|&n| is_distance(c, n)) {
            return None;
        }
        let text = format!("`{}` keeps only the larger of {} distances", self.name(c), parts.len());
        Some(
            Diagnostic::warning("HQ0565", self.value.span, text)
                .label(self.at(c, "min"), "met as soon as one of them is that large")
                .note("while one distance is large enough, the others may be zero")
                .help("write `min(..)` of the distances, or one limit for each"),
        )
    }
}

/// True for the length of a vector that depends on the robot.
fn is_distance(c: &Checked, node: usize) -> bool {
    matches!(c.context.graph.ops()[node], Op::Sqrt(_)) && c.context.graph.is_state(node)
}

/// Warns of targets of a value beyond a limit of the same value that has priority.
fn targets_inside(c: &Checked, out: &mut Vec<Diagnostic>) {
    let mut told: BTreeSet<usize> = BTreeSet::new();
    for stack in &c.program.stacks {
        let members = || stack.levels.iter().enumerate().flat_map(|(k, l)| l.members.iter().map(move |m| (k, l, m)));
        for (level, _, target) in members() {
            let Some(goal) = Side::of(c, target.task, "target") else { continue };
            // Values that time alone moves are examined with all limits of the stack.
            if readings::of_nodes(c, &goal.value.nodes).is_empty() {
                continue;
            }
            let above = members().filter(|(k, l, _)| l.hard || *k < level).map(|(_, _, m)| m.task);
            let sides = above.flat_map(|task| ["min", "max"].map(|name| Side::of(c, task, name))).flatten();
            let excluded =
                sides.filter(|side| side.value.nodes == goal.value.nodes).find_map(|side| beyond(c, &goal, &side));
            if let Some(d) = excluded
                && told.insert(target.task)
            {
                out.push(d);
            }
        }
    }
}

/// An operand with which a task compares its value.
struct Side<'c> {
    task: usize,
    name: &'static str,
    at: Span,
    value: &'c Typed,
    operand: &'c Typed,
}

impl<'c> Side<'c> {
    fn of(c: &Checked<'c>, task: usize, name: &'static str) -> Option<Side<'c>> {
        let place = c.places.tasks.get(task)?;
        let at = place.spans.get(name).copied().unwrap_or(place.span);
        Some(Side { task, name, at, value: place.operands.get("value")?, operand: place.operands.get(name)? })
    }
}

/// Warning of a target that a side of a limit excludes, with the nearest numbers of both.
fn beyond(c: &Checked, goal: &Side, side: &Side) -> Option<Diagnostic> {
    let ends = c.context.graph.goal(&goal.operand.nodes);
    let (&[end], &[bound]) = (ends.as_slice(), side.operand.nodes.as_slice()) else { return None };
    let ranges = Ranges::new(c.context, &[end, bound], &BTreeMap::new());
    let (target, limit) = (ranges.at(end), ranges.at(bound));
    let (target, limit, word) = match side.name {
        "min" if target.high < limit.low - SLIP => (target.high, limit.low, "smallest"),
        "max" if target.low > limit.high + SLIP => (target.low, limit.high, "largest"),
        _ => return None,
    };
    let (name, other) = (&c.program.tasks[goal.task].name, &c.program.tasks[side.task].name);
    let text = format!("`{name}` never gets to its target: `{other}` excludes it");
    Some(
        Diagnostic::warning("HQ0566", goal.at, text)
            .here(shown(target, goal.value.dimension))
            .label(side.at, format!("{word} value: {}", shown(limit, goal.value.dimension)))
            .note("both measure the same value, and the limit has priority")
            .help("choose a target inside the limit, or a wider limit"),
    )
}
