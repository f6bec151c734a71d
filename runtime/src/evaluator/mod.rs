//! A stack made ready to run: kinematics, parameter values and tasks, which together fill the hierarchical problem.
//!
//! The controller has one for its reference configuration; where the simulated robot is not perfect, the monitors have
//! another for the true one.

mod build;
mod capture;
mod curvature;
mod member;
mod moment;
mod ready;
mod telling;
mod update;

use robot::{Data, Model};
use solver::Problem;
use stdlib_tasks::task::Task;

pub use build::{Built, build_tasks};
use capture::Captured;
pub use member::Member;
pub use moment::{Moment, Rest};
use telling::Telling;

use crate::coasting::Coasting;
use crate::planning::Planning;
use crate::program::Interface;
use crate::safety::{Field, SafetyPlanner};
use crate::values::ValueTable;

/// A stack made ready to run.
pub struct Evaluator {
    model: Model,
    data: Data,
    values: ValueTable,
    captures: Vec<Captured>,
    tasks: Vec<Box<dyn Task>>,
    members: Vec<Member>,
    locked: Vec<usize>,
    coasting: Coasting,
    margins: Vec<f64>,
    measures: Vec<f64>,
    undefined: Vec<bool>,
    /// Safety planners of the stack.
    planners: Vec<Planning>,
    led: Led,
    /// What tasks tell of themselves.
    telling: Vec<Telling>,
    /// Signals that must be present.
    needs: Vec<usize>,
    /// Room for a configuration beside the one that is looked at.
    beside: Vec<f64>,
    /// Where joints must stand for idle rows to be idle: index in the configuration, lowest, highest position.
    limits: Vec<(usize, f64, f64)>,
    /// All joints stand inside them, where proofs about idle rows hold.
    inside: bool,
}

/// What an evaluator takes over from that of the controller, where it looks at another configuration: what the controller's
/// planners decided.
#[derive(Default)]
struct Led {
    /// Places of the table of values that planners work out, with their value and rate.
    values: Vec<(usize, f64, f64)>,
    /// It takes them over.
    on: bool,
}

/// How far beyond its limit a joint may stand and still count as inside, in rad or m: the reference ends a tick on the
/// limit only up to rounding. Proofs of idle rows reach as far.
pub const LIMIT_TOLERANCE: f64 = 1e-6;

impl Evaluator {
    /// The robot.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Kinematics at the last configuration.
    pub fn data(&self) -> &Data {
        &self.data
    }

    /// The tasks, in the order of levels.
    pub fn members(&self) -> &[Member] {
        &self.members
    }

    /// Degrees of freedom that the stack keeps still.
    pub fn locked(&self) -> &[usize] {
        &self.locked
    }

    /// `h` of every row of every limit.
    pub fn margins(&self) -> &[f64] {
        &self.margins
    }

    /// Every error of every target; NaN where it is undefined.
    pub fn measures(&self) -> &[f64] {
        &self.measures
    }

    /// For each task, whether a row was undefined at the last tick and left free.
    pub fn undefined(&self) -> &[bool] {
        &self.undefined
    }

    /// Whether a task took something from the robot when the stack was entered, beside its parameters.
    pub fn remembers_entry(&self, member: usize) -> bool {
        self.tasks.get(member).is_some_and(|t| t.remembers_entry())
    }

    /// What each row of a task keeps in reserve against sampling in time; empty where its limit cannot bend.
    pub fn reserve(&self, member: usize) -> Vec<f64> {
        self.tasks.get(member).map(|t| t.reserve()).unwrap_or_default()
    }

    /// What each row of a task can lose to sampling in time; empty where its limit cannot bend.
    pub fn sampled_loss(&self, member: usize) -> Vec<f64> {
        self.tasks.get(member).map(|t| t.sampled_loss()).unwrap_or_default()
    }

