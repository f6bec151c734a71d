//! Proof that the hard levels of a stack can be met: limits that stand still allow `v = 0` wherever their margins are not
//! negative, so that a stack whose hard levels have only such limits is never infeasible from a safe state.
//!
//! A task that breaks the proof does not make a hard level infeasible: these are the tasks to look at if one is.

use serde::Serialize;
use stdlib_tasks::bound::Bound;
use stdlib_tasks::expression::Leaf;
use stdlib_tasks::kinds;
use stdlib_tasks::task::{RowKind, TaskKind};

use crate::evaluator::build_tasks;
use crate::program::{Program, TaskProgram};

/// Limits that a robot at rest meets at every state with margins that are not negative, unless they move.
static STANDING: [&TaskKind; 6] = [
    &kinds::joint_position_limits::KIND,
    &kinds::joint_velocity_limits::KIND,
    &kinds::virtual_wall::KIND,
    &kinds::self_collision::KIND,
    &kinds::keep_clear::KIND,
    &kinds::keep::KIND,
];

/// Task of a hard level, or above one, that a robot at rest may not meet or that takes its freedom.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Obstacle {
    /// Index of the task in the program.
    pub task: usize,
    /// Index of its level in the stack.
    pub level: usize,
    /// The reason.
    pub why: Why,
}

/// Reason why a task breaks the proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Why {
    /// A target asks for a motion.
    Target,
    /// A robot that moves cannot stop at once.
    Accelerations,
    /// The limit changes during a run.
    Moves,
    /// A constant reserve pushes the robot away.
    Reserve,
    /// The task is on a soft level above a hard one, and uses freedom that the hard level may need.
    SoftAbove,
    /// Nothing is known about the task at rest.
    Unknown,
}

impl Why {
    /// The reason after the name of the task, as in "is a target".
    pub fn text(self) -> &'static str {
        match self {
            Why::Target => "is a target",
            Why::Accelerations => "limits accelerations, and a robot that moves cannot stop at once",
            Why::Moves => "is a limit that moves",
            Why::Reserve => "keeps a constant reserve",
            Why::SoftAbove => "is on a soft level above a hard one",
            Why::Unknown => "may ask a robot at rest to move",
        }
    }
}

/// Returns what breaks the proof for a stack, in the order of levels; empty if the hard levels are never infeasible from a
/// safe state. `None` if the stack has no rows on hard levels, or if its tasks cannot be built.
pub fn obstacles(program: &Program, stack: usize) -> Option<Vec<Obstacle>> {
    let stack = program.stacks.get(stack)?;
    let last = stack.levels.iter().rposition(|l| l.hard && !l.members.is_empty())?;
    let mut built = build_tasks(program, stack).into_iter();
    let mut found = Vec::new();
    for (level, l) in stack.levels.iter().enumerate().take(last + 1) {
        for m in &l.members {
            let (task, built) = (program.tasks.get(m.task)?, built.next()?.task.ok()?);
            let kind = stdlib_tasks::find(&task.kind)?;
            let reserve = built.sampled_margin().iter().any(|kept| *kept > 0.0);
            let why = match kind.row_kind {
                _ if !l.hard => Some(Why::SoftAbove),
                RowKind::Equality => Some(Why::Target),
                _ if !built.acceleration_limits().is_empty() => Some(Why::Accelerations),
                _ if !STANDING.iter().any(|k| k.name == kind.name) => Some(Why::Unknown),
                _ if moves(program, task) => Some(Why::Moves),
                _ => reserve.then_some(Why::Reserve),
            };
            found.extend(why.map(|why| Obstacle { task: m.task, level, why }));
        }
    }
    Some(found)
}

/// True if a number of the task other than its gain is computed during a run, or a safety field enters it.
fn moves(program: &Program, task: &TaskProgram) -> bool {
    let numbers = task.params.iter().filter(|(name, _)| name.as_str() != "gain").map(|(_, bound)| bound);
    numbers.clone().any(of_people)
        || numbers.flat_map(Bound::slots).any(|s| {
            let places = s.at..s.at + s.len;
            program.values.tape.outputs.iter().any(|o| places.contains(&o.at))
        })
}

/// True if an expression reads a safety field, which people move.
fn of_people(bound: &Bound) -> bool {
    match bound {
        Bound::Expression(e) => e.leaves.iter().any(|leaf| matches!(leaf, Leaf::Field(_))),
        Bound::Field(_) => true,
        _ => false,
    }
}

/// Result of the proof for a stack, as data.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Feasibility {
    /// Name of the stack.
    pub stack: String,
    /// True if its hard levels are never infeasible from a safe state, since `v = 0` meets every hard row.
    pub never_infeasible: bool,
    /// Tasks that break the proof.
    pub obstacles: Vec<NamedObstacle>,
}

/// A task that breaks the proof, by its name.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct NamedObstacle {
    /// Name of the task.
    pub task: String,
    /// Name of its level.
    pub level: String,
    /// The reason.
    pub why: Why,
}

/// Returns the results of all stacks with hard levels.
pub fn of_stacks(program: &Program) -> Vec<Feasibility> {
    let named = |stack: usize, o: &Obstacle| NamedObstacle {
        task: program.tasks[o.task].name.clone(),
        level: program.stacks[stack].levels[o.level].name.clone(),
        why: o.why,
    };
    let of = |index: usize| {
        let found = obstacles(program, index)?;
        Some(Feasibility {
            stack: program.stacks[index].name.clone(),
            never_infeasible: found.is_empty(),
            obstacles: found.iter().map(|o| named(index, o)).collect(),
        })
    };
    (0..program.stacks.len()).filter_map(of).collect()
}
