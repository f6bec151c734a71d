//! Scenarios: what the world does while a program runs, and what is expected of the run. No part of the controller.

use robot::LinkId;
use serde::{Deserialize, Serialize};
use stdlib_tasks::expression::Expression;

use super::{Formula, Unit};
use super::{Program, RunProgram};
use crate::fault::FaultKind;

/// A run with a world of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScenarioProgram {
    /// Its name.
    pub name: String,
    /// What runs, for how long, on which simulated robot. The seed of the simulator is that of the whole scenario.
    pub run: RunProgram,
    /// Where the robot stands at the beginning, `nq` numbers.
    pub start: Vec<f64>,
    /// What the world does.
    #[serde(default)]
    pub world: WorldProgram,
    /// What expectations are told of: numbers that are worked out at each tick.
    pub measures: Vec<Measure>,
    /// What formulas are made of.
    pub predicates: Vec<Predicate>,
    /// What must hold, in the order written.
    pub expectations: Vec<ExpectationProgram>,
}

/// What the world does.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WorldProgram {
    /// Values that signals are sent.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub signals: Vec<SignalScript>,
    /// What people do.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub humans: Vec<HumanScript>,
    /// Events that the host raises: index, and when, in s.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<(usize, Vec<f64>)>,
    /// What becomes of actions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub outcomes: Vec<OutcomeScript>,
    /// Forces of people.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pushes: Vec<PushScript>,
    /// Ticks that come late: at which time, in s, and by how much, in s.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub late: Vec<(f64, f64)>,
    /// Readings of positions that are lost.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lost: Vec<LostReading>,
}

impl WorldProgram {
    /// True where the controller is shown something else than what is.
    pub fn disturbs(&self) -> bool {
        !self.late.is_empty() || !self.lost.is_empty() || !self.humans.is_empty()
    }
}

/// Values that a signal is sent for some time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalScript {
    /// Index of the signal.
    pub signal: usize,
    /// When the first value is sent, in s.
    pub from: f64,
    /// From when on none is sent, in s; none for the end of the run.
    pub to: Option<f64>,
    /// Instants in s from the beginning of the run, rising, and the value at each. Between two the value is on the straight
    /// line from one to the other, before the first and behind the last it stands.
    pub path: Vec<(f64, Vec<f64>)>,
    /// Standard deviation of the noise on each number, in its unit; 0 for none.
    #[serde(default)]
    pub noise: f64,
    /// Time from the measurement of a value to its arrival, in s. It counts as received when it arrives.
    #[serde(default)]
    pub delay: f64,
    /// The share of values that are lost on the way.
    #[serde(default)]
    pub drop: f64,
    /// Time from a value to the next, in s; 0 for one at every tick.
    #[serde(default)]
    pub period: f64,
    /// Instants, in s, at which the value that is sent is not a number.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nan: Vec<f64>,
}

impl SignalScript {
    /// How its values are sent.
    pub fn sending(&self) -> Sending {
        let SignalScript { from, to, noise, delay, drop, period, .. } = *self;
        Sending { from, to, noise, delay, drop, period, nan: self.nan.clone(), gaps: Vec::new() }
    }
}

/// How values are sent on their way to the controller.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sending {
    /// When the first value is sent, in s.
    #[serde(default)]
    pub from: f64,
    /// From when on none is sent, in s; none for the end of the run.
    #[serde(default)]
    pub to: Option<f64>,
    /// Standard deviation of the noise on each number, in its unit; 0 for none.
    #[serde(default)]
    pub noise: f64,
    /// Time from the measurement of a value to its arrival, in s. It counts as received when it arrives.
    #[serde(default)]
    pub delay: f64,
    /// The share of values that are lost on the way.
    #[serde(default)]
    pub drop: f64,
    /// Time from a value to the next, in s; 0 for one at every tick.
    #[serde(default)]
    pub period: f64,
    /// Instants, in s, at which the value that is sent is not a number.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nan: Vec<f64>,
    /// Spans of time, in s, in which nothing is sent: from when, until when.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gaps: Vec<(f64, f64)>,
}

/// What a person does in the whole run, and how the tracker tells of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HumanScript {
    /// Index of the person.
    pub human: usize,
    /// How readings are sent: all points of the person together, so that one is lost or late as a whole. Noise is on
    /// positions alone.
    pub sending: Sending,
    /// Where each point of the person truly is, in the order of its points.
    pub tracks: Vec<Track>,
}

/// The true way of a tracked point: instants in s from the beginning of the run, rising, and where it is at each, in m.
/// Between two it goes on a straight line, before the first and behind the last it stands.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Track(pub Vec<(f64, [f64; 3])>);

impl Track {
    /// Where the point is at a time, and how fast it goes from there on, in m and m/s.
    pub fn at(&self, time: f64) -> ([f64; 3], [f64; 3]) {
        let behind = self.0.partition_point(|p| p.0 <= time);
        match (behind.checked_sub(1).and_then(|i| self.0.get(i)), self.0.get(behind)) {
            (Some((from, a)), Some((to, b))) => {
                let share = (time - from) / (to - from);
                let along = |i: usize| a[i] + share * (b[i] - a[i]);
                let speed = |i: usize| (b[i] - a[i]) / (to - from);
                ([along(0), along(1), along(2)], [speed(0), speed(1), speed(2)])
            }
            (Some((_, x)), None) | (None, Some((_, x))) => (*x, [0.0; 3]),
            (None, None) => ([f64::NAN; 3], [f64::NAN; 3]),
        }
    }
}

