//! The execution of layers behind the interface of all kinds: measures, logs and results.

use quantities::dimension::{ENERGY, LENGTH, NONE, TIME, WORKLOAD};

use crate::chart::Chart;
use crate::executed::{MeasureTable, Reports};
use crate::kind::{Cell, Event, Form, Measure, Table, Work, WorkState, number, truth};
use crate::labels::Labels;
use crate::map::Map;

use super::chart::chart;
use super::event;
use super::execution::{AgentOutcome, AgentView, Doing, LayersExecution, LayersWorld, LogEntry, Outcome};
use super::map::map;
use super::problem::Problem;
use super::words::{doing, of_log_entry};

const EVERYBODY: &[&str] = &["robot", "human"];

/// The results of an agent so far.
fn agent(of: &LayersExecution, index: usize) -> Option<(AgentView, AgentOutcome)> {
    Some((of.agent(index)?, of.statistics().agents.into_iter().nth(index)?))
}

/// Everything that is measured of missions of layers; the index is that of the agent.
pub(super) const MEASURES: &MeasureTable<LayersWorld> = &[
    (Measure::whole("done", Form::Truth, "True once every task is done; `done` alone is the same."), |of, _| {
        Some(truth(of.done()))
    }),
    (
        Measure::whole("stranded", Form::Truth, "True once no complete plan is feasible: no agent is left for a task."),
        |of, _| Some(truth(of.stranded().is_some())),
    ),
    (
        Measure::whole("makespan", Form::Number(TIME), "Time from the start to the end of the last finished task."),
        |of, _| Some(number(of.statistics().makespan)),
    ),
    (Measure::whole("cost", Form::Number(NONE), "Cost of the current plan."), |of, _| Some(number(of.plan().cost))),
    (
        Measure::whole(
            "energy",
            Form::Number(ENERGY),
            "Energy of all robots in tasks that have ended or were dropped.",
        ),
        |of, _| Some(number(of.statistics().agents.iter().map(|agent| agent.energy).sum())),
    ),
    (Measure::whole("workload", Form::Number(WORKLOAD), "Workload of all people."), |of, _| {
        Some(number(of.statistics().agents.iter().map(|agent| agent.workload).sum()))
    }),
    (Measure::whole("layer", Form::Number(NONE), "Number of layers that are done."), |of, _| {
        Some(number(of.statistics().layers as f64))
    }),
    (Measure::whole("tasks", Form::Number(NONE), "Number of tasks that are done."), |of, _| {
        Some(number(of.statistics().tasks as f64))
    }),
    (
        Measure::whole(
            "dropped",
            Form::Number(NONE),
            "Number of times that a task failed, or was dropped by an agent that was lost.",
        ),
        |of, _| Some(number(of.statistics().dropped as f64)),
    ),
    (
        Measure::whole(
            "reschedules",
            Form::Number(NONE),
            "Number of times that the plan was rescheduled with unchanged assignments.",
        ),
        |of, _| Some(number(of.statistics().reschedules as f64)),
    ),
    (
        Measure::whole(
            "reallocations",
            Form::Number(NONE),
            "Number of times that activities which had not begun were replanned.",
        ),
        |of, _| Some(number(of.statistics().reallocations as f64)),
    ),
    (Measure::of(EVERYBODY, "working", Form::Truth, "True while it is at work."), |of, index| {
        Some(truth(of.agent(index)?.doing == Doing::Working))
    }),
    (Measure::of(EVERYBODY, "lost", Form::Truth, "True while it is lost."), |of, index| {
        Some(truth(of.agent(index)?.doing == Doing::Lost))
    }),
    (Measure::of(EVERYBODY, "tasks", Form::Number(NONE), "Number of tasks that it has done."), |of, index| {
        Some(number(agent(of, index)?.1.tasks as f64))
    }),
    (
        Measure::of(EVERYBODY, "worked", Form::Number(TIME), "Time at work, including the task under way."),
        |of, index| {
            let (view, so_far) = agent(of, index)?;
            Some(number(so_far.worked + view.work.map_or(0.0, |work| of.time() - work.start)))
        },
    ),
    (
        Measure::of(
            EVERYBODY,
            "position",
            Form::Point,
            "Position of its hand: on the way from its base to the object, along the path and back, or at the base.",
        ),
        |of, index| Some(of.agent(index)?.position),
    ),
    (
        Measure::of(
            EVERYBODY,
            "travelled",
            Form::Number(LENGTH),
            "Distance covered in tasks that have ended or were dropped.",
        ),
        |of, index| Some(number(agent(of, index)?.1.travelled)),
    ),
    (Measure::of(&["robot"], "energy", Form::Number(ENERGY), "Energy for this distance."), |of, index| {
        Some(number(agent(of, index)?.1.energy))
    }),
    (
        Measure::of(
            &["human"],
            "workload",
            Form::Number(WORKLOAD),
            "Its workload: of each task that has ended or was dropped the time, times the mass of the object.",
        ),
        |of, index| Some(number(agent(of, index)?.1.workload)),
    ),
];

