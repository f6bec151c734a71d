//! A mission of the kind `walk`: a person walks straight to a place.

pub mod blocks;
mod execution;
mod pages;
pub mod plan;

use mission::kind::course::{Drivable, GroundPose};
use mission::kind::pages::{Pages, ServeSettings};
use mission::kind::{self, Event, EventInfo, Execution, Further, Impossible, Kind, Member, Mission, Mistake, Run};
use mission::labels::Labels;
use mission::planned::{PlanOptions, Planned, Refusal};
use serde::{Deserialize, Serialize};

use execution::{MEASURES, Walking};
use pages::WalkPages;

/// The entry of the kind.
pub static KIND: Kind = Kind {
    name: "walk",
    title: "a walk",
    doc: "A person walks straight to a place.",
    schema: &blocks::WALK,
    build: |declared, remarks| Box::new(blocks::build(declared, remarks)),
    measures: || MEASURES.iter().map(|(measure, _)| measure).collect(),
    events: &[
        EventInfo {
            name: "late",
            with: &[Further { key: "by", required: Some("5 s") }],
            not_of: &[],
            not_driven: None,
        },
        EventInfo { name: "done", with: &[], not_of: &[], not_driven: None },
        EventInfo { name: "lost", with: &[], not_of: &[], not_driven: None },
    ],
    absent: &[],
    formulations: || vec![plan::STRAIGHT],
    plan_keys: include_str!("plan.schema.json"),
    read: |value| Ok(Box::new(serde_json::from_value::<Walk>(value)?)),
};

/// A person walks straight to a place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Walk {
    /// Name of the person.
    pub person: String,
    /// Start (m).
    pub from: [f64; 2],
    /// The place (m).
    pub to: [f64; 2],
    /// Speed (m/s), more than 0.
    pub speed: f64,
    /// Text that people read in place of the name.
    pub labels: Labels,
}

impl Walk {
    /// Length of the way (m).
    pub fn length(&self) -> f64 {
        f64::hypot(self.to[0] - self.from[0], self.to[1] - self.from[1])
    }

    /// Label of the person.
    pub fn label(&self) -> &str {
        self.labels.member(&self.person)
    }

    /// The words for an event.
    fn words(&self, of: &Event) -> String {
        match of.number("by") {
            Some(by) => format!("{} is late by {by} s", self.label()),
            None => format!("{} is {}", self.label(), of.event),
        }
    }
}

impl Mission for Walk {
    fn kind(&self) -> &'static Kind {
        &KIND
    }

    fn members(&self) -> Vec<Member<'_>> {
        vec![Member { name: &self.person, role: "human" }]
    }

    fn labels(&self) -> &Labels {
        &self.labels
    }

    fn drivable(&self, member: usize) -> Option<Drivable> {
        let start = GroundPose { at: self.from, heading: 0.0 };
        (member == 0).then_some(Drivable { start, speed: self.speed })
    }

    fn check(&self) -> Result<(), Mistake> {
        match self.speed.is_finite() && self.speed > 0.0 {
            true => Ok(()),
            false => Err(Mistake { place: "speed".into(), why: "it is above zero".into() }),
        }
    }

    fn check_run(&self, _: &Run) -> Result<(), String> {
        Ok(())
    }

    fn check_event(&self, event: &Event) -> Result<(), Impossible> {
        match KIND.event(&event.event) {
            Some(_) if event.member == Some(0) => Ok(()),
            _ => Err("there is no such event, or nobody with this number".to_string().into()),
        }
    }

    fn describe(&self, event: &Event) -> String {
        self.words(event)
    }

    fn describe_run(&self, _: &Run) -> String {
        "the way takes as long as planned".into()
    }

    fn text(&self, name: &str) -> String {
        let ([x, y], speed) = (self.to, self.speed);
        format!("mission {name} : walk\n  {} walks to ({x}, {y}) m at {speed} m/s\n", self.person)
    }

    fn plan(&self, options: &PlanOptions<'_>) -> Result<Planned, Refusal> {
        options.formulation_among(&[()], |()| plan::STRAIGHT)?;
        plan::planned(self, &plan::plan(self))
    }

    fn execute(&self, how: &Run) -> Result<Box<dyn kind::Execution>, String> {
        Ok(Box::new(Walking::new(self, how)))
    }

    fn pages(&self, settings: &ServeSettings) -> Result<Box<dyn Pages>, String> {
        let mut walking = Walking::new(self, &settings.run());
        walking.advance(0.0);
        Ok(Box::new(WalkPages { walking }))
    }
}
