//! Finds stacks whose tasks move joints without a limit of their accelerations on a higher level.
//!
//! The reference takes the velocity `v` that the hierarchy returns at each tick. Without rows
//! `|v - v_last| <= a_max T`, a target that jumps, a limit that becomes active or a level that loses its freedom
//! changes `v` from one tick to the next by up to twice the speed limit. Limits of accelerations count on hard levels,
//! and on soft levels above the first target. There, a soft level yields only to hard limits, and beside limits of
//! distances it has to be able to yield (mathematics, limits).

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet, Span};
use names::list;
use runtime::Member;
use runtime::program::{MemberProgram, Op, Program, StackProgram, Tape, TaskProgram};
use stdlib_tasks::bound::Bound;
use stdlib_tasks::kinds::joint_acceleration_limits::KIND as LIMITS;
use stdlib_tasks::task::RowKind;

use super::Checked;
use crate::analysis::stacks::{Signals, Stacks};
use crate::source_map::SourceMap;

/// Joints that a stack moves, and joints whose acceleration it bounds.
pub(crate) struct AccelerationBounds {
    /// Degrees of freedom whose acceleration the stack bounds.
    bounded: BTreeSet<usize>,
    /// Degrees of freedom that its tasks move without a bound of the acceleration.
    unbounded: BTreeSet<usize>,
    /// True if its tasks also move degrees of freedom whose acceleration it bounds.
    partial: bool,
    /// Index in the program of the first task that moves the robot.
    moving_task: Option<usize>,
    /// Index in the program of a limit of accelerations that is too low in the stack to bound the moving tasks.
    ineffective: Option<usize>,
}

impl AccelerationBounds {
    /// Computes the bounds for the stack `index` of a program without errors.
    pub(crate) fn of(program: &Program, stacks: &Stacks, index: usize) -> AccelerationBounds {
        let (stack, model) = (&program.stacks[index], &program.robot.model);
        let members =
            || stack.levels.iter().enumerate().flat_map(|(k, l)| l.members.iter().map(move |m| (k, l.hard, m)));
        let movers = movers(program, stack);
        let target = |m: &MemberProgram| row_kind(program, m.task) == Some(RowKind::Equality);
        let first = members().find(|(_, _, m)| target(m)).map_or(usize::MAX, |m| m.0);
        let all = stacks.tasks(index);
        let (mut bounded, mut ineffective) = (BTreeSet::new(), None);
        for ((level, hard, m), built) in members().zip(all) {
            let limits = built.task.as_ref().map(|t| t.acceleration_limits()).unwrap_or_default();
            if hard || level < first {
                bounded.extend(limits.iter().map(|l| l.0));
            } else if !limits.is_empty() {
                ineffective = ineffective.or(Some(m.task));
            }
        }
        let free: BTreeSet<usize> = (0..model.nv()).filter(|dof| !stack.locked.contains(dof)).collect();
        let (mut unbounded, mut partial) = (BTreeSet::new(), false);
        // Without a target the robot stands still, and at most yields to limits.
        if !movers.is_empty() && first < usize::MAX && !free.is_subset(&bounded) {
            let moved: BTreeSet<usize> =
                moved_dofs(program, stacks, index, &movers, 0.0).intersection(&free).copied().collect();
            unbounded = moved.difference(&bounded).copied().collect();
            partial = unbounded.len() < moved.len();
        }
        AccelerationBounds { bounded, unbounded, partial, moving_task: movers.first().copied(), ineffective }
    }

    /// Returns true if velocities may jump from one tick to the next while the stack runs.
    pub(crate) fn may_jump(&self) -> bool {
        !self.unbounded.is_empty()
    }

    /// Returns true if the stack bounds the accelerations of all these degrees of freedom.
    pub(crate) fn bounds(&self, mut dofs: impl Iterator<Item = usize>) -> bool {
        dofs.all(|dof| self.bounded.contains(&dof))
    }
}

/// Targets of a stack that move the robot by themselves: they differ from the state at entry, or change. In stack order.
pub(super) fn moving_targets(program: &Program, stack: usize) -> Vec<usize> {
    let origins = Origins::of(&program.values.tape);
    let members = program.stacks[stack].levels.iter().flat_map(|l| &l.members).map(|m| m.task);
    let targets = members.filter(|&task| row_kind(program, task) == Some(RowKind::Equality));
    targets.filter(|&task| moves(program, &origins, task)).collect()
}

