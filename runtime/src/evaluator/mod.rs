//! A stack prepared for execution: kinematics, parameter values and tasks, which together fill the hierarchical
//! problem.
//!
//! The controller has one for its reference configuration. If the simulated robot is not perfect, the monitors have
//! another one for the true configuration.

mod ahead;
mod build;
mod capture;
mod curvature;
mod foresight;
mod member;
mod parts;
mod ready;
mod task_outputs;
mod tick_inputs;
mod update;

use robot::{Data, Model};
use solver::Problem;
use stdlib_tasks::task::Task;

pub(crate) use ahead::{Ahead, ShortRow};
pub use build::{Built, build_tasks};
use capture::Captured;
use foresight::Foresight;
pub use member::Member;
use task_outputs::TaskOutputs;
pub use tick_inputs::{RestInputs, TickInputs};

use crate::locked_joint_motion::LockedJointMotion;
use crate::planning::Planning;
use crate::program::Interface;
use crate::safety::{Field, SafetyPlanner, TaskLevel};
use crate::values::ValueTable;

/// Stack prepared for execution.
pub struct Evaluator {
    model: Model,
    data: Data,
    /// Values of each part of the stack; a stack that was not merged is one part.
    values: Vec<ValueTable>,
    /// Time at which each part was entered (s), where it is not that of the stack.
    clocks: Vec<Option<f64>>,
    /// True for each part that is entered with the stack, and does not go on from the stack before.
    fresh: Vec<bool>,
    /// True for each member that goes on from the stack before.
    goes_on: Vec<bool>,
    captures: Vec<Captured>,
    foresight: Foresight,
    tasks: Vec<Box<dyn Task>>,
    members: Vec<Member>,
    locked: Vec<usize>,
    locked_joint_motion: LockedJointMotion,
    margins: Vec<f64>,
    measures: Vec<f64>,
    undefined: Vec<bool>,
    /// Safety planners of the stack.
    planners: Vec<Planning>,
    led: Led,
    /// Outputs of the tasks.
    outputs: Vec<TaskOutputs>,
    /// Signals that must be present.
    needs: Vec<usize>,
    /// Storage for a configuration beside the present one.
    beside: Vec<f64>,
    /// Joint limits within which idle rows are idle.
    limits: Vec<JointLimits>,
    /// True if all joints are inside these limits, so that the proofs about idle rows hold.
    inside: bool,
}

/// Rows of a level.
#[derive(Clone, Debug)]
pub(crate) struct LevelRows {
    /// Index of the level.
    pub level: usize,
    /// Their range in the level.
    pub rows: std::ops::Range<usize>,
}

/// Limits of a joint's position, in rad or m.
struct JointLimits {
    /// Index of the joint in the configuration.
    q_index: usize,
    lower: f64,
    upper: f64,
}

/// Entry of the table of values that a planner of another evaluator computes.
struct LedValue {
    /// Part of the stack that reads it.
    part: usize,
    /// Index of the entry.
    at: usize,
    value: f64,
    /// Rate of the value, per s.
    rate: f64,
}

/// Decisions of the controller's planners, which an evaluator at another configuration takes over from the controller's
/// evaluator.
#[derive(Default)]
struct Led {
    /// Values that planners compute.
    values: Vec<LedValue>,
    /// True if these values are used.
    on: bool,
}

/// Distance beyond its limit at which a joint still counts as inside, in rad or m: the reference ends a tick on the
/// limit only up to rounding. Proofs of idle rows cover this distance.
pub const LIMIT_TOLERANCE: f64 = 1e-6;

impl Evaluator {
    /// Model of the robot.
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

    /// Degrees of freedom that the stack locks.
    pub fn locked(&self) -> &[usize] {
        &self.locked
    }

    /// Margin `h` of every row of every limit.
    pub fn margins(&self) -> &[f64] {
        &self.margins
    }

    /// Every error of every target; NaN if it is undefined.
    pub fn measures(&self) -> &[f64] {
        &self.measures
    }

    /// True for each task that had an undefined row at the last tick, which was left free.
    pub fn undefined(&self) -> &[bool] {
        &self.undefined
    }

    /// Returns true if a task captured values other than its parameters when the stack was entered.
    pub fn remembers_entry(&self, member: usize) -> bool {
        self.tasks.get(member).is_some_and(|t| t.remembers_entry())
    }

    /// Returns true if all joints were inside their limits at the last update, so that what was proven of these configurations holds.
    pub(crate) fn is_inside(&self) -> bool {
        self.inside
    }

    /// Returns true if all joints of a configuration are inside their limits.
    pub(crate) fn is_within_limits(&self, q: &[f64]) -> bool {
        self.limits.iter().all(|l| l.lower <= q[l.q_index] && q[l.q_index] <= l.upper)
    }

    /// The task of a member, to be changed.
    pub(crate) fn task_mut(&mut self, member: usize) -> Option<&mut (dyn Task + 'static)> {
        self.tasks.get_mut(member).map(|t| &mut **t)
    }

