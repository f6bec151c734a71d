//! Preparation of a stack: tasks and the ranges of their numbers, the problem that they fill, planners and captures.

use std::collections::BTreeSet;

use robot::{Data, Dof, Model};
use solver::{LevelShape, Problem};
use stdlib_tasks::task::{BuildError, RowKind, Task};

use super::foresight::Foresight;
use super::{Built, Evaluator, JointLimits, LIMIT_TOLERANCE, Led, LedValue, Member, TaskOutputs, build_tasks, capture};
use crate::locked_joint_motion::LockedJointMotion;
use crate::planning::{self, Planning, Protection, TaskIndex};
use crate::program::{Capture, EqualTask, Program, ProgramError, StackProgram, TaskProgram, overshoots};
use crate::values::ValueTable;

/// Indices of the table of values that some tasks read. Values of other stacks are not computed and cause no faults.
fn places<'p>(tasks: impl Iterator<Item = &'p TaskProgram>) -> BTreeSet<usize> {
    let slots = tasks.flat_map(|t| t.params.values()).flat_map(|b| b.slots());
    slots.flat_map(|s| s.at..s.at + s.len).collect()
}

/// Position limits of joints, widened by [`LIMIT_TOLERANCE`].
fn limits(model: &Model) -> Vec<JointLimits> {
    let limited = model.dofs.iter().filter(|d| d.lower.is_finite() || d.upper.is_finite());
    let widened =
        |q_index, d: &Dof| JointLimits { q_index, lower: d.lower - LIMIT_TOLERANCE, upper: d.upper + LIMIT_TOLERANCE };
    limited.filter_map(|d| Some(widened(d.q_index?, d))).collect()
}

/// Writes the coefficients of rows that never change, once for all ticks.
fn write_constant(task: &dyn Task, member: &Member, locked: &[usize], problem: &mut Problem) {
    let Some(dofs) = task.degrees_of_freedom() else { return };
    let level = &mut problem.levels[member.level];
    for (row, dof) in member.rows.clone().zip(dofs) {
        if !locked.contains(&dof) {
            level.row_mut(row)[dof] = 1.0;
        }
    }
    level.fix(member.rows.clone());
}

/// Tasks of a stack and the ranges of their numbers, before there is a problem.
struct Layout {
    tasks: Vec<Box<dyn Task>>,
    members: Vec<Member>,
    shapes: Vec<LevelShape>,
    /// For each task of the stack, the largest speed of each degree of freedom that it received.
    speeds: Vec<Vec<f64>>,
}

impl Layout {
    /// Layout of a stack, or of one of its tasks only.
    fn new(program: &Program, stack: &StackProgram, only: Option<usize>) -> Result<Layout, ProgramError> {
        let built = build_tasks(program, stack);
        let speeds: Vec<Vec<f64>> = built.iter().map(|b| b.speed.clone()).collect();
        let (mut tasks, mut members, mut shapes) = (Vec::new(), Vec::new(), Vec::new());
        let (mut margins, mut measures) = (0, 0);
        let mut built = built.into_iter();
        for (level, l) in stack.levels.iter().enumerate() {
            let mut rows = 0;
            for m in &l.members {
                let p = &program.tasks[m.task];
                let place = format!("tasks[{}]", m.task);
                let failed = |e: BuildError| crate::program::error(&place, e.message);
                let Some(Built { task, .. }) = built.next() else { continue };
                if only.is_some_and(|o| o != m.task) {
                    continue;
                }
                let task = task.map_err(failed)?;
                let (period, gains) = (program.robot.period, task.gains(&program.values.initial));
                if let Some(gain) = gains.into_iter().find(|gain| overshoots(*gain, period)) {
                    let text = format!("the gain {gain} /s of `{}` overshoots within the period of {period} s", p.name);
                    return Err(crate::program::error(&place, text));
                }
                let Some(kind) = stdlib_tasks::find(&p.kind) else { continue };
                let (row_info, measure_info) = (task.rows(), task.measures());
                let limits = if kind.row_kind == RowKind::Inequality { row_info.len() } else { 0 };
                let mut idle = if m.idle.is_empty() { Vec::new() } else { vec![false; row_info.len()] };
                for i in &m.idle {
                    match idle.get_mut(i.row) {
                        Some(is) => *is = true,
                        None => return Err(crate::program::error(&place, "an idle row does not exist".to_string())),
                    }
                }
                members.push(Member {
                    name: p.name.clone(),
                    kind: kind.name,
                    row_kind: kind.row_kind,
                    level,
                    rows: rows..rows + row_info.len(),
                    margins: margins..margins + limits,
                    measures: measures..measures + measure_info.len(),
                    row_info,
                    measure_info,
                    program_index: m.task,
                    slots: places(std::iter::once(p)).into_iter().collect(),
                    constant: task.degrees_of_freedom().is_some(),
                    idle,
                    parts: if m.parts.is_empty() { vec![0] } else { m.parts.clone() },
                });
                if let Some(last) = members.last() {
                    rows = last.rows.end;
                    margins = last.margins.end;
                    measures = last.measures.end;
                }
                tasks.push(task);
            }
            shapes.push(LevelShape { rows, hard: l.hard, damping: l.damping });
        }
        Ok(Layout { tasks, members, shapes, speeds })
    }

