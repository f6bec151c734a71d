//! Web pages of a search: people report that an activity is done or late, and send the messages of srs section 7.1.

mod messages;

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::{Value, json};

use crate::executed::Executed;
use crate::execution::PlanChange;
use crate::kind::pages::words::clock_time;
use crate::kind::pages::{
    ALREADY_NOTED, Activity, Button, ButtonGroup, JournalSink, Pages, PersonContent, PersonMap, PersonMessage,
    Progress, Refusal, Step, additional_time, parse,
};
use crate::kind::{Detail, Execution};

use super::event::{activity, named};
use super::execution::{AgentView, Event as Handled, LogEntry, SearchWorld};
use super::plan::{Activity as Planned, Phase};
use super::problem::{EMPTY, Problem};

use self::messages::{Message, Sent, planned};

/// Delay of the button for a longer activity (s).
const DELAY: f64 = 30.0;

/// A request of a person. An activity is named by its number, so that duplicated or late requests are recognised.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(tag = "what", rename_all = "snake_case", deny_unknown_fields)]
enum PersonRequest {
    /// The activity is done.
    Done {
        activity: usize,
    },
    /// The activity takes longer, until a new expected end (s).
    Longer {
        activity: usize,
        until: f64,
    },
    /// A hidden object is found: the number of those of its group that the page shows as found, and its member.
    Found {
        object: usize,
        found: usize,
    },
    /// A message: *My pose*, *My goal*, *Robot goal*, *Robot pose*, the goal of somebody is withdrawn, *Replan*.
    MyPose(Message),
    MyGoal(Message),
    RobotGoal(Message),
    RobotPose(Message),
    Free(Message),
    Replan(Message),
}

/// A search under way with its pages.
pub(super) struct SearchPages {
    run: Executed<SearchWorld>,
    /// Messages of each person, by member.
    sent: BTreeMap<usize, Sent>,
}

impl SearchPages {
    /// The pages of a search at its start.
    pub(super) fn new(run: Executed<SearchWorld>) -> SearchPages {
        SearchPages { run, sent: BTreeMap::new() }
    }

    fn problem(&self) -> &Problem {
        self.run.execution.problem()
    }

    fn view(&self, member: usize) -> Option<AgentView> {
        self.run.execution.agent(member)
    }
}

/// An activity as an instruction for the person who performs it.
fn instruction(problem: &Problem, phase: Phase, source: Option<usize>) -> String {
    if phase == Phase::Staying && source.is_none() {
        return "Look around".into();
    }
    let source = source.map_or("a place", |source| problem.source_label(source));
    match phase {
        Phase::Going => format!("Go to {source}"),
        Phase::Staying => format!("Stay at {source}"),
        Phase::Waiting => "Wait".into(),
    }
}

impl SearchPages {
    /// The buttons by which people report finds.
    fn hidden_objects(&self, here: bool) -> Option<ButtonGroup> {
        let open = self.problem().objects.iter().enumerate().filter(|(_, object)| object.left() > 0);
        let buttons: Vec<Button> = open
            .map(|(index, object)| {
                let request = json!({ "what": "found", "object": index, "found": object.found });
                let label = format!("Found: {}", self.problem().object_label(index));
                Button::new(format!("found_{index}"), label, here, request)
            })
            .collect();
        let count: (usize, usize) =
            self.problem().objects.iter().fold((0, 0), |(found, all), of| (found + of.found, all + of.count));
        let heading = format!("Hidden objects, {} of {} found", count.0, count.1);
        (!buttons.is_empty()).then_some(ButtonGroup { heading, buttons })
    }
}

impl Pages for SearchPages {
    fn execution(&self) -> &dyn Execution {
        &self.run
    }

    fn execution_mut(&mut self) -> &mut dyn Execution {
        &mut self.run
    }

    fn plan_status(&self) -> String {
        let plan = self.run.execution.plan();
        format!("the last plan promises a reward of {:.2} ({})", 0.0 - plan.cost, plan.engine)
    }

    fn progress(&self) -> Progress {
        let of = &self.run.execution;
        Progress {
            done: Some(format!("reward {:.2}", of.rewards().total)),
            over: of.done().then(|| "The search is over: every activity is done.".into()),
            stranded: of.stranded().map(|why| format!("The search has stopped: {why}.")),
        }
    }

