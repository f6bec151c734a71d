//! The interface between a kind of mission and everything that runs, judges, logs and shows missions.
//!
//! A kind is an entry of the list in [`crate::kinds`]. Its folder has the problem, the planner, the validator and the
//! execution; here is what the rest of the house asks of them, object-safe: a [`Mission`] is executed as an [`Execution`],
//! which takes [`Event`]s, is measured by the kind's [`Measure`]s, and describes itself.
//!
//! A *member* is everybody who takes part, robot, person or working robot. Members are numbered through in the order of
//! [`Mission::members`].

pub mod course;
pub mod generation;
mod measure;
mod outcome;
pub mod pages;

use std::any::Any;
use std::collections::BTreeMap;
use std::fmt;

use blocks::{BlockSchema, Key, Place, ValueType};
use learning::grid::World;
use serde::{Deserialize, Serialize};

use self::course::{Course, Drivable, Driven, GroundPose};
use self::generation::Generation;
pub use self::measure::{Form, Measure};
pub(crate) use self::measure::{number, truth};
pub use self::outcome::{Cell, Outcome, ReportPart, Table, Work, WorkState};
use self::pages::{Pages, ServeSettings};
use crate::chart::Chart;
use crate::declare::{DeclaredMission, Remarks};
use crate::execution::Replan;
use crate::labels::Labels;
use crate::map::Map;
use crate::plan_data::Form as PlanForm;
use crate::planned::{PlanOptions, Planned, Refusal};

/// A mission of some kind: what is planned and executed.
pub trait Mission: MissionData + Any + fmt::Debug + Send + Sync {
    /// The entry of its kind.
    fn kind(&self) -> &'static Kind;

    /// Everybody who takes part.
    fn members(&self) -> Vec<Member<'_>>;

    /// Text that people read in place of names.
    fn labels(&self) -> &Labels;

    /// The mission as one whose tasks a language model may write; none: its kind takes no tasks from one.
    fn generation(&self) -> Option<&dyn Generation> {
        None
    }

    /// True if nothing is to be done yet: a language model is to write the tasks.
    fn waits_for_tasks(&self) -> bool {
        false
    }

    /// True if positions have a height; on the ground distances are those of the plane.
    fn has_height(&self) -> bool {
        false
    }

    /// True if the ground of its map changes while it is executed, as beliefs do. Runs then keep maps of several instants.
    fn map_changes(&self) -> bool {
        false
    }

    /// Number of pieces of work of a member that may run a controller of its own; zero for others.
    fn work_of(&self, _member: usize) -> usize {
        0
    }

    /// A member whose base a controller of its own may drive along the planned way; none for others.
    fn drivable(&self, _member: usize) -> Option<Drivable> {
        None
    }

    /// The grid world of its person, for training a policy that knows this number of types of targets; none for kinds whose
    /// people have no learned model.
    ///
    /// # Errors
    /// The reason why there is no such world, in a sentence.
    fn grid_world(&self, _types: usize) -> Option<Result<World, String>> {
        None
    }

    /// Checks that it can be planned; a mission that the compiler lowered always can.
    ///
    /// # Errors
    /// The first part that cannot be planned.
    fn check(&self) -> Result<(), Mistake>;

    /// Checks that it can be executed so.
    ///
    /// # Errors
    /// The first reason against it, in a sentence.
    fn check_run(&self, how: &Run) -> Result<(), String>;

    /// Checks that an event is one of this kind, of a member that exists, and possible in this mission.
    ///
    /// # Errors
    /// The reason.
    fn check_event(&self, event: &Event) -> Result<(), Impossible>;

    /// The words for an event.
    fn describe(&self, event: &Event) -> String;

    /// The words for the settings of a run.
    fn describe_run(&self, how: &Run) -> String;

    /// The mission as text, for people to review and for snapshots to hold. `name` is that of the mission.
    fn text(&self, name: &str) -> String;