    /// The least limit of each degree of freedom's acceleration, in rad/s² or m/s²; infinite if no task has one.
    pub fn acceleration_limits(&self) -> Vec<f64> {
        let mut limits = vec![f64::INFINITY; self.model.nv()];
        for (dof, limit) in self.tasks.iter().flat_map(|t| t.acceleration_limits()) {
            limits[dof] = limits[dof].min(limit);
        }
        limits
    }

    /// The rows of the tasks that limit accelerations: their level, and their places in it.
    pub(crate) fn acceleration_rows(&self) -> Vec<(usize, std::ops::Range<usize>)> {
        let limits = self.tasks.iter().zip(&self.members).filter(|(task, _)| !task.acceleration_limits().is_empty());
        limits.map(|(_, m)| (m.level, m.rows.clone())).collect()
    }

    /// The value of a parameter at the last tick.
    pub fn value(&self, at: usize) -> Option<f64> {
        self.values.current.get(at).copied()
    }

    /// Whether the value of a parameter has come to where it is going: it does not move, and a trajectory that it follows
    /// from stands at its goal.
    pub fn is_settled(&self, at: usize) -> bool {
        self.rate(at).is_none_or(|r| r == 0.0)
            && self.values.is_settled(at)
            && self.planners.iter().all(|p| p.values.is_settled(at))
    }

    /// How fast the value of a parameter changed at the last tick, per second.
    pub fn rate(&self, at: usize) -> Option<f64> {
        self.values.rates.get(at).copied()
    }

    /// Signals that must be present for the stack to run.
    pub fn needs(&self) -> &[usize] {
        &self.needs
    }

    /// Tells the soft levels of the stack's problem how much their rows bend; see [`curvature`]. `exact` says which levels are
    /// never damped. Called before the stack is entered.
    pub(crate) fn measure_curvature(
        &mut self,
        period: f64,
        interface: &Interface,
        exact: &[bool],
        problem: &mut Problem,
    ) {
        let Evaluator { model, values, tasks, members, locked, .. } = self;
        curvature::Stack { model, members, tasks, values, interface, locked, period }.measure(problem);
        for planner in &mut self.planners {
            let Member { level, rows, .. } = &self.members[planner.task];
            let task = (&problem.levels[*level], rows.start);
            planner.bend(&self.model, &problem.levels[..*level], task, &exact[..=*level], curvature::horizon(period));
        }
    }

    /// Takes over what the planners of another evaluator of the same robot decided at this tick, that of the controller:
    /// for the next update, and for good. Never allocates.
    pub fn follow(&mut self, leader: &Evaluator) {
        self.led.on = true;
        for (at, value, rate) in &mut self.led.values {
            if let (Some(x), Some(r)) = (leader.value(*at), leader.rate(*at)) {
                (*value, *rate) = (x, r);
            }
        }
        for planner in &leader.planners {
            let mine = self.members.iter().position(|m| m.program_index == planner.program_index);
            if let Some(task) = mine.and_then(|i| self.tasks.get_mut(i)) {
                task.decided(&planner.internal);
            }
        }
    }

    /// Moves clocks and deviations of planners on by a period, as they were decided. Never allocates.
    pub(crate) fn advance(&mut self) {
        self.planners.iter_mut().for_each(Planning::advance);
    }

    /// The safety planners of the stack, each with its field, as of the last tick.
    pub fn safety(&self) -> impl Iterator<Item = (&SafetyPlanner, &Field)> {
        self.planners.iter().map(|p| (p.planner(), p.field()))
    }

    /// The field of the safety planner that a task of the program is, at the last tick.
    pub fn field_of(&self, task: usize) -> Option<&Field> {
        self.planners.iter().find(|p| p.program_index == task).map(|p| p.field())
    }

    /// Locked joints come to rest at the next update, or stand.
    pub(crate) fn coast(&mut self, coasts: bool) {
        if std::mem::replace(&mut self.coasting.on, coasts) != coasts {
            self.tasks.iter_mut().for_each(|task| task.coast(coasts));
        }
    }

    /// What was kept back from the rows of locked joints at the last update.
    pub(crate) fn coasting(&self) -> &Coasting {
        &self.coasting
    }
}