    /// The task of a member.
    pub(crate) fn task(&self, member: usize) -> Option<&dyn Task> {
        self.tasks.get(member).map(|t| &**t)
    }

    /// Reserve that each row of a task keeps against sampling in time; empty if its limit has no curvature.
    pub fn sampled_margin(&self, member: usize) -> Vec<f64> {
        self.tasks.get(member).map(|t| t.sampled_margin()).unwrap_or_default()
    }

    /// Returns true if a limit looks ahead where it is on a hard level; see [`Task::looks_ahead`].
    pub fn looks_ahead(&self, member: usize) -> bool {
        self.tasks.get(member).is_some_and(|t| t.looks_ahead())
    }

    /// Margin that each row of a task can lose to sampling in time; empty if its limit has no curvature.
    pub fn sampled_loss(&self, member: usize) -> Vec<f64> {
        self.tasks.get(member).map(|t| t.sampled_loss()).unwrap_or_default()
    }

    /// Smallest limit of each degree of freedom's acceleration, in rad/s² or m/s²; infinite if no task has one.
    pub fn acceleration_limits(&self) -> Vec<f64> {
        let mut limits = vec![f64::INFINITY; self.model.nv()];
        for (dof, limit) in self.tasks.iter().flat_map(|t| t.acceleration_limits()) {
            limits[dof] = limits[dof].min(limit);
        }
        limits
    }

    /// Rows of the tasks that limit accelerations.
    pub(crate) fn acceleration_rows(&self) -> Vec<LevelRows> {
        let limits = self.tasks.iter().zip(&self.members).filter(|(task, _)| !task.acceleration_limits().is_empty());
        limits.map(|(_, m)| LevelRows { level: m.level, rows: m.rows.clone() }).collect()
    }

    /// Value of a parameter at the last tick.
    pub fn value(&self, at: usize) -> Option<f64> {
        self.table_of(at).current.get(at).copied()
    }

    /// Returns true if the value of a parameter has settled: it does not move, and a trajectory that it follows from is
    /// at its goal.
    pub fn is_settled(&self, at: usize) -> bool {
        self.rate(at).is_none_or(|r| r == 0.0)
            && self.table_of(at).is_settled(at)
            && self.planners.iter().all(|p| p.values.is_settled(at))
    }

    /// Rate of a parameter at the last tick, per second.
    pub fn rate(&self, at: usize) -> Option<f64> {
        self.table_of(at).rates.get(at).copied()
    }

    /// Signals that must be present for the stack to run.
    pub fn needs(&self) -> &[usize] {
        &self.needs
    }

    /// Stores the curvature of the rows in the levels of the stack's problem; see [`curvature`]. `exact` marks the
    /// levels that are never damped. Called before the stack is entered.
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
            let task = TaskLevel { level: &problem.levels[*level], first: rows.start };
            planner.set_curvature(
                &self.model,
                &problem.levels[..*level],
                task,
                &exact[..=*level],
                curvature::horizon(period),
            );
        }
    }

    /// Takes over the decisions that the planners of the controller's evaluator made at this tick. They are used for
    /// the next update and for all later ones, instead of own decisions. Never allocates.
    pub fn follow(&mut self, leader: &Evaluator) {
        self.led.on = true;
        self.values.iter_mut().zip(&leader.values).for_each(|(mine, theirs)| mine.wait_as(theirs));
        for LedValue { part, at, value, rate } in &mut self.led.values {
            if let Some(table) = leader.values.get(*part)
                && let (Some(x), Some(r)) = (table.current.get(*at), table.rates.get(*at))
            {
                (*value, *rate) = (*x, *r);
            }
        }
        for planner in &leader.planners {
            let mine = self.members.iter().position(|m| m.program_index == planner.program_index);
            if let Some(task) = mine.and_then(|i| self.tasks.get_mut(i)) {
                task.set_decided_velocity(&planner.internal);
            }
        }
    }

    /// Advances the clocks and deviations of the planners by a part of a period, as decided. Never allocates.
    pub(crate) fn advance(&mut self, part: f64) {
        self.planners.iter_mut().for_each(|planner| planner.advance(part));
    }

    /// Safety planners of the stack, each with its field, as of the last tick.
    pub fn safety(&self) -> impl Iterator<Item = (&SafetyPlanner, &Field)> {
        self.planners.iter().map(|p| (p.planner(), p.field()))
    }

    /// Field of a safety planner, given by the index of its task in the program, at the last tick.
    pub fn field_of(&self, task: usize) -> Option<&Field> {
        self.planners.iter().find(|p| p.program_index == task).map(|p| p.field())
    }

    /// Sets whether locked joints are coming to rest at the next update, or are at rest.
    pub(crate) fn set_locked_joints_moving(&mut self, moving: bool) {
        if std::mem::replace(&mut self.locked_joint_motion.on, moving) != moving {
            self.tasks.iter_mut().for_each(|task| task.set_locked_joints_moving(moving));
        }
    }

    /// Coefficients of locked joints that were stored at the last update.
    pub(crate) fn locked_joint_motion(&self) -> &LockedJointMotion {
        &self.locked_joint_motion
    }
}