impl Reports for LayersWorld {
    type Results = Outcome;

    const MEASURES: &'static MeasureTable<LayersWorld> = MEASURES;

    fn labels(problem: &Problem) -> &Labels {
        &problem.labels
    }

    fn member(problem: &Problem, member: usize) -> Option<(&'static str, usize)> {
        let who = problem.agents.get(member)?;
        Some((if who.is_human() { "human" } else { "robot" }, member))
    }

    fn describe(problem: &Problem, event: &Event) -> String {
        event::describe(problem, event)
    }

    fn handle(of: &mut LayersExecution, event: &Event) -> Result<(), String> {
        let event = event::typed(&of.problem, event)?;
        of.handle_event(event).map(|_| ()).map_err(|why| why.to_string())
    }

    fn describe_happening(problem: &Problem, what: &LogEntry) -> String {
        of_log_entry(what, problem)
    }

    fn is_notable(what: &LogEntry) -> bool {
        match what {
            LogEntry::Handled { .. } | LogEntry::Dropped { .. } | LogEntry::Done => true,
            LogEntry::Plan(change) => change.is_notable(),
            _ => false,
        }
    }

    fn chart(of: &LayersExecution) -> Chart {
        let mut begun = vec![false; of.problem.tasks.len()];
        for record in of.records() {
            let (task, is) = match record.what {
                LogEntry::Begun { task, .. } => (task, true),
                LogEntry::Dropped { task, .. } => (task, false),
                _ => continue,
            };
            if let Some(slot) = begun.get_mut(task) {
                *slot = is;
            }
        }
        let mut plan = of.plan.clone();
        for activity in &mut plan.activities {
            activity.begun = begun.get(activity.task) == Some(&true);
        }
        chart(&of.problem, &plan)
    }

    fn map(of: &LayersExecution) -> Map {
        map(&of.problem, &of.plan)
    }

    fn results(of: &LayersExecution) -> Outcome {
        of.statistics()
    }

    fn tables(results: &Outcome, labels: &Labels) -> Vec<Table> {
        let rows = results.agents.iter().map(|a| {
            let only = |human: bool, x: f64, unit: &'static str| match a.human == human {
                true => Cell::Number(x, unit),
                false => Cell::Text("-".into()),
            };
            vec![
                Cell::Text(labels.member(&a.name).to_string()),
                Cell::Count(a.tasks),
                Cell::Number(a.worked, "s"),
                Cell::Number(a.travelled, "m"),
                only(false, a.energy, "J"),
                only(true, a.workload, "kg s"),
            ]
        });
        let columns = vec!["agent", "tasks", "at work", "travelled", "energy", "workload"];
        vec![Table { columns, rows: rows.collect() }]
    }

    fn columns(problem: &Problem) -> Vec<String> {
        let of = |name: &String| ["x", "y", "z", "doing", "task", "object", "tasks"].map(|of| format!("{name}.{of}"));
        problem.agents.iter().flat_map(|who| of(&who.name)).collect()
    }

    fn row(of: &LayersExecution) -> Vec<Cell> {
        let (problem, mut row) = (&of.problem, Vec::new());
        for view in (0..).map_while(|agent| of.agent(agent)) {
            row.extend(view.position.map(|x| Cell::Number(x, "m")));
            let task = view.work.and_then(|work| problem.tasks.get(work.task)).map(|task| task.name.clone());
            let object = view.work.and_then(|work| problem.objects.get(work.object?)).map(|thing| thing.name.clone());
            row.push(Cell::Text(doing(view.doing).into()));
            row.extend([task, object].map(|name| Cell::Text(name.unwrap_or_default())));
            row.push(Cell::Count(view.tasks));
        }
        row
    }

    fn work(of: &LayersExecution, member: usize) -> Option<Work> {
        let view = of.agent(member)?;
        let state = match view.doing {
            Doing::Working => WorkState::Works,
            Doing::Lost => WorkState::Lost,
            Doing::Idle if view.next.is_some() => WorkState::Waits,
            Doing::Idle => WorkState::Over,
        };
        Some(Work { state, since: view.since })
    }
}
