//! Warns of targets at which the value that is tracked has no derivative: a distance of zero, and the place of a hand at the
//! end of the stretched arm. There the rows of the task vanish in a direction, and hold nothing in it.

use std::collections::{BTreeMap, BTreeSet};

use dsl::Diagnostic;
use robot::{Data, LinkId};
use runtime::program::Op;
use stdlib_tasks::bound::{Bound, Slot};
use stdlib_tasks::dimension::LENGTH;
use stdlib_tasks::task::RowKind;

use super::reachability::in_stacks;
use super::{Checked, place, questioned};
use crate::analysis::stacks::postures;
use crate::analysis::value_ranges::{Ball, Ranges};
use crate::units::shown;

/// Distance from the end of the reach, relative to it, within which an arm counts as stretched. At a thousandth the elbow is
/// bent by about five degrees.
const STRETCHED: f64 = 1e-3;

/// Distance from the middle of the reach, relative to it, below which an arm is folded.
const FOLDED: f64 = 0.95;

/// Number of random configurations, beside home, at which the distance is determined.
const CONFIGURATIONS: usize = 5;

pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let mut told: BTreeSet<usize> = BTreeSet::new();
    for task in in_stacks(c.program) {
        let found = distance_of_zero(c, task).or_else(|| stretched(c, task));
        if let Some(d) = found.filter(|d| !questioned(out, d.primary.span))
            && told.insert(task)
        {
            out.push(d);
        }
    }
}

/// The length of a vector, or a size, that is tracked to zero.
fn distance_of_zero(c: &Checked, task: usize) -> Option<Diagnostic> {
    let own = c.places.tasks.get(task).filter(|t| t.kind.row_kind == RowKind::Equality)?;
    let (value, target) = own.operands.get("value").zip(own.operands.get("target"))?;
    let &[node] = value.nodes.as_slice() else { return None };
    let word = match c.context.graph.ops()[node] {
        Op::Sqrt(_) => "a distance",
        Op::Abs(_) => "a size",
        _ => return None,
    };
    let goal = c.context.graph.goal(&target.nodes);
    let zero = goal.iter().all(|&n| c.context.graph.constant(n) == Some(0.0));
    if !zero || !c.context.graph.is_state(node) {
        return None;
    }
    let name = &c.program.tasks[task].name;
    let text = format!("at its target the value of `{name}` has no derivative");
    Some(
        Diagnostic::warning("HQ0539", place(c.places, task, "target"), text)
            .here("zero")
            .label(value.span, format!("{word}, which turns round there"))
            .note("the row changes its direction from one side of zero to the other: the task holds nothing there, and may tremble")
            .help("track the vector itself, or use `frame_position` for the place of a frame"),
    )
}

/// True if a frame comes well inside of its ball: a single joint keeps it at the end of the reach everywhere.
fn folds(c: &Checked, link: LinkId, ball: Ball) -> bool {
    let model = &c.program.robot.model;
    let mut data = Data::new(model);
    postures(c.program, CONFIGURATIONS).iter().any(|q| {
        model.forward(q, &mut data);
        (data.pose(link).translation.vector - ball.centre).norm() < FOLDED * ball.radius
    })
}

/// A position of a frame at the end of its reach.
fn stretched(c: &Checked, task: usize) -> Option<Diagnostic> {
    let params = &c.program.tasks[task].params;
    let (Some(Bound::Frame(name, link)), Some(Bound::Value(Slot { at, len: 3 }))) =
        (params.get("frame"), params.get("position"))
    else {
        return None;
    };
    let own = c.context.origin(*link)?;
    // For a trajectory, the goal is checked.
    let nodes = c.context.graph.goal(c.context.table.placed.get(*at..*at + 3).unwrap_or_default());
    if nodes.is_empty() || nodes.iter().any(|&n| c.context.graph.constant(n).is_none()) {
        return None;
    }
    let goal = Ranges::new(c.context, &nodes, &BTreeMap::new()).ball(&nodes);
    let away = (own.centre - goal.centre).norm();
    if own.radius <= 0.0 || (away - own.radius).abs() > STRETCHED * own.radius || !folds(c, *link, own) {
        return None;
    }
    let text = format!("`{name}` is at the end of its reach here");
    Some(
        Diagnostic::warning("HQ0529", place(c.places, task, "position"), text)
            .here("the stretched arm")
            .note(format!(
                "its origin stays within {} of its first joints: there the arm is straight, and cannot move the hand along \
                 itself",
                shown((own.radius * 1e4).round() * 1e-4, LENGTH)
            ))
            .help("choose a place some centimetres nearer, or move the base of the robot"),
    )
}
