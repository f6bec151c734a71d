//! The compiled program: everything that can be executed, as plain data.
//!
//! Names have become indices, quantities SI numbers, expressions a [`Tape`]. A program can be written out, read back
//! and run without the spec it came from; [`Program::check`] makes sure that one that was read from a file cannot make
//! the controller panic.

mod check;
mod check_machine;
mod check_scenario;
mod drive;
mod formula;
mod gain;
mod machine;
mod mission;
mod mission_scenario;
mod plant;
mod regions;
mod ros;
mod scenario;
mod signal;
mod tape;
mod task_equality;
mod trajectory;
mod window;
mod worker;

use nalgebra::{Point3, Vector3};
use robot::{Base, MobileBase, Model};
use serde::{Deserialize, Serialize};
use stdlib_tasks::bound::Obstacle;
use stdlib_tasks::bound::{Arm, BoundParams, Geometry};
use stdlib_tasks::expression::Expression;
use stdlib_tasks::field::FieldProgram;

pub use check::ProgramError;
pub(crate) use check::error;
pub use drive::{DriveProgram, around, driven_base};
pub use formula::{Formula, MAX_NODES, Node, Unit};
pub use gain::overshoots;
pub use machine::{
    ActionProgram, FaultPattern, MachineAction, MachineProgram, MeasuredProgram, MergedStack, Reached, ReachedProgram,
    SpeedBound, StateProgram, TransitionProgram, Trigger,
};
pub use mission::{CompiledFile, MissionProgram};
pub use mission_scenario::{
    MAX_EVENTS, MAX_INSTANTS, MAX_MISSION, MissionMeasure, MissionScenarioProgram, TimedEvent, ends_with_step,
    step_within,
};
pub use plant::{Actuators, Gravity, MOST_BODY_ELEMENTS, NoBody, Payload, PlantProgram, no_body, varies};
pub use regions::{BESIDE, MAX_MERGED};
pub use ros::{BaseOdometry, CommandForm, CommandTopic, JointStates, RosProgram, SignalTopic, TickSource, wrong_topic};
pub use scenario::{
    ExpectationProgram, Force, HumanScript, LostReading, Measure, OutcomeProgram, OutcomeScript, Predicate,
    PredicateTable, PushScript, ScenarioProgram, Sending, SignalScript, Track, TrueObstacle, WorldProgram,
};
pub use signal::{
    Between, Conditioning, HumanProgram, Initial, Interface, Lost, MAX_SIGNAL, SignalProgram, Tracking, Velocity,
};
pub use tape::{Op, Output, Tape, Times};
pub(crate) use tape::{TapeReads, TapeWrites};
pub use trajectory::{MAX_POINTS, Motion, Shape, TrajectoryProgram};
pub use window::{Window, WindowError};
pub use worker::{ControllerProgram, Job, MAX_RUNNING, MAX_TICKS, Running, WorkerProgram};

/// The version of the format; a program of another version is refused.
pub const FORMAT: u32 = 9;

/// Longest lag and longest dead time of drives, in s: one that is further behind is no drive that a velocity can be sent to.
pub const MOST_BEHIND: f64 = 1.0;

/// A compiled spec.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Program {
    /// [`FORMAT`].
    pub format: u32,
    /// The spec's name: that of its file, without the ending.
    pub name: String,
    /// Title of the spec, for reports.
    pub title: String,
    /// The robot.
    pub robot: RobotProgram,
    /// Signals and events.
    pub interface: Interface,
    /// Values of parameters, constant and moving.
    pub values: Values,
    /// Safety fields, in the order declared; their points are places in the table of values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fields: Vec<FieldProgram>,
    /// Obstacles, in the order declared; their poses are places in the table of values. Tasks have copies of theirs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub obstacles: Vec<Obstacle>,
    /// Tasks that some stack uses, in the order declared.
    pub tasks: Vec<TaskProgram>,
    /// Stacks, in the order declared.
    pub stacks: Vec<StackProgram>,
    /// The machine that changes between them.
    pub machine: Option<MachineProgram>,
    /// Content of `run`.
    pub run: RunProgram,
    /// Runs in worlds of their own, with what is expected of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub scenarios: Vec<ScenarioProgram>,
    /// Warnings of the compiler that the spec allows, for reports.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub allowed: Vec<AllowedWarning>,
}

/// A warning of the compiler that the spec allows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AllowedWarning {
    /// Its code.
    pub code: String,
    /// Its message.
    pub message: String,
    /// The reason for which it is allowed.
    pub reason: String,
}

impl Program {
    /// The stack that a run begins with; none where it begins with standing still.
    pub fn first_stack(&self) -> Option<usize> {
        match (self.run.subject, &self.machine) {
            (Subject::Stack(stack), _) => Some(stack),
            (Subject::Machine, Some(machine)) => machine.stack(machine.leaf(0)),
            (Subject::Machine, None) => None,
        }
    }

    /// Names of the signals that must all be true for the robot to take commands.
    pub fn enabling_names(&self) -> Vec<&str> {
        let signals = self.robot.enabling.iter().filter_map(|s| self.interface.signals.get(*s));
        signals.map(|s| s.name.as_str()).collect()
    }

