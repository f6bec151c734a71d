//! The execution of a search behind the interface of all kinds: measures, logs and results.

use quantities::dimension::{LENGTH, NONE, TIME};
use serde::Serialize;

use crate::chart::Chart;
use crate::executed::{MeasureTable, Reports};
use crate::kind::{Cell, Event, Form, Measure, Table, Work, number, truth};
use crate::labels::Labels;
use crate::map::Map;

use super::chart::chart;
use super::event;
use super::execution::{LogEntry, Role, SearchExecution, SearchWorld};
use super::map::map;
use super::plan::Phase;
use super::problem::{EMPTY, Problem};

const EVERYBODY: &[&str] = &["robot", "human"];
const SOURCE: &[&str] = &["source"];

/// Everything that is measured of searches; the index is that of the agent or of the source.
pub(super) const MEASURES: &MeasureTable<SearchWorld> = &[
    (Measure::whole("done", Form::Truth, "True once every activity is done; `done` alone is the same."), |of, _| {
        Some(truth(of.done()))
    }),
    (Measure::whole("stranded", Form::Truth, "True while everybody is lost."), |of, _| {
        Some(truth(of.stranded().is_some()))
    }),
    (
        Measure::whole("makespan", Form::Number(TIME), "Time from the start to the end of the last finished activity."),
        |of, _| Some(number(of.makespan())),
    ),
    (Measure::whole("reward", Form::Number(NONE), "Reward of the team so far."), |of, _| {
        Some(number(of.rewards().total))
    }),
    (
        Measure::whole("promised", Form::Number(NONE), "Reward that the first plan promises, up to the horizon."),
        |of, _| Some(number(of.promised())),
    ),
    (
        Measure::whole(
            "reschedules",
            Form::Number(NONE),
            "Number of times that the plan was rescheduled with unchanged activities.",
        ),
        |of, _| Some(number(of.log.reschedules as f64)),
    ),
    (
        Measure::whole(
            "reallocations",
            Form::Number(NONE),
            "Number of times that the remaining activities were replanned.",
        ),
        |of, _| Some(number(of.log.reallocations as f64)),
    ),
    (Measure::whole("messages", Form::Number(NONE), "Number of messages that people have sent."), |of, _| {
        Some(number(of.messages().all() as f64))
    }),
    (
        Measure::whole("leader_follower", Form::Truth, "True while the plan decides the goals of people and robots."),
        |of, _| Some(truth(of.role() == Role::LeaderFollower)),
    ),
    (Measure::whole("peer_to_peer", Form::Truth, "True while a person has told their own goal alone."), |of, _| {
        Some(truth(of.role() == Role::PeerToPeer))
    }),
    (
        Measure::whole("master_slave", Form::Truth, "True while a person has told their own goal and that of a robot."),
        |of, _| Some(truth(of.role() == Role::MasterSlave)),
    ),
    (
        Measure::whole("leader_leader", Form::Truth, "True while a person has told the goal of a robot alone."),
        |of, _| Some(truth(of.role() == Role::LeaderLeader)),
    ),
    (Measure::of(EVERYBODY, "position", Form::Point, "Its position."), |of, agent| {
        let [x, y] = of.agent(agent)?.pose.at;
        Some([x, y, 0.0])
    }),
    (
        Measure::of(
            EVERYBODY,
            "believed",
            Form::Point,
            "Its position as the others believe it to be, from which they plan.",
        ),
        |of, agent| {
            let [x, y] = of.agent(agent)?.believed.at;
            Some([x, y, 0.0])
        },
    ),
    (
        Measure::of(
            EVERYBODY,
            "told",
            Form::Truth,
            "True while it has a goal that a person has told, and has not reached it.",
        ),
        |of, agent| Some(truth(of.told_goal(agent).is_some())),
    ),
    (Measure::of(EVERYBODY, "going", Form::Truth, "True while it is on a way."), |of, agent| {
        Some(truth(of.agent(agent)?.doing == Some(Phase::Going)))
    }),
    (Measure::of(EVERYBODY, "staying", Form::Truth, "True while it stays at a source."), |of, agent| {
        Some(truth(of.agent(agent)?.doing == Some(Phase::Staying)))
    }),
    (Measure::of(EVERYBODY, "lost", Form::Truth, "True while it is lost."), |of, agent| {
        Some(truth(of.agent(agent)?.lost))
    }),
    (Measure::of(EVERYBODY, "travelled", Form::Number(LENGTH), "Distance covered."), |of, agent| {
        Some(number(of.agent(agent)?.travelled))
    }),
    (Measure::of(EVERYBODY, "reward", Form::Number(NONE), "Reward that it has collected."), |of, agent| {
        Some(number(*of.rewards().agents.get(agent)?))
    }),
    (Measure::of(SOURCE, "reward", Form::Number(NONE), "Reward that it has given."), |of, source| {
        Some(number(*of.rewards().sources.get(source)?))
    }),
    (
        Measure::of(SOURCE, "pool", Form::Number(NONE), "Reward that is left in it; infinite without a `pool`."),
        |of, source| Some(number(*of.rewards().pools.get(source)?)),
    ),
    (Measure::of(SOURCE, "consumed", Form::Truth, "True while its pool is empty."), |of, source| {
        Some(truth(*of.rewards().pools.get(source)? <= EMPTY))
    }),
];

