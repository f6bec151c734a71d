//! State machine as data. States form a tree whose root is the machine itself, so that transitions of the machine apply
//! in all states.

use serde::{Deserialize, Serialize};
use stdlib_tasks::expression::Expression;

use super::Measure;
use crate::fault::FaultKind;

/// A machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MachineProgram {
    /// States, parents before children; the first is the machine itself.
    pub states: Vec<StateProgram>,
    /// Actions that the states request.
    pub actions: Vec<ActionProgram>,
    /// Measures of the motion that conditions read.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measured: Vec<MeasuredProgram>,
    /// Targets that conditions ask to be reached.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reached: Vec<ReachedProgram>,
    /// Stacks of regions that run together.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub merged: Vec<MergedStack>,
}

/// Stack that runs while several regions add theirs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct MergedStack {
    /// Stacks of the regions, in the order of these.
    pub parts: Vec<usize>,
    /// The merged stack.
    pub stack: usize,
}

/// Target that conditions ask to be reached: a flag that only the controller sets, before it tests the transitions of a
/// tick. It is false while the stack of the task does not run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReachedProgram {
    /// Index of the flag among the signals.
    pub signal: usize,
    /// The criterion.
    #[serde(flatten)]
    pub criterion: Reached,
}

/// Measure of the motion that conditions read: a variable that only the controller sets, at the end of each tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredProgram {
    /// Index of the variable among the signals; it has one number.
    pub signal: usize,
    /// Speeds, an acceleration or reversals, of the velocity that the hierarchy chose.
    pub measure: Measure,
    /// State since whose last entry a count runs; `None` for measures that are not counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub since: Option<usize>,
}

/// A state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StateProgram {
    /// Its name, after those of the states around it: `outer.inner`. The name of the root is that of the machine.
    pub name: String,
    /// State around it; `None` for the root.
    pub parent: Option<usize>,
    /// State inside it that is entered with it; of a state with regions, the first of these.
    pub initial: Option<usize>,
    /// Regions of the state: states inside it that are active beside each other, in the order written; none if only one
    /// state inside it is active at a time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub regions: Vec<usize>,
    /// Stack that is entered with it. If it is `None`, the stack of the state around it continues.
    pub stack: Option<usize>,
    /// True if the machine ends in this state.
    #[serde(rename = "final")]
    pub is_final: bool,
    /// Actions on entering, in order.
    pub enter: Vec<usize>,
    /// Actions that begin on entering and are cancelled on leaving.
    pub activities: Vec<usize>,
    /// Actions on leaving.
    pub exit: Vec<usize>,
    /// Outgoing transitions, in the order in which they are tested.
    pub transitions: Vec<TransitionProgram>,
}

/// Transition from one state to another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransitionProgram {
    /// Its trigger.
    pub trigger: Trigger,
    /// The trigger in the words of the spec: `when norm(right_ft.force) < 3 N for 3 s`.
    pub text: String,
    /// Index of the target state.
    pub target: usize,
    /// Duration of the blend to the command of another stack, in s.
    pub blend: f64,
}

/// Trigger of a transition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Trigger {
    /// An event occurred since the last tick.
    Event(usize),
    /// A condition holds, and has held for some time without a break.
    When {
        /// A truth value: 1 for true, -1 for false. NaN is false.
        condition: Expression,
        /// Time for which it must have held, in s.
        hold: f64,
    },
    /// This time has passed since the state was entered, in s.
    After(f64),
    /// A target is reached.
    Reached(Reached),
    /// These regions have ended: each of them is in a final state.
    Ended(Vec<usize>),
    /// A fault occurred.
    Fault(FaultPattern),
}

/// Criterion that a target is reached: it does not move, each of the errors is at most its tolerance, and the rows are
/// slow enough. A target that signals move counts as one that does not move.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reached {
    /// The task.
    pub task: usize,
    /// Tolerance of each of the task's errors, in the order of [`stdlib_tasks::task::Task::measures`].
    pub tolerances: Vec<f64>,
    /// Bounds on the speed with which the robot moves along the task's rows.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub speeds: Vec<SpeedBound>,
}