    /// The stacks that a run can enter, each once.
    pub fn run_stacks(&self) -> Vec<usize> {
        self.entered_by([self.run.subject])
    }

    /// The stacks that a run or a scenario can enter, each once.
    pub fn entered_stacks(&self) -> Vec<usize> {
        self.entered_by([self.run.subject].into_iter().chain(self.scenarios.iter().map(|s| s.run.subject)))
    }

    fn entered_by(&self, subjects: impl IntoIterator<Item = Subject>) -> Vec<usize> {
        let mut stacks: Vec<usize> = Vec::new();
        for subject in subjects {
            let entered: Vec<usize> = match subject {
                Subject::Stack(stack) => vec![stack],
                Subject::Machine => self.machine.iter().flat_map(MachineProgram::stacks).collect(),
            };
            for stack in entered {
                if !stacks.contains(&stack) {
                    stacks.push(stack);
                }
            }
        }
        stacks
    }
}

/// The robot of a program.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RobotProgram {
    /// Its name in the spec.
    pub name: String,
    /// The URDF as the spec names it; for people, nothing reads it.
    pub urdf: String,
    /// The model, reduced to the joints that move.
    pub model: Model,
    /// Control period, in s. [`Program::at_period`] changes it; a controller refuses a program whose gains overshoot within it.
    pub period: f64,
    /// Start configuration, `nq` numbers.
    pub home: Vec<f64>,
    /// A tick that comes later than this after the one before is a fault, in s.
    pub deadline: f64,
    /// Gain of the low-level layer, thesis (3.9), in 1/s.
    pub tracking_gain: f64,
    /// Time constant of the drives, from the velocity that they are told to that of the robot, in s.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub lag: f64,
    /// Time after which a command begins to act, in s.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub dead_time: f64,
    /// True if the robot is stopped in one tick, by a host that stops it itself.
    #[serde(default, skip_serializing_if = "is_false")]
    pub stops_at_once: bool,
    /// True if a robot that takes commands again goes on by itself.
    #[serde(default, skip_serializing_if = "is_false")]
    pub resumes_itself: bool,
    /// Signals that must all be true for the robot to take commands.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub enabling: Vec<usize>,
    /// Arms, in the order declared.
    pub arms: Vec<Arm>,
    /// Named points and segments, in the order declared; for drawing.
    pub geometries: Vec<Geometry>,
}

/// Returns true for a setting that need not be written.
fn is_false(set: &bool) -> bool {
    !*set
}

/// Returns true for a time that need not be written.
fn is_zero(time: &f64) -> bool {
    *time == 0.0
}

impl RobotProgram {
    /// Time by which the robot is behind its commands, as declared (s).
    pub fn behind(&self) -> f64 {
        self.lag + self.dead_time
    }

    /// True where the home configuration lies within the joints' mechanical limits.
    pub fn home_is_legal(&self) -> bool {
        self.model.dofs.iter().all(|d| d.q_index.is_none_or(|i| self.home[i] >= d.lower && self.home[i] <= d.upper))
    }

    /// Words for the bases: `unicycle`, or `left unicycle, right floating` for several robots.
    pub fn base_words(&self) -> String {
        let of = |base: &MobileBase| format!("{} {}", base.prefix(&self.model).trim_end_matches('_'), base.kind.word());
        let words: Vec<String> = self.model.bases.iter().map(of).collect();
        if words.is_empty() { Base::Fixed.word().to_string() } else { words.join(",").trim_start().to_string() }
    }

    /// Origin of the first base that moves, at home; that of the world if no base moves \[m\].
    pub fn stands_at(&self) -> Vector3<f64> {
        let origin = |base: &MobileBase| {
            let at = |i: usize| self.home.get(base.first_coordinate + i).copied().unwrap_or(0.0);
            let z = if base.kind.drives() { 0.0 } else { at(2) };
            (self.model.place(base) * Point3::new(at(0), at(1), z)).coords
        };
        self.model.bases.first().map_or_else(Vector3::zeros, origin)
    }

    /// Names of the numbers of a configuration, of each robot its base first.
    pub fn q_names(&self) -> Vec<String> {
        let mut names = vec![String::new(); self.model.nq()];
        for base in &self.model.bases {
            let prefix = base.prefix(&self.model);
            for (i, name) in base.coordinates().zip(base.kind.coordinate_names()) {
                names[i] = format!("{prefix}{name}");
            }
        }
        for dof in &self.model.dofs {
            if let Some(i) = dof.q_index {
                names[i].clone_from(&dof.name);
            }
        }
        names
    }
}

/// The table of values that tasks read their parameters from.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Values {
    /// One number for each place; those of moving outputs hold their value at `t = 0` with captures at zero, or
    /// zero where that is not finite.
    pub initial: Vec<f64>,
    /// Operations that compute the moving values.
    pub tape: Tape,
    /// Values captured at the entry of the stack, in the order of the tape's inputs.
    pub captures: Vec<Capture>,
    /// Ranges that moving values must stay in; outside is a fault. A value that is not finite is outside every range.
    pub ranges: Vec<ValueRange>,
}