/// What becomes of an action: of each request for it in order; the last entry repeats.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OutcomeScript {
    /// The action's first argument, or its verb.
    pub key: String,
    /// One for each request.
    pub requests: Vec<OutcomeProgram>,
}

/// How an action comes out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OutcomeProgram {
    /// The word for the outcome; none for an action that never ends.
    pub outcome: Option<String>,
    /// How long it takes, in s.
    pub after: f64,
    /// Signals that have these values from then on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sets: Vec<(usize, Vec<f64>)>,
}

/// A force on a sensor, for some time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PushScript {
    /// The signal that reports it, a wrench: force in N, then moment in Nm.
    pub signal: usize,
    /// From when, in s.
    pub from: f64,
    /// Until when, in s; none for the end of the run.
    pub to: Option<f64>,
    /// What is done.
    pub force: Force,
}

/// What a person does to a sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Force {
    /// The same wrench all the time: force in N and moment in Nm, in the axes of the world.
    Constant([f64; 6]),
    /// A hand that pulls a link towards a point of the world, as a spring with a damper, force in the axes of the world:
    /// `f = k (p - x) - d x'`, no larger than `most`.
    Towards {
        /// The link whose origin is pulled.
        link: robot::LinkId,
        /// The point of the world, in m.
        point: [f64; 3],
        /// k, in N/m.
        stiffness: f64,
        /// d, in N s/m.
        damping: f64,
        /// The largest force, in N.
        most: f64,
    },
}

/// A joint whose position is not measured for some time: the reading is not a number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LostReading {
    /// The degree of freedom.
    pub dof: usize,
    /// From when, in s.
    pub from: f64,
    /// Until when, in s.
    pub to: f64,
}

/// Something that is measured at each tick at the true configuration, one number. It is NaN where it has no value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// The smallest `h` of a limit, in the unit of its rows; zero where rounding is all that it is away from zero. The
    /// index is that of the task.
    Margin(usize),
    /// The size of an error of a target: of one part, or the norm of all.
    Error {
        /// Index of the task.
        task: usize,
        /// Index of the part among [`stdlib_tasks::task::Task::measures`].
        part: Option<usize>,
    },
    /// 1 in a state or inside it, else -1.
    In(usize),
    /// 1 while there is a fault of this kind, or any where none is said; else -1.
    Fault(Option<FaultKind>),
    /// How fast a degree of freedom moved since the tick before, in rad/s or m/s; never negative.
    Speed(usize),
    /// How fast the origin of a link moved in the world since the tick before, in m/s; never negative.
    PointSpeed(LinkId),
    /// By how much the velocity that the hierarchy chose for a degree of freedom differs from that of the tick before, over
    /// the period, in rad/s² or m/s²; never negative.
    Acceleration(usize),
    /// The same of the velocity that these velocities give the origin of a link in the world, in m/s²; never negative.
    PointAcceleration(LinkId),
    /// How often these degrees of freedom have reversed so far, all together.
    Reversals(Vec<usize>),
    /// The number that this was at the start of the run. Its inputs are places of [`ScenarioProgram::table`], without those
    /// of other numbers of the start.
    Initial(Expression),
}

impl Measure {
    /// The task that is looked at.
    pub fn task(&self) -> Option<usize> {
        match self {
            Measure::Margin(task) | Measure::Error { task, .. } => Some(*task),
            Measure::In(_)
            | Measure::Fault(_)
            | Measure::Speed(_)
            | Measure::PointSpeed(_)
            | Measure::Acceleration(_)
            | Measure::PointAcceleration(_)
            | Measure::Reversals(_)
            | Measure::Initial(_) => None,
        }
    }
}

/// The least part of a formula: a number that says by how much something is true, negative where it is not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Predicate {
    /// The number, of the robot's true state. Its inputs are places of [`ScenarioProgram::table`].
    pub value: Expression,
    /// What the number is; of a truth value only the sign counts.
    pub unit: Unit,
}

/// Something that must hold.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExpectationProgram {
    /// What a report calls it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// As it is written.
    pub text: String,
    /// What it says of the predicates.
    pub formula: Formula,
}

impl ExpectationProgram {
    /// Its label, or its text.
    pub fn title(&self) -> &str {
        self.label.as_deref().unwrap_or(&self.text)
    }
}

/// Where the numbers that predicates read stand: the clocks, signals, measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PredicateTable {
    /// Numbers of the table of signals.
    pub signals: usize,
    /// Number of measures.
    pub measures: usize,
}

impl PredicateTable {
    /// Time since the stack was entered.
    pub const T: usize = 0;
    /// Time since the start of the run.
    pub const TIME: usize = 1;

    /// The place of a number of the table of signals.
    pub fn signal(self, k: usize) -> usize {
        2 + k
    }

    /// The place of a measure.
    pub fn measure(self, k: usize) -> usize {
        2 + self.signals + k
    }

    /// How many numbers there are.
    pub fn width(self) -> usize {
        2 + self.signals + self.measures
    }
}

impl ScenarioProgram {
    /// The layout of the numbers that its predicates read.
    pub fn table(&self, program: &Program) -> PredicateTable {
        PredicateTable { signals: program.interface.width(), measures: self.measures.len() }
    }

    /// What the numbers of its predicates are.
    pub fn units(&self) -> Vec<Unit> {
        self.predicates.iter().map(|p| p.unit).collect()
    }

    /// The program that runs in it: the same with another run and another start.
    pub fn program(&self, of: &Program) -> Program {
        let mut program = of.clone();
        program.title.clone_from(&self.name);
        program.run = self.run.clone();
        program.robot.home.clone_from(&self.start);
        program
    }
}
