//! The page of a person of a mission of layers: current and next task with objects and positions.

use serde_json::json;

use crate::kind::pages::words::clock_time;
use crate::kind::pages::{Button, ButtonGroup, PersonContent, Step};
use crate::kinds::layers::execution::{Doing, LayersExecution, LogEntry};
use crate::kinds::layers::problem::Problem;
use crate::kinds::layers::steps::{Step as Planned, from_plan};

/// Describes a task: `cube_5_1: pick_and_place left_green_cube_2, past rack, to (-0.20, 0.20, 0.00) m`.
pub(super) fn task(problem: &Problem, task: usize, object: Option<usize>) -> String {
    let Some(what) = problem.tasks.get(task) else { return "a task".into() };
    let mut text = format!("{}: {}", problem.labels.task(&what.name), what.action);
    if let Some(thing) = object.and_then(|object| problem.object_label(object)) {
        text += &format!(" {thing}");
    }
    for (number, position) in what.path.iter().enumerate() {
        let way = if number + 1 < what.path.len() { "past" } else { "to" };
        text += &format!(", {way} {}", problem.called(position));
    }
    text
}

/// Returns the page of an agent; `None` if there is no such agent.
pub(super) fn page(on: &LayersExecution, agent: usize) -> Option<PersonContent> {
    let (problem, view) = (on.problem(), on.agent(agent)?);
    let (work, next) = (view.work, view.next);
    let open = next.filter(|next| next.open && view.doing == Doing::Idle);
    let doing = match (work, view.doing) {
        (Some(work), _) => format!("You do {}.", task(problem, work.task, work.object)),
        (None, Doing::Lost) => "You have left the mission.".into(),
        _ => match open {
            Some(next) => format!("Your turn: {}.", task(problem, next.task, next.object)),
            None if next.is_some() => "You wait for the previous layer.".into(),
            None => "You have nothing to do.".into(),
        },
    };
    // The page already shows the open task above.
    let own = own(on, agent);
    let then = match open {
        Some(open) => {
            let after = own.iter().skip_while(|step| step.task != open.task).nth(1);
            after.map(|step| (step.task, step.object, step.start))
        }
        None => next.map(|next| (next.task, next.object, next.start)),
    };
    let index = work.map(|work| work.task).or(next.map(|next| next.task)).unwrap_or_default();
    let shown = work.map(|work| work.task).or(open.map(|next| next.task));
    let until = work.map(|work| work.expected);
    let request = |what: &str| json!({ "what": what, "task": index });
    let longer = |by: f64| {
        let until = until.map_or(serde_json::Value::Null, |until| (until + by).into());
        json!({ "what": "longer", "task": index, "until": until })
    };
    let groups = vec![
        ButtonGroup {
            heading: shown.map_or("Task", |task| problem.task_label(task).unwrap_or_default()).into(),
            buttons: vec![
                Button::main("begin", "Start", open.is_some(), request("begin")),
                Button::main("done", "Finish", work.is_some(), request("done")),
            ],
        },
        ButtonGroup {
            heading: "Problems".into(),
            buttons: vec![
                Button::new("longer", "30 s longer", work.is_some(), longer(30.0)),
                Button::new("much", "2 min longer", work.is_some(), longer(120.0)),
                Button::new(
                    "failed",
                    "It failed",
                    work.is_some(),
                    json!({ "what": "failed", "task": index, "until": until }),
                ),
            ],
        },
    ];
    Some(PersonContent {
        doing,
        since: work.map(|_| view.since),
        until,
        next: match then {
            Some((what, object, start)) => format!("{}, at {}.", task(problem, what, object), clock_time(start)),
            None => "Nothing more is planned for you.".into(),
        },
        groups,
        steps: steps(on, agent, own),
        ..PersonContent::default()
    })
}

/// Returns the planned steps of an agent, sorted by start.
fn own(on: &LayersExecution, agent: usize) -> Vec<Planned> {
    let mut steps = from_plan(on.plan());
    steps.retain(|step| step.agent == agent);
    steps.sort_by(|a, b| a.start.total_cmp(&b.start).then(a.task.cmp(&b.task)));
    steps
}

/// Returns the tasks of an agent.
fn steps(on: &LayersExecution, agent: usize, own: Vec<Planned>) -> Vec<Step> {
    let now = on.agent(agent).and_then(|view| view.work).map(|work| work.task);
    let ended = |index: usize| {
        let done = LogEntry::Ended { agent, task: index };
        on.records().iter().any(|record| record.what == done)
    };
    let step = |step: Planned| Step {
        at: step.start,
        text: task(on.problem(), step.task, step.object),
        state: match step.task {
            index if now == Some(index) => "now",
            index if ended(index) => "done",
            _ => "next",
        },
    };
    let planned = |step: &Step| step.state != "next" || on.stranded().is_none();
    own.into_iter().map(step).filter(planned).collect()
}