/// Returns the tasks of a stack that move the robot by themselves, in the order of the levels.
pub(super) fn movers(program: &Program, stack: &StackProgram) -> Vec<usize> {
    let origins = Origins::of(&program.values.tape);
    let members = stack.levels.iter().flat_map(|l| &l.members);
    members.map(|m| m.task).filter(|&task| moves(program, &origins, task)).collect()
}

fn row_kind(program: &Program, task: usize) -> Option<RowKind> {
    stdlib_tasks::find(&program.tasks[task].kind).map(|kind| kind.row_kind)
}

/// Returns true if a task moves the robot by itself: a target that differs from the state at entry, or a moving limit.
fn moves(program: &Program, origins: &Origins, index: usize) -> bool {
    let task = &program.tasks[index];
    let (mut changes, mut captured) = (false, true);
    for (name, bound) in task.params.iter() {
        let slots = bound.slots();
        let mut places = slots.iter().flat_map(|s| s.at..s.at + s.len);
        changes |= matches!(bound, Bound::Field(_)) || places.clone().any(|at| origins.changing.contains(&at));
        captured &= name == "gain" || places.all(|at| origins.captured.contains(&at));
    }
    match row_kind(program, index) {
        Some(RowKind::Equality) => changes || !(captured || stops(program, task)),
        // `speed_separation` bounds how fast the robot approaches, so a robot at rest meets it.
        Some(RowKind::Inequality) => changes && task.kind != "speed_separation",
        None => false,
    }
}

/// Places of the table of values whose numbers are not constant.
struct Origins {
    /// Places that depend on time, signals or variables.
    changing: BTreeSet<usize>,
    /// Places that are captured when the stack is entered, and constant from then on.
    captured: BTreeSet<usize>,
}

impl Origins {
    fn of(tape: &Tape) -> Origins {
        let mut changes = vec![false; tape.ops.len()];
        // Operands precede their users, so one pass suffices.
        for (i, op) in tape.ops.iter().enumerate() {
            changes[i] = matches!(op, Op::T | Op::Time | Op::State(_) | Op::Signal(_) | Op::Trajectory(_))
                || op.operands().into_iter().flatten().any(|a| changes[a]);
        }
        let places =
            |test: &dyn Fn(usize) -> bool| tape.outputs.iter().filter(|o| test(o.value)).map(|o| o.at).collect();
        Origins {
            changing: places(&|value| changes[value]),
            captured: places(&|value| matches!(tape.ops[value], Op::Input(_))),
        }
    }
}

/// Returns true for a target velocity that is the constant zero.
fn stops(program: &Program, task: &TaskProgram) -> bool {
    let zero = |at: usize| program.values.initial.get(at) == Some(&0.0);
    task.kind == "joint_velocity"
        && task.params.values().flat_map(|b| b.slots()).all(|s| (s.at..s.at + s.len).all(zero))
}

/// Returns the degrees of freedom in the rows of a stack's targets and of its moving tasks; all of them if the rows
/// cannot be computed. `least` is the magnitude (m/rad, or of another row) above which a coefficient counts.
pub(super) fn moved_dofs(
    program: &Program,
    stacks: &Stacks,
    stack: usize,
    movers: &[usize],
    least: f64,
) -> BTreeSet<usize> {
    let mut found = BTreeSet::new();
    let mut computed = false;
    let counts = |m: &&Member| m.row_kind == RowKind::Equality || movers.contains(&m.program_index);
    for sample in stacks.samples(stack, Signals::Absent) {
        computed = true;
        for row in stacks.members(stack).iter().filter(counts).flat_map(|m| sample.rows(m)) {
            found.extend((0..row.len()).filter(|&dof| row[dof].abs() > least));
        }
    }
    if computed { found } else { (0..program.robot.model.nv()).collect() }
}

/// Returns the hard level of joint limits of a stack, or else its first hard level; `None` without a hard level.
pub(super) fn level_of_limits(stack: &StackProgram, program: &Program) -> Option<usize> {
    let hard = || stack.levels.iter().enumerate().filter(|(_, l)| l.hard);
    let of_joints = |m: &MemberProgram| {
        matches!(program.tasks[m.task].kind.as_str(), "joint_position_limits" | "joint_velocity_limits")
    };
    let joints = hard().find(|(_, l)| l.members.iter().any(of_joints));
    joints.or_else(|| hard().next()).map(|(k, _)| k)
}