/// Bound on the norm of `J v` over some rows of a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpeedBound {
    /// The rows, in the order of [`stdlib_tasks::task::Task::rows`].
    pub rows: Vec<usize>,
    /// The largest norm, in the unit of the rows per second.
    pub most: f64,
}

impl Reached {
    /// Returns true if this criterion holds whenever the other one does.
    pub fn follows_from(&self, other: &Reached) -> bool {
        let looser = |(mine, theirs): (&f64, &f64)| mine >= theirs;
        let bounded = |mine: &SpeedBound| other.speeds.iter().any(|o| o.rows == mine.rows && mine.most >= o.most);
        self.task == other.task
            && self.tolerances.iter().zip(&other.tolerances).all(looser)
            && self.speeds.iter().all(bounded)
    }
}

/// Faults that trigger a transition.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultPattern {
    /// Every fault.
    Any,
    /// Faults of a kind.
    Kind(FaultKind),
    /// A signal is stale.
    Stale(usize),
    /// One of these signals is stale.
    StaleAmong(Vec<usize>),
    /// A hard level of this name cannot be met.
    Infeasible(String),
    /// The limit of this task is violated.
    Limit(usize),
}

/// Action that the outside world is requested to perform.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActionProgram {
    /// Verb of the action: `say`, `capture`, `gripper`.
    pub verb: String,
    /// Its arguments, as text.
    pub arguments: Vec<String>,
    /// Event that the controller itself raises, for `emit`.
    pub event: Option<usize>,
    /// Events that report the outcome, each with the word for it.
    pub outcomes: Vec<(String, usize)>,
    /// Action of the controller on its own signals; it is not requested from the host.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own: Option<MachineAction>,
}

/// Action that the controller performs itself, at the tick of the action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MachineAction {
    /// Sets a variable to a value.
    Set {
        /// Index of the variable among the signals.
        variable: usize,
        /// Its value.
        value: Expression,
    },
    /// Makes a variable absent.
    Clear(usize),
    /// Tares a wrench: its present value is added to the bias.
    Tare(usize),
}

impl MachineProgram {
    /// States from this one up to the root.
    pub fn path(&self, state: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(state), |&s| self.states.get(s).and_then(|s| s.parent))
    }

    /// Innermost state that is entered together with a state; of regions beside each other, that of the first one.
    pub fn leaf(&self, state: usize) -> usize {
        std::iter::successors(Some(state), |&s| self.states.get(s).and_then(|s| s.initial)).last().unwrap_or(state)
    }

    /// Returns true if `inner` is inside `outer`, at any depth.
    pub fn is_around(&self, outer: usize, inner: usize) -> bool {
        outer != inner && self.path(inner).any(|s| s == outer)
    }

    /// Returns true if a transition of a state keeps the machine in its target while the trigger holds: the target is
    /// inside the state, and a trigger that may continue to hold does not enter it again.
    pub fn keeps(&self, state: usize, transition: &TransitionProgram) -> bool {
        let happens = matches!(transition.trigger, Trigger::Event(_) | Trigger::Fault(_));
        !happens && self.is_around(state, transition.target)
    }

    /// Returns true if a transition re-enters the state that defines it for a trigger that may continue to hold: a
    /// condition, or a target that is reached. A time restarts with the state.
    pub fn restarts(&self, state: usize, transition: &TransitionProgram) -> bool {
        let lasts = matches!(transition.trigger, Trigger::When { .. } | Trigger::Reached(_));
        let left = self.path(state).any(|s| s == transition.target);
        lasts && left && self.path(self.leaf(transition.target)).any(|s| s == state)
    }

    /// Returns true if the machine has ended in a state: the state, or one around it, is final.
    pub fn ends(&self, state: usize) -> bool {
        self.path(state).any(|s| self.states[s].is_final)
    }

    /// Returns true if a transition of `source` can be taken in an innermost state: a machine that has ended goes only to
    /// states in which it has ended too. A region that has ended does not keep the states around it from their
    /// transitions.
    pub fn permits(&self, leaf: usize, source: usize, transition: &TransitionProgram) -> bool {
        let leaf = if self.region(source).is_some() { leaf } else { self.spine(leaf) };
        !self.ends(leaf) || self.ends(self.leaf(transition.target))
    }
}
