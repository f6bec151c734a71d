//! A search as a [`Mission`](kind::Mission): its parts, its checks, and how it is executed.

use serde::{Deserialize, Serialize};

use crate::executed::Executed;
use crate::execution::Durations;
use crate::kind::course::{Drivable, GroundPose};
use crate::kind::pages::{Pages, ServeSettings};
use crate::kind::{self, Event, EventInfo, Further, Impossible, Kind, Member, Mistake, NotOf, Run};
use crate::labels::Labels;
use crate::planned::{PlanOptions, Planned, Refusal};

use super::blocks::SEARCH;
use super::build::build;
use super::check::{Item, check};
use super::check_people::in_range;
use super::choose::{Formulation, Options};
use super::execution::{SearchExecution, Settings};
use super::pages::SearchPages;
use super::problem::{MAX_COUNT, Problem, RateFunction};
use super::run::MEASURES;
use super::{event, text};

/// Sources and hidden objects take part in no event of agents.
const A_SOURCE: NotOf =
    NotOf { role: "source", who: "a source", why: "a source is consumed by agents and performs nothing" };
const AN_OBJECT: NotOf =
    NotOf { role: "object", who: "a hidden object", why: "a hidden object is found, and performs nothing" };
const NOT_A_SOURCE: &[NotOf] = &[A_SOURCE, AN_OBJECT];

const fn event_of(name: &'static str, with: &'static [Further]) -> EventInfo {
    EventInfo { name, with, not_of: NOT_A_SOURCE, not_driven: None }
}

/// Reason against events that move an agent.
const DRIVEN: Option<&str> = Some("in this scenario its controller drives it, and only that moves it");

const TO: &[Further] = &[Further { key: "to", required: Some("[2, 0] m") }];

/// An event of people.
const fn of_person(name: &'static str, with: &'static [Further]) -> EventInfo {
    const OTHERS: &[NotOf] = &[
        A_SOURCE,
        AN_OBJECT,
        NotOf {
            role: "robot",
            who: "a robot",
            why: "people send messages, leave the plan and are seen; a robot follows the plan",
        },
    ];
    EventInfo { name, with, not_of: OTHERS, not_driven: None }
}

/// A message about a robot.
const fn of_robot(name: &'static str, with: &'static [Further]) -> EventInfo {
    const OTHERS: &[NotOf] = &[
        A_SOURCE,
        AN_OBJECT,
        NotOf { role: "human", who: "a person", why: "people tell their own poses and goals, `my_pose` and `my_goal`" },
    ];
    EventInfo { name, with, not_of: OTHERS, not_driven: None }
}

/// An event of hidden objects.
const OF_AN_OBJECT: EventInfo = EventInfo {
    name: "found",
    with: &[],
    not_of: &[
        A_SOURCE,
        NotOf { role: "robot", who: "a robot", why: "hidden objects are found; name the object" },
        NotOf { role: "human", who: "a person", why: "hidden objects are found; name the object" },
    ],
    not_driven: None,
};

/// The entry of the kind.
pub static KIND: Kind = Kind {
    name: "search",
    title: "a search",
    doc: "Ways of a team on a map, along which it collects the most reward from sources.",
    schema: &SEARCH,
    build: |declared, remarks| Box::new(build(declared, remarks)),
    measures: || MEASURES.iter().map(|(measure, _)| measure).collect(),
    events: &[
        event_of("late", &[Further { key: "by", required: Some("5 s") }]),
        EventInfo { not_driven: DRIVEN, ..event_of("moved", TO) },
        event_of("done", &[]),
        event_of("lost", &[]),
        event_of("back", &[]),
        of_person("my_pose", TO),
        of_person("my_goal", TO),
        of_robot("robot_goal", TO),
        EventInfo { not_driven: DRIVEN, ..of_robot("robot_pose", TO) },
        event_of("free", &[]),
        of_person("replan", &[]),
        of_person("strays", TO),
        of_person("seen", &[]),
        OF_AN_OBJECT,
    ],
    absent: &[
        ("travel", "agents of a search move at their own speeds"),
        (
            "failed",
            "an agent keeps the reward that it has collected; `moved` reports its position, and the rest is planned anew",
        ),
        ("begun", "an agent begins its next activity as soon as the one before ends"),
        ("served", "a search has no services"),
        ("feedback", "feedback rates a service, and a search has no services"),
    ],
    formulations: || Formulation::ALL.map(Formulation::name).to_vec(),
    plan_keys: include_str!("plan.schema.json"),
    read: |value| Ok(Box::new(serde_json::from_value::<Search>(value)?)),
};

/// A search to be planned and executed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Search {
    /// The problem of the planner.
    pub problem: Problem,
}

impl Search {
    /// The settings of a run.
    pub fn settings(&self, how: &Run) -> Settings {
        Settings {
            durations: how.sampled.map_or(Durations::Planned, |seed| Durations::Sampled { seed }),
            replan: how.replan,
            budget: Options::of(&self.problem).budget,
            formulation: Formulation::TreeSearch,
            reporting: how.reporting.clone(),
            driven: how.driven.clone(),
        }
    }
}

