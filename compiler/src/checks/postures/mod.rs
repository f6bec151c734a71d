//! Targets that the robot does not get to: beyond its reach, or excluded by limits or by other targets of their level.
//!
//! The numbers of the spec decide, without a run: a search looks for a posture at which a target is met within the limits of
//! its stack, see [`PostureSearch`]. A target that moves is examined at some moments.

mod pace;
mod parts;
mod report;

use std::collections::BTreeSet;

use dsl::Diagnostic;
use runtime::program::MemberProgram;

use super::Checked;
use crate::analysis::postures::{FixedValue, Parts, Posture, PostureSearch};
use pace::Moment;
use parts::{StackParts, Target, shared_level};
use report::Missed;

/// Number of moments at which a target that moves is examined.
const MOMENTS: usize = 16;

/// Warns of targets that no posture meets, except for tasks that already have a warning (`told`, one of `known`).
pub(super) fn check(c: &Checked, mut told: BTreeSet<usize>, known: &[Diagnostic], out: &mut Vec<Diagnostic>) {
    let mut searched = BTreeSet::new();
    // A stack without a joint that moves was reported.
    let moves = |stack: &usize| c.program.stacks[*stack].locked.len() < c.program.robot.model.nv();
    for stack in (0..c.program.stacks.len()).filter(moves) {
        let parts = StackParts::new(c, stack);
        let mut all_met = true;
        for target in &parts.targets {
            let task = target.member.task;
            let limits = parts.limits_of(target.level);
            let of_limits: Vec<usize> = limits.iter().map(|l| l.task).collect();
            // Stacks often share targets and limits.
            if told.contains(&task)
                || !searched.insert((task, of_limits, c.program.stacks[stack].locked.clone(), parts.at_home))
            {
                continue;
            }
            let found = examine(c, stack, &parts, &[target], &limits);
            all_met &= !matches!(found, Found::Missed(_));
            let d = match found {
                Found::Nothing => None,
                Found::Missed(missed) => Some(report::target(c, &missed, target)),
                Found::Met(moments) => pace::check(c, stack, &parts.joint_limits, &target.member, &moments),
            };
            if let Some(d) = d
                && told.insert(task)
            {
                out.push(d);
            }
        }
        out.extend(moving_limits(c, stack, &parts, &mut told));
        for velocity in &parts.velocities {
            let member = &velocity.member;
            if told.contains(&member.task) {
                continue;
            }
            let home = &c.program.robot.home;
            let moments: Vec<Moment> = moments(parts.duration).map(|t| Moment { q: home.clone(), t }).collect();
            let too_fast = pace::check(c, stack, &parts.joint_limits, member, &moments);
            if let Some(d) = too_fast.or_else(|| pace::stops(c, stack, velocity, parts.duration)) {
                told.insert(member.task);
                out.push(d);
            }
        }
        let shared = shared_level(&c.program.stacks[stack].levels, &parts).filter(|_| all_met);
        let Some((level, _)) = shared else { continue };
        let targets: Vec<&Target> = parts.targets.iter().filter(|t| t.level == level).collect();
        // Two frames with the same target were reported.
        let at = |t: &&Target| report::place(c, t.member.task, "position");
        let same = targets.iter().any(|t| known.iter().any(|d| d.code == "HQ0624" && d.primary.span == at(t)));
        if same || targets.iter().any(|t| told.contains(&t.member.task)) {
            continue;
        }
        if let Found::Missed(missed) = examine(c, stack, &parts, &targets, &parts.limits_of(level)) {
            told.extend(targets.iter().map(|t| t.member.task));
            out.push(report::level(c, &missed, level, &targets));
        }
    }
}

/// Moments of a motion, with irregular distances, so that a periodic one is not always met in one phase.
fn moments(duration: f64) -> impl Iterator<Item = f64> {
    let part = move |k: usize| duration * (k as f64 + (0.618 * k as f64).fract()) / MOMENTS as f64;
    (0..MOMENTS).map(part).chain([duration])
}

/// Result of a search.
enum Found {
    /// There is nothing to search.
    Nothing,
    /// The targets are met at these moments; none for targets that stand still.
    Met(Vec<Moment>),
    /// They are not met.
    Missed(Missed),
}

