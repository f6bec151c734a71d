//! The execution of a search behind the interface of all kinds: measures, logs and results.

use quantities::dimension::{LENGTH, NONE, TIME};
use serde::Serialize;

use crate::chart::Chart;
use crate::executed::{MeasureTable, Reports};
use crate::kind::course::{Course, GroundPose};
use crate::kind::{Cell, Event, Form, Measure, Table, Work, number, truth};
use crate::labels::Labels;
use crate::map::Map;

use super::chart::chart_of_execution;
use super::event;
use super::execution::{LogEntry, Role, SearchExecution, SearchWorld};
use super::map::map;
use super::plan::Phase;
use super::problem::{EMPTY, Problem};

const EVERYBODY: &[&str] = &["robot", "human"];
const PERSON: &[&str] = &["human"];
const SOURCE: &[&str] = &["source"];
const OBJECT: &[&str] = &["object"];

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
    (
        Measure::whole(
            "explored",
            Form::Number(NONE),
            "Share of the ground that is explored: the mean over its cells of the probability that a hidden object there would have \
             been detected.",
        ),
        |of, _| Some(number(of.explored(None))),
    ),
    (Measure::whole("all_found", Form::Truth, "True once every hidden object is found."), |of, _| {
        Some(truth(!of.problem().is_searching()))
    }),
    (
        Measure::of(
            EVERYBODY,
            "explored",
            Form::Number(NONE),
            "Share of the ground that it has explored before the others.",
        ),
        |of, agent| Some(number(of.explored(Some(agent)))),
    ),
    (
        Measure::of(EVERYBODY, "finds", Form::Number(NONE), "Number of hidden objects that it has found."),
        |of, agent| Some(number(of.finds(agent) as f64)),
    ),
    (Measure::of(OBJECT, "found", Form::Number(NONE), "Number of these objects that are found."), |of, object| {
        Some(number(of.problem().objects.get(object)?.found as f64))
    }),
    (
        Measure::of(OBJECT, "left", Form::Number(NONE), "Number of these objects that are still hidden."),
        |of, object| Some(number(of.problem().objects.get(object)?.left() as f64)),
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
    (Measure::of(PERSON, "poses", Form::Number(NONE), "Number of its messages *My pose*."), |of, agent| {
        Some(number(of.poses(agent) as f64))
    }),
    (
        Measure::of(
            PERSON,
            "prompt",
            Form::Number(NONE),
            "Share of the times between its messages *My pose* that are below the threshold: `below` of its habits, else `after` of \
             the reminder, else 10 s. Before the second message it is 1.",
        ),
        |of, agent| {
            let [times, prompt] = of.times_between_poses(agent);
            Some(number(if times == 0 { 1.0 } else { prompt as f64 / times as f64 }))
        },
    ),
    (
        Measure::of(PERSON, "reminders", Form::Number(NONE), "Number of times that it was reminded to send its pose."),
        |of, agent| Some(number(of.reminders(agent) as f64)),
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
    (
        Measure::of(
            &["robot"],
            "faulted",
            Form::OfController,
            "True while it is lost because the controller that it runs has broken down.",
        ),
        |_, _| None,
    ),
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
    #[serde(skip_serializing_if = "Option::is_none")]
    explored: Option<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    objects: Vec<ObjectResult>,
}

#[derive(Debug, Serialize)]
pub struct AgentResult {
    name: String,
    reward: f64,
    travelled: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    explored: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    finds: Option<usize>,
}

#[derive(Debug, Serialize)]
pub struct ObjectResult {
    name: String,
    count: usize,
    found: usize,
    /// Times at which they were found (s).
    times: Vec<f64>,
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
                if source < problem.sources.len() {
                    return Some(("source", source));
                }
                let object = source - problem.sources.len();
                (object < problem.objects.len()).then_some(("object", object))
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
            LogEntry::Begun { .. } | LogEntry::Reminded { .. } => false,
            LogEntry::Plan(change) => change.is_notable(),
            LogEntry::Consumed { .. }
            | LogEntry::Found { .. }
            | LogEntry::Handled { .. }
            | LogEntry::GoalReached { .. }
            | LogEntry::Role { .. }
            | LogEntry::Done => true,
        }
    }

    fn chart(of: &SearchExecution) -> Chart {
        chart_of_execution(of)
    }

    fn map(of: &SearchExecution) -> Map {
        map(&of.problem_from_start(), &of.activities())
    }

    fn results(of: &SearchExecution) -> Results {
        let (problem, rewards) = (&of.problem, of.rewards());
        let hides = !problem.objects.is_empty();
        let agents = problem.agents.iter().enumerate().map(|(index, agent)| AgentResult {
            name: agent.name.clone(),
            reward: rewards.agents[index],
            travelled: of.agent(index).map_or(0.0, |view| view.travelled),
            explored: hides.then(|| of.explored(Some(index))),
            finds: hides.then(|| of.finds(index)),
        });
        let objects = problem.objects.iter().enumerate().map(|(index, object)| {
            let own = of.secrets().iter().filter(|secret| secret.object == index);
            let mut times: Vec<f64> = own.filter_map(|secret| secret.found).collect();
            times.sort_by(f64::total_cmp);
            ObjectResult { name: object.name.clone(), count: object.count, found: object.found, times }
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
            explored: hides.then(|| of.explored(None)),
            objects: objects.collect(),
        }
    }

    fn tables(results: &Results, labels: &Labels) -> Vec<Table> {
        let label = |name: &str| Cell::Text(labels.member(name).to_string());
        let of_agent = |agent: &AgentResult| {
            let mut row = vec![label(&agent.name), Cell::Number(agent.reward, ""), Cell::Number(agent.travelled, "m")];
            row.extend(agent.explored.map(|share| Cell::Number(100.0 * share, "%")));
            row.extend(agent.finds.map(|finds| Cell::Number(finds as f64, "")));
            row
        };
        let of_object = |object: &ObjectResult| {
            let last = object.times.last().map_or(Cell::Text("-".into()), |last| Cell::Number(*last, "s"));
            vec![label(&object.name), Cell::Text(format!("{} of {}", object.found, object.count)), last]
        };
        let of_source = |source: &SourceResult| {
            let left = source.left.map_or(Cell::Text("endless".into()), |left| Cell::Number(left, ""));
            vec![label(&source.name), Cell::Number(source.reward, ""), left]
        };
        let hides = !results.objects.is_empty();
        let mut columns = vec!["agent", "reward", "travelled"];
        if hides {
            columns.extend(["explored", "finds"]);
        }
        let mut tables = vec![Table { columns, rows: results.agents.iter().map(of_agent).collect() }];
        if !results.sources.is_empty() || !hides {
            let rows = results.sources.iter().map(of_source).collect();
            tables.push(Table { columns: vec!["source", "reward", "left"], rows });
        }
        if hides {
            let rows = results.objects.iter().map(of_object).collect();
            tables.push(Table { columns: vec!["hidden", "found", "last found"], rows });
        }
        tables
    }

    fn columns(problem: &Problem) -> Vec<String> {
        let of = |name: &String| ["x", "y", "doing", "source", "reward"].map(|of| format!("{name}.{of}"));
        let pools = problem.sources.iter().filter(|source| source.pool.is_some());
        let pools = pools.map(|source| format!("{}.pool", source.name));
        let found = problem.objects.iter().map(|object| format!("{}.found", object.name));
        let explored = (!problem.objects.is_empty()).then(|| "explored".to_string());
        problem.agents.iter().flat_map(|agent| of(&agent.name)).chain(pools).chain(found).chain(explored).collect()
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
        row.extend(problem.objects.iter().map(|object| Cell::Number(object.found as f64, "")));
        row.extend((!problem.objects.is_empty()).then(|| Cell::Number(of.explored(None), "")));
        row
    }

    fn work(of: &SearchExecution, member: usize) -> Option<Work> {
        of.driven_work(member)
    }

    fn pose(of: &SearchExecution, member: usize, time: f64) -> Option<GroundPose> {
        (member < of.problem().agents.len()).then(|| {
            let pose = of.true_pose(member, time);
            GroundPose { at: pose.at, heading: pose.heading }
        })
    }

    fn course(of: &SearchExecution, member: usize) -> Option<Course<'_>> {
        of.course(member)
    }

    fn drive(of: &mut SearchExecution, member: usize, time: f64, pose: GroundPose) {
        of.drive(member, time, pose);
    }
}
