//! A state machine as data: states form a tree whose root is the machine itself, so that what is said of the machine
//! holds in all states.

use serde::{Deserialize, Serialize};
use stdlib_tasks::expression::Expression;

use super::Measure;
use crate::fault::FaultKind;

/// A machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MachineProgram {
    /// States, parents before children; the first is the machine itself.
    pub states: Vec<StateProgram>,
    /// What states ask the outside world to do.
    pub actions: Vec<ActionProgram>,
    /// What conditions measure of the motion.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measured: Vec<MeasuredProgram>,
}

/// A measure of the motion that conditions read: a variable that the controller sets at the end of each tick, and nobody else.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MeasuredProgram {
    /// The signal that is the variable, of one number.
    pub signal: usize,
    /// A speed, an acceleration or reversals, of the velocity that the hierarchy chose.
    pub measure: Measure,
    /// For what is counted the state since whose last entry it is; none for the others.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub since: Option<usize>,
}

/// A state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StateProgram {
    /// Its name, behind those of the states that it stands in: `outer.inner`. That of the root is the machine's.
    pub name: String,
    /// The state that it stands in; none for the root.
    pub parent: Option<usize>,
    /// The state inside it that is entered with it.
    pub initial: Option<usize>,
    /// The stack that is entered with it; where none is given, that of the state around it goes on.
    pub stack: Option<usize>,
    /// The machine has come to its end here.
    #[serde(rename = "final")]
    pub is_final: bool,
    /// Actions on entering, in order.
    pub enter: Vec<usize>,
    /// Actions that are begun on entering and called off on leaving.
    pub activities: Vec<usize>,
    /// Actions on leaving.
    pub exit: Vec<usize>,
    /// Ways out, in the order in which they are looked at.
    pub transitions: Vec<TransitionProgram>,
}

/// A way from one state to another.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TransitionProgram {
    /// When it is taken.
    pub trigger: Trigger,
    /// The same in the words of the spec: `when norm(right_ft.force) < 3 N for 3 s`.
    pub text: String,
    /// The state that it leads to.
    pub target: usize,
    /// How long the command takes to go over to that of another stack, in s.
    pub blend: f64,
}

/// When a transition is taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Trigger {
    /// An event came since the last tick.
    Event(usize),
    /// A condition holds, and has held for some time without a break.
    When {
        /// A truth value: 1 for true, -1 for false. One that is not a number is false.
        condition: Expression,
        /// How long, in s.
        hold: f64,
    },
    /// The state was entered so long ago, in s.
    After(f64),
    /// A target is reached: it stands still, and each of the errors is at most its tolerance. A target that signals move
    /// counts as one that stands.
    Reached {
        /// The task.
        task: usize,
        /// For each of the task's errors, in the order of [`stdlib_tasks::task::Task::measures`].
        tolerances: Vec<f64>,
    },
    /// A fault came.
    Fault(FaultPattern),
}

/// The faults that a transition answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultPattern {
    /// Every fault.
    Any,
    /// Those of a kind.
    Kind(FaultKind),
    /// A signal is stale.
    Stale(usize),
    /// One of these signals is stale.
    StaleAmong(Vec<usize>),
    /// A hard level of this name cannot be met.
    Infeasible(String),
    /// A limit is passed.
    Limit(usize),
}

/// Something that the outside world is asked to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActionProgram {
    /// `say`, `capture`, `gripper`.
    pub verb: String,
    /// What it is said with, as text.
    pub arguments: Vec<String>,
    /// The event that the controller itself raises, for `emit`.
    pub event: Option<usize>,
    /// Events that tell how it came out, with the word for the outcome.
    pub outcomes: Vec<(String, usize)>,
    /// What the controller itself does with its signals; the host is not asked for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub own: Option<OwnAction>,
}

/// What the controller does itself, at the tick of the action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OwnAction {
    /// Gives a variable a value.
    Set {
        /// The signal that is the variable.
        variable: usize,
        /// Its value.
        value: Expression,
    },
    /// Makes a variable absent.
    Clear(usize),
    /// Lets what a wrench shows now become its bias.
    Tare(usize),
}

impl MachineProgram {
    /// From a state up to the root.
    pub fn path(&self, state: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(state), |&s| self.states.get(s).and_then(|s| s.parent))
    }

    /// The innermost state that is entered when a state is.
    pub fn leaf(&self, state: usize) -> usize {
        std::iter::successors(Some(state), |&s| self.states.get(s).and_then(|s| s.initial)).last().unwrap_or(state)
    }

    /// Whether a state stands inside another, at whatever depth.
    pub fn is_around(&self, outer: usize, inner: usize) -> bool {
        outer != inner && self.path(inner).any(|s| s == outer)
    }

    /// Whether a transition of a state keeps the machine in its target while it holds: the target stands inside the state,
    /// and is not entered anew for what may go on holding.
    pub fn keeps(&self, state: usize, transition: &TransitionProgram) -> bool {
        let happens = matches!(transition.trigger, Trigger::Event(_) | Trigger::Fault(_));
        !happens && self.is_around(state, transition.target)
    }

    /// Whether a transition of a state enters that state anew for something that may go on holding: for a condition, or for
    /// a target that is reached. A time begins anew with the state.
    pub fn restarts(&self, state: usize, transition: &TransitionProgram) -> bool {
        let lasts = matches!(transition.trigger, Trigger::When { .. } | Trigger::Reached { .. });
        let left = self.path(state).any(|s| s == transition.target);
        lasts && left && self.path(self.leaf(transition.target)).any(|s| s == state)
    }

    /// The state whose stack runs in a state.
    pub fn owner(&self, state: usize) -> Option<usize> {
        self.path(state).find(|&s| self.states[s].stack.is_some())
    }

    /// The stack that runs in a state.
    pub fn stack(&self, state: usize) -> Option<usize> {
        self.owner(state).and_then(|s| self.states[s].stack)
    }
}