/// Searches postures at which the targets are met: at their goals, and at moments of the run.
fn examine(c: &Checked, stack: usize, parts: &StackParts, targets: &[&Target], limits: &[MemberProgram]) -> Found {
    let members: Vec<MemberProgram> = targets.iter().map(|t| t.member.clone()).collect();
    let goals: Option<Vec<Vec<FixedValue>>> = targets.iter().map(|t| t.goal.clone()).collect();
    let still = goals.as_ref().is_some_and(|goals| goals.iter().all(Vec::is_empty));
    if let Some(goals) = goals {
        let fixed = goals.concat();
        let found = search(c, &Parts { stack, limits, targets: &members, fixed: &fixed }, parts, &[0.0]);
        if let Found::Missed(_) = found {
            return found;
        }
    }
    if still || !targets.iter().all(|t| t.timed) {
        return Found::Nothing;
    }
    let all: Vec<f64> = moments(parts.duration).collect();
    search(c, &Parts { stack, limits, targets: &members, fixed: &[] }, parts, &all)
}

/// Searches a posture at each moment.
fn search(c: &Checked, parts: &Parts, of_stack: &StackParts, moments: &[f64]) -> Found {
    let Some(mut search) = PostureSearch::new(c.program, parts) else { return Found::Nothing };
    let mut q = c.program.robot.home.clone();
    let mut met = Vec::new();
    for &t in moments {
        let Some(from_here) = search.descend(q.clone(), t) else { return Found::Nothing };
        let stuck = from_here.still && of_stack.at_home && t == 0.0;
        let best = match from_here.is_good() {
            true => from_here.clone(),
            false => match search.from(&q, t) {
                Some(best) => best,
                None => return Found::Nothing,
            },
        };
        if !best.is_good() {
            return Found::Missed(missed(c, parts, &mut search, best, t));
        }
        if !from_here.is_good() && stuck {
            return Found::Missed(Missed::stuck(&search, parts, from_here));
        }
        if of_stack.at_home && t == 0.0 && search.half_turn(&c.program.robot.home, t) {
            return Found::Missed(Missed::half_turn(&search, parts, from_here));
        }
        q = best.q;
        met.push(Moment { q: q.clone(), t });
    }
    Found::Met(met)
}

/// Warns of the first limit that moves to where no posture keeps it together with the constant limits.
fn moving_limits(c: &Checked, stack: usize, parts: &StackParts, told: &mut BTreeSet<usize>) -> Option<Diagnostic> {
    for member in parts.moving_limits.iter().filter(|m| !told.contains(&m.task)) {
        let limits: Vec<MemberProgram> =
            parts.limits.iter().map(|l| l.member.clone()).chain([member.clone()]).collect();
        let of_stack = Parts { stack, limits: &limits, targets: &[], fixed: &[] };
        let mut search = PostureSearch::new(c.program, &of_stack)?;
        let mut q = c.program.robot.home.clone();
        for t in moments(parts.duration) {
            let best = search.from(&q, t)?;
            if !best.is_good() {
                told.insert(member.task);
                return Some(report::moving_limit(
                    c,
                    &Missed::new(&search, &of_stack, best, Vec::new(), t),
                    member.task,
                ));
            }
            q = best.q;
        }
    }
    None
}

/// Finds the limits to blame for a target that is not met.
fn missed(c: &Checked, parts: &Parts, search: &mut PostureSearch, best: Posture, t: f64) -> Missed {
    let met_without = |without: &[MemberProgram]| {
        let reduced = Parts { limits: without, ..*parts };
        let mut search = PostureSearch::new(c.program, &reduced)?;
        search.from(&best.q, t).map(|p| p.is_good())
    };
    let mut blamed = Vec::new();
    if met_without(&[]) == Some(true) {
        let margins = search.margins(&best.q, t).unwrap_or_default();
        let mut near: Vec<usize> = (0..parts.limits.len()).collect();
        near.sort_by(|a, b| {
            let margin = |i: usize| margins.get(i).copied().unwrap_or(f64::INFINITY);
            margin(*a).total_cmp(&margin(*b))
        });
        let one = near.iter().copied().find(|&i| {
            let others: Vec<MemberProgram> =
                parts.limits.iter().enumerate().filter(|(k, _)| *k != i).map(|(_, l)| l.clone()).collect();
            met_without(&others) == Some(true)
        });
        blamed = match one {
            Some(i) => vec![parts.limits[i].task],
            None => near.iter().take(2).map(|&i| parts.limits[i].task).collect(),
        };
    }
    Missed::new(search, parts, best, blamed, t)
}
