//! Web pages of an exploration: the person says where they are, and that they have left.

use serde::Deserialize;
use serde_json::{Value, json};

use crate::kind::pages::{
    Activity, Button, ButtonGroup, JournalSink, Pages, PersonContent, PersonMap, PersonMessage, PointInput, Progress,
    Refusal, parse,
};
use crate::kind::{Detail, Event, Execution};

use super::execution::{ExploreExecution, LogEntry};

/// A request of the person.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(tag = "what", rename_all = "snake_case", deny_unknown_fields)]
enum Request {
    /// The person is at a place.
    MyPose { to: [f64; 2] },
    /// The person has left.
    Left {},
}

/// An exploration under way with its pages.
pub(super) struct ExplorePages {
    run: ExploreExecution,
}

impl ExplorePages {
    /// The pages of an exploration at its start.
    pub(super) fn new(run: ExploreExecution) -> ExplorePages {
        ExplorePages { run }
    }

    fn person_index(&self) -> usize {
        self.run.problem().robots.len()
    }
}

impl Pages for ExplorePages {
    fn execution(&self) -> &dyn Execution {
        &self.run
    }

    fn execution_mut(&mut self) -> &mut dyn Execution {
        &mut self.run
    }

    fn plan_status(&self) -> String {
        match self.run.trouble() {
            Some(why) => format!("no plan: {why}"),
            None => {
                let targets = self.run.assigned().len();
                format!("robots are to take {targets} more {}", if targets == 1 { "target" } else { "targets" })
            }
        }
    }

    fn progress(&self) -> Progress {
        let problem = self.run.problem();
        let taken = self.run.measure("targets", None)[0];
        Progress {
            done: Some(format!("{taken:.0} of {} targets taken", problem.targets.len())),
            over: self.run.done().map(|_| format!("The exploration is over: {} has left.", problem.person_label())),
            stranded: self.run.stranded().map(|why| format!("The robots do nothing any more: {why}.")),
        }
    }

    fn activity(&self, member: usize) -> Activity {
        let (problem, robots) = (self.run.problem(), self.person_index());
        if let Some(target) = member.checked_sub(robots + 1) {
            let doing = match (problem.targets.get(target), self.run.measure("taken", Some(member))[0] > 0.0) {
                (None, _) => "stands".to_string(),
                (_, true) => "is taken".into(),
                (_, false) => "is left".into(),
            };
            return Activity { doing, ..Activity::default() };
        }
        let lost = self.run.measure("lost", Some(member))[0] > 0.0;
        let next = self.run.assigned().into_iter().find(|(robot, _)| *robot == member);
        let doing = match (lost, next) {
            (true, _) if member < robots => "takes no part".into(),
            (true, _) => "is out of sight".into(),
            (_, Some((_, target))) => format!("goes to {}", problem.target_label(target)),
            (_, None) if member < robots => "keeps the team connected".into(),
            (_, None) => "walks".into(),
        };
        Activity { doing, at: self.run.place(member), lost, ..Activity::default() }
    }

    fn person(&self, member: usize) -> PersonContent {
        let (problem, is_open) = (self.run.problem(), self.run.done().is_none());
        if member != self.person_index() {
            return PersonContent::default();
        }
        let mut pose = Button::main("my_pose", "My pose", is_open, json!({ "what": "my_pose" }));
        pose.point = Some(PointInput { key: "to", prompt: "You are at".into() });
        let left = Button::new("left", "I have left", is_open, json!({ "what": "left" }));
        PersonContent {
            doing: if is_open { "You walk as you like.".into() } else { "You have left.".into() },
            next: match self.run.assigned().len() {
                0 => "The robots leave all targets to you.".into(),
                _ => {
                    let names =
                        self.run.assigned().into_iter().map(|(_, target)| problem.target_label(target).to_string());
                    format!("The robots take {}.", names.collect::<Vec<String>>().join(", "))
                }
            },
            groups: vec![ButtonGroup { heading: "Messages".into(), buttons: vec![pose, left] }],
            map: Some(PersonMap {
                drawing: self.run.log_len() + self.run.periods() as usize,
                marks: (0..=self.person_index()).filter_map(|member| self.run.place(member)).collect(),
            }),
            ..PersonContent::default()
        }
    }

    fn message(&self, entry: usize, member: usize) -> Option<PersonMessage> {
        let record = self.run.records().get(entry)?;
        let text = self.run.describe_entry(&record.what);
        match &record.what {
            LogEntry::Taken { member: taker, .. } if *taker != member => Some(PersonMessage::new(format!("{text}."))),
            LogEntry::Assigned { .. } => Some(PersonMessage::latest("plan", format!("There is a new plan: {text}."))),
            LogEntry::NoPlan { kept: false, .. } => Some(PersonMessage::latest("plan", format!("Careful: {text}."))),
            LogEntry::Done => Some(PersonMessage::new("The exploration is over.")),
            _ => None,
        }
    }

    fn request(&mut self, member: usize, body: &Value, journal: &mut JournalSink<'_>) -> Result<String, Refusal> {
        let request: Request = parse(body)?;
        if member != self.person_index() {
            return Err(Refusal::Invalid("there is no such person".into()));
        }
        match request {
            Request::MyPose { to } => {
                let event = Event::of("my_pose", member).and("to", Detail::Point(to));
                self.happen(&event, journal)?;
                Ok(format!("Noted: you are at ({:.1}, {:.1}) m.", to[0], to[1]))
            }
            Request::Left {} => {
                self.happen(&Event::of("done", member), journal)?;
                Ok("Noted: you have left.".into())
            }
        }
    }
}
