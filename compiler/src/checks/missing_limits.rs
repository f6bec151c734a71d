//! Warns of stacks that move joints whose speed or position no hard level bounds.
//!
//! The hierarchy returns any velocity that meets its rows. Without a limit of velocities a distant target asks for more than
//! a joint can do, and without one of positions a motion of the hand runs joints into their stops. Targets of single joints
//! are compared with the joint's range elsewhere, so positions count where the rows of a target couple joints.

use std::collections::BTreeSet;

use dsl::{Diagnostic, Help, Snippet, Span};
use names::list;
use runtime::Member;
use runtime::program::{MemberProgram, Program, StackProgram};
use stdlib_tasks::kinds::{joint_position_limits, joint_velocity, joint_velocity_limits};
use stdlib_tasks::task::RowKind;

use super::{Checked, accelerations, coverage};
use crate::analysis::stacks::Signals;
use crate::demands::JointQuantity;

/// Coefficient of a row up to which a joint has no part in it.
const NOTHING: f64 = 1e-9;

/// Warns of each stack that runs; once for stacks that share the level of their limits.
pub(super) fn check(c: &Checked, out: &mut Vec<Diagnostic>) {
    let mut told: BTreeSet<Span> = BTreeSet::new();
    for stack in c.program.run_stacks() {
        let Some(compiled) = c.program.stacks.get(stack) else { continue };
        let Some(&mover) = accelerations::moving_targets(c.program, stack).first() else { continue };
        let bounds = [Quantity::Velocity, Quantity::Position].map(|q| (q, Bounds::of(c, stack, q)));
        let Some(moved) = Moved::of(c, stack, &bounds[1].1) else { continue };
        let open = bounds.map(|(quantity, bounds)| Open::new(c.program, quantity, bounds, &moved));
        // A `coverage` that demands these limits reports what is missing, and says whether they may be soft.
        let open: Vec<Open> =
            open.into_iter().filter(|o| !coverage::demands_of_joints(c, stack, o.quantity.demanded())).collect();
        let (name, levels) = &c.places.stacks[stack];
        let at = |level: Option<usize>| level.and_then(|k| levels.get(k)).copied().unwrap_or(*name);
        // A derived stack has a copy of the original's text, so spans are compared in the original source.
        let mut once = |at: Span| told.insert(Span { source: c.sources.text_of(at.source), ..at });
        let of_mover = |d: Diagnostic| d.label(c.places.tasks[mover].span, "this moves the robot");
        if let Some(level) = open.iter().find_map(Open::soft_level)
            && once(at(Some(level)))
        {
            out.push(of_mover(soft(compiled, level, at(Some(level)), &open)));
        }
        let missing: Vec<&Open> = open.iter().filter(|o| o.is_missing()).collect();
        let limits = at(accelerations::level_of_limits(compiled, c.program));
        if !missing.is_empty() && once(limits) {
            out.push(of_mover(absent(c.program, compiled, limits, &missing)));
        }
    }
}

/// A quantity of joints that a robot's description limits.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Quantity {
    Velocity,
    Position,
}

impl Quantity {
    /// Name in messages.
    fn name(self) -> &'static str {
        match self {
            Quantity::Velocity => "velocities",
            Quantity::Position => "positions",
        }
    }

    /// Task type that limits it.
    fn kind(self) -> &'static str {
        match self {
            Quantity::Velocity => joint_velocity_limits::KIND.name,
            Quantity::Position => joint_position_limits::KIND.name,
        }
    }

    /// The quantity in a `coverage`.
    fn demanded(self) -> JointQuantity {
        match self {
            Quantity::Velocity => JointQuantity::Velocity,
            Quantity::Position => JointQuantity::Position,
        }
    }

    /// True if the robot's description limits it for a degree of freedom.
    fn is_limited(self, program: &Program, dof: usize) -> bool {
        program.robot.model.dofs.get(dof).is_some_and(|d| match self {
            Quantity::Velocity => d.velocity.is_finite(),
            Quantity::Position => d.lower.is_finite() && d.upper.is_finite(),
        })
    }
}