    fn activity(&self, member: usize) -> Activity {
        let problem = self.problem();
        let Some(view) = self.view(member) else {
            let source = member - problem.agents.len().min(member);
            if let Some(object) = source.checked_sub(problem.sources.len()).and_then(|of| problem.objects.get(of)) {
                let doing = format!("{} of {} found", object.found, object.count);
                return Activity { doing, ..Activity::default() };
            }
            let pool = self.run.execution.rewards().pools.get(source).copied().unwrap_or_default();
            let doing = match pool {
                pool if pool.is_infinite() => "never ends".into(),
                pool if pool <= EMPTY => "is consumed".into(),
                pool => format!("{pool:.2} left"),
            };
            return Activity { doing, ..Activity::default() };
        };
        let what = view.doing.map(|phase| activity(problem, phase, view.source));
        Activity {
            doing: match (view.lost, what, view.until) {
                (true, _, _) => "has left".into(),
                (_, Some(what), Some(until)) => format!("{what}, until {}", clock_time(until)),
                (_, Some(what), None) => what,
                (_, None, _) => "has nothing to do".into(),
            },
            at: Some(view.pose.at),
            lost: view.lost,
            until: view.until,
            fails: false,
        }
    }

    fn person(&self, member: usize) -> PersonContent {
        let (problem, of) = (self.problem(), &self.run.execution);
        let Some(view) = self.view(member) else { return PersonContent::default() };
        let own: Vec<Planned> = of.activities().into_iter().filter(|activity| activity.agent == member).collect();
        let does = |activity: &Planned| instruction(problem, activity.phase, activity.source);
        let next = own.get(view.number + usize::from(view.doing.is_some()));
        let ends = view.until.is_some();
        let of_activity = |what: &str| json!({ "what": what, "activity": view.number });
        let until = view.until.map_or(Value::Null, |until| (until + DELAY).into());
        let longer = json!({ "what": "longer", "activity": view.number, "until": until });
        let step = |(number, activity): (usize, &Planned)| Step {
            at: activity.start,
            text: does(activity),
            state: match number.cmp(&view.number) {
                std::cmp::Ordering::Less => "done",
                std::cmp::Ordering::Equal if view.doing.is_some() => "now",
                _ => "next",
            },
        };
        PersonContent {
            doing: match view.doing {
                Some(phase) => format!("{}.", instruction(problem, phase, view.source)),
                None if view.lost => "You have left the search.".into(),
                None => "You have nothing to do.".into(),
            },
            since: view.doing.map(|_| view.since),
            until: view.until,
            next: match next {
                Some(next) => format!("{}, at {}.", does(next), clock_time(next.start)),
                None => "Nothing more is planned for you.".into(),
            },
            detail: Some(self.roles()),
            groups: std::iter::once(ButtonGroup {
                heading: "Activity".into(),
                buttons: vec![
                    Button::main("done", "Done", ends, of_activity("done")),
                    Button::new("longer", "30 s longer", ends, longer),
                ],
            })
            .chain(self.hidden_objects(!view.lost))
            .chain(self.message_buttons(member, !view.lost))
            .collect(),
            map: Some(PersonMap {
                drawing: of.records().len(),
                marks: (0..problem.agents.len()).filter_map(|agent| Some(of.agent(agent)?.believed.at)).collect(),
            }),
            reminder: self.reminder(member),
            steps: own.iter().enumerate().map(step).collect(),
            ..PersonContent::default()
        }
    }