/// Everybody who takes part: agents, then sources, and then hidden objects.
pub(super) fn members(problem: &Problem) -> Vec<Member<'_>> {
    let role = |human: bool| if human { "human" } else { "robot" };
    let agents = problem.agents.iter().map(|agent| Member { name: &agent.name, role: role(agent.human) });
    let sources = problem.sources.iter().map(|source| Member { name: &source.name, role: "source" });
    let objects = problem.objects.iter().map(|object| Member { name: &object.name, role: "object" });
    agents.chain(sources).chain(objects).collect()
}

impl kind::Mission for Search {
    fn kind(&self) -> &'static Kind {
        &KIND
    }

    fn members(&self) -> Vec<Member<'_>> {
        members(&self.problem)
    }

    fn labels(&self) -> &Labels {
        &self.problem.labels
    }

    fn map_changes(&self) -> bool {
        !self.problem.objects.is_empty()
    }

    fn drivable(&self, member: usize) -> Option<Drivable> {
        let agent = self.problem.agents.get(member).filter(|agent| !agent.human)?;
        let start = GroundPose { at: agent.start, heading: agent.heading };
        Some(Drivable { start, speed: agent.speed })
    }

    fn check(&self) -> Result<(), Mistake> {
        let p = &self.problem;
        let good = |of: &[usize], count: usize| of.iter().all(|index| *index < count);
        let agents = p.agents.iter().all(|a| good(&a.passes, p.walls.len()) && good(&a.unaware, p.sources.len()));
        let sources = p.sources.iter().all(|s| {
            good(&s.targets, p.agents.len())
                && good(&s.after, p.sources.len())
                && good(&s.until, p.sources.len())
                && s.of.is_none_or(|of| of < p.agents.len())
        });
        let pairs = p.codependent.iter().all(|pair| good(&pair.of, p.sources.len()));
        Mistake::unless(agents && sources && pairs, "the mission", "a part refers to another one that does not exist")?;
        let rates = p.sources.iter().flat_map(|source| [&source.inside, &source.outside]);
        for function in rates.filter_map(|rate| rate.function.as_ref()) {
            let sound = function.of.check(RateFunction::ARGUMENTS);
            sound.map_err(|why| Mistake { place: "the mission".into(), why: why.into() })?;
        }
        let planner = &p.planner;
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let hidden = positive(p.cell)
            && p.planner.window.is_none_or(positive)
            && p.objects
                .iter()
                .all(|of| (1..=MAX_COUNT).contains(&of.count) && of.found <= of.count && positive(of.worth))
            && p.agents.iter().filter_map(|a| a.sees).all(|sees| positive(sees.within) && positive(sees.rate))
            && in_range(p)
            && p.exposure.iter().all(|x| x.is_finite() && *x >= 0.0);
        let settings = hidden
            && (16..=20_000).contains(&planner.tree_nodes)
            && planner.goals >= 1
            && planner.stay >= 0.1
            && (0.0..1.0).contains(&planner.reduction)
            && (0.0..1.0).contains(&planner.discount)
            && p.horizon > p.start
            && p.agents.iter().all(|a| a.speed > 0.0 && a.radius >= 0.0 && a.spread >= 0.0 && a.told.is_none());
        Mistake::unless(settings, "the mission", "a setting is out of its range")?;
        if let Some(mistake) = check(p).into_iter().next() {
            let place = match mistake.item {
                Item::Mission => "the mission".into(),
                Item::Wall(i) => format!("walls.{i}"),
                Item::Agent(i) => format!("agents.{i}"),
                Item::Source(i) => format!("sources.{i}"),
                Item::Object(i) => format!("objects.{i}"),
            };
            return Err(Mistake { place, why: mistake.text });
        }
        p.labels.check_among(members(p).iter().map(|member| member.name))
    }

    fn check_run(&self, how: &Run) -> Result<(), String> {
        if how.bases || !how.replies.is_empty() {
            return Err("a search has no bases and no services".into());
        }
        self.settings(how).check(&self.problem).map_err(|why| why.to_string())
    }

    fn check_event(&self, of: &Event) -> Result<(), Impossible> {
        event::typed(&self.problem, of).map(|_| ()).map_err(Impossible::from)
    }

    fn describe(&self, of: &Event) -> String {
        event::describe(&self.problem, of)
    }

    fn describe_run(&self, how: &Run) -> String {
        let durations = if how.sampled.is_some() { "sampled" } else { "planned" };
        format!("ways take as long as {durations}")
    }

    fn text(&self, name: &str) -> String {
        text::text(name, self)
    }

    fn plan(&self, options: &PlanOptions<'_>) -> Result<Planned, Refusal> {
        self.planned(options)
    }

    fn execute(&self, how: &Run) -> Result<Box<dyn kind::Execution>, String> {
        let execution =
            SearchExecution::new(self.problem.clone(), self.settings(how)).map_err(|why| why.to_string())?;
        Ok(Box::new(Executed::new(execution, Vec::new())))
    }

    fn pages(&self, of: &ServeSettings) -> Result<Box<dyn Pages>, String> {
        let mut settings = self.settings(&of.run());
        settings.budget = of.budget(self.problem.planner.states);
        let execution = SearchExecution::new(self.problem.clone(), settings).map_err(|why| why.to_string())?;
        Ok(Box::new(SearchPages::new(Executed::new(execution, Vec::new()))))
    }
}
