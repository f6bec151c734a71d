//! Scenarios: the behaviour of the world while a program runs, and the expectations on the run. Not used by the
//! controller.

use robot::LinkId;
use serde::{Deserialize, Serialize};
use stdlib_tasks::bound::{Bound, Slot};
use stdlib_tasks::expression::Expression;

use super::{Formula, Unit};
use super::{Program, RunProgram};
use crate::fault::FaultKind;

/// Run with a world of its own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScenarioProgram {
    /// Its name.
    pub name: String,
    /// Subject and duration of the run, and its simulated robot. The seed of the simulator is that of the whole
    /// scenario.
    pub run: RunProgram,
    /// Configuration of the robot at the start, `nq` numbers.
    pub start: Vec<f64>,
    /// Behaviour of the world.
    #[serde(default)]
    pub world: WorldProgram,
    /// Numbers that are computed at each tick and that predicates read.
    pub measures: Vec<Measure>,
    /// Predicates that formulas are made of.
    pub predicates: Vec<Predicate>,
    /// Expectations, in the order written.
    pub expectations: Vec<ExpectationProgram>,
}

/// True place of an obstacle; what is `None` is as declared.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrueObstacle {
    /// Index of the obstacle.
    pub obstacle: usize,
    /// Position, in m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<[f64; 3]>,
    /// Orientation, as `w x y z`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation: Option<[f64; 4]>,
    /// True if the obstacle is there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub present: Option<bool>,
}

/// Behaviour of the world.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WorldProgram {
    /// Values that are sent to signals.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub signals: Vec<SignalScript>,
    /// Motion of people.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub humans: Vec<HumanScript>,
    /// Obstacles that are elsewhere than the controller believes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<TrueObstacle>,
    /// Events that the host raises: index, and times in s.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<(usize, Vec<f64>)>,
    /// Times at which the host stops the robot, in s.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stops: Vec<f64>,
    /// Times at which it lets the robot go on, in s.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub resumes: Vec<f64>,
    /// Outcomes of actions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub outcomes: Vec<OutcomeScript>,
    /// Forces of people.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pushes: Vec<PushScript>,
    /// Late ticks: time and delay, both in s.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub late: Vec<(f64, f64)>,
    /// Readings of positions that are lost.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lost: Vec<LostReading>,
}

impl WorldProgram {
    /// Returns true if the observations of the controller can differ from the true state.
    pub fn disturbs(&self) -> bool {
        !self.late.is_empty() || !self.lost.is_empty() || !self.humans.is_empty() || !self.obstacles.is_empty()
    }
}

/// Values that are sent to a signal for some time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SignalScript {
    /// Index of the signal.
    pub signal: usize,
    /// Time at which the first value is sent, in s.
    pub from: f64,
    /// Time from which none is sent, in s; `None` for the end of the run.
    pub to: Option<f64>,
    /// Instants in s from the beginning of the run, rising, and the value at each. Values are interpolated linearly,
    /// and constant before the first and after the last instant.
    pub path: Vec<(f64, Vec<f64>)>,
    /// Standard deviation of the noise on each number, in its unit; 0 for none.
    #[serde(default)]
    pub noise: f64,
    /// Time from the measurement of a value to its arrival, in s. It counts as received when it arrives.
    #[serde(default)]
    pub delay: f64,
    /// Fraction of the values that are lost in transmission.
    #[serde(default)]
    pub drop: f64,
    /// Time from a value to the next, in s; 0 for one at every tick.
    #[serde(default)]
    pub period: f64,
    /// Instants, in s, at which the value that is sent is NaN.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nan: Vec<f64>,
}

impl SignalScript {
    /// Transmission of its values.
    pub fn sending(&self) -> Sending {
        let SignalScript { from, to, noise, delay, drop, period, .. } = *self;
        Sending { from, to, noise, delay, drop, period, nan: self.nan.clone(), gaps: Vec::new() }
    }
}

