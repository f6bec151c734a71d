//! A schedule as a [`Mission`]: its parts, its checks, and how it is executed.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::engine::Budget;
use crate::executed::Executed;
use crate::execution::Durations;
use crate::kind::pages::{Pages, ServeSettings};
use crate::kind::{self, Event, EventInfo, Further, Impossible, Kind, Member, Mistake, NotOf, Run};
use crate::labels::Labels;
use crate::numbers::MAX_BATCH;
use crate::planned::{PlanOptions, Planned, Refusal};

use super::adapt::Adaptation;
use super::blocks::SCHEDULE;
use super::build::build;
use super::check::Item;
use super::choose::{Formulation, Options};
use super::execution::{Potentials, ScheduleExecution, Settings, Travel};
use super::pages::SchedulePages;
use super::problem::{AgentKind, Distances, Problem};
use super::run::MEASURES;
use super::{event, text};

/// The work of a plan, the first one and each that is made anew. The count of nodes ends it at the same place in every run: a
/// second on a usual machine. The time, which would not, is far beyond that.
const BUDGET: Budget = Budget { time: Duration::from_secs(60), nodes: 300, gap: 1e-4 };

/// The entry of the kind.
pub static KIND: Kind = Kind {
    name: "schedule",
    title: "a schedule",
    doc: "Who serves whom, when and how fast: service robots come to people and working robots at the end of each of their \
          operations.",
    schema: &SCHEDULE,
    build: |declared, remarks| Box::new(build(declared, remarks)),
    measures: || MEASURES.iter().map(|(measure, _)| measure).collect(),
    events: &[
        of_agents("begun", &[]),
        of_agents("done", &[]),
        EventInfo {
            name: "late",
            with: &[Further { key: "by", required: Some("60 s") }],
            not_of: &[],
            not_driven: None,
        },
        of_agents("served", &[]),
        EventInfo { name: "failed", with: &[], not_of: &[], not_driven: None },
        EventInfo {
            name: "moved",
            with: &[Further { key: "to", required: Some("[2, 0] m") }],
            not_of: &[NotOf { role: "robot", who: SERVES, why: "the position of a robot follows from its plan" }],
            not_driven: None,
        },
        EventInfo {
            name: "feedback",
            with: &[
                Further { key: "wait", required: None },
                Further { key: "approach", required: None },
                Further { key: "distance", required: None },
            ],
            not_of: &[
                NotOf { role: "robot", who: SERVES, why: PEOPLE },
                NotOf { role: "worker", who: "a working robot", why: PEOPLE },
            ],
            not_driven: None,
        },
        EventInfo { name: "lost", with: &[], not_of: &[], not_driven: None },
        EventInfo { name: "back", with: &[], not_of: &[], not_driven: None },
    ],
    absent: &[],
    formulations: || Formulation::ALL.map(Formulation::name).to_vec(),
    plan_keys: include_str!("plan.schema.json"),
    read: |value| Ok(Box::new(serde_json::from_value::<Schedule>(value)?)),
};

const SERVES: &str = "a robot that serves";
const PEOPLE: &str = "only people give feedback";

/// An event of those who are served.
const fn of_agents(name: &'static str, with: &'static [Further]) -> EventInfo {
    const SERVED: &[NotOf] =
        &[NotOf { role: "robot", who: SERVES, why: "a service robot has no operations: it serves those of agents" }];
    EventInfo { name, with, not_of: SERVED, not_driven: None }
}

/// A schedule to be planned, executed and repaired.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Schedule {
    /// The problem of the planner.
    pub problem: Problem,
    /// Constants of the adaptation to feedback.
    pub adaptation: Adaptation,
    /// The relative change of its cost above which the rest of a plan is planned anew, `iota` of thesis (5.19). Zero or
    /// more.
    pub reallocate_above: f64,
    /// Operations planned at a time if there are too many for all at once, 1 to [`MAX_BATCH`].
    pub batch: usize,
}

impl Schedule {
    /// The settings of a run.
    pub fn settings(&self, how: &Run) -> Settings {
        let agent = |member: &usize| member.checked_sub(self.problem.robots.len());
        Settings {
            durations: how.sampled.map_or(Durations::Planned, |seed| Durations::Sampled { seed }),
            travel: if how.bases { Travel::Bases(Potentials::default()) } else { Travel::Planned },
            adaptation: self.adaptation,
            reallocate_above: self.reallocate_above,
            replan: how.replan,
            planning: Options { batch: self.batch, budget: BUDGET, ..Options::default() },
            reporting: how.reporting.iter().filter_map(agent).collect(),
        }
    }