    fn message(&self, entry: usize, member: usize) -> Option<PersonMessage> {
        let (problem, record) = (self.problem(), self.run.execution.records().get(entry)?);
        let who = |agent: &usize| problem.agent_label(*agent);
        let text = match &record.what {
            LogEntry::Begun { agent, phase, source } if *agent == member => {
                format!("{}.", instruction(problem, *phase, *source))
            }
            LogEntry::Consumed { source } => format!("{} is consumed.", problem.source_label(*source)),
            LogEntry::Handled { event: Handled::Lost { agent } } if *agent == member => {
                "You have left the search.".into()
            }
            LogEntry::Handled { event: Handled::Back { agent } } if *agent == member => "You are back.".into(),
            LogEntry::Handled { event: Handled::RobotGoal { agent, .. } } => {
                format!("{} has a goal that was told.", who(agent))
            }
            LogEntry::Handled { event: Handled::MyGoal { agent, .. } } if *agent != member => {
                format!("{} has told a goal.", who(agent))
            }
            LogEntry::Found { object, agent } if *agent == member => {
                format!("You have found {}.", problem.object_label(*object))
            }
            LogEntry::Found { object, agent } => {
                format!("{} has found {}.", who(agent), problem.object_label(*object))
            }
            LogEntry::Handled { event: Handled::Found { object } } => {
                format!("{} is found.", problem.object_label(*object))
            }
            LogEntry::Reminded { agent } if *agent == member => {
                return Some(PersonMessage::latest("reminder", "You are reminded to send your pose."));
            }
            LogEntry::GoalReached { agent } if *agent == member => "You have reached your goal.".into(),
            LogEntry::GoalReached { agent } => format!("{} has reached the goal.", who(agent)),
            LogEntry::Role { role } => return Some(PersonMessage::latest("role", format!("Roles: {}.", role.name()))),
            LogEntry::Handled { event: Handled::Lost { agent } } => format!("{} has left.", who(agent)),
            LogEntry::Handled { event: Handled::Back { agent } } => format!("{} is back.", who(agent)),
            LogEntry::Plan(PlanChange::Reallocated { .. }) => {
                return Some(PersonMessage::latest("plan", "There is a new plan."));
            }
            LogEntry::Plan(PlanChange::Stranded { why }) => {
                return Some(PersonMessage::latest("plan", format!("The search has stopped: {why}.")));
            }
            LogEntry::Done => "The search is over.".into(),
            _ => return None,
        };
        Some(PersonMessage::new(text))
    }

    fn request(&mut self, member: usize, body: &Value, journal: &mut JournalSink<'_>) -> Result<String, Refusal> {
        let request: PersonRequest = parse(body)?;
        let view = self.view(member).ok_or_else(|| Refusal::Invalid("there is no such member".into()))?;
        let now = clock_time(self.run.execution.time());
        match request {
            PersonRequest::Done { activity } | PersonRequest::Longer { activity, .. } if activity < view.number => {
                Ok("This activity is done already.".into())
            }
            PersonRequest::Done { activity } | PersonRequest::Longer { activity, .. }
                if activity > view.number || view.until.is_none() =>
            {
                Err(Refusal::NotNow("This activity is not yours now: look at the page.".into()))
            }
            PersonRequest::Done { .. } => {
                self.happen(&named(member, "done", None), journal)?;
                Ok(format!("Noted: done at {now}."))
            }
            PersonRequest::Longer { until, .. } => {
                let Some(by) = additional_time(view.until, until) else { return Ok(ALREADY_NOTED.into()) };
                let update = self.happen(&named(member, "late", Some(("by", Detail::Number(by)))), journal)?;
                Ok(format!("Noted: {by:.0} s longer, until {}. {}", clock_time(until), planned(update)))
            }
            PersonRequest::Found { object, found } => {
                let of = self
                    .problem()
                    .objects
                    .get(object)
                    .ok_or_else(|| Refusal::Invalid("there is no such object".into()))?;
                if found < of.found {
                    return Ok("This find is noted already.".into());
                }
                if found > of.found || of.left() == 0 {
                    return Err(Refusal::NotNow("This page is not up to date: look at it, and send it again.".into()));
                }
                let whole = self.problem().agents.len() + self.problem().sources.len() + object;
                self.happen(&named(whole, "found", None), journal)?;
                Ok(format!("Noted: found at {now}."))
            }
            PersonRequest::MyPose(message) => self.send(member, message, "my_pose", member, journal),
            PersonRequest::MyGoal(message) => self.send(member, message, "my_goal", member, journal),
            PersonRequest::RobotGoal(message) => self.send(member, message, "robot_goal", message.agent()?, journal),
            PersonRequest::RobotPose(message) => self.send(member, message, "robot_pose", message.agent()?, journal),
            PersonRequest::Free(message) => self.send(member, message, "free", message.agent()?, journal),
            PersonRequest::Replan(message) => self.send(member, message, "replan", member, journal),
        }
    }
}
