//! The rules of a mission in plain words, for a model that allocates or schedules. Thesis 6.4.4 gives its baselines a
//! translation of each constraint of the optimiser, and the cost that it minimises.
//!
//! A plan that is computed correctly from these words alone is accepted by the validator; a test checks this.

use serde_json::{Value, json};

use crate::kinds::layers::json::Mode;
use crate::kinds::layers::problem::{Body, Problem};

/// Returns the constraints that the model must satisfy itself, one directive each, in the order of the thesis
/// equations.
pub fn directives(problem: &Problem, mode: Mode) -> Vec<String> {
    if mode == Mode::Context {
        return Vec::new();
    }
    let back = match problem.returns {
        true => "and from there back to its own `place`: the way back is a part of the task",
        false => "and no further: there is no way back, and every task begins at the `place` of its agent again",
    };
    let mut all = vec![
        // (6.9)
        "A task that asks for features uses exactly one object, and the object has all of these features. A task that asks \
         for none uses none; then leave out `features` and `object`."
            .to_string(),
        // (6.10)
        "Each object is used by at most one task.".to_string(),
        // (6.11)
        "Each task is done by exactly one agent, which has the action among its `time_of_action`. If the agent has a `reach`, \
         the object and all positions of the task are within that distance of its `place`; if it has a `payload`, the \
         object is not heavier; and the object has none of the features that it `cannot_handle`."
            .to_string(),
        // (6.12)
        "An agent cannot carry out multiple tasks simultaneously.".to_string(),
        format!(
            "The way of a task, in straight lines: from the `place` of the agent to the object if there is one, through the \
             positions of `motion`, to `to` if it is given, {back}."
        ),
        // (6.14)
        "A task takes the `time_of_action` of its agent for the action, plus the length of its way divided by the speed."
            .to_string(),
    ];
    if problem.agents.iter().any(|who| !who.lost && !who.is_human()) {
        // (6.13)
        all.push(
            "A robot keeps one speed during a task, not below the first and not above the second number of its `speed`."
                .to_string(),
        );
    }
    if problem.agents.iter().any(|who| !who.lost && who.is_human()) {
        // (6.15)
        all.push(format!(
            "The speed of a human is `speed` * `pace` of the action / (1 + `slowing` * (mass of the object - {})), where {0} kg \
             is the least mass of all objects; without an object it is `speed` * `pace` of the action.",
            problem.least_mass()
        ));
    }
    if mode == Mode::Scheduled {
        all.extend(times(problem));
    }
    all
}

/// Returns the constraints on start and end times.
fn times(problem: &Problem) -> Vec<String> {
    let begins = format!("No task starts before {} s.", problem.start);
    vec![
        // (6.8)
        "The start and end times of each task must be determined according to its position within the task hierarchy: no \
         task of a layer starts before all tasks of all layers before it have ended."
            .to_string(),
        begins,
        // (6.14)
        "`end` - `start` of a task is at least what the task takes: of a human at the speed above, of a robot at its \
         greatest speed. A robot that is given more time moves more slowly, at way / (`end` - `start` - `time_of_action`), but \
         never below its least speed; then it waits at the end."
            .to_string(),
        "Times are checked to a millionth of a second: round `end` up and never down, to three decimals for instance."
            .to_string(),
    ]
}

/// Returns the cost (6.7) with the weights of the mission.
pub fn cost(problem: &Problem) -> Value {
    let weights = problem.weights;
    json!({
        "minimise": format!(
            "J = {} * workload + {} * energy + {} * makespan",
            weights.workload, weights.energy, weights.makespan
        ),
        "workload": "Of each human: the sum over its tasks of what the task takes (`end` - `start`) times the mass of the object, \
                     divided by the largest such product that a single task could have with this human. Added up over all \
                     humans. A task without an object is no workload.",
        "energy": "Of each robot: the sum over its tasks of way * (`standby` / v + `friction` + `drag` * v) at the speed v, \
                   divided by D * (`standby` / v_min + `friction` + `drag` * v_max), where D is the longest way of any task \
                   with any agent and object that could do it, and v_min and v_max are the limits of the robot's `speed`. \
                   Added up over all robots.",
        "makespan": "The time at which the last task ends, divided by (number of tasks) * (largest `time_of_action` + D / \
                     the least speed of all agents, of a human that of its slowest action with the heaviest object).",
    })
}

/// Returns the instruction that is added to the person's, in the words of thesis 6.4.4.
pub fn wanted(mode: Mode) -> Option<&'static str> {
    match mode {
        Mode::Context => None,
        Mode::Allocated => Some(
            "For every task, assign an available object that matches the required features, and an agent, such that human \
             workload, robot energy use and total makespan are all minimised, as the cost says. Speeds and times are decided \
             by an optimiser afterwards.",
        ),
        Mode::Scheduled => Some(
            "For every task, assign an available object that matches the required features, and an agent; and allocate a \
             start and end time to each task according to the directives, minimising the makespan, human workload and robotic \
             energy consumption, as the cost says.",
        ),
    }
}

/// Describes the speed of an agent and the parameters that its speed depends on.
pub fn motion(body: &Body) -> Value {
    match body {
        Body::Robot { speed, energy } => json!({
            "kind": "robot",
            "speed": [speed.low, speed.high],
            "energy": { "standby": energy.standby, "friction": energy.friction, "drag": energy.drag },
        }),
        Body::Human { speed, slowing } => json!({ "kind": "human", "speed": speed, "slowing": slowing }),
    }
}
