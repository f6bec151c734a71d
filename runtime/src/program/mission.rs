//! Missions of a compiled spec: what their planners need, and how what they plan is executed.
//!
//! A spec may declare missions beside a robot, or missions alone. A compiled file holds both: the fields of the
//! [`Program`], if there is one, and `missions`.

use mission::kinds::layers;
use mission::kinds::layers::reason::Reason;
use mission::kinds::schedule::adapt::Adaptation;
use mission::kinds::schedule::check::{Item, Mistake};
use mission::kinds::schedule::problem::Problem;
use mission::labels::Labels;
use serde::{Deserialize, Serialize};

use super::check::ensure;
use super::{FORMAT, MissionScenarioProgram, Program, ProgramError, Running, error};

/// The most operations of a batch; a larger one is never faster.
pub const MAX_BATCH: usize = 512;

/// A mission.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissionProgram {
    /// Its name in the spec.
    pub name: String,
    /// What is planned.
    #[serde(flatten)]
    pub kind: MissionKind,
    /// Executions of it in worlds of their own, with what is expected of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scenarios: Vec<MissionScenarioProgram>,
}

/// The kinds of mission.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MissionKind {
    /// Robots that serve agents at the end of their operations.
    Schedule(ScheduleProgram),
    /// A team that does layers of tasks.
    Layers(LayersProgram),
}

/// A schedule to be planned, executed and repaired.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScheduleProgram {
    /// What is planned.
    pub problem: Problem,
    /// How plans follow what people say of them.
    pub adaptation: Adaptation,
    /// The relative change of its cost above which what is left of a plan is planned anew, `iota` of thesis (5.19). Zero or
    /// more.
    pub reallocate_above: f64,
    /// Operations that are planned at a time where there are too many for all at once, 1 to [`MAX_BATCH`].
    pub batch: usize,
    /// Working robots that run controllers of their own in scenarios.
    #[serde(default, skip_serializing_if = "Running::is_empty")]
    pub running: Running,
}

/// Layers of tasks to be planned.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LayersProgram {
    /// What is planned.
    pub problem: layers::problem::Problem,
    /// Tasks that are planned at a time, 1 to [`MAX_BATCH`]; none: all at once.
    pub batch: Option<usize>,
    /// While it is executed: the relative change of its cost above which what has not begun is planned anew. Zero or more.
    #[serde(default = "a_tenth")]
    pub reallocate_above: f64,
    /// What is to be done, for a language model that is asked for the layers. With it there may be no tasks yet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instruction: Option<String>,
    /// What the model must obey, a sentence each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub directives: Vec<String>,
}

fn a_tenth() -> f64 {
    0.1
}

impl MissionProgram {
    /// The schedule, if it is one.
    pub fn schedule(&self) -> Option<&ScheduleProgram> {
        match &self.kind {
            MissionKind::Schedule(schedule) => Some(schedule),
            MissionKind::Layers(_) => None,
        }
    }

    /// Checks that it can be planned; what the compiler gives always can.
    ///
    /// # Errors
    /// The first part that cannot be planned.
    pub fn check(&self) -> Result<(), ProgramError> {
        let own = |e: ProgramError| error(format!("{}: {}", self.name, e.place), e.message);
        match &self.kind {
            MissionKind::Schedule(schedule) => {
                schedule.check().map_err(own)?;
                let each = |(i, s): (usize, &MissionScenarioProgram)| {
                    let place = format!("scenarios[{i}]");
                    s.check(&schedule.problem, &place)?;
                    schedule.running.check_scenario(s, &place)
                };
                self.scenarios.iter().enumerate().try_for_each(each).map_err(own)
            }
            MissionKind::Layers(layers) => {
                layers.check().map_err(own)?;
                let each =
                    |(i, s): (usize, &MissionScenarioProgram)| s.check_layered(layers, &format!("scenarios[{i}]"));
                self.scenarios.iter().enumerate().try_for_each(each).map_err(own)
            }
        }
    }
}

/// Checks that labels can be shown, and that people can tell these agents apart.
fn labels<'n>(labels: &Labels, agents: impl Iterator<Item = &'n str>) -> Result<(), ProgramError> {
    labels.check().map_err(|(name, why)| error(format!("labels.{name}"), why.to_string()))?;
    ensure(labels.mistaken(agents).is_none(), "labels", "two agents are shown by the same text")
}

