//! The plan of a walk: one way, which the validator computes anew.

use mission::chart::{Bar, Chart, Entry, LabelPlace, Row, Style};
use mission::map::{Line, Map, Shape, Sign};
use mission::plan::{self, Statistics, Status};
use mission::plan_data::{Cost, Named, Part};
use mission::planned::{Listing, Method, Planned, Refusal};
use serde::Serialize;

use super::Walk;

/// Name of the only formulation.
pub const STRAIGHT: &str = "straight";

/// The plan of a walk.
pub type Plan = plan::Plan<Way>;

/// A way of the person.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    pub start: f64,
    pub end: f64,
    pub begun: bool,
}

impl plan::Activity for Way {
    fn start(&self) -> f64 {
        self.start
    }

    fn end(&self) -> f64 {
        self.end
    }
}

/// Plans a walk; its cost is its time.
pub fn plan(walk: &Walk) -> Plan {
    let end = walk.length() / walk.speed;
    Plan {
        members: vec![walk.person.clone()],
        activities: vec![Way { start: 0.0, end, begun: false }],
        cost: end,
        status: Status::Proven { bound: end },
        engine: "closed form".into(),
        statistics: Statistics::default(),
    }
}

/// Constraints that a plan breaks.
pub fn validate(walk: &Walk, plan: &Plan) -> Vec<&'static str> {
    let takes = |way: &Way| ((way.end - way.start) * walk.speed - walk.length()).abs() < 1e-9;
    match &plan.activities[..] {
        [way] if takes(way) => Vec::new(),
        [_] => vec!["the way takes its length divided by the speed"],
        _ => vec!["there is one way"],
    }
}

#[derive(Debug, Serialize)]
struct Data {
    agents: Vec<AgentData>,
    activities: Vec<WayData>,
}

#[derive(Debug, Serialize)]
struct AgentData {
    #[serde(flatten)]
    named: Named,
    kind: &'static str,
    place: [f64; 3],
}

#[derive(Debug, Serialize)]
struct WayData {
    agent: String,
    phase: &'static str,
    start: f64,
    end: f64,
    metres: f64,
    begun: bool,
}

/// Describes a plan, if the validator accepts it.
pub fn planned(walk: &Walk, plan: &Plan) -> Result<Planned, Refusal> {
    let violations = validate(walk, plan);
    if !violations.is_empty() {
        return Err(Refusal::Invalid(violations.into_iter().map(String::from).collect()));
    }
    let [x, y] = walk.from;
    let named = Named::new(&walk.person, walk.label());
    let activities = plan.activities.iter().map(|way| WayData {
        agent: walk.person.clone(),
        phase: "walking",
        start: way.start,
        end: way.end,
        metres: walk.length(),
        begun: way.begun,
    });
    let data =
        Data { agents: vec![AgentData { named, kind: "human", place: [x, y, 0.0] }], activities: activities.collect() };
    let method = Method { formulation: STRAIGHT, why: "nothing is in the way".into() };
    let cells = |way: &Way| vec![walk.label().to_string(), format!("{:.1}", way.start), format!("{:.1}", way.end)];
    Ok(Planned {
        summary: "1 way".into(),
        cost: Cost { total: plan.cost, parts: vec![Part::plain("time", plan.cost)] },
        cost_text: format!("cost {:.1}: time", plan.cost),
        table: Listing {
            columns: vec!["who", "leaves", "arrives"],
            names: 1,
            rows: plan.activities.iter().map(cells).collect(),
            note: "(times in s)",
        },
        ..Planned::new(plan, method, chart(walk, plan), map(walk), Box::new(data))
    })
}

static WALKING: Style = Style { name: "walking", height: 14.0, sign: '>', colour: "34", activity: true, kept: false };

/// The chart of a plan.
pub fn chart(walk: &Walk, plan: &Plan) -> Chart {
    let bar = |way: &Way| Bar {
        style: &WALKING,
        group: None,
        work: 0,
        title: "to the place".into(),
        label: Some("to the place".into()),
        start: way.start,
        end: way.end,
        speed: Some(walk.speed),
        begun: way.begun,
    };
    let bars = plan.activities.iter().map(bar).collect();
    Chart {
        rows: vec![Row::new(walk.label().to_string(), LabelPlace::Above, bars)],
        legend: vec![Entry { style: &WALKING, group: None, text: "walking".into() }],
        groups: "",
    }
}

/// The map of a walk.
pub fn map(walk: &Walk) -> Map {
    Map {
        title: "map: the way",
        most_scale: 100.0,
        extent: vec![walk.from, walk.to],
        clear: vec![walk.from, walk.to],
        shapes: vec![
            Shape::Line { line: Line::Path, points: vec![walk.from, walk.to], title: None },
            Shape::sign(Sign::Person, walk.from, walk.label().to_string()),
            Shape::Name { at: walk.from, text: walk.label().to_string() },
        ],
        moving: Vec::new(),
        legend: vec![(Sign::Person, "person")],
    }
}
