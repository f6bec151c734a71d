//! Page contents of a mission of layers: current and next tasks of people with objects and positions, and the overview
//! of the supervisor.

use mission::execution::PlanChange;
use mission::kinds::layers::execution::{AgentView, Doing, Event, Happening, LayeredExecution, Record};
use mission::kinds::layers::problem::Problem;
use mission::kinds::layers::steps::{Step as Planned, from_plan};

use crate::layered::{people, robots};
use crate::overview::{NO_PLAN, status, times};
use crate::view::{AgentRow, May, Message, PersonView, RobotRow, Step, SupervisorView, Trouble};
use crate::words::written;

fn name(problem: &Problem, agent: usize) -> &str {
    problem.agent_label(agent).unwrap_or("?")
}

/// Describes a task: `cube_5_1: pick_and_place left_green_cube_2, past rack, to (-0.20, 0.20, 0.00) m`.
fn task(problem: &Problem, task: usize, object: Option<usize>) -> String {
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

/// Returns a record as a message for this agent; `None` if it does not concern the agent.
pub fn for_one(problem: &Problem, who: usize, record: &Record) -> Option<String> {
    let of = |task: &usize| problem.task_label(*task).unwrap_or("A task");
    Some(match &record.what {
        Happening::Began { agent, task, .. } if *agent == who => format!("{} begins.", of(task)),
        Happening::Ended { agent, task } if *agent == who => format!("{} is done.", of(task)),
        Happening::Dropped { agent, task } if *agent == who => format!("{} is to be done again.", of(task)),
        Happening::TaskLate { agent, task, expected } if *agent == who => {
            format!("{} is now expected to be done at {}.", of(task), written(*expected))
        }
        Happening::Told { event: Event::Late { agent, by } } if *agent == who => format!("It takes {by:.0} s longer."),
        Happening::Told { event: Event::Failed { agent } } if *agent == who => "It failed.".into(),
        Happening::LayerDone { layer } => {
            format!("Layer {} is done.", problem.layer_label(*layer).unwrap_or_default())
        }
        Happening::Told { event: Event::Lost { agent } } if *agent == who => "You have left the mission.".into(),
        Happening::Told { event: Event::Back { agent } } if *agent == who => "You are back.".into(),
        Happening::Told { event: Event::Lost { agent } } => {
            format!("{} takes no part any more.", name(problem, *agent))
        }
        Happening::Told { event: Event::Back { agent } } => format!("{} is back.", name(problem, *agent)),
        Happening::Plan(PlanChange::Reallocated { .. }) => "The plan was made anew.".into(),
        Happening::Plan(PlanChange::Stranded { why }) => format!("There is no plan for everything any more: {why}."),
        Happening::Done => "The mission is done.".into(),
        _ => return None,
    })
}

/// Returns the page of the person with this agent index.
pub fn person(on: &LayeredExecution, agent: usize, messages: Vec<Message>, running: bool) -> PersonView {
    let problem = on.problem();
    let view = on.agent(agent);
    let work = view.and_then(|view| view.work);
    let next = view.and_then(|view| view.next);
    let idle = view.is_some_and(|view| view.doing == Doing::Idle);
    let open = next.filter(|next| next.open && idle);
    let may = May {
        begin: running && open.is_some(),
        done: running && work.is_some(),
        failed: running && work.is_some(),
        longer: running && work.is_some(),
        ..May::default()
    };
    let doing = match (work, view.map(|view| view.doing)) {
        (Some(work), _) => format!("You do {}.", task(problem, work.task, work.object)),
        (None, Some(Doing::Lost)) => "You have left the mission.".into(),
        _ => match open {
            Some(next) => format!("Your turn: {}.", task(problem, next.task, next.object)),
            None if next.is_some() => "You wait until the layer before is done.".into(),
            None => "You have nothing to do.".into(),
        },
    };
    // The page already shows the open task above.
    let then = if open.is_some() { second(on, agent) } else { next.map(|next| (next.task, next.object, next.start)) };
    PersonView {
        name: name(problem, agent).into(),
        doing,
        since: work.and(view.map(|view| view.since)),
        until: work.map(|work| work.expected),
        next: match then {
            Some((what, object, start)) => format!("{}, at {}.", task(problem, what, object), written(start)),
            None => "Nothing more is planned for you.".into(),
        },
        comes: None,
        robot: None,
        at: work.map(|work| work.task).or(next.map(|next| next.task)).unwrap_or(problem.tasks.len()),
        operation: match work.map(|work| work.task).or(open.map(|next| next.task)) {
            Some(index) => problem.task_label(index).unwrap_or_default().to_string(),
            None => "Task".into(),
        },
        service: None,
        may,
        measured: Vec::new(),
        ask: None,
        steps: steps(on, agent),
        messages,
        note: note(on, view, running),
    }
}

/// Returns the planned steps of an agent, sorted by start.
fn own(on: &LayeredExecution, agent: usize) -> Vec<Planned> {
    let mut steps = from_plan(on.plan());
    steps.retain(|step| step.agent == agent);
    steps.sort_by(|a, b| a.start.total_cmp(&b.start).then(a.task.cmp(&b.task)));
    steps
}

/// Returns the task after the next one, with its object and start (s).
fn second(on: &LayeredExecution, agent: usize) -> Option<(usize, Option<usize>, f64)> {
    let next = on.agent(agent)?.next?.task;
    let mut own = own(on, agent).into_iter().skip_while(|step| step.task != next).skip(1);
    own.next().map(|step| (step.task, step.object, step.start))
}

fn note(on: &LayeredExecution, view: Option<AgentView>, running: bool) -> Option<String> {
    match () {
        () if on.done() => Some("The mission is done. Thank you.".into()),
        () if view.is_some_and(|view| view.doing == Doing::Lost) => {
            Some("The supervisor has noted that you left. If you are back, tell the supervisor.".into())
        }
        () if !running => Some("The clock of the mission stands. The supervisor lets it run.".into()),
        () => on.stranded().map(|why| format!("There is no plan for everything any more: {why}. Ask the supervisor.")),
    }
}

/// Returns the tasks of an agent.
fn steps(on: &LayeredExecution, agent: usize) -> Vec<Step> {
    let problem = on.problem();
    let now = on.agent(agent).and_then(|view| view.work).map(|work| work.task);
    let ended = |index: usize| {
        let done = Happening::Ended { agent, task: index };
        on.records().iter().any(|record| record.what == done)
    };
    let step = |step: Planned| Step {
        at: step.start,
        text: task(problem, step.task, step.object),
        state: match step.task {
            index if now == Some(index) => "now",
            index if ended(index) => "done",
            _ => "next",
        },
    };
    let planned = |step: &Step| step.state != "next" || on.stranded().is_none();
    own(on, agent).into_iter().map(step).filter(planned).collect()
}

/// Returns the possible reports about an agent's task.
fn trouble(on: &LayeredExecution, agent: usize) -> Trouble {
    let work = on.agent(agent).and_then(|view| view.work);
    Trouble { until: work.map(|work| work.expected), fails: work.is_some() }
}

/// Returns the page of the supervisor; the state of the pages is added by the server's routes.
pub fn supervisor(on: &LayeredExecution, events: Vec<Message>) -> SupervisorView {
    let (plan, problem) = (on.plan(), on.problem());
    let numbers = on.statistics();
    let doing = |agent: usize| {
        let Some(view) = on.agent(agent) else { return (String::new(), false) };
        let text = match (view.doing, view.work) {
            (Doing::Lost, _) => "takes no part any more".into(),
            (_, Some(work)) => {
                format!("{}, until {}", task(problem, work.task, work.object), written(work.expected))
            }
            _ => match view.next {
                Some(next) if next.open => format!("is to begin {}", task(problem, next.task, next.object)),
                Some(_) => "waits for the layer before".into(),
                None => "has nothing to do".into(),
            },
        };
        (text, view.doing == Doing::Lost)
    };
    let agents = people(problem).into_iter().map(|agent| {
        let (doing, lost) = doing(agent);
        let (page, trouble) = (String::new(), trouble(on, agent));
        AgentRow { name: name(problem, agent).into(), doing, page, paged: false, lost, trouble }
    });
    let robots = robots(problem).into_iter().map(|agent| {
        let (doing, lost) = doing(agent);
        let at = on.agent(agent).map(|view| [view.position[0], view.position[1]]);
        RobotRow { name: name(problem, agent).into(), doing, at, lost, trouble: trouble(on, agent) }
    });
    let stands = on.stranded().is_none();
    let ends = plan.end().filter(|_| stands).map(|end| format!("ends at {}, ", written(end))).unwrap_or_default();
    let (done, all) = (numbers.tasks, problem.tasks.len());
    SupervisorView {
        status: if stands { status(plan) } else { NO_PLAN.into() },
        numbers: format!(
            "{done} of {all} tasks done, {ends}moved {}, planned anew {}",
            times(numbers.reschedules),
            times(numbers.reallocations)
        ),
        over: on.done().then(|| "The mission is done: every task is done.".to_string()),
        note: on.stranded().map(|why| format!("There is no plan for everything any more: {why}.")),
        moves: false,
        agents: agents.collect(),
        robots: robots.collect(),
        events,
        drawing: on.records().len(),
    }
}
