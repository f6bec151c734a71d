//! Warns of well-formed declarations without the intended effect: a frame that nothing moves, a target beyond a joint's
//! limit, a duplicate task, weights of too different sizes.

use std::collections::{BTreeMap, BTreeSet};

use dsl::tree::{self, MemberTask, Stack, TaskDefinition};
use dsl::{Diagnostic, Help, Snippet, Span};
use runtime::Member;
use runtime::program::Program;
use stdlib_tasks::bound::{Bound, Slot};
use stdlib_tasks::dimension::{ANGLE, LENGTH};
use stdlib_tasks::expression::{Leaf, Op};
use stdlib_tasks::task::RowKind;

use super::Checked;
use crate::analysis::stacks::{RANDOM, Sample, Signals};
use crate::expand::Expanded;
use crate::source_map::SourceMap;
use crate::units::{shown, shown_range};

/// Maximum ratio of weights in one level; beyond it, the lighter task is lost in the rounding of the heavier one.
const WEIGHT_RANGE: f64 = 1e6;

/// Maximum number of tasks of one type and stack that are compared with each other.
const MOST_COMPARED: usize = 64;

/// Least number of postures at which rows have to be zero before they count as zero everywhere.
const ENOUGH: usize = 3;

/// Warnings that follow from the spec, given its compiled program.
pub(crate) fn spec(expanded: &Expanded, program: &Program, diagnostics: &mut Vec<Diagnostic>) {
    let tasks: BTreeMap<&str, &TaskDefinition> =
        expanded.tasks.iter().map(|t| (t.name.value.as_str(), &t.definition)).collect();
    for (stack, compiled) in expanded.stacks.iter().zip(&program.stacks) {
        twice(stack, &tasks, diagnostics);
        for (level, compiled) in stack.levels.iter().zip(&compiled.levels) {
            let weights = compiled.members.iter().map(|m| m.weight);
            let heaviest = weights.clone().fold(0.0, f64::max);
            for (member, weight) in level.members.iter().zip(weights) {
                let at = member.weight.as_ref().map_or(member.span, |w| w.span);
                if let Some(written) = member.weight.as_ref().filter(|_| compiled.hard) {
                    diagnostics.push(
                        Diagnostic::warning("HQ0625", written.span, "a weight on a hard level has no effect")
                            .label(level.name.span, "this level is hard")
                            .note("weights share the error of rows that cannot all be met; a hard level has no error")
                            .help("remove the weight, or put the more important task on a level above"),
                    );
                } else if weight * WEIGHT_RANGE < heaviest {
                    let message = format!("another task of this level weighs {:.0e} times as much", heaviest / weight);
                    diagnostics.push(
                        Diagnostic::warning("HQ0622", at, message)
                            .here(format!("a weight of {weight:e}"))
                            .note("relative to it, the influence of this task is below rounding")
                            .help("put the more important task on a level of its own, above"),
                    );
                }
            }
        }
    }
}

/// Warns of identical tasks in one stack.
fn twice(stack: &Stack, tasks: &BTreeMap<&str, &TaskDefinition>, diagnostics: &mut Vec<Diagnostic>) {
    let mut seen: BTreeMap<&str, Vec<(&TaskDefinition, &tree::Member)>> = BTreeMap::new();
    let mut bare: BTreeMap<&str, &tree::Member> = BTreeMap::new();
    let mut warn = |first: &tree::Member, second: &tree::Member| {
        diagnostics.push(
            Diagnostic::warning("HQ0621", second.span, "this task duplicates another one of the stack")
                .label(first.span, "the other one")
                .note("on the same level it counts twice; on a lower one it has no effect")
                .help(Help::with("keep one of them; {} makes a task count twice", [Snippet::entry("weight", "2")])),
        );
    };
    for member in stack.levels.iter().flat_map(|l| &l.members) {
        let definition = match &member.task {
            // Repetitions were unrolled before.
            MemberTask::For(_) => continue,
            MemberTask::Inline(d) => d,
            MemberTask::Name(n) => match tasks.get(n.value.as_str()) {
                Some(d) => *d,
                // The bare name of a type, without a body.
                None => {
                    if let Some(first) = bare.insert(&n.value, member) {
                        warn(first, member);
                    }
                    continue;
                }
            },
        };
        let known = seen.entry(definition.kind.value.as_str()).or_default();
        if let Some((_, first)) = known.iter().find(|(d, _)| *d == definition) {
            warn(first, member);
        } else if known.len() < MOST_COMPARED {
            known.push((definition, member));
        }
    }
}

/// Warnings that follow from the finished program only. Returns the tasks that have one.
pub(super) fn program(c: &Checked, diagnostics: &mut Vec<Diagnostic>) -> BTreeSet<usize> {
    hard_axis_weights(c.program, c.places, diagnostics);
    let mut told = targets(c.program, c.places, diagnostics);
    for stack in 0..c.stacks.len() {
        for index in unmoved_targets(c, stack, diagnostics) {
            told.insert(index);
        }
    }
    told
}

