//! The execution of a schedule behind the interface of all kinds: measures, logs and results.

use quantities::dimension::{ENERGY, LENGTH, NONE, TIME, VELOCITY};

use super::plan::Actor;
use crate::chart::Chart;
use crate::executed::{MeasureTable, Reports};
use crate::kind::{Cell, Event, Form, Measure, Table, Work, WorkState, number, truth};
use crate::labels::Labels;
use crate::map::Map;

use super::chart::chart;
use super::event;
use super::execution::{
    AgentOutcome, AgentView, Doing, LogEntry, Outcome, RobotOutcome, RobotView, ScheduleExecution, ScheduleWorld, Stage,
};
use super::map::map;
use super::problem::{AgentKind, Problem};
use super::words::{doing, of_log_entry, stage};

const AGENTS: &[&str] = &["human", "worker"];
const ROBOTS: &[&str] = &["robot"];

/// The results of an agent so far.
fn agent(of: &ScheduleExecution, index: usize) -> Option<(AgentView, AgentOutcome)> {
    Some((of.agent(index)?, of.statistics().agents.into_iter().nth(index)?))
}

/// The results of a robot so far.
fn robot(of: &ScheduleExecution, index: usize) -> Option<(RobotView, RobotOutcome)> {
    Some((of.robot(index)?, of.statistics().robots.into_iter().nth(index)?))
}

/// Everything that is measured of schedules; the index is that of the agent or of the robot.
pub(super) const MEASURES: &MeasureTable<ScheduleWorld> = &[
    (
        Measure::whole(
            "done",
            Form::Truth,
            "True once all possible services are done and every robot is back at its depot; `done` alone is the same.",
        ),
        |of, _| Some(truth(of.done())),
    ),
    (
        Measure::whole(
            "stranded",
            Form::Truth,
            "True once no plan is feasible: no robot is left, or no plan was found.",
        ),
        |of, _| Some(truth(of.stranded().is_some())),
    ),
    (
        Measure::whole("makespan", Form::Number(TIME), "Time from the start to the end of the last finished service."),
        |of, _| Some(number(of.statistics().makespan)),
    ),
    (Measure::whole("cost", Form::Number(NONE), "Cost of the current plan."), |of, _| Some(number(of.plan().cost))),
    (Measure::whole("energy", Form::Number(ENERGY), "Energy of all robots for trips that have ended."), |of, _| {
        Some(number(of.statistics().energy()))
    }),
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
    (
        Measure::of(AGENTS, "waited", Form::Number(TIME), "Sum of its waits so far, including the current one."),
        |of, index| Some(number(agent(of, index)?.1.waited())),
    ),
    (
        Measure::of(AGENTS, "served", Form::Number(NONE), "Number of its operations that have been served."),
        |of, index| Some(number(agent(of, index)?.1.served as f64)),
    ),
    (Measure::of(AGENTS, "working", Form::Truth, "True while it is at work."), |of, index| {
        Some(truth(of.agent(index)?.doing == Doing::Working))
    }),
    (Measure::of(AGENTS, "lost", Form::Truth, "True while it is lost: it has left."), |of, index| {
        Some(truth(of.agent(index)?.doing == Doing::Lost))
    }),
    (
        Measure::of(
            AGENTS,
            "faulted",
            Form::OfController,
            "True if the controller that it runs has broken down, so that it is lost.",
        ),
        |_, _| None,
    ),
    (Measure::of(AGENTS, "position", Form::Point, "Position at which it works and is served."), |of, index| {
        let [x, y] = of.agent(index)?.place;
        Some([x, y, 0.0])
    }),
    (
        Measure::of(
            AGENTS,
            "adaptation",
            Form::Number(NONE),
            "Adaptation index of its waits: 1 at the start; larger if its waits changed as its feedback asked.",
        ),
        |of, index| Some(number(agent(of, index)?.1.wait_index)),
    ),
    (
        Measure::of(
            AGENTS,
            "speed_adaptation",
            Form::Number(NONE),
            "Adaptation index of the approach speeds of robots.",
        ),
        |of, index| Some(number(agent(of, index)?.1.speed_index)),
    ),
    (
        Measure::of(
            AGENTS,
            "wait_satisfaction",
            Form::Number(NONE),
            "Smoothed feedback about its waits: from -1, too short, to 1, too long; 0 without feedback.",
        ),
        |of, index| Some(number(of.satisfaction(index).wait)),
    ),
    (
        Measure::of(
            AGENTS,
            "approach_satisfaction",
            Form::Number(NONE),
            "Smoothed feedback about approaches: from -1, very fast, to 1, very slow; 0 without feedback.",
        ),
        |of, index| Some(number(of.satisfaction(index).approach)),
    ),
    (Measure::of(ROBOTS, "position", Form::Point, "Its position."), |of, index| {
        let [x, y] = of.robot(index)?.position;
        Some([x, y, 0.0])
    }),
    (Measure::of(ROBOTS, "speed", Form::Number(VELOCITY), "Its speed, zero or more."), |of, index| {
        Some(number(speed(&of.robot(index)?)))
    }),
    (
        Measure::of(ROBOTS, "travelled", Form::Number(LENGTH), "Distance covered in trips that have ended."),
        |of, index| Some(number(robot(of, index)?.1.travelled)),
    ),
    (Measure::of(ROBOTS, "energy", Form::Number(ENERGY), "Energy for this distance."), |of, index| {
        Some(number(robot(of, index)?.1.energy))
    }),
    (
        Measure::of(ROBOTS, "busy", Form::Truth, "True while it is under way, waits for an agent, serves, or unloads."),
        |of, index| Some(truth(!matches!(of.robot(index)?.stage, Stage::Home | Stage::Lost))),
    ),
    (Measure::of(ROBOTS, "served", Form::Number(NONE), "Number of operations that it has served."), |of, index| {
        Some(number(robot(of, index)?.1.served as f64))
    }),
    (Measure::of(ROBOTS, "lost", Form::Truth, "True while it is lost: it has broken down."), |of, index| {
        Some(truth(of.robot(index)?.stage == Stage::Lost))
    }),
];