    /// Plans the mission, and validates the plan.
    ///
    /// # Errors
    /// See [`Refusal`].
    fn plan(&self, options: &PlanOptions<'_>) -> Result<Planned, Refusal>;

    /// Plans the mission and stands at its start.
    ///
    /// # Errors
    /// The reason why there is no plan, in a sentence.
    fn execute(&self, how: &Run) -> Result<Box<dyn Execution>, String>;

    /// Plans the mission and stands at its start, with web pages for the people who take part.
    ///
    /// # Errors
    /// The reason why there is no plan, in a sentence.
    fn pages(&self, settings: &ServeSettings) -> Result<Box<dyn Pages>, String>;
}

impl dyn Mission {
    /// The mission as one of this type; none if it is of another kind.
    pub fn downcast<M: Mission>(&self) -> Option<&M> {
        let any: &dyn Any = self;
        any.downcast_ref()
    }
}

/// A mission as a value. Every mission that can be cloned and serialised is one.
pub trait MissionData {
    /// A copy.
    fn boxed(&self) -> Box<dyn Mission>;

    /// The mission as data, which [`Kind::read`] reads.
    fn to_value(&self) -> serde_json::Value;
}

impl<M: Mission + Clone + Serialize> MissionData for M {
    fn boxed(&self) -> Box<dyn Mission> {
        Box::new(self.clone())
    }

    fn to_value(&self) -> serde_json::Value {
        // Names, numbers and lists can always be serialised.
        serde_json::to_value(self).unwrap_or_default()
    }
}

/// The entry of a kind of mission: everything that the language, the editor and the pages derive from.
#[derive(Debug)]
pub struct Kind {
    /// The word of the language, `schedule`.
    pub name: &'static str,
    /// Name in messages, with its article: `a schedule`.
    pub title: &'static str,
    /// Meaning, in Markdown.
    pub doc: &'static str,
    /// Keys of its settings, and roles of its members with their keys.
    pub schema: &'static BlockSchema,
    /// Builds a mission from its declaration, and adds everything that is wrong with it or hardly meant to the remarks. If
    /// there is an error, in the remarks or in the declaration, the result is only good for reports of further mistakes.
    pub build: fn(&DeclaredMission, &mut Remarks) -> Box<dyn Mission>,
    /// Everything that can be measured.
    pub measures: fn() -> Vec<&'static Measure>,
    /// Everything that can happen in a scenario.
    pub events: &'static [EventInfo],
    /// Keys of scenarios and events that other kinds have and this one has not, each with the reason.
    pub absent: &'static [(&'static str, &'static str)],
    /// Names of the formulations of its planner.
    pub formulations: fn() -> Vec<&'static str>,
    /// JSON Schema of the keys that it adds to plans; see [`PlanForm::keys`].
    pub plan_keys: &'static str,
    /// Reads a mission of the kind.
    pub read: fn(serde_json::Value) -> serde_json::Result<Box<dyn Mission>>,
}

impl Kind {
    /// The key of a mission that names the kind.
    pub const fn key(&self) -> Key {
        Key::optional(self.name, ValueType::Block(self.schema), self.doc).at(Place::Word)
    }

    /// The measure of this name of a member with a role; none: of the mission.
    pub fn measure(&self, role: Option<&str>, name: &str) -> Option<&'static Measure> {
        (self.measures)().into_iter().find(|measure| measure.name == name && measure.is_of(role))
    }

    /// True for the name of an event, and for a further key of one.
    pub fn has(&self, key: &str) -> bool {
        self.events.iter().any(|event| event.name == key || event.with.iter().any(|further| further.key == key))
    }

    /// The form of its plans as JSON.
    pub fn plan_form(&self) -> PlanForm {
        PlanForm { kind: self.name, title: self.title, keys: self.plan_keys }
    }

    /// The event of this name.
    pub fn event(&self, name: &str) -> Option<&'static EventInfo> {
        self.events.iter().find(|event| event.name == name)
    }
}