    /// Creates the problem that the tasks fill, with weights and with the coefficients that never change.
    fn problem(&self, nv: usize, stack: &StackProgram, only: Option<usize>) -> Problem {
        let mut problem = Problem::new(nv, &self.shapes);
        let weights =
            stack.levels.iter().flat_map(|l| &l.members).filter(|m| only.is_none_or(|o| o == m.task)).map(|m| m.weight);
        for ((member, task), weight) in self.members.iter().zip(&self.tasks).zip(weights) {
            let of_rows = &mut problem.levels[member.level].weight[member.rows.clone()];
            of_rows.fill(weight);
            of_rows.iter_mut().zip(task.row_weights()).for_each(|(of_row, factor)| *of_row *= factor);
        }
        for (member, task) in self.members.iter().zip(&self.tasks) {
            write_constant(task.as_ref(), member, &stack.locked, &mut problem);
        }
        problem
    }
}

impl Evaluator {
    /// Prepares a stack of a checked program and creates the problem that it fills.
    ///
    /// # Errors
    /// A task cannot be built, which a compiled program excludes.
    pub fn new(program: &Program, stack: usize) -> Result<(Evaluator, Problem), ProgramError> {
        Evaluator::of(program, &program.stacks[stack], None)
    }

    /// Prepares a stack that need not be among those of the program.
    ///
    /// # Errors
    /// A task cannot be built, which a compiled program excludes.
    pub(crate) fn of_stack(program: &Program, stack: &StackProgram) -> Result<(Evaluator, Problem), ProgramError> {
        Evaluator::of(program, stack, None)
    }

    /// Prepares one task of a stack, built as in the stack. Its problem has the stack's levels without the rows of
    /// other tasks.
    ///
    /// # Errors
    /// The task cannot be built, which a compiled program excludes.
    pub fn alone(program: &Program, stack: &StackProgram, task: usize) -> Result<(Evaluator, Problem), ProgramError> {
        Evaluator::of(program, stack, Some(task))
    }