/// Results as they are stored in files.
#[derive(Debug, Serialize)]
pub struct Results {
    reward: f64,
    promised: f64,
    makespan: f64,
    agents: Vec<AgentResult>,
    sources: Vec<SourceResult>,
}

#[derive(Debug, Serialize)]
pub struct AgentResult {
    name: String,
    reward: f64,
    travelled: f64,
}

#[derive(Debug, Serialize)]
pub struct SourceResult {
    name: String,
    reward: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    left: Option<f64>,
}

impl Reports for SearchWorld {
    type Results = Results;

    const MEASURES: &'static MeasureTable<SearchWorld> = MEASURES;

    fn labels(problem: &Problem) -> &Labels {
        &problem.labels
    }

    fn member(problem: &Problem, member: usize) -> Option<(&'static str, usize)> {
        match problem.agents.get(member) {
            Some(agent) => Some((if agent.human { "human" } else { "robot" }, member)),
            None => {
                let source = member - problem.agents.len();
                (source < problem.sources.len()).then_some(("source", source))
            }
        }
    }

    fn describe(problem: &Problem, event: &Event) -> String {
        event::describe(problem, event)
    }

    fn handle(of: &mut SearchExecution, event: &Event) -> Result<(), String> {
        let event = event::typed(&of.problem, event)?;
        of.handle_event(event).map(|_| ()).map_err(|why| why.to_string())
    }

    fn describe_happening(problem: &Problem, what: &LogEntry) -> String {
        event::of_log_entry(problem, what)
    }

    fn is_notable(what: &LogEntry) -> bool {
        match what {
            LogEntry::Begun { .. } => false,
            LogEntry::Plan(change) => change.is_notable(),
            LogEntry::Consumed { .. }
            | LogEntry::Handled { .. }
            | LogEntry::GoalReached { .. }
            | LogEntry::Role { .. }
            | LogEntry::Done => true,
        }
    }

    fn chart(of: &SearchExecution) -> Chart {
        chart(&of.problem, &of.activities())
    }

    fn map(of: &SearchExecution) -> Map {
        map(&of.problem_from_start(), &of.activities())
    }

    fn results(of: &SearchExecution) -> Results {
        let (problem, rewards) = (&of.problem, of.rewards());
        let agents = problem.agents.iter().enumerate().map(|(index, agent)| AgentResult {
            name: agent.name.clone(),
            reward: rewards.agents[index],
            travelled: of.agent(index).map_or(0.0, |view| view.travelled),
        });
        let sources = problem.sources.iter().enumerate().map(|(index, source)| SourceResult {
            name: source.name.clone(),
            reward: rewards.sources[index],
            left: source.pool.map(|_| rewards.pools[index]),
        });
        Results {
            reward: rewards.total,
            promised: of.promised(),
            makespan: of.makespan(),
            agents: agents.collect(),
            sources: sources.collect(),
        }
    }

    fn tables(results: &Results, labels: &Labels) -> Vec<Table> {
        let label = |name: &str| Cell::Text(labels.member(name).to_string());
        let of_agent = |agent: &AgentResult| {
            vec![label(&agent.name), Cell::Number(agent.reward, ""), Cell::Number(agent.travelled, "m")]
        };
        let of_source = |source: &SourceResult| {
            let left = source.left.map_or(Cell::Text("endless".into()), |left| Cell::Number(left, ""));
            vec![label(&source.name), Cell::Number(source.reward, ""), left]
        };
        vec![
            Table {
                columns: vec!["agent", "reward", "travelled"],
                rows: results.agents.iter().map(of_agent).collect(),
            },
            Table { columns: vec!["source", "reward", "left"], rows: results.sources.iter().map(of_source).collect() },
        ]
    }

    fn columns(problem: &Problem) -> Vec<String> {
        let of = |name: &String| ["x", "y", "doing", "source", "reward"].map(|of| format!("{name}.{of}"));
        let pools = problem.sources.iter().filter(|source| source.pool.is_some());
        let pools = pools.map(|source| format!("{}.pool", source.name));
        problem.agents.iter().flat_map(|agent| of(&agent.name)).chain(pools).collect()
    }

    fn row(of: &SearchExecution) -> Vec<Cell> {
        let (problem, rewards) = (&of.problem, of.rewards());
        let mut row = Vec::new();
        for (index, reward) in rewards.agents.iter().enumerate() {
            let Some(view) = of.agent(index) else { continue };
            row.extend(view.pose.at.map(|x| Cell::Number(x, "m")));
            let source = view.source.and_then(|source| problem.sources.get(source)).map(|source| source.name.clone());
            let doing = if view.lost { "lost" } else { view.doing.map_or("idle", Phase::name) };
            row.push(Cell::Text(doing.into()));
            row.push(Cell::Text(source.unwrap_or_default()));
            row.push(Cell::Number(*reward, ""));
        }
        let pools = problem.sources.iter().zip(&rewards.pools).filter(|(source, _)| source.pool.is_some());
        row.extend(pools.map(|(_, pool)| Cell::Number(*pool, "")));
        row
    }

    fn work(_: &SearchExecution, _: usize) -> Option<Work> {
        None
    }
}
