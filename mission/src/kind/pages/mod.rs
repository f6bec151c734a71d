//! Web pages of missions: the data of the pages, the requests of their clients, and the interface that a kind implements.
//!
//! A kind implements [`Pages`] in its folder, `mission/src/kinds/NAME/pages.rs`, and returns it from
//! [`Mission::pages`](crate::kind::Mission::pages). It supplies
//!
//! - the execution, and its plan in words;
//! - the page of a person ([`PersonContent`]): activities, buttons, questions, steps. A button and a form carry the request
//!   that a press sends, so that the pages need no script of the kind;
//! - the activity of a member on the supervisor's page ([`Activity`]);
//! - the effect of a person's request;
//! - the messages that a log entry gives a person.
//!
//! [`MissionSession`] does the rest for all kinds: the supervisor's page and requests, which are events of the kind, message
//! lists, notices, and the journal. Pages number members as [`Mission::members`](crate::kind::Mission::members) does.
//!
//! Nothing here knows HTTP: the server passes JSON in and out.

mod data;
mod message_log;
mod request;
mod session;
pub mod words;

use std::time::Duration;

use serde_json::Value;

use crate::engine::Budget;
use crate::kind::{Event, Execution, Run};

pub use self::data::{
    Activity, Answer, Button, ButtonGroup, Form, Measured, MemberRow, Message, PageData, PageReminder, PersonContent,
    PersonMap, PersonPage, PointInput, Question, Step, SupervisorPage,
};
pub use self::request::{ALREADY_NOTED, Client, JournalSink, Refusal, Request, additional_time, is_current, parse};
pub use self::session::{MissionSession, Session};

/// Settings of a mission that is served.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ServeSettings {
    /// Seed of the durations of simulated members; none: as planned.
    pub sampled: Option<u64>,
    /// Members whose work begins and ends when they report it: those with a page.
    pub reporting: Vec<usize>,
    /// Maximum number of nodes of a search; none: the default of the kind.
    pub nodes: Option<u64>,
}

impl ServeSettings {
    /// The settings of the run.
    pub fn run(&self) -> Run {
        Run { sampled: self.sampled, reporting: self.reporting.clone(), ..Run::default() }
    }

    /// The budget of a search; `nodes` is the kind's default. The count of nodes ends it, so that a journal leads to the same
    /// plans; the time is for machines on which nodes take too long.
    pub fn budget(&self, nodes: u64) -> Budget {
        Budget { time: Duration::from_secs(30), nodes: self.nodes.unwrap_or(nodes), ..Budget::default() }
    }
}

/// The pages of a mission under way: a kind's part.
pub trait Pages: Send {
    /// The execution.
    fn execution(&self) -> &dyn Execution;

    /// The execution.
    fn execution_mut(&mut self) -> &mut dyn Execution;

    /// The cost and status of the plan in words; see [`words::plan_status`].
    fn plan_status(&self) -> String;

    /// The state of the mission in words.
    fn progress(&self) -> Progress;

    /// The current activity of a member.
    fn activity(&self, member: usize) -> Activity;

    /// The page of a person.
    fn person(&self, member: usize) -> PersonContent;

    /// The message of a log entry for a person; none if it does not concern the person.
    fn message(&self, entry: usize, member: usize) -> Option<PersonMessage>;

    /// Processes a new log entry, before its messages are requested.
    fn observe(&mut self, _entry: usize) {}

    /// Applies a request of a person, and returns the reply. It calls [`JournalSink::record`], or [`Pages::happen`], before
    /// the first effect. Its result depends on the state of the mission and the request alone, since the server restores a
    /// mission by applying the recorded requests again.
    ///
    /// # Errors
    /// The reason for rejecting it, in a sentence for the person.
    fn request(&mut self, member: usize, request: &Value, journal: &mut JournalSink<'_>) -> Result<String, Refusal>;

    /// True for a request that is accepted while the clock of the mission is stopped.
    fn accepts_stopped(&self, _request: &Value) -> bool {
        false
    }

    /// Records the request in the journal, lets an event happen, and returns its effect on the plan.
    ///
    /// # Errors
    /// The journal cannot be written, or the event cannot happen now.
    fn happen(&mut self, event: &Event, journal: &mut JournalSink<'_>) -> Result<PlanUpdate, Refusal> {
        journal.record()?;
        let before = self.execution().outcome();
        let handled = self.execution_mut().handle(event);
        handled.map_err(|why| Refusal::NotNow(format!("Not possible now: {why}.")))?;
        let after = self.execution().outcome();
        Ok(match () {
            () if after.reallocations > before.reallocations => PlanUpdate::Replanned,
            () if after.reschedules > before.reschedules => PlanUpdate::Rescheduled,
            () => PlanUpdate::Unchanged,
        })
    }
}

/// State of a mission in words.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Amount of work that is done, such as `3 of 4 tasks done`; none: it is not counted.
    pub done: Option<String>,
    /// Sentence for a mission that has ended.
    pub over: Option<String>,
    /// Sentence for a mission without a feasible plan for all work.
    pub stranded: Option<String>,
}

/// A message for a person.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PersonMessage {
    /// Text.
    pub text: String,
    /// If set, the message replaces earlier ones of the same topic.
    pub topic: Option<&'static str>,
}

impl PersonMessage {
    /// A message that stays.
    pub fn new(text: impl Into<String>) -> PersonMessage {
        PersonMessage { text: text.into(), topic: None }
    }

    /// A message that replaces earlier ones of the same topic.
    pub fn latest(topic: &'static str, text: impl Into<String>) -> PersonMessage {
        PersonMessage { text: text.into(), topic: Some(topic) }
    }
}

/// Effect of an event on the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlanUpdate {
    /// The plan is unchanged.
    Unchanged,
    /// Times of the plan have changed.
    Rescheduled,
    /// There is a new plan for what has not begun.
    Replanned,
}
