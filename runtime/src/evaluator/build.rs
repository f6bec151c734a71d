//! The tasks of a stack, built: each is told how fast those before it let the robot move.

use robot::Model;
use stdlib_tasks::task::{BuildError, Context, Task};

use crate::program::{StackProgram, TaskProgram};

/// A task of a stack, built.
pub struct Built {
    /// The task, or why there is none.
    pub task: Result<Box<dyn Task>, BuildError>,
    /// The largest speed of each degree of freedom that it was told, in rad/s or m/s.
    pub speed: Vec<f64>,
}

/// Builds the tasks of a stack, one for each member in the order of levels. A task is told the speed limits that hold
/// whatever it does: those of tasks on hard levels down to its own. A soft level gives way, a lower one comes after, and
/// the robot's own limits bound the command but not the reference that the levels move.
pub fn build_tasks(
    model: &Model,
    period: f64,
    values: &[f64],
    tasks: &[TaskProgram],
    stack: &StackProgram,
) -> Vec<Built> {
    let one = |task: &TaskProgram, speed: &[f64]| match stdlib_tasks::find(&task.kind) {
        Some(kind) => (kind.build)(&task.params, &Context { model, values, period, speed }),
        None => Err(BuildError::new("", format!("there is no task type `{}`", task.kind))),
    };
    let mut speed = vec![f64::INFINITY; model.nv()];
    for &dof in &stack.locked {
        speed[dof] = 0.0;
    }
    let mut built = Vec::new();
    for level in &stack.levels {
        let members = level.members.iter().map(|m| &tasks[m.task]);
        if level.hard {
            let limits: Vec<(usize, f64)> = members
                .clone()
                .filter_map(|t| one(t, &speed).ok())
                .flat_map(|task| task.speed_limits(values))
                .collect();
            for (dof, limit) in limits {
                speed[dof] = speed[dof].min(limit);
            }
        }
        built.extend(members.map(|t| Built { task: one(t, &speed), speed: speed.clone() }));
    }
    built
}
