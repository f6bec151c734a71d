//! Construction of the tasks of a stack: each task receives the speed limits that the tasks before it impose.

use std::collections::BTreeMap;

use stdlib_tasks::task::{BuildError, Context, Task};

use crate::program::{Program, StackProgram, TaskProgram};

/// Built task of a stack.
pub struct Built {
    /// The task, or the reason why it cannot be built.
    pub task: Result<Box<dyn Task>, BuildError>,
    /// Largest speed of each degree of freedom that the task received, in rad/s or m/s.
    pub speed: Vec<f64>,
}

/// Builds the tasks of a stack, one for each member in the order of levels. A task receives the speed limits that hold
/// whatever it does: those of tasks on hard levels down to its own. A soft level can be violated, a lower one is solved
/// later, and the robot's own limits bound the command but not the reference that the levels move. Joints that the
/// stack locks have the speed zero; while they come to rest, their limit is the speed at which other stacks may leave
/// them.
pub fn build_tasks(program: &Program, stack: &StackProgram) -> Vec<Built> {
    let values = &program.values.initial;
    let mut speed = vec![f64::INFINITY; program.robot.model.nv()];
    let entered = speeds_at_entry(program, stack);
    for &(dof, _) in &entered {
        speed[dof] = 0.0;
    }
    let entry_speed = |speed: &[f64]| {
        let mut entry_speed = speed.to_vec();
        entered.iter().for_each(|&(dof, at_entry)| entry_speed[dof] = at_entry);
        entry_speed
    };
    let mut built = Vec::new();
    for level in &stack.levels {
        let members = level.members.iter().map(|m| &program.tasks[m.task]);
        if level.hard {
            let limits: Vec<(usize, f64)> = members
                .clone()
                .filter_map(|t| one(program, t, &speed, &entry_speed(&speed)).ok())
                .flat_map(|task| task.speed_limits(values))
                .collect();
            for (dof, limit) in limits {
                speed[dof] = speed[dof].min(limit);
            }
        }
        let entry_speed = entry_speed(&speed);
        built.extend(members.map(|t| Built { task: one(program, t, &speed, &entry_speed), speed: speed.clone() }));
    }
    built
}

fn one(program: &Program, task: &TaskProgram, speed: &[f64], entry_speed: &[f64]) -> Result<Box<dyn Task>, BuildError> {
    let Some(kind) = stdlib_tasks::find(&task.kind) else {
        return Err(BuildError::new("", format!("there is no task type `{}`", task.kind)));
    };
    let (model, values, period) = (&program.robot.model, &program.values.initial, program.robot.period);
    (kind.build)(&task.params, &Context { model, values, period, speed, entry_speed })
}

/// Largest speed that each locked joint of a stack may have when the stack is entered: the largest that the hard levels
/// of a stack that moves the joint allow. It is infinite if one of these stacks has no limit, and zero if no stack of
/// the run moves the joint.
fn speeds_at_entry(program: &Program, stack: &StackProgram) -> Vec<(usize, f64)> {
    let mut entered: Vec<(usize, f64)> = stack.locked.iter().map(|dof| (*dof, 0.0)).collect();
    let open = vec![f64::INFINITY; program.robot.model.nv()];
    // Stacks share most of their limits, so these are cached by task.
    let mut limits: BTreeMap<usize, Vec<(usize, f64)>> = BTreeMap::new();
    let run = program.run_stacks().into_iter().filter_map(|s| program.stacks.get(s));
    for other in run.filter(|s| stack.locked.iter().any(|dof| !s.locked.contains(dof))) {
        let mut own: BTreeMap<usize, f64> = BTreeMap::new();
        for member in other.levels.iter().filter(|l| l.hard).flat_map(|l| &l.members) {
            let known = limits.entry(member.task).or_insert_with(|| {
                let task = one(program, &program.tasks[member.task], &open, &open);
                task.map(|t| t.speed_limits(&program.values.initial)).unwrap_or_default()
            });
            for &(dof, limit) in known.iter() {
                own.entry(dof).and_modify(|least| *least = least.min(limit)).or_insert(limit);
            }
        }
        for (dof, speed) in entered.iter_mut().filter(|(dof, _)| !other.locked.contains(dof)) {
            *speed = speed.max(own.get(dof).copied().unwrap_or(f64::INFINITY));
        }
    }
    entered
}