    fn of(
        program: &Program,
        stack_program: &StackProgram,
        only: Option<usize>,
    ) -> Result<(Evaluator, Problem), ProgramError> {
        let model = program.robot.model.clone();
        let layout = Layout::new(program, stack_program, only)?;
        let problem = layout.problem(model.nv(), stack_program, only);
        let Layout { mut tasks, members, shapes, speeds } = layout;
        let margins = members.last().map_or(0, |m| m.margins.end);
        let measures = members.last().map_or(0, |m| m.measures.end);
        let mut locked_joint_motion = LockedJointMotion::new(&problem, &stack_program.locked);
        members.iter().zip(&tasks).for_each(|(member, task)| locked_joint_motion.fix(member, task.as_ref()));
        let planned = planning::planners(program, stack_program);
        // A part computes the values of all of its tasks, so that it is the same in each stack that it goes on in.
        let wanted_by = |part: usize| {
            let own = members.iter().filter(|m| m.parts.contains(&part)).map(|m| m.program_index);
            let is_member = |e: &&EqualTask| members.iter().any(|m| m.program_index == e.member);
            let equal = stack_program.parts.get(part).map_or(&[][..], |p| &p.equal).iter().filter(is_member);
            places(own.chain(equal.map(|e| e.task)).filter_map(|t| program.tasks.get(t)))
        };
        let mut wanted: Vec<BTreeSet<usize>> = (0..stack_program.parts.len().max(1)).map(wanted_by).collect();
        let mut led = Led::default();
        for m in members.iter().filter(|m| planning::planner_of(program, m.program_index).is_some()) {
            let of = |&at: &usize| LedValue { part: m.part(), at, value: 0.0, rate: 0.0 };
            led.values.extend(m.slots.iter().map(of));
        }
        let mut planners = Vec::new();
        for Protection { guard, task } in planned.iter().filter(|_| only.is_none()) {
            let at = |index: usize| members.iter().position(|m: &Member| m.program_index == index);
            let (Some(g), Some(t)) = (at(*guard), at(*task)) else { continue };
            let index = |member, program| TaskIndex { member, program };
            let both = Protection { guard: index(g, *guard), task: index(t, *task) };
            let speed = speeds.get(g).map_or(&[][..], Vec::as_slice);
            let above = &shapes[..members[t].level];
            let planner = Planning::new(program, stack_program, both, tasks[t].as_mut(), speed, above)?;
            let wanted = &mut wanted[members[t].part()];
            wanted.retain(|at| planner.places.binary_search(at).is_err());
            wanted.extend(Planning::reads(program, *guard));
            planners.push(planner);
        }
        // Planners decide in the order of levels.
        planners.sort_by_key(|p: &Planning| members[p.task].level);
        let table = |wanted| ValueTable::new(&program.values, wanted, &program.interface);
        let values: Vec<ValueTable> = wanted.iter().map(table).collect();
        let tables = || values.iter().chain(planners.iter().map(|p| &p.values));
        let mut captures = Vec::new();
        for (part, table) in values.iter().enumerate() {
            // A planner reads the captured numbers of the part that contains it.
            let of_part: Vec<&ValueTable> = std::iter::once(table)
                .chain(planners.iter().filter(|p| members[p.task].part() == part).map(|p| &p.values))
                .collect();
            let reads = |c: &&Capture| (c.at..c.at + c.len).any(|k| of_part.iter().any(|t| t.is_read(k)));
            let own = program.values.captures.iter().filter(reads);
            captures.extend(own.filter_map(|c| capture::ready(c, &model, &members, part)));
        }
        let needs: BTreeSet<usize> = tables().flat_map(|t| t.needs().iter().copied()).collect();
        let evaluator = Evaluator {
            data: Data::new(&model),
            captures,
            foresight: Foresight::default(),
            needs: needs.into_iter().collect(),
            led,
            outputs: members.iter().enumerate().filter_map(|(i, m)| TaskOutputs::new(program, i, m)).collect(),
            clocks: vec![None; values.len()],
            fresh: vec![true; values.len()],
            goes_on: vec![false; tasks.len()],
            values,
            planners,
            undefined: vec![false; tasks.len()],
            tasks,
            members,
            locked_joint_motion,
            locked: stack_program.locked.clone(),
            margins: vec![f64::INFINITY; margins],
            measures: vec![0.0; measures],
            limits: limits(&model),
            inside: false,
            beside: vec![0.0; model.nq()],
            model,
        };
        Ok((evaluator, problem))
    }
}