/// Degrees of freedom of which the tasks of a stack bound a quantity.
struct Bounds {
    /// Those of hard levels, and of soft ones whose rows cannot contradict each other.
    hard: BTreeSet<usize>,
    /// Those of other soft levels.
    soft: BTreeSet<usize>,
    /// The first soft level with such a task.
    soft_level: Option<usize>,
}

impl Bounds {
    fn of(c: &Checked, index: usize, quantity: Quantity) -> Bounds {
        let (program, stack) = (c.program, &c.program.stacks[index]);
        let levels = stack.levels.iter().enumerate();
        let members = levels.flat_map(|(k, l)| l.members.iter().map(move |m| (k, l.hard, m)));
        let mut bounds = Bounds { hard: BTreeSet::new(), soft: BTreeSet::new(), soft_level: None };
        let of_range = |m: &MemberProgram| {
            [Quantity::Velocity, Quantity::Position].iter().any(|q| q.kind() == program.tasks[m.task].kind)
        };
        let others = stack.levels.iter().position(|l| !l.members.iter().all(of_range)).unwrap_or(usize::MAX);
        for ((level, hard, member), built) in members.zip(c.stacks.tasks(index)) {
            let Ok(made) = &built.task else { continue };
            let dofs: Vec<usize> = match quantity {
                Quantity::Velocity => made.speed_limits(&program.values.initial).iter().map(|s| s.0).collect(),
                Quantity::Position if program.tasks[member.task].kind == quantity.kind() => {
                    made.degrees_of_freedom().unwrap_or_default()
                }
                Quantity::Position => Vec::new(),
            };
            if dofs.is_empty() {
                continue;
            }
            // Ranges of positions and velocities, with nothing else above or beside them, all hold at once: zero is in each.
            if hard || level < others {
                bounds.hard.extend(dofs);
            } else {
                bounds.soft.extend(dofs);
                bounds.soft_level = bounds.soft_level.or(Some(level));
            }
        }
        bounds
    }
}

/// Degrees of freedom in the rows of a stack.
struct Moved {
    /// Those that targets move.
    all: BTreeSet<usize>,
    /// Those that share a row of a target with others.
    coupled: BTreeSet<usize>,
    /// Those that a limit of its own keeps inside a part of their range, such as that of a joint's angle.
    kept: BTreeSet<usize>,
}

impl Moved {
    /// Evaluates the rows at some configurations; `None` if that is not possible.
    fn of(c: &Checked, stack: usize, positions: &Bounds) -> Option<Moved> {
        let (program, members) = (c.program, c.stacks.members(stack));
        if members.is_empty() {
            return None;
        }
        let mut moved = Moved { all: BTreeSet::new(), coupled: BTreeSet::new(), kept: positions.hard.clone() };
        let (levels, locked) = (&program.stacks[stack].levels, &program.stacks[stack].locked);
        for sample in c.stacks.samples(stack, Signals::Present) {
            let problem = sample.problem();
            let dofs_of = |m: &Member, r: usize| -> Vec<usize> {
                let row = problem.levels[m.level].row(r);
                let free = (0..program.robot.model.nv()).filter(|dof| !locked.contains(dof));
                free.filter(|&dof| row[dof].abs() > NOTHING).collect()
            };
            for m in members {
                for r in m.rows.clone() {
                    let dofs = dofs_of(m, r);
                    match (m.row_kind, dofs.as_slice()) {
                        (RowKind::Equality, [one]) if m.kind == joint_velocity::KIND.name => {
                            let wanted = problem.levels[m.level].lower[r].abs();
                            let constant = m.slots.iter().all(|&at| !changes(program, at));
                            let slow = program.robot.model.dofs.get(*one).is_some_and(|d| wanted <= d.velocity);
                            moved.all.extend(Some(*one).filter(|_| !(constant && slow)));
                        }
                        (RowKind::Equality, _) => {
                            moved.coupled.extend(dofs.iter().filter(|_| dofs.len() > 1));
                            moved.all.extend(dofs);
                        }
                        // Limits of velocities and accelerations have infinite margins at rest.
                        (RowKind::Inequality, [one]) if levels[m.level].hard => {
                            let margin = sample.margins.get(m.margins.start + (r - m.rows.start));
                            moved.kept.extend(Some(*one).filter(|_| margin.is_some_and(|h| h.is_finite())));
                        }
                        _ => {}
                    }
                }
            }
        }
        Some(moved)
    }
}