/// An event of a kind.
#[derive(Debug)]
pub struct EventInfo {
    /// Name: a key of the event, with the member behind it.
    pub name: &'static str,
    /// Further keys.
    pub with: &'static [Further],
    /// Roles of members that it cannot be of.
    pub not_of: &'static [NotOf],
    /// The reason why it cannot be of a member whose base a controller drives; none: it can.
    pub not_driven: Option<&'static str>,
}

/// A further key of an event.
#[derive(Debug)]
pub struct Further {
    /// The key.
    pub key: &'static str,
    /// If it is required: an example of its value.
    pub required: Option<&'static str>,
}

/// A role that an event cannot be of.
#[derive(Debug)]
pub struct NotOf {
    /// The role.
    pub role: &'static str,
    /// Words for a member with it: `a robot that serves`.
    pub who: &'static str,
    /// The reason.
    pub why: &'static str,
}

/// The reason against an event.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Impossible {
    /// In a sentence.
    pub text: String,
    /// The cause, if it needs one.
    pub note: Option<&'static str>,
    /// A way out.
    pub help: Option<&'static str>,
}

impl From<String> for Impossible {
    fn from(text: String) -> Impossible {
        Impossible { text, note: None, help: None }
    }
}

/// A mission under way.
pub trait Execution: Send {
    /// Present time (s).
    fn time(&self) -> f64;

    /// Lets time pass until `to` (s). A time before the present, or no finite number, lets nothing pass.
    fn advance(&mut self, to: f64);

    /// Time of the next step that happens by itself (s), as far as it is known.
    fn next(&self) -> Option<f64>;

    /// Time at which everything was done (s); none: something is to be done.
    fn done(&self) -> Option<f64>;

    /// Reason why there is no plan for everything any more, if so.
    fn stranded(&self) -> Option<String>;

    /// The Gantt chart of the plan as it is now: activities as they were performed, and those that are to come.
    fn chart(&self) -> Chart;

    /// Text that people read in place of names.
    fn labels(&self) -> &Labels;

    /// The map of the plan.
    fn map(&self) -> Map;

    /// The words for an event.
    fn describe(&self, event: &Event) -> String;

    /// An event happens at the present time.
    ///
    /// # Errors
    /// The reason why it cannot happen now, in a sentence. Nothing has changed then.
    fn handle(&mut self, event: &Event) -> Result<(), String>;

    /// Events that followed from the settings of the run and could not happen, since the last call.
    fn take_rejected(&mut self) -> Vec<Rejected> {
        Vec::new()
    }

    /// Number of entries of the log.
    fn log_len(&self) -> usize;

    /// The log in words, from this entry on.
    fn log_from(&self, first: usize) -> Vec<Entry>;

    /// The log in words.
    fn log(&self) -> Vec<Entry> {
        self.log_from(0)
    }

    /// The value of a measure of the mission, or of a member: a number, a truth value as 1 or -1, or a point (m). NaN for a
    /// measure that does not exist.
    fn measure(&self, name: &str, member: Option<usize>) -> [f64; 3];

    /// Results so far.
    fn outcome(&self) -> Outcome;

    /// Further parts of a report, in order.
    fn report_parts(&self) -> Vec<ReportPart> {
        Vec::new()
    }

    /// Names of the columns of the log of states.
    fn columns(&self) -> Vec<String>;

    /// The present state, a cell a column.
    fn row(&self) -> Vec<Cell>;

    /// The work of a member that runs a controller of its own.
    fn work(&self, member: usize) -> Option<Work>;

    /// The true pose of a member at a time (s) between the present and the next step; none: it has none.
    fn pose(&self, _member: usize, _time: f64) -> Option<GroundPose> {
        None
    }

    /// The way of a member that a controller drives; none for others.
    fn course(&self, _member: usize) -> Option<Course<'_>> {
        None
    }

    /// The base of a driven member is at this pose, at a time (s) between the present and the next step.
    fn drive(&mut self, _member: usize, _time: f64, _pose: GroundPose) {}
}

