//! Data of the pages, sent as JSON.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;
use serde_json::Value;

use crate::chart::Chart;
use crate::map::Map;

/// All pages of a mission at one instant.
#[derive(Clone, Debug)]
pub struct PageData {
    /// Pages of people, by member.
    pub people: BTreeMap<usize, PersonPage>,
    /// The page of the supervisor.
    pub supervisor: SupervisorPage,
    /// The chart of the plan.
    pub chart: Arc<Chart>,
    /// The map. Its moving marks are the members whose rows have a position.
    pub map: Arc<Map>,
}

/// The page of a person.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PersonPage {
    /// Label of the person.
    pub name: String,
    /// Notice above all other content.
    pub note: Option<String>,
    /// The kind's part.
    #[serde(flatten)]
    pub content: PersonContent,
    /// Messages, the latest first.
    pub messages: Vec<Message>,
}

/// The kind's part of a person's page.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PersonContent {
    /// Current activity, as a sentence.
    pub doing: String,
    /// Start of the current activity (s).
    pub since: Option<f64>,
    /// Planned end of the current activity (s).
    pub until: Option<f64>,
    /// Next activity, as a sentence.
    pub next: String,
    /// Time to which the page counts down (s), such as the arrival of a robot.
    pub countdown: Option<f64>,
    /// Further information about the next activity.
    pub detail: Option<String>,
    /// Buttons, in groups.
    pub groups: Vec<ButtonGroup>,
    /// Measured durations.
    pub measured: Vec<Measured>,
    /// Questions to the person.
    pub form: Option<Form>,
    /// The steps of the plan.
    pub steps: Vec<Step>,
    /// The map, if people see it: the one of the supervisor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<PersonMap>,
    /// A reminder to press a button, until it was pressed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reminder: Option<PageReminder>,
}

/// A reminder to press a button.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PageReminder {
    /// Number of the reminder: the page shows each once.
    pub number: usize,
    /// Form: `toast`, a small message that passes; `popup`, a window that blocks the page until the button is used; `multimodal`, vibration
    /// and a blinking button.
    pub kind: &'static str,
    /// Identifier of the button.
    pub button: &'static str,
    /// Text.
    pub text: String,
}

/// The map on a person's page.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PersonMap {
    /// Changes whenever the map does.
    pub drawing: usize,
    /// Positions (m) of the moving marks, in the order of the robots of the [`Map`].
    pub marks: Vec<[f64; 2]>,
}

/// Buttons under a heading.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ButtonGroup {
    /// Heading.
    pub heading: String,
    /// The buttons.
    pub buttons: Vec<Button>,
}

/// A button.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Button {
    /// Identifier, unique on a person's page and in a row of the supervisor's.
    pub id: Cow<'static, str>,
    /// Text.
    pub text: Cow<'static, str>,
    /// Explanation under the pointer.
    pub title: Option<&'static str>,
    /// True if it can be pressed. While the clock is stopped, no button of a person can.
    pub enabled: bool,
    /// True for a prominent button.
    pub main: bool,
    /// True if a second press has to confirm it.
    pub confirm: bool,
    /// A point that the page adds to the request.
    pub point: Option<PointInput>,
    /// Number of its uses, which the page shows behind the text; none: it is not shown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uses: Option<usize>,
    /// The request that it sends.
    pub request: Value,
}

impl Button {
    /// A plain button.
    pub fn new(
        id: impl Into<Cow<'static, str>>,
        text: impl Into<Cow<'static, str>>,
        enabled: bool,
        request: Value,
    ) -> Button {
        let (id, text) = (id.into(), text.into());
        Button { id, text, title: None, enabled, main: false, confirm: false, point: None, uses: None, request }
    }

    /// A prominent button.
    pub fn main(
        id: impl Into<Cow<'static, str>>,
        text: impl Into<Cow<'static, str>>,
        enabled: bool,
        request: Value,
    ) -> Button {
        Button { main: true, ..Button::new(id, text, enabled, request) }
    }
}

/// A point of the map that a request needs, typed or picked on the map.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PointInput {
    /// Key of the request.
    pub key: &'static str,
    /// Text before the coordinates.
    pub prompt: String,
}

/// Questions with one answer each.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Form {
    /// Identifier: a form with another one is a new form.
    pub key: String,
    /// Heading.
    pub heading: &'static str,
    /// Introduction.
    pub text: String,
    /// The questions.
    pub questions: Vec<Question>,
    /// The request that it sends, to which the page adds the answers. An unanswered question counts as 0.
    pub request: Value,
}

/// A question.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Question {
    /// Key of the request.
    pub key: &'static str,
    /// Text.
    pub text: &'static str,
    /// Possible answers.
    pub answers: Vec<Answer>,
}

/// An answer.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// Text.
    pub text: &'static str,
    /// Its value in the request.
    pub value: i8,
}

/// A measured duration.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// Name of the measured activity.
    pub name: String,
    /// Duration (s); `None` during the measurement.
    pub seconds: Option<f64>,
}

/// A step of a person's plan.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Step {
    /// Start (s).
    pub at: f64,
    /// Description.
    pub text: String,
    /// `done`, `now` or `next`.
    pub state: &'static str,
}

/// A message about an event.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Message {
    /// Time (s).
    pub at: f64,
    /// Text.
    pub text: String,
}

/// The page of the supervisor.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct SupervisorPage {
    /// Cost and status of the plan in words.
    pub status: String,
    /// Results so far.
    pub numbers: String,
    /// Sentence for a mission that has ended.
    pub over: Option<String>,
    /// Notice above all other content of a running mission.
    pub note: Option<String>,
    /// Buttons for the whole mission.
    pub buttons: Vec<Button>,
    /// Everybody who takes part.
    pub members: Vec<MemberRow>,
    /// Events, the latest first.
    pub events: Vec<Message>,
    /// Changes whenever chart or map do.
    pub drawing: usize,
}

/// A member in the supervisor's tables.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MemberRow {
    /// Its number.
    pub member: usize,
    /// Its label.
    pub name: String,
    /// Its role: robots have a table of their own.
    pub role: &'static str,
    /// True if it has a page.
    pub paged: bool,
    /// State of its page, which the server adds.
    pub page: &'static str,
    /// Its activity.
    #[serde(flatten)]
    pub activity: Activity,
    /// Buttons.
    pub buttons: Vec<Button>,
}

/// Current activity of a member.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Activity {
    /// In words.
    pub doing: String,
    /// Position (m), if it is shown on the map.
    pub at: Option<[f64; 2]>,
    /// True if the member takes no part any more.
    pub lost: bool,
    /// Expected end (s), which an event may delay. `None` without a current activity.
    pub until: Option<f64>,
    /// True if the activity can fail.
    pub fails: bool,
}