/// Transmission of values to the controller.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Sending {
    /// Time at which the first value is sent, in s.
    #[serde(default)]
    pub from: f64,
    /// Time from which none is sent, in s; `None` for the end of the run.
    #[serde(default)]
    pub to: Option<f64>,
    /// Standard deviation of the noise on each number, in its unit; 0 for none.
    #[serde(default)]
    pub noise: f64,
    /// Time from the measurement of a value to its arrival, in s. It counts as received when it arrives.
    #[serde(default)]
    pub delay: f64,
    /// Fraction of the values that are lost in transmission.
    #[serde(default)]
    pub drop: f64,
    /// Time from a value to the next, in s; 0 for one at every tick.
    #[serde(default)]
    pub period: f64,
    /// Instants, in s, at which the value that is sent is NaN.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub nan: Vec<f64>,
    /// Intervals in which nothing is sent: start and end, in s.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gaps: Vec<(f64, f64)>,
}

/// Motion of a person in the whole run, and transmission of the tracker's readings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HumanScript {
    /// Index of the person.
    pub human: usize,
    /// Transmission of the readings: all points of the person together, so that a reading is lost or late as a whole.
    /// Noise is added to positions only.
    pub sending: Sending,
    /// True path of each point of the person, in the order of its points.
    pub tracks: Vec<Track>,
}

/// True path of a tracked point: instants in s from the beginning of the run, rising, and the position at each, in m.
/// The position is interpolated linearly, and constant before the first and after the last instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Track(pub Vec<(f64, [f64; 3])>);

impl Track {
    /// Position of the point at a time, and its velocity from then on, in m and m/s.
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

/// Outcomes of an action, for its requests in order; the last entry repeats.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OutcomeScript {
    /// The action's first argument, or its verb.
    pub key: String,
    /// One for each request.
    pub requests: Vec<OutcomeProgram>,
}

/// Outcome of one request.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OutcomeProgram {
    /// Word for the outcome; `None` for an action that never ends.
    pub outcome: Option<String>,
    /// Duration of the action, in s.
    pub after: f64,
    /// Values that signals have from then on.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sets: Vec<(usize, Vec<f64>)>,
}

/// A force on a sensor, for some time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PushScript {
    /// Index of the signal that reports it, a wrench: force in N, then moment in Nm.
    pub signal: usize,
    /// Start, in s.
    pub from: f64,
    /// End, in s; `None` for the end of the run.
    pub to: Option<f64>,
    /// The force.
    pub force: Force,
}

/// Force of a person on a sensor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Force {
    /// Constant wrench: force in N and moment in Nm, in the axes of the world.
    Constant([f64; 6]),
    /// A hand that pulls a link towards a point of the world, like a spring with a damper:
    /// `f = k (p - x) - d x'`, no larger than `most`, in the axes of the world.
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

/// Joint whose position is not measured for some time: the reading is NaN.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LostReading {
    /// Index of the degree of freedom.
    pub dof: usize,
    /// Start, in s.
    pub from: f64,
    /// End, in s.
    pub to: f64,
}

/// Number that is measured at each tick at the true configuration. It is NaN if it is undefined.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Smallest `h` of a limit, in the unit of its rows; zero if it differs from zero by rounding only. The index is
    /// that of the task.
    Margin(usize),
    /// Magnitude of an error of a target: of one part, or the norm of all.
    Error {
        /// Index of the task.
        task: usize,
        /// Index of the part among [`stdlib_tasks::task::Task::measures`].
        part: Option<usize>,
    },
    /// 1 in a state or inside it, otherwise -1.
    In(usize),
    /// 1 while there is a fault of this kind, or of any kind for `None`; otherwise -1.
    Fault(Option<FaultKind>),
    /// Speed of a degree of freedom since the previous tick, in rad/s or m/s; never negative.
    Speed(usize),
    /// Largest speed of these degrees of freedom since the previous tick, all in rad/s or all in m/s; never negative.
    LargestSpeed(Vec<usize>),
    /// Speed of the origin of a link in the world since the previous tick, in m/s; never negative.
    PointSpeed(LinkId),
    /// Magnitude of the change of the velocity that the hierarchy chose for a degree of freedom since the previous
    /// tick, divided by the period, in rad/s² or m/s²; never negative.
    Acceleration(usize),
    /// Largest of these for several degrees of freedom, all in rad/s² or all in m/s²; never negative.
    LargestAcceleration(Vec<usize>),
    /// Acceleration of the origin of a link in the world, computed from the same velocities, in m/s²; never negative.
    PointAcceleration(LinkId),
    /// Number of reversals of these degrees of freedom so far, in total.
    Reversals(Vec<usize>),
    /// Value of an expression at the start of the run. Its inputs are indices into [`ScenarioProgram::table`], other
    /// than those of measures of this kind.
    Initial(Expression),
}

