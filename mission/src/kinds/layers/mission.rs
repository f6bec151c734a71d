//! Layers as a [`Mission`](kind::Mission): their parts, their checks, and how they are executed.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::engine::Budget;
use crate::executed::Executed;
use crate::execution::Durations;
use crate::kind::generation::Generation;
use crate::kind::pages::{Pages, ServeSettings};
use crate::kind::{self, Event, EventInfo, Further, Impossible, Kind, Member, Mistake, Run};
use crate::labels::Labels;
use crate::numbers::MAX_BATCH;
use crate::planned::{PlanOptions, Planned, Refusal};

use super::blocks::LAYERS;
use super::build::build;
use super::choose::{Formulation, Options, parts_of_a_second};
use super::execution::{LayersExecution, Settings};
use super::pages::LayersPages;
use super::problem::Problem;
use super::reason::Reason;
use super::run::MEASURES;
use super::{event, text};

/// The longest time of a plan, the first one and each that is made anew: far longer than the parts of the branch and bound
/// that end it at the same place in every run.
const LONGEST: Duration = Duration::from_secs(60);

/// The entry of the kind.
pub static KIND: Kind = Kind {
    name: "layers",
    title: "a mission of layers",
    doc: "Assignment of tasks and objects to agents: layers of tasks, one after the other.",
    schema: &LAYERS,
    build: |declared, remarks| Box::new(build(declared, remarks)),
    measures: || MEASURES.iter().map(|(measure, _)| measure).collect(),
    events: &[
        EventInfo {
            name: "late",
            with: &[Further { key: "by", required: Some("5 s") }],
            not_of: &[],
            not_driven: None,
        },
        EventInfo { name: "failed", with: &[], not_of: &[], not_driven: None },
        EventInfo { name: "lost", with: &[], not_of: &[], not_driven: None },
        EventInfo { name: "back", with: &[], not_of: &[], not_driven: None },
        EventInfo { name: "done", with: &[], not_of: &[], not_driven: None },
    ],
    absent: &[
        ("travel", "agents of layers travel from their base along the path of the task and back"),
        ("moved", "every task begins and ends at the base of its agent, which does not move"),
        ("begun", "an agent begins its next task as soon as it is free and the layers before are done"),
        ("served", "a mission of layers has no services"),
        ("feedback", "feedback rates a service, and a mission of layers has no services"),
    ],
    formulations: || Formulation::ALL.map(Formulation::name).to_vec(),
    plan_keys: include_str!("plan.schema.json"),
    read: |value| Ok(Box::new(serde_json::from_value::<Layers>(value)?)),
};

/// Layers of tasks to be planned and executed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Layers {
    /// The problem of the planner.
    pub problem: Problem,
    /// Tasks planned at a time, 1 to [`MAX_BATCH`]; none: all at once.
    pub batch: Option<usize>,
    /// In an execution: the relative change of its cost above which the part that has not begun is planned anew. Zero or
    /// more.
    #[serde(default = "a_tenth")]
    pub reallocate_above: f64,
    /// Instruction for a language model that is asked for the layers. With it there may be no tasks yet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instruction: Option<String>,
    /// Rules that the model must obey, a sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub directives: Vec<String>,
}

fn a_tenth() -> f64 {
    0.1
}

impl Layers {
    /// The settings of a run.
    pub fn settings(&self, how: &Run) -> Settings {
        let budget = Budget { time: LONGEST, nodes: parts_of_a_second(&self.problem), gap: 1e-4 };
        Settings {
            durations: how.sampled.map_or(Durations::Planned, |seed| Durations::Sampled { seed }),
            replan: how.replan,
            reallocate_above: self.reallocate_above,
            planning: Options { batch: self.batch, budget, ..Options::default() },
            reporting: how.reporting.clone(),
        }
    }
}

/// Everybody who takes part.
pub(super) fn members(problem: &Problem) -> Vec<Member<'_>> {
    let role = |human: bool| if human { "human" } else { "robot" };
    problem.agents.iter().map(|agent| Member { name: &agent.name, role: role(agent.is_human()) }).collect()
}

impl kind::Mission for Layers {
    fn kind(&self) -> &'static Kind {
        &KIND
    }

    fn members(&self) -> Vec<Member<'_>> {
        members(&self.problem)
    }

    fn labels(&self) -> &Labels {
        &self.problem.labels
    }

    fn generation(&self) -> Option<&dyn Generation> {
        Some(self)
    }

    fn waits_for_tasks(&self) -> bool {
        self.problem.tasks.is_empty()
    }

    fn has_height(&self) -> bool {
        true
    }

    fn check(&self) -> Result<(), Mistake> {
        let waits = |m: &super::check::Mistake| self.instruction.is_some() && m.reason == Reason::NoTask;
        if let Some(mistake) = self.problem.check().iter().find(|m| !waits(m)) {
            return Err(Mistake { place: "the mission".into(), why: mistake.describe(&self.problem).0 });
        }
        self.problem.labels.check_among(members(&self.problem).iter().map(|member| member.name))?;
        let usual = self.reallocate_above.is_finite() && self.reallocate_above >= 0.0;
        Mistake::unless(usual, "reallocate_above", "it is zero or more")?;
        let good = self.batch.is_none_or(|batch| (1..=MAX_BATCH).contains(&batch));
        Mistake::unless(good, "batch", "it is a whole number from 1 to 512")
    }

    fn check_run(&self, how: &Run) -> Result<(), String> {
        if let Some(mistake) = self.problem.check().first() {
            return Err(mistake.describe(&self.problem).0);
        }
        if how.bases || !how.replies.is_empty() {
            return Err("a mission of layers has no bases and no services".into());
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
        format!("tasks take as long as {durations}")
    }

    fn text(&self, name: &str) -> String {
        text::text(name, self)
    }

    fn plan(&self, options: &PlanOptions<'_>) -> Result<Planned, Refusal> {
        self.planned(options)
    }

    fn execute(&self, how: &Run) -> Result<Box<dyn kind::Execution>, String> {
        let execution =
            LayersExecution::new(self.problem.clone(), self.settings(how)).map_err(|why| why.to_string())?;
        Ok(Box::new(Executed::new(execution, Vec::new())))
    }

    fn pages(&self, of: &ServeSettings) -> Result<Box<dyn Pages>, String> {
        let mut settings = self.settings(&of.run());
        settings.planning.budget = of.budget(parts_of_a_second(&self.problem));
        let execution = LayersExecution::new(self.problem.clone(), settings).map_err(|why| why.to_string())?;
        Ok(Box::new(LayersPages::new(Executed::new(execution, Vec::new()))))
    }
}
