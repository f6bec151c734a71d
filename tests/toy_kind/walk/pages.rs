//! Web pages of a walk: the person reports the arrival.

use mission::kind::pages::{
    Activity, Button, ButtonGroup, JournalSink, Pages, PersonContent, PersonMessage, Progress, Refusal, parse,
};
use mission::kind::{Event, Execution};
use serde::Deserialize;
use serde_json::{Value, json};

use super::execution::Walking;

/// A walk with its pages.
pub struct WalkPages {
    pub walking: Walking,
}

/// A request of the person.
#[derive(Deserialize)]
#[serde(tag = "what", rename_all = "snake_case", deny_unknown_fields)]
enum Request {
    Arrived {},
}

impl Pages for WalkPages {
    fn execution(&self) -> &dyn Execution {
        &self.walking
    }

    fn execution_mut(&mut self) -> &mut dyn Execution {
        &mut self.walking
    }

    fn plan_status(&self) -> String {
        format!("arrives at {:.0} s", self.walking.arrives)
    }

    fn progress(&self) -> Progress {
        let over = self.walking.arrived.map(|_| "The walk is over.".to_string());
        Progress { over, ..Progress::default() }
    }

    fn activity(&self, _: usize) -> Activity {
        let walks = self.walking.arrived.is_none();
        Activity {
            doing: if walks { "walks".into() } else { "has arrived".into() },
            at: Some(self.walking.position()),
            until: walks.then_some(self.walking.arrives),
            ..Activity::default()
        }
    }

    fn person(&self, _: usize) -> PersonContent {
        let walks = self.walking.arrived.is_none();
        let arrived = Button::main("arrived", "I have arrived", walks, json!({ "what": "arrived" }));
        PersonContent {
            doing: if walks { "You walk to the place.".into() } else { "You have arrived.".into() },
            groups: vec![ButtonGroup { heading: "Way".into(), buttons: vec![arrived] }],
            ..PersonContent::default()
        }
    }

    fn message(&self, entry: usize, _: usize) -> Option<PersonMessage> {
        self.walking.log_from(entry).into_iter().next().map(|entry| PersonMessage::new(entry.text))
    }

    fn request(&mut self, member: usize, request: &Value, journal: &mut JournalSink<'_>) -> Result<String, Refusal> {
        let Request::Arrived {} = parse(request)?;
        let event = Event { event: "done".into(), member: Some(member), with: Default::default() };
        self.happen(&event, journal)?;
        Ok("Noted: you have arrived.".into())
    }
}