/// Returns true if a stack keeps distances or other values of the whole robot on hard levels. Unlike limits of joints,
/// these limits can contradict limits of accelerations.
fn keeps_distances(stack: &StackProgram, program: &Program) -> bool {
    let members = stack.levels.iter().filter(|l| l.hard).flat_map(|l| &l.members);
    members.map(|m| &program.tasks[m.task]).any(|t| {
        !t.kind.starts_with("joint_") && stdlib_tasks::find(&t.kind).is_some_and(|k| k.row_kind == RowKind::Inequality)
    })
}

/// Warns of stacks that move joints without a bound of the acceleration; once for stacks that share a level of limits.
pub(super) fn check(c: &Checked, diagnostics: &mut Vec<Diagnostic>) {
    let (program, places, sources) = (c.program, c.places, c.sources);
    let mut found: Vec<Unbounded> = Vec::new();
    for (i, stack) in program.stacks.iter().enumerate() {
        let bounds = AccelerationBounds::of(program, &c.stacks, i);
        if !bounds.may_jump() {
            continue;
        }
        let (name, levels) = &places.stacks[i];
        let at = level_of_limits(stack, program).and_then(|k| levels.get(k)).copied().unwrap_or(*name);
        // A derived stack has a copy of the original's text, so spans are compared in the original source.
        let written = Span { source: sources.text_of(at.source), ..at };
        match found.iter_mut().find(|f| f.written == written) {
            Some(same) => same.others += 1,
            None => found.push(Unbounded { written, at, stack: i, bounds, others: 0 }),
        }
    }
    diagnostics.extend(found.iter().map(|f| warning(program, places, f)));
}

/// A stack to warn of, with the number of other stacks that share its level of limits.
struct Unbounded {
    written: Span,
    at: Span,
    stack: usize,
    bounds: AccelerationBounds,
    others: usize,
}

fn warning(program: &Program, places: &SourceMap, found: &Unbounded) -> Diagnostic {
    let (stack, model, bounds) = (&program.stacks[found.stack], &program.robot.model, &found.bounds);
    let more = match found.others {
        0 => String::new(),
        1 => ", and of one other stack".to_string(),
        n => format!(", and of {n} other stacks"),
    };
    let names = || bounds.unbounded.iter().map(|&d| model.dofs[d].name.as_str());
    let text = if !bounds.partial {
        format!("no limit bounds the joint accelerations of stack `{}`{more}", stack.name)
    } else {
        format!("no limit bounds the accelerations of {} in stack `{}`{more}", list(names(), 3), stack.name)
    };
    let mut d = Diagnostic::warning("HQ0525", found.at, text);
    if let Some(mover) = bounds.moving_task {
        d = d.label(places.tasks[mover].span, "this moves the robot");
    }
    if let Some(low) = bounds.ineffective {
        d = d.label(places.tasks[low].span, "this bounds only the freedom that the levels above leave");
    }
    d.note("a target that jumps or a limit that becomes active changes velocities within one tick, by up to twice the speed limit")
        .help(help(program, stack, bounds))
}

fn help(program: &Program, stack: &StackProgram, bounds: &AccelerationBounds) -> Help {
    let dofs = &program.robot.model.dofs;
    let limited = |d: usize| dofs[d].velocity.is_finite() && dofs[d].velocity > 0.0;
    if let Some(&first) = bounds.unbounded.iter().find(|&&d| !limited(d)) {
        let unit = if dofs[first].unit == robot::DofUnit::Metre { "m/s^2" } else { "rad/s^2" };
        return format!(
            "`{}` has no speed limit to take one from: add `joint_acceleration_limits` with `max {{ {} 10 {unit} }}`, or give the \
             joint a speed limit under `limits` of the robot",
            dofs[first].name, dofs[first].name
        )
        .into();
    }
    if bounds.ineffective.is_some() {
        return "move it to a level above the tasks that move the robot".into();
    }
    if keeps_distances(stack, program) {
        return Help::with(
            "write {} below the hard levels: from rest to its speed limit a joint then takes 0.1 s or more",
            [Snippet::level("gentle", false, LIMITS.name)],
        );
    }
    match level_of_limits(stack, program) {
        Some(k) => format!(
            "add `joint_acceleration_limits` to level `{}`: from rest to its speed limit a joint then takes 0.1 s or more",
            stack.levels[k].name
        )
        .into(),
        None => Help::with(
            "begin the stack with {}: from rest to its speed limit a joint then takes 0.1 s or more",
            [Snippet::level("limits", true, LIMITS.name)],
        ),
    }
}
