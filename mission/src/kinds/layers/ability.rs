//! Precomputed abilities of a problem: by agent and task, by agent and object, by task and object.

use super::problem::Problem;

/// Tables of `c_a` and of the features. They ignore lost agents, and the agent or object that a task names.
pub(super) struct Abilities {
    /// By task and agent: true if the agent has the skill and reaches the path.
    moves: Vec<Vec<bool>>,
    /// By object and agent: true if reach, payload and features permit the agent to handle the object.
    grips: Vec<Vec<bool>>,
    /// By task: the objects with its features; for a task without features the named object.
    pub objects: Vec<Vec<usize>>,
}

impl Abilities {
    pub fn of(problem: &Problem) -> Abilities {
        let agents = 0..problem.agents.len();
        let moves = |task: usize| agents.clone().map(|agent| problem.task_obstacle(agent, task).is_none()).collect();
        let grips = |thing: usize| agents.clone().map(|agent| problem.grip_obstacle(agent, thing).is_none()).collect();
        let objects = problem.tasks.iter().map(|task| {
            let fits = |index: &usize| match task.object {
                Some(named) if task.features.is_empty() => named == *index,
                _ => task.features.is_subset(&problem.objects[*index].features),
            };
            if task.needs_object() { (0..problem.objects.len()).filter(fits).collect() } else { Vec::new() }
        });
        Abilities {
            moves: (0..problem.tasks.len()).map(moves).collect(),
            grips: (0..problem.objects.len()).map(grips).collect(),
            objects: objects.collect(),
        }
    }

    /// Returns true if this agent has all abilities for this task and object.
    pub fn could(&self, agent: usize, task: usize, object: Option<usize>) -> bool {
        self.moves[task][agent] && object.is_none_or(|object| self.grips[object][agent])
    }
}