    /// The part that a mistake of the problem is about.
    fn place(&self, at: Item) -> String {
        let named = |what: &str, name: Option<&String>| format!("{what} `{}`", name.map_or("?", String::as_str));
        match at {
            Item::Mission => "the mission".to_string(),
            Item::Robot(i) => named("robot", self.problem.robots.get(i).map(|m| &m.name)),
            Item::Agent(i) => named("agent", self.problem.agents.get(i).map(|a| &a.name)),
            Item::Begun(i) => format!("begun[{i}]"),
        }
    }
}

/// Everybody who takes part: robots, then agents.
pub(super) fn members(problem: &Problem) -> Vec<Member<'_>> {
    let robots = problem.robots.iter().map(|robot| Member { name: &robot.name, role: "robot" });
    let agents = problem.agents.iter().map(|agent| Member {
        name: &agent.name,
        role: match agent.kind {
            AgentKind::Human => "human",
            AgentKind::Worker => "worker",
        },
    });
    robots.chain(agents).collect()
}

impl kind::Mission for Schedule {
    fn kind(&self) -> &'static Kind {
        &KIND
    }

    fn members(&self) -> Vec<Member<'_>> {
        members(&self.problem)
    }

    fn labels(&self) -> &Labels {
        &self.problem.labels
    }

    fn work_of(&self, member: usize) -> usize {
        let agent = member.checked_sub(self.problem.robots.len());
        agent.and_then(|agent| self.problem.agents.get(agent)).map_or(0, |agent| agent.operations)
    }

    fn check(&self) -> Result<(), Mistake> {
        if let Some(mistake) = self.problem.check().first() {
            return Err(Mistake { place: self.place(mistake.at.item), why: mistake.reason.to_string() });
        }
        self.problem.labels.check_among(members(&self.problem).iter().map(|member| member.name))?;
        let usual = |x: f64| x.is_finite() && x >= 0.0;
        let Adaptation { memory, wait_gain, approach_gain, margin, wait_step } = self.adaptation;
        let share = |x: f64| (0.0..=1.0).contains(&x);
        let good = share(memory) && share(margin) && usual(wait_gain) && usual(approach_gain) && usual(wait_step);
        Mistake::unless(good, "adaptation", "its numbers must be zero or more, memory and margin at most 1")?;
        Mistake::unless(usual(self.reallocate_above), "reallocate_above", "it is zero or more")?;
        Mistake::unless((1..=MAX_BATCH).contains(&self.batch), "batch", "it is a whole number from 1 to 512")
    }

    fn check_run(&self, how: &Run) -> Result<(), String> {
        self.settings(how).check(&self.problem).map_err(|why| why.to_string())?;
        let mut seen = Vec::new();
        for replies in &how.replies {
            let members = members(&self.problem);
            let person = members.get(replies.member).is_some_and(|member| member.role == "human");
            if !person || seen.contains(&replies.member) || replies.services.is_empty() {
                return Err("only people give feedback, each in one entry".into());
            }
            seen.push(replies.member);
        }
        Ok(())
    }

    fn check_event(&self, of: &Event) -> Result<(), Impossible> {
        if of.event == "moved" && self.problem.distances != Distances::Straight {
            return Err(Impossible {
                text: "`moved` is not possible in this mission".into(),
                note: Some("the lengths of paths come from `distances`, which has no other places"),
                help: Some("remove it, or remove `distances` from the mission for straight lines"),
            });
        }
        event::typed(&self.problem, of).map(|_| ()).map_err(Impossible::from)
    }

    fn describe(&self, of: &Event) -> String {
        event::describe(&self.problem, of)
    }

    fn describe_run(&self, how: &Run) -> String {
        let operations = if how.sampled.is_some() { "sampled" } else { "planned" };
        let travel = if how.bases { "as bases" } else { "as planned" };
        format!("operations {operations}, robots travel {travel}")
    }

    fn text(&self, name: &str) -> String {
        text::text(name, self)
    }

    fn plan(&self, options: &PlanOptions<'_>) -> Result<Planned, Refusal> {
        self.planned(options)
    }

    fn execute(&self, how: &Run) -> Result<Box<dyn kind::Execution>, String> {
        let execution =
            ScheduleExecution::new(self.problem.clone(), self.settings(how)).map_err(|why| why.to_string())?;
        Ok(Box::new(Executed::new(execution, how.replies.clone())))
    }

    fn pages(&self, of: &ServeSettings) -> Result<Box<dyn Pages>, String> {
        let mut settings = self.settings(&of.run());
        settings.planning.budget = of.budget(0);
        let execution = ScheduleExecution::new(self.problem.clone(), settings).map_err(|why| why.to_string())?;
        Ok(Box::new(SchedulePages::new(Executed::new(execution, Vec::new()))))
    }
}