/// Somebody who takes part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Member<'m> {
    /// Name.
    pub name: &'m str,
    /// Role: the word of the language that declares it, `robot`, `human`, `worker`.
    pub role: &'static str,
}

/// Settings of a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// Seed of true durations; none: as planned.
    pub sampled: Option<u64>,
    /// Robots are kinematic bases that avoid each other.
    pub bases: bool,
    /// Reaction of the plan to differences.
    pub replan: Replan,
    /// Members whose work ends when an event says so.
    pub reporting: Vec<usize>,
    /// Members whose bases controllers drive: a way ends when an event says so.
    pub driven: Vec<Driven>,
    /// Feedback of people after each service.
    pub replies: Vec<Replies>,
}

/// Feedback of a person after each service.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Replies {
    /// Index of the member, a person.
    pub member: usize,
    /// One event for each service, none for silence; the last one repeats.
    pub services: Vec<Option<Event>>,
}

/// A mistake in a mission that was read from a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mistake {
    /// The part.
    pub place: String,
    /// Reason, in a sentence.
    pub why: String,
}

impl Mistake {
    /// A mistake in a part, unless it is `good`.
    pub(crate) fn unless(good: bool, place: &str, why: &str) -> Result<(), Mistake> {
        if good { Ok(()) } else { Err(Mistake { place: place.into(), why: why.into() }) }
    }
}

impl Labels {
    /// Checks that labels can be shown, and that people can tell the members of a mission apart by them.
    pub(crate) fn check_among<'n>(&self, members: impl Iterator<Item = &'n str>) -> Result<(), Mistake> {
        let unfit = |(name, why): (String, crate::labels::Unfit)| Mistake {
            place: format!("labels.{name}"),
            why: why.to_string(),
        };
        self.check().map_err(unfit)?;
        Mistake::unless(self.mistaken(members).is_none(), "labels", "two members have the same label")
    }
}

/// An event, by the words of the language.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// Name, such as `late`.
    pub event: String,
    /// Index of the member that it is of; none: the whole mission.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub member: Option<usize>,
    /// Further keys, such as `by`.
    #[serde(flatten)]
    pub with: BTreeMap<String, Detail>,
}

/// A further key of an event.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Detail {
    /// A number in SI.
    Number(f64),
    /// A point of the ground (m).
    Point([f64; 2]),
}

impl Event {
    /// An event of a member without further keys.
    pub fn of(event: &str, member: usize) -> Event {
        Event { event: event.into(), member: Some(member), with: BTreeMap::new() }
    }

    /// An event of the whole mission.
    pub fn of_all(event: &str) -> Event {
        Event { event: event.into(), member: None, with: BTreeMap::new() }
    }

    /// With a further key.
    pub fn and(mut self, key: &str, detail: Detail) -> Event {
        self.with.insert(key.into(), detail);
        self
    }

    /// The number behind a key; none if there is none.
    pub fn number(&self, key: &str) -> Option<f64> {
        match self.with.get(key) {
            Some(Detail::Number(x)) => Some(*x),
            _ => None,
        }
    }

    /// The point behind a key; none if there is none.
    pub fn point(&self, key: &str) -> Option<[f64; 2]> {
        match self.with.get(key) {
            Some(Detail::Point(point)) => Some(*point),
            _ => None,
        }
    }
}

/// An event that followed from the settings and could not happen.
#[derive(Clone, Debug, PartialEq)]
pub struct Rejected {
    /// Time of the event (s).
    pub time: f64,
    /// The event in words.
    pub event: String,
    /// Reason.
    pub why: String,
}

/// An entry of the log in words.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Time (s).
    pub time: f64,
    /// Content.
    pub text: String,
    /// It came from outside, or changed an assignment.
    pub notable: bool,
}
