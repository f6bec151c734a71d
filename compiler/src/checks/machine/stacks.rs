//! Compares the stacks of a machine: dropped limits, velocity jumps, growing reserves.

use std::collections::{BTreeMap, BTreeSet};

use dsl::{Diagnostic, Help, Snippet, Span};
use names::list;
use runtime::program::Program;
use stdlib_tasks::bound::Bound;
use stdlib_tasks::kinds::joint_acceleration_limits::KIND as LIMITS;
use stdlib_tasks::task::{RowKind, Task};

use super::fault_answers::moves;
use super::{Checked, is_fault};
use crate::analysis::stacks::Stacks;
use crate::checks::accelerations::AccelerationBounds;
use crate::checks::first_tick::millimetres;

/// Increases of a reserve below this size are ignored (m).
const SLIGHT: f64 = 1e-5;

impl Checked<'_> {
    pub(super) fn stacks(&self, diagnostics: &mut Vec<Diagnostic>) {
        self.dropped(diagnostics);
        self.jumps(diagnostics);
        self.reserves(diagnostics);
    }

    /// Stacks that may run before a transition of `state` is taken.
    fn before(&self, state: usize) -> BTreeSet<Option<usize>> {
        let inside = self.reached.iter().copied().filter(|&l| self.machine.path(l).any(|p| p == state));
        inside.map(|l| self.machine.stack(l)).collect()
    }

    /// Warns of limits of hard levels that some states keep and others do not.
    fn dropped(&self, diagnostics: &mut Vec<Diagnostic>) {
        let owners: Vec<usize> =
            self.reached.iter().copied().filter(|&s| self.machine.states[s].stack.is_some()).collect();
        let kept = |s: usize| -> BTreeSet<usize> {
            let Some(stack) = self.machine.states[s].stack else { return BTreeSet::new() };
            let levels = self.program.stacks[stack].levels.iter().filter(|l| l.hard);
            let tasks = levels.flat_map(|l| &l.members).map(|m| m.task);
            tasks.filter(|&t| self.row_kind(t) == Some(RowKind::Inequality)).collect()
        };
        let all: BTreeSet<usize> = owners.iter().flat_map(|&s| kept(s)).collect();
        let mut told: Vec<usize> = Vec::new();
        for &s in &owners {
            let Some(stack) = self.machine.states[s].stack.filter(|k| !told.contains(k)) else { continue };
            let stands = !moves(self.program, self.stacks, stack);
            // A robot that only stands has no acceleration to bound: it may stop at once.
            let needless = |t: usize| stands && self.program.tasks[t].kind == LIMITS.name;
            let lost = all.iter().copied().filter(|&t| !self.alike(stack, t) && !needless(t));
            let (soft, missing): (Vec<usize>, Vec<usize>) = lost.partition(|&t| self.holds(stack, t));
            let names = |tasks: Vec<usize>| list(tasks.iter().map(|&t| self.program.tasks[t].name.as_str()), 6);
            let at = self.places.stacks[s].unwrap_or(self.places.states[s]);
            if !(soft.is_empty() && missing.is_empty()) {
                told.push(stack);
            }
            if !missing.is_empty() {
                let text = format!("state `{}` lacks limits of other states: {}", self.name(s), names(missing));
                diagnostics.push(
                    Diagnostic::warning("HQ0708", at, text)
                        .note("in this state the robot may violate them")
                        .help(Help::with("add them to the stack too: {} keeps all other levels", [changed()])),
                );
            }
            if !soft.is_empty() {
                let text = format!(
                    "state `{}` has limits on a soft level that are hard in other states: {}",
                    self.name(s),
                    names(soft)
                );
                diagnostics.push(
                    Diagnostic::warning("HQ0708", at, text)
                        .note("in this state the robot may violate them, because a soft level has slack")
                        .help(Help::each(
                            "write `hard` after the name of their level, or move them to a hard level",
                            "write `hard: true` into their level, or move them to a hard level",
                        )),
                );
            }
        }
    }

    /// True if a stack has a hard task that is equal to `task` under another name.
    fn alike(&self, stack: usize, task: usize) -> bool {
        let members = self.program.stacks[stack].levels.iter().filter(|l| l.hard).flat_map(|l| &l.members);
        members.into_iter().any(|m| self.program.same_task(m.task, task))
    }

    fn row_kind(&self, task: usize) -> Option<RowKind> {
        stdlib_tasks::find(&self.program.tasks[task].kind).map(|k| k.row_kind)
    }

    /// Warns of limits with a larger reserve in a stack than in a preceding one: the current margin may be smaller.
    fn reserves(&self, diagnostics: &mut Vec<Diagnostic>) {
        let mut kept: BTreeMap<usize, BTreeMap<usize, f64>> = BTreeMap::new();
        let mut told = BTreeSet::new();
        for &s in &self.reached {
            for (i, t) in self.machine.states[s].transitions.iter().enumerate() {
                let Some(to) = self.machine.stack(self.machine.leaf(t.target)) else { continue };
                for from in self.before(s).into_iter().flatten().filter(|from| *from != to) {
                    for stack in [from, to] {
                        kept.entry(stack).or_insert_with(|| reserves_of(self.program, self.stacks, stack));
                    }
                    for (&task, &more) in &kept[&to] {
                        let Some(&less) = kept[&from].get(&task).filter(|less| more > **less + SLIGHT) else {
                            continue;
                        };
                        if told.insert(task) {
                            let at = self.places.transitions[s][i].target;
                            diagnostics.push(self.larger_reserve(at, task, [from, to], [less, more]));
                        }
                    }
                }
            }
        }
    }

    fn larger_reserve(&self, at: Span, task: usize, stacks: [usize; 2], kept: [f64; 2]) -> Diagnostic {
        let [from, to] = stacks.map(|stack| &self.program.stacks[stack].name);
        let [less, more] = kept.map(millimetres);
        let name = &self.program.tasks[task].name;
        Diagnostic::warning("HQ0505", at, format!("`{name}` needs a larger reserve in stack `{to}` than in `{from}`"))
            .here(format!("{more} here, {less} before"))
            .note(
                "a robot that comes with less than the reserve is pushed away at once; where limits push against each other, a \
                 hard level ends in a fault",
            )
            .help("let both stacks have the same speed limits, or leave `sampled_margin` out, so that the limit looks ahead instead")
    }

    /// Warns of transitions to another stack without a blend, at which velocities may jump.
    fn jumps(&self, diagnostics: &mut Vec<Diagnostic>) {
        let (mut found, mut entered) = (Vec::new(), BTreeMap::new());
        for &s in &self.reached {
            for (i, t) in self.machine.states[s].transitions.iter().enumerate() {
                if is_fault(&t.trigger) || self.is_dead(s, i) || self.places.transitions[s][i].blend {
                    continue;
                }
                let to = self.machine.leaf(t.target);
                let from = self.before(s);
                let other = from.iter().any(|f| f.is_some() && *f != self.machine.stack(to));
                let Some(stack) = self.machine.stack(to).filter(|_| other) else { continue };
                let entered =
                    entered.entry(stack).or_insert_with(|| AccelerationBounds::of(self.program, self.stacks, stack));
                if !is_bounded_or_reported(self.program, entered, &from, stack) {
                    found.push(self.places.transitions[s][i].target);
                }
            }
        }
        let Some(&first) = found.first() else { return };
        let text = match found.len() {
            1 => "here the velocity may jump".to_string(),
            2 => "here the velocity may jump, and at one other transition".to_string(),
            n => format!("here the velocity may jump, and at {} other transitions", n - 1),
        };
        diagnostics.push(
            Diagnostic::warning("HQ0709", first, text)
                .note("the next stack starts at once, with another velocity")
                .help(Help::with(
                    "write {} in the machine, in a state or in a transition; {} if this is intended",
                    [Snippet::entry("blend", "0.3 s"), Snippet::entry("blend", "0 s")],
                )),
        );
    }
}