/// True if a place of the table of values changes with time.
fn changes(program: &Program, at: usize) -> bool {
    program.values.tape.outputs.iter().any(|o| o.at == at)
}

/// Degrees of freedom that a stack moves without a hard bound of a quantity.
struct Open {
    quantity: Quantity,
    bounds: Bounds,
    /// The degrees of freedom.
    dofs: BTreeSet<usize>,
    /// True if the stack also moves some with a hard bound.
    partial: bool,
}

impl Open {
    fn new(program: &Program, quantity: Quantity, bounds: Bounds, moved: &Moved) -> Open {
        let (moved, bounded) = match quantity {
            Quantity::Velocity => (&moved.all, &bounds.hard),
            Quantity::Position => (&moved.coupled, &moved.kept),
        };
        let dofs = moved.difference(bounded).copied().filter(|&dof| quantity.is_limited(program, dof)).collect();
        let partial = !moved.is_disjoint(bounded);
        Open { quantity, dofs, partial, bounds }
    }

    /// The soft level whose limits are the only ones.
    fn soft_level(&self) -> Option<usize> {
        let only = !self.partial && !self.dofs.is_disjoint(&self.bounds.soft);
        self.bounds.soft_level.filter(|_| only)
    }

    /// True if no task at all bounds the quantity. Speed limits of some joints are another warning.
    fn is_missing(&self) -> bool {
        let some = self.partial && self.quantity == Quantity::Velocity;
        !self.dofs.is_empty() && self.soft_level().is_none() && !some
    }
}

fn soft(stack: &StackProgram, level: usize, at: Span, open: &[Open]) -> Diagnostic {
    let quantities: Vec<&str> = open.iter().filter(|o| o.soft_level().is_some()).map(|o| o.quantity.name()).collect();
    let name = &stack.levels[level].name;
    let text = format!("the limits of joint {} are on the soft level `{name}`", quantities.join(" and "));
    Diagnostic::warning("HQ0561", at, text)
        .here("a soft level has slack")
        .note("limits that cannot hold together are weighed against each other, and the reference passes them")
        .help(Help::each(format!("write `level {name} hard`"), format!("write `hard: true` into level `{name}`")))
}

fn absent(program: &Program, stack: &StackProgram, at: Span, missing: &[&Open]) -> Diagnostic {
    let names = |open: &Open| {
        let dofs = &program.robot.model.dofs;
        list(open.dofs.iter().filter_map(|&dof| Some(dofs.get(dof)?.name.as_str())), 3)
    };
    let text = match missing {
        [one] if one.partial => {
            format!("no limit bounds the {} of {} in stack `{}`", one.quantity.name(), names(one), stack.name)
        }
        _ => {
            let quantities: Vec<&str> = missing.iter().map(|o| o.quantity.name()).collect();
            format!("no limit bounds the joint {} of stack `{}`", quantities.join(" and "), stack.name)
        }
    };
    let consequence = |o: &&Open| match o.quantity {
        Quantity::Velocity => "the reference may be faster than the joints, which then lag behind it",
        Quantity::Position => "a target of the hand can run a joint into its stop",
    };
    let mut d = Diagnostic::warning("HQ0560", at, text);
    for o in missing {
        d = d.note(consequence(o));
    }
    let kinds: Vec<&str> = missing.iter().map(|o| o.quantity.kind()).collect();
    match accelerations::level_of_limits(stack, program) {
        Some(k) => {
            let kinds: Vec<String> = kinds.iter().map(|k| format!("`{k}`")).collect();
            d.help(format!("add {} to level `{}`", kinds.join(" and "), stack.levels[k].name))
        }
        None => {
            let level = Snippet::each(
                format!("level limits hard {{ {} }}", kinds.join("  ")),
                format!("{{ name: limits, hard: true, tasks: [{}] }}", kinds.join(", ")),
            );
            d.help(Help::with("begin the stack with {}", [level]))
        }
    }
}