impl LayersProgram {
    fn check(&self) -> Result<(), ProgramError> {
        let waits = |m: &layers::check::Mistake| self.instruction.is_some() && m.reason == Reason::NoTask;
        if let Some(mistake) = self.problem.check().iter().find(|m| !waits(m)) {
            return Err(error("the mission", mistake.describe(&self.problem).0));
        }
        labels(&self.problem.labels, self.problem.agents.iter().map(|who| who.name.as_str()))?;
        let good = self.batch.is_none_or(|batch| (1..=MAX_BATCH).contains(&batch));
        let usual = self.reallocate_above.is_finite() && self.reallocate_above >= 0.0;
        ensure(usual, "reallocate_above", "it is zero or more")?;
        ensure(good, "batch", "it is a whole number from 1 to 512")
    }
}

impl ScheduleProgram {
    fn check(&self) -> Result<(), ProgramError> {
        if let Some(mistake) = self.problem.check().first() {
            return Err(error(self.place(mistake), mistake.reason.to_string()));
        }
        let names = self.problem.robots.iter().map(|m| m.name.as_str());
        labels(&self.problem.labels, names.chain(self.problem.agents.iter().map(|a| a.name.as_str())))?;
        let usual = |x: f64| x.is_finite() && x >= 0.0;
        let Adaptation { memory, wait_gain, approach_gain, margin, wait_step } = self.adaptation;
        let share = |x: f64| (0.0..=1.0).contains(&x);
        let good = share(memory) && share(margin) && usual(wait_gain) && usual(approach_gain) && usual(wait_step);
        ensure(good, "adaptation", "its numbers are zero or more, memory and margin at most 1")?;
        ensure(usual(self.reallocate_above), "reallocate_above", "it is zero or more")?;
        ensure((1..=MAX_BATCH).contains(&self.batch), "batch", "it is a whole number from 1 to 512")?;
        self.running.check(&self.problem)
    }

    /// What a mistake is about, in words.
    fn place(&self, mistake: &Mistake) -> String {
        let named = |what: &str, name: Option<&String>| format!("{what} `{}`", name.map_or("?", String::as_str));
        match mistake.at.item {
            Item::Mission => "the mission".to_string(),
            Item::Robot(i) => named("robot", self.problem.robots.get(i).map(|m| &m.name)),
            Item::Agent(i) => named("agent", self.problem.agents.get(i).map(|a| &a.name)),
            Item::Begun(i) => format!("begun[{i}]"),
        }
    }
}

/// What a compiled file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CompiledFile {
    /// The program of the robot; none for a spec of missions alone.
    pub program: Option<Program>,
    /// Missions, in the order declared.
    pub missions: Vec<MissionProgram>,
}

/// A file with a program.
#[derive(Serialize)]
struct Both<'a> {
    #[serde(flatten)]
    program: &'a Program,
    #[serde(skip_serializing_if = "<[MissionProgram]>::is_empty")]
    missions: &'a [MissionProgram],
}

/// A file of missions alone.
#[derive(Serialize)]
struct Missions<'a> {
    format: u32,
    name: &'a str,
    missions: &'a [MissionProgram],
}

/// What tells the two apart; everything else of a program is left for its own reading.
#[derive(Deserialize)]
struct Head {
    format: Option<u32>,
    robot: Option<serde::de::IgnoredAny>,
    #[serde(default)]
    missions: Vec<MissionProgram>,
}

impl CompiledFile {
    /// The text of the file. `name` is that of the spec.
    ///
    /// # Errors
    /// A number of it is not finite, which no compiled spec has.
    pub fn to_json(
        name: &str,
        program: Option<&Program>,
        missions: &[MissionProgram],
    ) -> Result<String, serde_json::Error> {
        let text = match program {
            Some(program) if missions.is_empty() => serde_json::to_string_pretty(program),
            Some(program) => serde_json::to_string_pretty(&Both { program, missions }),
            None => serde_json::to_string_pretty(&Missions { format: FORMAT, name, missions }),
        };
        text.map(|text| text + "\n")
    }

    /// Reads a file and checks all of it.
    ///
    /// # Errors
    /// Why it cannot be run or planned, in a sentence.
    pub fn read(text: &str) -> Result<CompiledFile, String> {
        let unread = |e: serde_json::Error| format!("it is no compiled program: {e}");
        let head: Head = serde_json::from_str(text).map_err(unread)?;
        let program = match head.robot {
            None if !head.missions.is_empty() => None,
            _ => Some(serde_json::from_str::<Program>(text).map_err(unread)?),
        };
        let refused = |e: ProgramError| format!("it is no program that can be run: {e}");
        if head.format != Some(FORMAT) {
            let e = error("format", "this program was compiled by another version; compile the spec again");
            return Err(refused(e));
        }
        program.iter().try_for_each(Program::check).map_err(refused)?;
        head.missions.iter().try_for_each(MissionProgram::check).map_err(refused)?;
        Ok(CompiledFile { program, missions: head.missions })
    }
}
