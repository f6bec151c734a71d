//! Signals and machines: the inputs of a robot while it runs, and the states that it switches between.

use super::{Block, Call, Comments, Entry, Expect, Value};
use crate::span::{Span, Spanned};

/// `signal peduncle : point?  timeout 0.5 s`: a typed input.
#[derive(Clone, Debug)]
pub struct Signal {
    /// Its name.
    pub name: Spanned<String>,
    /// Type of its value: `point`, `event`; empty if no type could be read.
    pub ty: Spanned<String>,
    /// Location of the `?` after the type, if there is one: the signal may be absent.
    pub optional: Option<Span>,
    /// `timeout 0.5 s`
    pub settings: Block,
}

equal_by!(Signal: name, ty, optional.is_some(), settings);

/// `variable attempts : number = 0`: a value that the machine stores and sets itself.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Its name.
    pub name: Spanned<String>,
    /// Type of its value: `number`, `point`; empty if no type could be read.
    pub ty: Spanned<String>,
    /// Location of the `?` after the type, if there is one: the variable may be absent.
    pub optional: Option<Span>,
    /// Initial value.
    pub value: Option<Value>,
}

equal_by!(Variable: name, ty, optional.is_some(), value);

/// `machine harvest { initial look  state look { .. } }`
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Its name.
    pub name: Spanned<String>,
    /// Its settings and states, and the transitions that apply in all of them.
    pub body: StateBody,
}

/// A state of a machine, or of another state, or one of the regions of a state that are active beside each other.
#[derive(Clone, Debug)]
pub struct State {
    /// Its name.
    pub name: Spanned<String>,
    /// True for a region, `region left { .. }`.
    pub region: bool,
    /// Location of `final`, if it was written. (`final: false` in YAML is `None`.)
    pub final_: Option<Span>,
    /// Its content; empty if no braces were written.
    pub body: StateBody,
    /// The whole state.
    pub span: Span,
    /// Comments before it and at the end of its first line.
    pub comments: Comments,
}

equal_by!(State: name, region, final_.is_some(), body);

/// Content of the braces of a machine or a state. The order within a group is significant, the order of the groups is
/// not; the actions of each moment are a group of their own.
#[derive(Clone, Debug, Default)]
pub struct StateBody {
    /// The stack that is active: `stack reach_to(goal: peduncle)`.
    pub stack: Option<Call>,
    /// Comments before and after the stack.
    pub stack_comments: Comments,
    /// `initial look`, `blend 0.5 s`
    pub settings: Block,
    /// Actions on entering, while in the state, and on leaving.
    pub actions: Vec<Action>,
    /// Transitions out of the state; the first enabled one is taken.
    pub transitions: Vec<Transition>,
    /// Properties that hold at every tick at which the state is active: `check always not gripper_open`.
    pub properties: Vec<Expect>,
    /// Nested states, and regions.
    pub states: Vec<State>,
    /// Comments before the closing brace.
    pub closing_comments: Comments,
}

impl PartialEq for StateBody {
    fn eq(&self, other: &Self) -> bool {
        let at = |body: &StateBody, moment| body.actions_at(moment).cloned().collect::<Vec<Action>>();
        self.stack == other.stack
            && self.settings == other.settings
            && Moment::ALL.into_iter().all(|moment| at(self, moment) == at(other, moment))
            && self.transitions == other.transitions
            && self.properties == other.properties
            && [false, true].into_iter().all(|region| self.inner(region).eq(other.inner(region)))
    }
}

impl State {
    /// Returns the word that it begins with in `*.hq` texts.
    pub fn word(&self) -> &'static str {
        if self.region { "region" } else { "state" }
    }
}

impl StateBody {
    /// Returns the nested states, or the regions, in their order.
    pub fn inner(&self, region: bool) -> impl Iterator<Item = &State> {
        self.states.iter().filter(move |state| state.region == region)
    }

    /// Returns the actions of a moment in their order.
    pub fn actions_at(&self, moment: Moment) -> impl Iterator<Item = &Action> {
        self.actions.iter().filter(move |action| action.moment.value == moment)
    }
}

/// Moment of an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// Once, on entering the state.
    Enter,
    /// From entering the state on.
    Do,
    /// Once, on leaving the state.
    Exit,
}

impl Moment {
    /// The moments in temporal order.
    pub const ALL: [Moment; 3] = [Moment::Enter, Moment::Do, Moment::Exit];

    /// Returns the keyword of the moment.
    pub fn word(self) -> &'static str {
        match self {
            Moment::Enter => "enter",
            Moment::Do => "do",
            Moment::Exit => "exit",
        }
    }
}

/// `enter say "text"`, `do capture(head_camera)`, `exit gripper close right`
#[derive(Clone, Debug)]
pub struct Action {
    /// Moment of the action.
    pub moment: Spanned<Moment>,
    /// Verb of the action; empty if nothing could be read.
    pub verb: Spanned<String>,
    /// Arguments by position.
    pub args: Vec<Value>,
    /// Arguments by name, after those by position.
    pub named: Vec<Entry>,
    /// True if written without parentheses, `gripper close`; the two are equivalent.
    pub bare: bool,
    /// The whole action.
    pub span: Span,
    /// Comments before and after it.
    pub comments: Comments,
}

equal_by!(Action: moment, verb, args, named);

/// `when norm(right_ft.force) < 3 N for 3 s -> grasp blend 1 s`
#[derive(Clone, Debug)]
pub struct Transition {
    /// The trigger.
    pub trigger: Trigger,
    /// Target state, as a path through the enclosing states, `outer.inner`; empty if none could be read.
    pub target: Spanned<String>,
    /// `blend 1 s`
    pub settings: Block,
    /// The whole transition.
    pub span: Span,
    /// Comments before and after it.
    pub comments: Comments,
}

equal_by!(Transition: trigger, target, settings);

/// Trigger of a transition.
#[derive(Clone, Debug, PartialEq)]
pub enum Trigger {
    /// `on found`, `on reached(reach, 5 mm)`: an event.
    On(Value),
    /// `when x < 3 N for 3 s`: a condition.
    When {
        /// The condition.
        condition: Value,
        /// Duration for which it must be true; the transition is taken at once if there is none.
        hold: Option<Value>,
    },
    /// `after 10 s`: time in the state.
    After(Value),
    /// No readable trigger; a diagnostic has reported it.
    Missing,
}