/// The range of a moving value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ValueRange {
    /// Its place in the table of values.
    pub at: usize,
    /// The smallest value allowed; none for minus infinity.
    pub min: Option<f64>,
    /// The largest value allowed; none for infinity.
    pub max: Option<f64>,
    /// The value is a gain: the largest allowed is one over the control period.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub gain: bool,
}

impl ValueRange {
    /// True for a finite number in the range.
    pub fn contains(&self, x: f64) -> bool {
        x.is_finite() && self.min.is_none_or(|m| x >= m) && self.max.is_none_or(|m| x <= m)
    }
}

/// A value that is read once, when the stack becomes active.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Capture {
    /// First input of the tape that it fills.
    pub at: usize,
    /// Number of values.
    pub len: usize,
    /// Source of the values.
    pub source: CaptureSource,
}

/// Source of a [`Capture`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CaptureSource {
    /// A value of a task, by the name that its type gives it.
    Task(usize, String),
    /// Rate of a value of a task at the present velocity of the robot: of a number, of a vector, or the angular
    /// velocity in the world of an orientation; of a pose, both in sequence. The fields are the task, the name, and the
    /// number of numbers of the value.
    Velocity(usize, String, usize),
    /// An expression of the robot's state, which reads nothing of the table of values.
    State(Expression),
}

/// A task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TaskProgram {
    /// Its name; an inline task is called after its level and type.
    pub name: String,
    /// Its type in the task library.
    pub kind: String,
    /// Bound parameters.
    pub params: BoundParams,
}

/// A stack.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StackProgram {
    /// Its name.
    pub name: String,
    /// Degrees of freedom that are kept still: their columns are switched off (thesis 3.4).
    pub locked: Vec<usize>,
    /// Levels, the most important first.
    pub levels: Vec<LevelProgram>,
    /// Parts of a stack that was merged of those of regions, in the order of the regions; none for a stack that was
    /// written.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<PartProgram>,
}

/// Part of a merged stack: the stack of one region. Its values have a clock of their own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartProgram {
    /// Tasks of that stack that are no members, because they equal one of an earlier part.
    pub equal: Vec<EqualTask>,
}

/// Task of a part of a merged stack that equals a member of an earlier part.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct EqualTask {
    /// Index into [`Program::tasks`].
    pub task: usize,
    /// Index of the task that is a member.
    pub member: usize,
}

/// A level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LevelProgram {
    /// Its name.
    pub name: String,
    /// Takes no slack: if it cannot be met, that is a fault.
    pub hard: bool,
    /// Weight of `|v|^2` in the level's own cost, whether it can be met or not; 0 for the damping that the program chooses
    /// where it cannot.
    pub damping: f64,
    /// The exact optimum also where the level cannot be met, without any damping.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub exact: bool,
    /// Tasks, in the order written.
    pub members: Vec<MemberProgram>,
}

/// A task in a level.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MemberProgram {
    /// Index into [`Program::tasks`].
    pub task: usize,
    /// Weight of its squared slack inside the level.
    pub weight: f64,
    /// Parts of a merged stack that contain the task, in ascending order; it reads the values of the first one. Empty in a
    /// stack that was written.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub parts: Vec<usize>,
    /// Rows that were proven to have no say, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub idle: Vec<IdleRow>,
}

/// A row of a limit that can never become active while joints stand inside their position limits and keep to the speeds
/// that hard levels allow, and why.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct IdleRow {
    /// The row of the task, from 0.
    pub row: usize,
    /// Largest rate at which its `h` can fall, in the row's unit per s.
    pub fastest: f64,
    /// Smallest rate of fall that the row permits at any joint position, in the same unit: more than `fastest`.
    pub allowed: f64,
}

/// Content of `run`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunProgram {
    /// Stack or machine that runs.
    pub subject: Subject,
    /// Duration, in s.
    pub duration: f64,
    /// Solver of the hierarchy.
    #[serde(default)]
    pub solver: solver::Backend,
    /// The simulated robot.
    pub simulator: Simulator,
    /// The time in s that a tick of the controller may take before the robot makes do with what is known of the answer; none for any time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tick_budget: Option<f64>,
    /// The connection to ROS 2; none for the usual one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ros: Option<RosProgram>,
}

/// Subject of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Subject {
    /// One stack, from start to end: an index into [`Program::stacks`].
    Stack(usize),
    /// The machine.
    Machine,
}

/// Deviations of the simulated robot from a perfect one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Simulator {
    /// Time constant of the actuators' first-order lag, in s; 0 for none.
    pub lag: f64,
    /// Standard deviation of the noise on measured positions, in rad or m; 0 for none.
    pub noise: f64,
    /// Seed of the noise.
    pub seed: u64,
    /// The largest real speed of each joint, in rad/s or m/s, where its own limit is not smaller; none for that alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed: Option<f64>,
    /// The largest real acceleration of each joint, in rad/s^2 or m/s^2; none for any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub acceleration: Option<f64>,
    /// The robot as a body with masses and drives, in place of the lag and the limits above; none for one that moves as it is
    /// commanded but for them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plant: Option<PlantProgram>,
}
