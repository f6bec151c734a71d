//! Requests of clients: small JSON objects, whose form is checked before anything else.

use std::collections::BTreeMap;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::kind::{Detail, Event};

/// Tolerance for equal times (s).
const TOLERANCE: f64 = 1e-6;

/// Reply to a request whose effect has happened already.
pub const ALREADY_NOTED: &str = "Already noted: the page shows the new expected end.";

/// Sender of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Client {
    /// The supervisor.
    Supervisor,
    /// The person that is this member.
    Person(usize),
}

/// A request. The journal stores it as it is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Its sender.
    pub from: Client,
    /// Content: an event of the kind from the supervisor, and the kind's own JSON from a person.
    pub body: Value,
}

/// Reason for rejecting a request, as text for its sender.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The request is malformed, or impossible in this mission at any time: a phrase.
    Invalid(String),
    /// The request is impossible in the present state: a sentence.
    NotNow(String),
}

/// Parses a request.
///
/// # Errors
/// It has another form.
pub fn parse<T: DeserializeOwned>(body: &Value) -> Result<T, Refusal> {
    T::deserialize(body).map_err(|e| Refusal::Invalid(e.to_string()))
}

/// Records a request in the journal before it has an effect.
pub struct JournalSink<'j> {
    /// Writer of the request; none if it has been written.
    write: Option<&'j mut dyn FnMut() -> Result<(), String>>,
}

impl<'j> JournalSink<'j> {
    /// A sink that writes the request with this function, at most once.
    pub fn new(write: &'j mut dyn FnMut() -> Result<(), String>) -> JournalSink<'j> {
        JournalSink { write: Some(write) }
    }

    /// The sink of a request that was read from the journal.
    pub fn replay() -> JournalSink<'static> {
        JournalSink { write: None }
    }

    /// Records the request, if it has not been recorded.
    ///
    /// # Errors
    /// It cannot be written, and must have no effect.
    pub fn record(&mut self) -> Result<(), Refusal> {
        let Some(write) = &mut self.write else { return Ok(()) };
        write().map_err(Refusal::NotNow)?;
        self.write = None;
        Ok(())
    }
}

/// A request of the supervisor: an event of the kind, by its name and keys.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub(super) struct EventRequest {
    /// Name of the event.
    pub what: String,
    /// The member that it is of.
    pub member: Option<usize>,
    /// The expected end of the member's activity that the page showed (s): a duplicated request has no effect.
    pub until: Option<f64>,
    /// Further keys.
    #[serde(flatten)]
    pub with: BTreeMap<String, Detail>,
}

impl EventRequest {
    /// The event.
    pub fn event(self) -> Event {
        Event { event: self.what, member: self.member, with: self.with }
    }
}

/// Returns the additional time (s) of an activity with this expected end and the new end `until`; `None` if it is not
/// longer.
pub fn additional_time(expected: Option<f64>, until: f64) -> Option<f64> {
    expected.map(|expected| until - expected).filter(|by| *by > TOLERANCE)
}

/// Returns true if the expected end that a page showed is still valid: no earlier request has changed it.
pub fn is_current(expected: Option<f64>, shown: Option<f64>) -> bool {
    shown.is_none_or(|shown| expected.is_some_and(|expected| (expected - shown).abs() <= TOLERANCE))
}