/// A stack that is declared as changes of another one.
fn changed() -> Snippet {
    Snippet::each(
        "stack B from A { replace LEVEL { .. } }",
        "stacks: { B: { from: A, changes: [ { replace: LEVEL, .. } ] } }",
    )
}

/// Largest reserve (m) of each limit on a hard level of a stack that computes its own reserve.
fn reserves_of(program: &Program, stacks: &Stacks, index: usize) -> BTreeMap<usize, f64> {
    let hard = program.stacks[index].levels.iter().flat_map(|l| l.members.iter().map(move |m| (l.hard, m.task)));
    let built = hard.zip(stacks.tasks(index)).filter(|((hard, task), _)| {
        *hard && matches!(program.tasks[*task].params.get("sampled_margin"), Some(Bound::Choice(_)))
    });
    let largest = |task: &dyn Task| task.sampled_margin().into_iter().fold(0.0, f64::max);
    built.filter_map(|((_, task), built)| Some((task, largest(built.task.as_ref().ok()?.as_ref())))).collect()
}

/// Returns true if the stack `to` bounds the accelerations of all joints that are free in it or in a preceding stack,
/// or if HQ0525 already reports it.
fn is_bounded_or_reported(
    program: &Program,
    entered: &AccelerationBounds,
    from: &BTreeSet<Option<usize>>,
    to: usize,
) -> bool {
    let free = |stack: usize, dof: usize| !program.stacks[stack].locked.contains(&dof);
    let all = (0..program.robot.model.nv()).filter(|&d| free(to, d) || from.iter().flatten().any(|&f| free(f, d)));
    entered.may_jump() || entered.bounds(all)
}
