//! A walk under way, with the clock of all kinds.

use mission::chart::Chart;
use mission::execution::DiscreteEvents;
use mission::kind::course::{Course, Driven, GroundPose, covered};
use mission::kind::{self, Cell, Entry, Event, Form, Measure, Outcome, Run, Table, Work, WorkState};
use mission::labels::Labels;
use mission::map::Map;
use serde_json::json;
use stdlib_tasks::dimension::{LENGTH, TIME};

use super::Walk;
use super::plan::{Plan, chart, map, plan};

type Value = fn(&Walking) -> [f64; 3];

/// Everything that is measured of a walk.
pub static MEASURES: &[(Measure, Value)] = &[
    (Measure::whole("done", Form::Truth, "The person has arrived."), |of| {
        number(if of.arrived.is_some() { 1.0 } else { -1.0 })
    }),
    (Measure::whole("makespan", Form::Number(TIME), "From the start to the arrival."), |of| {
        number(of.arrived.unwrap_or(0.0))
    }),
    (Measure::of(&["human"], "travelled", Form::Number(LENGTH), "The way so far."), |of| {
        number(of.share() * of.walk.length())
    }),
    (Measure::of(&["human"], "position", Form::Point, "Where the person is."), |of| {
        let [x, y] = of.position();
        [x, y, 0.0]
    }),
];

fn number(x: f64) -> [f64; 3] {
    [x, f64::NAN, f64::NAN]
}

/// A step that happens by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Step {
    /// The person arrives.
    Arrive,
}

/// A walk under way.
pub struct Walking {
    walk: Walk,
    plan: Plan,
    now: f64,
    /// Expected time of arrival (s).
    pub arrives: f64,
    /// Time of arrival (s).
    pub arrived: Option<f64>,
    /// The person reports the arrival.
    reports: bool,
    /// A controller drives a base in place of the person.
    driven: Option<Driven>,
    base: GroundPose,
    /// Ends of the way, and the share of it that the base has covered.
    way: [[f64; 2]; 2],
    covered: f64,
    lost: bool,
    log: Vec<Entry>,
    moved: usize,
}

impl Walking {
    pub fn new(walk: &Walk, how: &Run) -> Walking {
        let mut plan = plan(walk);
        plan.activities[0].begun = true;
        Walking {
            walk: walk.clone(),
            now: 0.0,
            arrives: plan.activities[0].end,
            plan,
            arrived: None,
            reports: how.reporting.contains(&0),
            driven: how.driven.iter().find(|driven| driven.member == 0).copied(),
            base: GroundPose { at: walk.from, heading: 0.0 },
            way: [walk.from, walk.to],
            covered: 0.0,
            lost: false,
            log: Vec::new(),
            moved: 0,
        }
    }

    /// Share of the way that is behind the person.
    fn share(&self) -> f64 {
        if self.arrived.is_some() { 1.0 } else { (self.now / self.arrives).min(1.0) }
    }

    pub fn position(&self) -> [f64; 2] {
        if self.driven.is_some() {
            return self.base.at;
        }
        let (from, to, share) = (self.walk.from, self.walk.to, self.share());
        [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]
    }

    fn note(&mut self, text: String, notable: bool) {
        self.log.push(Entry { time: self.now, text, notable });
    }

    fn expect(&mut self, arrives: f64) {
        (self.arrives, self.plan.activities[0].end) = (arrives, arrives);
    }
}

impl DiscreteEvents for Walking {
    type Step = Step;

    fn now(&self) -> f64 {
        self.now
    }

    fn set_time(&mut self, time: f64) {
        self.now = time;
    }

    fn due(&self, _: bool) -> Vec<(f64, Step)> {
        if self.arrived.is_some() || self.reports || self.driven.is_some() {
            Vec::new()
        } else {
            vec![(self.arrives, Step::Arrive)]
        }
    }

    fn perform(&mut self, Step::Arrive: Step) {
        self.arrived = Some(self.now);
        self.expect(self.now);
        self.note(format!("{} arrives", self.walk.label()), true);
    }
}

impl kind::Execution for Walking {
    fn time(&self) -> f64 {
        self.now
    }

    fn advance(&mut self, to: f64) {
        self.run_until(to);
    }

    fn next(&self) -> Option<f64> {
        self.upcoming(true).map(|(time, _)| time)
    }

    fn done(&self) -> Option<f64> {
        self.arrived
    }

    fn stranded(&self) -> Option<String> {
        self.lost.then(|| format!("{} is lost", self.walk.label()))
    }

    fn chart(&self) -> Chart {
        chart(&self.walk, &self.plan)
    }

    fn labels(&self) -> &Labels {
        &self.walk.labels
    }

    fn map(&self) -> Map {
        map(&self.walk)
    }

    fn describe(&self, event: &Event) -> String {
        self.walk.words(event)
    }

    fn handle(&mut self, event: &Event) -> Result<(), String> {
        if self.arrived.is_some() {
            return Err(format!("{} has arrived", self.walk.label()));
        }
        let words = self.walk.words(event);
        self.note(words, true);
        if event.event == "lost" {
            self.lost = true;
            return Ok(());
        }
        match event.number("by") {
            Some(by) => {
                self.moved += 1;
                self.expect((self.arrives + by).max(self.now));
            }
            None => self.perform(Step::Arrive),
        }
        Ok(())
    }

    fn log_len(&self) -> usize {
        self.log.len()
    }

    fn log_from(&self, first: usize) -> Vec<Entry> {
        self.log[first..].to_vec()
    }

    fn measure(&self, name: &str, member: Option<usize>) -> [f64; 3] {
        let role = member.map(|_| "human");
        let found = MEASURES.iter().find(|(measure, _)| measure.name == name && measure.is_of(role));
        found.map_or(number(f64::NAN), |(_, value)| value(self))
    }

    fn outcome(&self) -> Outcome {
        let row = vec![Cell::Text(self.walk.label().into()), Cell::Number(self.share() * self.walk.length(), "m")];
        Outcome {
            reschedules: self.moved,
            reallocations: 0,
            data: json!({ "arrived": self.arrived }),
            tables: vec![Table { columns: vec!["who", "travelled"], rows: vec![row] }],
        }
    }

    fn columns(&self) -> Vec<String> {
        ["x", "y"].map(|axis| format!("{}.{axis}", self.walk.person)).to_vec()
    }

    fn row(&self) -> Vec<Cell> {
        self.position().map(|x| Cell::Number(x, "m")).to_vec()
    }

    fn work(&self, _: usize) -> Option<Work> {
        self.driven?;
        let state = match self.arrived {
            _ if self.lost => WorkState::Lost,
            None => WorkState::Works,
            Some(_) => WorkState::Over,
        };
        Some(Work { state, since: 0.0 })
    }

    fn pose(&self, _: usize, _: f64) -> Option<GroundPose> {
        Some(GroundPose { at: self.position(), heading: self.base.heading })
    }

    fn course(&self, member: usize) -> Option<Course<'_>> {
        let state = self.work(member)?.state;
        let heading = self.base.heading;
        Some(Course {
            state,
            points: &self.way,
            times: &[],
            share: self.covered,
            from: [0.0; 2],
            ends: self.arrives,
            heading,
        })
    }

    fn drive(&mut self, _: usize, _: f64, pose: GroundPose) {
        self.base = pose;
        self.covered = covered(&self.way, self.covered, pose.at, 1.0);
    }
}
