//! Targets that the robot does not get to: beyond its reach, or excluded by limits or by other targets of their level.
//!
//! The numbers of the spec decide, without a run: a search looks for a posture at which a target is met within the limits of
//! its stack, see [`PostureSearch`]. A target that moves is examined at some moments.

mod half_turns;
mod pace;
mod parts;
mod report;

use std::collections::BTreeSet;

use dsl::Diagnostic;
use runtime::program::{MemberProgram, Program};

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
    let stacks = (0..c.program.stacks.len()).filter(moves);
    let all: Vec<Examined> = stacks.map(|stack| Examined::new(c, stack, &told, &mut searched)).collect();
    let found = in_threads(&all, |of| of.search(c.program));
    for (of, found) in all.iter().zip(found) {
        report_stack(c, of, found, &mut told, known, out);
    }
    half_turns::check(c, &mut told, out);
}

/// A stack, and what is searched in it.
struct Examined {
    stack: usize,
    parts: StackParts,
    /// Targets that are searched, as indices into those of the stack: stacks often share targets and limits.
    targets: Vec<usize>,
    /// Velocities of joints that are examined, likewise.
    velocities: Vec<usize>,
}

/// Results of the searches in a stack, one for each target and velocity that is examined.
struct FoundInStack {
    targets: Vec<FoundTarget>,
    velocities: Vec<Option<pace::Finding>>,
}

/// Result for a target.
enum FoundTarget {
    /// Nothing is wrong.
    Good,
    /// No posture meets it.
    Missed(Missed),
    /// It is too fast.
    TooFast(pace::Finding),
}

/// The inputs of a search.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct SearchKey {
    task: usize,
    limits: Vec<usize>,
    locked: Vec<usize>,
    at_home: bool,
}

impl Examined {
    fn new(c: &Checked, stack: usize, told: &BTreeSet<usize>, searched: &mut BTreeSet<SearchKey>) -> Examined {
        let parts = StackParts::new(c, stack);
        let is_new = |target: &Target| {
            let task = target.member.task;
            let limits: Vec<usize> = parts.limits_of(target.level).iter().map(|l| l.task).collect();
            let locked = c.program.stacks[stack].locked.clone();
            !told.contains(&task) && searched.insert(SearchKey { task, limits, locked, at_home: parts.at_home })
        };
        let is_new: Vec<bool> = parts.targets.iter().map(is_new).collect();
        let targets = (0..parts.targets.len()).filter(|&i| is_new[i]).collect();
        let velocities = (0..parts.velocities.len()).filter(|&i| !told.contains(&parts.velocities[i].member.task));
        Examined { stack, velocities: velocities.collect(), targets, parts }
    }

    fn search(&self, program: &Program) -> FoundInStack {
        let Examined { stack, parts, .. } = self;
        let target = |&i: &usize| {
            let target = &parts.targets[i];
            match examine(program, *stack, parts, &[target], &parts.limits_of(target.level)) {
                Found::Nothing => FoundTarget::Good,
                Found::Missed(missed) => FoundTarget::Missed(missed),
                Found::Met(moments) => pace::of_target(program, *stack, &parts.joint_limits, &target.member, &moments)
                    .map_or(FoundTarget::Good, FoundTarget::TooFast),
            }
        };
        let home = &program.robot.home;
        let moments: Vec<Moment> = moments(parts.duration).map(|t| Moment { q: home.clone(), t }).collect();
        let velocity = |&i: &usize| {
            pace::of_velocity(program, *stack, &parts.joint_limits, &parts.velocities[i], parts.duration, &moments)
        };
        FoundInStack {
            targets: self.targets.iter().map(target).collect(),
            velocities: self.velocities.iter().map(velocity).collect(),
        }
    }
}

/// Most threads that share the searches.
const THREADS: usize = 8;

/// Applies a function to all items, in several threads if there are many. The order of the results is that of the items.
fn in_threads<T: Sync, R: Send>(all: &[T], run: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let available = std::thread::available_parallelism().map_or(1, |n| n.get());
    let threads = available.min(THREADS).min(all.len());
    if threads < 2 {
        return all.iter().map(run).collect();
    }
    // Neighbours in the text take equally long.
    let part = |first: usize| -> Vec<R> { all.iter().skip(first).step_by(threads).map(&run).collect() };
    let parts: Vec<Vec<R>> = std::thread::scope(|scope| {
        let part = &part;
        let all: Vec<_> = (0..threads).map(|first| scope.spawn(move || part(first))).collect();
        // A thread that panicked has told why.
        all.into_iter().map(|t| t.join().unwrap_or_else(|why| std::panic::resume_unwind(why))).collect()
    });
    let mut parts: Vec<_> = parts.into_iter().map(Vec::into_iter).collect();
    (0..all.len()).filter_map(|i| parts[i % threads].next()).collect()
}