impl Measure {
    /// Index of the task that is measured.
    pub fn task(&self) -> Option<usize> {
        match self {
            Measure::Margin(task) | Measure::Error { task, .. } => Some(*task),
            Measure::In(_)
            | Measure::Fault(_)
            | Measure::Speed(_)
            | Measure::LargestSpeed(_)
            | Measure::PointSpeed(_)
            | Measure::Acceleration(_)
            | Measure::LargestAcceleration(_)
            | Measure::PointAcceleration(_)
            | Measure::Reversals(_)
            | Measure::Initial(_) => None,
        }
    }
}

/// Atomic part of a formula: a number whose magnitude is the robustness, negative if the predicate is false.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Predicate {
    /// Expression of the number, of the robot's true state. Its inputs are indices into [`ScenarioProgram::table`].
    pub value: Expression,
    /// Unit of the number; only the sign of a truth value counts.
    pub unit: Unit,
}

/// Expectation on a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExpectationProgram {
    /// Its name in a report.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub label: Option<String>,
    /// Its text in the spec.
    pub text: String,
    /// Its formula over the predicates.
    pub formula: Formula,
}

impl ExpectationProgram {
    /// Its label, or its text.
    pub fn title(&self) -> &str {
        self.label.as_deref().unwrap_or(&self.text)
    }
}

/// Layout of the numbers that predicates read: the clocks, signals, measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PredicateTable {
    /// Length of the table of signals.
    pub signals: usize,
    /// Number of measures.
    pub measures: usize,
}

impl PredicateTable {
    /// Time since the stack was entered.
    pub const T: usize = 0;
    /// Time since the start of the run.
    pub const TIME: usize = 1;

    /// Index of a number of the table of signals.
    pub fn signal(self, k: usize) -> usize {
        2 + k
    }

    /// Index of a measure.
    pub fn measure(self, k: usize) -> usize {
        2 + self.signals + k
    }

    /// Number of numbers.
    pub fn width(self) -> usize {
        2 + self.signals + self.measures
    }
}

impl ScenarioProgram {
    /// Layout of the numbers that its predicates read.
    pub fn table(&self, program: &Program) -> PredicateTable {
        PredicateTable { signals: program.interface.width(), measures: self.measures.len() }
    }

    /// Units of its predicates.
    pub fn units(&self) -> Vec<Unit> {
        self.predicates.iter().map(|p| p.unit).collect()
    }

    /// Program that runs in it: a copy with the scenario's run and start.
    pub fn program(&self, of: &Program) -> Program {
        let mut program = of.clone();
        program.title.clone_from(&self.name);
        program.run = self.run.clone();
        program.robot.home.clone_from(&self.start);
        program
    }

    /// The program whose obstacles are where they truly are, for monitors; `None` if the declared places are true.
    pub fn true_program(&self, of: &Program) -> Option<Program> {
        if self.world.obstacles.is_empty() {
            return None;
        }
        let mut program = of.clone();
        for truth in &self.world.obstacles {
            let initial = &mut program.values.initial;
            let mut place = |numbers: &[f64]| {
                let at = initial.len();
                initial.extend_from_slice(numbers);
                Slot { at, len: numbers.len() }
            };
            let position = truth.position.map(|x| place(&x));
            let orientation = truth.orientation.map(|x| place(&x));
            let present = truth.present.map(|yes| place(&[if yes { 1.0 } else { -1.0 }]));
            let Some(name) = of.obstacles.get(truth.obstacle).map(|o| &o.name) else { continue };
            let bounds = program.tasks.iter_mut().flat_map(|t| t.params.values_mut());
            let copies = bounds.filter_map(|b| if let Bound::Obstacles(all) = b { Some(all) } else { None }).flatten();
            for o in copies.chain(&mut program.obstacles).filter(|o| o.name == *name) {
                o.position = position.unwrap_or(o.position);
                o.orientation = orientation.unwrap_or(o.orientation);
                o.present = present.or(o.present);
            }
        }
        Some(program)
    }
}