fn speed(view: &RobotView) -> f64 {
    f64::hypot(view.velocity[0], view.velocity[1])
}

impl Reports for ScheduleWorld {
    type Results = Outcome;

    const MEASURES: &'static MeasureTable<ScheduleWorld> = MEASURES;

    fn labels(problem: &Problem) -> &Labels {
        &problem.labels
    }

    fn member(problem: &Problem, member: usize) -> Option<(&'static str, usize)> {
        Some(match event::actor(problem, member)? {
            Actor::Robot(robot) => (ROBOTS[0], robot),
            Actor::Agent(agent) => (AGENTS[0], agent),
        })
    }

    fn describe(problem: &Problem, event: &Event) -> String {
        event::describe(problem, event)
    }

    fn handle(of: &mut ScheduleExecution, event: &Event) -> Result<(), String> {
        event::handle(of, event)
    }

    fn describe_happening(problem: &Problem, what: &LogEntry) -> String {
        of_log_entry(what, problem)
    }

    fn is_notable(what: &LogEntry) -> bool {
        match what {
            LogEntry::Handled { .. } | LogEntry::HeldUp { .. } | LogEntry::BrokenOff { .. } | LogEntry::Done => true,
            LogEntry::Plan(change) => change.is_notable(),
            _ => false,
        }
    }

    fn served(problem: &Problem, what: &LogEntry) -> Option<usize> {
        match what {
            LogEntry::Served { agent, .. } => Some(event::member(problem, Actor::Agent(*agent))),
            _ => None,
        }
    }

    fn chart(of: &ScheduleExecution) -> Chart {
        chart(&of.problem, &of.plan)
    }

    fn map(of: &ScheduleExecution) -> Map {
        map(&of.problem, &of.plan)
    }

    fn results(of: &ScheduleExecution) -> Outcome {
        of.statistics()
    }

    fn tables(results: &Outcome, labels: &Labels) -> Vec<Table> {
        let label = |name: &str| Cell::Text(labels.member(name).to_string());
        let agents = results.agents.iter().map(|a| {
            let (all, most) = (a.waits.iter().sum::<f64>(), a.waits.iter().copied().fold(0.0, f64::max));
            vec![label(&a.name), Cell::Count(a.served), Cell::Number(all, "s"), Cell::Number(most, "s")]
        });
        let robots = results.robots.iter().map(|r| {
            vec![label(&r.name), Cell::Count(r.served), Cell::Number(r.travelled, "m"), Cell::Number(r.energy, "J")]
        });
        vec![
            Table { columns: vec!["agent", "served", "waited", "longest wait"], rows: agents.collect() },
            Table { columns: vec!["robot", "served", "travelled", "energy"], rows: robots.collect() },
        ]
    }

    fn columns(problem: &Problem) -> Vec<String> {
        let of = |name: &str, parts: &[&str]| parts.iter().map(|of| format!("{name}.{of}")).collect::<Vec<_>>();
        let robots = problem.robots.iter().flat_map(|m| of(&m.name, &["x", "y", "speed", "stage"]));
        let agents = problem.agents.iter().flat_map(|a| of(&a.name, &["x", "y", "doing", "served", "waited"]));
        robots.chain(agents).collect()
    }

    fn row(of: &ScheduleExecution) -> Vec<Cell> {
        let mut row = Vec::new();
        for view in (0..).map_while(|i| of.robot(i)) {
            let [x, y] = view.position;
            row.extend([Cell::Number(x, "m"), Cell::Number(y, "m"), Cell::Number(speed(&view), "m/s")]);
            row.push(Cell::Text(stage(view.stage).into()));
        }
        let so_far = of.statistics();
        for (view, results) in (0..).map_while(|i| of.agent(i)).zip(&so_far.agents) {
            let [x, y] = view.place;
            row.extend([Cell::Number(x, "m"), Cell::Number(y, "m"), Cell::Text(doing(view.doing).into())]);
            row.extend([Cell::Count(results.served), Cell::Number(results.waited(), "s")]);
        }
        row
    }

    fn work(of: &ScheduleExecution, member: usize) -> Option<Work> {
        let agent = event::agent(&of.problem, member)?;
        let (view, who) = (of.agent(agent)?, of.problem.agents.get(agent)?);
        if who.kind != AgentKind::Worker {
            return None;
        }
        let last = view.operation.is_none_or(|operation| operation + 1 >= who.operations);
        let state = match view.doing {
            Doing::Working => WorkState::Works,
            Doing::Lost => WorkState::Lost,
            Doing::Finished => WorkState::Over,
            Doing::Waiting | Doing::Served if last => WorkState::Over,
            _ => WorkState::Waits,
        };
        Some(Work { state, since: view.since })
    }
}