fn report_stack(
    c: &Checked,
    of: &Examined,
    found: FoundInStack,
    told: &mut BTreeSet<usize>,
    known: &[Diagnostic],
    out: &mut Vec<Diagnostic>,
) {
    let Examined { stack, parts, .. } = of;
    let mut all_met = true;
    for (&i, found) in of.targets.iter().zip(found.targets) {
        let target = &parts.targets[i];
        // Another stack may have the same target.
        if told.contains(&target.member.task) {
            continue;
        }
        let d = match found {
            FoundTarget::Good => continue,
            FoundTarget::Missed(missed) => {
                all_met = false;
                report::target(c, &missed, target)
            }
            FoundTarget::TooFast(finding) => pace::warning(c, &target.member, &finding, parts.duration),
        };
        told.insert(target.member.task);
        out.push(d);
    }
    out.extend(moving_limits(c, *stack, parts, told));
    for (&i, found) in of.velocities.iter().zip(found.velocities) {
        let member = &parts.velocities[i].member;
        if let Some(finding) = found
            && told.insert(member.task)
        {
            out.push(pace::warning(c, member, &finding, parts.duration));
        }
    }
    let Some((level, _)) = shared_level(&c.program.stacks[*stack].levels, parts).filter(|_| all_met) else { return };
    let targets: Vec<&Target> = parts.targets.iter().filter(|t| t.level == level).collect();
    // Two frames with the same target were reported.
    let at = |t: &&Target| report::place(c, t.member.task, "position");
    let same = targets.iter().any(|t| known.iter().any(|d| d.code == "HQ0624" && d.primary.span == at(t)));
    if same || targets.iter().any(|t| told.contains(&t.member.task)) {
        return;
    }
    if let Found::Missed(missed) = examine(c.program, *stack, parts, &targets, &parts.limits_of(level)) {
        told.extend(targets.iter().map(|t| t.member.task));
        out.push(report::level(c, &missed, level, &targets));
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
fn examine(
    program: &Program,
    stack: usize,
    parts: &StackParts,
    targets: &[&Target],
    limits: &[MemberProgram],
) -> Found {
    let members: Vec<MemberProgram> = targets.iter().map(|t| t.member.clone()).collect();
    let goals: Option<Vec<Vec<FixedValue>>> = targets.iter().map(|t| t.goal.clone()).collect();
    let still = goals.as_ref().is_some_and(|goals| goals.iter().all(Vec::is_empty));
    if let Some(goals) = goals {
        let fixed = goals.concat();
        let found = search(program, &Parts { stack, limits, targets: &members, fixed: &fixed }, parts, &[0.0]);
        if let Found::Missed(_) = found {
            return found;
        }
    }
    if still || !targets.iter().all(|t| t.timed) {
        return Found::Nothing;
    }
    let all: Vec<f64> = moments(parts.duration).collect();
    search(program, &Parts { stack, limits, targets: &members, fixed: &[] }, parts, &all)
}

/// Searches a posture at each moment.
fn search(program: &Program, parts: &Parts, of_stack: &StackParts, moments: &[f64]) -> Found {
    let Some(mut search) = PostureSearch::new(program, parts) else { return Found::Nothing };
    let mut q = program.robot.home.clone();
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
            return Found::Missed(missed(program, parts, &mut search, best, t));
        }
        if !from_here.is_good() && stuck {
            return Found::Missed(Missed::stuck(&search, parts, from_here));
        }
        if of_stack.at_home && t == 0.0 && search.half_turn(&program.robot.home, t).is_some() {
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
fn missed(program: &Program, parts: &Parts, search: &mut PostureSearch, best: Posture, t: f64) -> Missed {
    let met_without = |without: &[MemberProgram]| {
        let reduced = Parts { limits: without, ..*parts };
        let mut search = PostureSearch::new(program, &reduced)?;
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