/// Warns of weights of axes in tasks of hard levels.
fn hard_axis_weights(program: &Program, places: &SourceMap, diagnostics: &mut Vec<Diagnostic>) {
    let mut told = BTreeSet::new();
    for level in program.stacks.iter().flat_map(|s| &s.levels).filter(|l| l.hard) {
        for m in &level.members {
            let Some(at) = places.tasks.get(m.task).and_then(|t| t.spans.get("axis_weights")) else { continue };
            if !told.insert(m.task) {
                continue;
            }
            diagnostics.push(
                Diagnostic::warning("HQ0625", *at, "weights of axes have no effect on a hard level")
                    .note(format!(
                        "`{}` is on the hard level `{}`, which has no error to share",
                        program.tasks[m.task].name, level.name
                    ))
                    .help("remove the weights; to let an axis go, leave it out of `axes`"),
            );
        }
    }
}

/// Warns of constant joint targets beyond the joints' limits. Returns their tasks.
fn targets(program: &Program, places: &SourceMap, diagnostics: &mut Vec<Diagnostic>) -> BTreeSet<usize> {
    let mut beyond = BTreeSet::new();
    let moving = |at: usize| program.values.tape.outputs.iter().any(|o| o.at == at);
    for (index, (task, bound)) in program.tasks.iter().zip(&places.tasks).enumerate() {
        let list: Vec<(usize, Slot)> = match (task.kind.as_str(), task.params.get("value"), task.params.get("target")) {
            ("joint_position", _, Some(Bound::PerJoint(list))) => list.clone(),
            ("track", Some(Bound::Expression(e)), Some(Bound::Value(slot))) => match (&e.ops[..], &e.leaves[..]) {
                ([Op::State(_)], [Leaf::Joint(dof)]) => vec![(*dof, *slot)],
                _ => continue,
            },
            _ => continue,
        };
        let mut told: Vec<Span> = Vec::new();
        for (dof, slot) in &list {
            let (Some(d), Some(&x)) = (program.robot.model.dofs.get(*dof), program.values.initial.get(slot.at)) else {
                continue;
            };
            if moving(slot.at) || (x >= d.lower && x <= d.upper) {
                continue;
            }
            let number = bound.numbers.iter().find(|n| n.slot.at == slot.at).map(|n| n.span);
            let at = number.or(bound.spans.get("target").copied()).unwrap_or(bound.span);
            if told.contains(&at) {
                continue;
            }
            told.push(at);
            beyond.insert(index);
            let dimension = if d.unit == robot::DofUnit::Metre { LENGTH } else { ANGLE };
            let allowed = shown_range(d.lower, d.upper, dimension);
            diagnostics.push(
                Diagnostic::warning("HQ0520", at, format!("`{}` cannot go to {}", d.name, shown(x, dimension)))
                    .here(format!("allowed are {allowed}"))
                    .note("the task pulls the joint against its limit and never reaches its target")
                    .help("choose a target within that range"),
            );
        }
    }
    beyond
}

/// Warns of targets whose rows are zero. Returns their tasks.
fn unmoved_targets(c: &Checked, stack: usize, diagnostics: &mut Vec<Diagnostic>) -> Vec<usize> {
    let (program, places) = (c.program, c.places);
    let mut told = Vec::new();
    // A limit that nothing moves stays satisfied; a target is never reached.
    for m in unmoved(c, stack).iter().filter(|m| m.row_kind == RowKind::Equality) {
        told.push(m.program_index);
        let task = &places.tasks[m.program_index];
        let named = ["frame", "frames", "joints", "arm", "points"].iter().find_map(|p| task.spans.get(*p));
        let at = named.copied().unwrap_or(task.span);
        let d = Diagnostic::warning("HQ0620", at, format!("no joint affects task `{}`", m.name));
        diagnostics.push(if m.kind == "track" {
            d.note("value and target move together, so no motion changes their difference")
                .help("name a part that moves against the others, or remove the task")
        } else if program.stacks[stack].locked.is_empty() {
            d.note("no joint is between it and the ground, so the task has no effect")
                .help("name a part of the robot that moves, or remove the task")
        } else {
            d.label(places.stacks[stack].0, "this stack locks joints")
                .help("unlock the joints that move it, or take the task out of this stack")
        });
    }
    told
}

/// Tasks of a stack whose rows are zero, at home and at a few other postures, since a single one may be singular.
pub(super) fn unmoved<'c>(c: &'c Checked, stack: usize) -> Vec<&'c Member> {
    if c.program.stacks[stack].locked.len() >= c.program.robot.model.nv() {
        return Vec::new();
    }
    let members = c.stacks.members(stack);
    let mut still = vec![true; members.len()];
    let mut note = |sample: &Sample| {
        for (i, m) in members.iter().enumerate() {
            let zero = sample.rows(m).all(|row| row.iter().all(|x| *x == 0.0));
            still[i] &= zero && !m.rows.is_empty() && !sample.undefined[i];
        }
    };
    let mut seen = 0;
    for posture in 0..=RANDOM {
        // The rows do not exist if parts overlap; at home, this was reported.
        let Some(sample) = c.stacks.sample(stack, Signals::Absent, posture) else { continue };
        note(sample);
        seen += 1;
        // A value can depend on the robot only while a signal is present, `if(present(..), .., ..)`.
        c.stacks.sample(stack, Signals::Present, posture).into_iter().for_each(&mut note);
    }
    if seen < ENOUGH {
        return Vec::new();
    }
    members.iter().zip(still).filter(|(_, still)| *still).map(|(m, _)| m).collect()
}
