//! Signals, humans and machines: what a robot is told while it runs, and the states between which it goes.

use super::{Block, Call, Comments, Entry, Value};
use crate::span::{Span, Spanned};

/// `signal peduncle : point?  timeout 0.5 s`: a typed input.
#[derive(Clone, Debug)]
pub struct Signal {
    /// Its name.
    pub name: Spanned<String>,
    /// What it carries: `point`, `event`; empty where no type could be read.
    pub ty: Spanned<String>,
    /// Where the `?` stands behind the type, if it does: the signal may be absent.
    pub optional: Option<Span>,
    /// `timeout 0.5 s`
    pub settings: Block,
}

impl PartialEq for Signal {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
            && self.ty == other.ty
            && self.optional.is_some() == other.optional.is_some()
            && self.settings == other.settings
    }
}

/// `human operator { points [chest, left_wrist]  lost hold }`: a person whose points are tracked.
#[derive(Clone, Debug, PartialEq)]
pub struct Human {
    /// Its name.
    pub name: Spanned<String>,
    /// What is said of it.
    pub body: Block,
}

/// `safety_field nearness { of operator  points mean }`: how far the robot is from people, as one number.
#[derive(Clone, Debug, PartialEq)]
pub struct SafetyField {
    /// Its name.
    pub name: Spanned<String>,
    /// What is said of it.
    pub body: Block,
}

/// `variable attempts : number = 0`: what the machine keeps and sets itself.
#[derive(Clone, Debug)]
pub struct Variable {
    /// Its name.
    pub name: Spanned<String>,
    /// What it holds: `number`, `point`; empty where no type could be read.
    pub ty: Spanned<String>,
    /// Where the `?` stands behind the type, if it does: the variable may be absent.
    pub optional: Option<Span>,
    /// What it holds at the start.
    pub value: Option<Value>,
}

impl PartialEq for Variable {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
            && self.ty == other.ty
            && self.optional.is_some() == other.optional.is_some()
            && self.value == other.value
    }
}

/// `machine harvest { initial look  state look { .. } }`
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Its name.
    pub name: Spanned<String>,
    /// Its settings and states, and the transitions that hold in all of them.
    pub body: StateBody,
}

/// A state of a machine, or of another state.
#[derive(Clone, Debug)]
pub struct State {
    /// Its name.
    pub name: Spanned<String>,
    /// Where `final` was written, if it was. (`final: false` in YAML is `None`.)
    pub final_: Option<Span>,
    /// What holds in it; empty where no braces were written.
    pub body: StateBody,
    /// The whole state.
    pub span: Span,
    /// Comments before it, and behind its first line.
    pub comments: Comments,
}

impl PartialEq for State {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.final_.is_some() == other.final_.is_some() && self.body == other.body
    }
}

/// What stands in the braces of a machine or a state. Within a group the order says something, between the groups it
/// does not; the actions of each moment are a group of their own.
#[derive(Clone, Debug, Default)]
pub struct StateBody {
    /// The stack that runs: `stack reach_to(goal: peduncle)`.
    pub stack: Option<Call>,
    /// Comments before and behind the stack.
    pub stack_comments: Comments,
    /// `initial look`, `blend 0.5 s`
    pub settings: Block,
    /// What is done on entering, while here, on leaving.
    pub actions: Vec<Action>,
    /// Ways out, the first that holds is taken.
    pub transitions: Vec<Transition>,
    /// States inside.
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
            && self.states == other.states
    }
}

impl StateBody {
    /// The actions of a moment in their order.
    pub fn actions_at(&self, moment: Moment) -> impl Iterator<Item = &Action> {
        self.actions.iter().filter(move |action| action.moment.value == moment)
    }
}

/// When an action is done.
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
    /// The moments in the order in which they come.
    pub const ALL: [Moment; 3] = [Moment::Enter, Moment::Do, Moment::Exit];

    /// The word that is written.
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
    /// When it is done.
    pub moment: Spanned<Moment>,
    /// What is done; empty where nothing could be read.
    pub verb: Spanned<String>,
    /// Arguments by position.
    pub args: Vec<Value>,
    /// Arguments by name, behind those by position.
    pub named: Vec<Entry>,
    /// Written without parentheses, `gripper close`: a matter of spelling only.
    pub bare: bool,
    /// The whole action.
    pub span: Span,
    /// Comments before it and behind it.
    pub comments: Comments,
}

impl PartialEq for Action {
    fn eq(&self, other: &Self) -> bool {
        self.moment == other.moment && self.verb == other.verb && self.args == other.args && self.named == other.named
    }
}

/// `when norm(right_ft.force) < 3 N for 3 s -> grasp blend 1 s`
#[derive(Clone, Debug)]
pub struct Transition {
    /// What it waits for.
    pub trigger: Trigger,
    /// The next state, as a path through the states that hold it, `outer.inner`; empty where none could be read.
    pub target: Spanned<String>,
    /// `blend 1 s`
    pub settings: Block,
    /// The whole transition.
    pub span: Span,
    /// Comments before it and behind it.
    pub comments: Comments,
}

impl PartialEq for Transition {
    fn eq(&self, other: &Self) -> bool {
        self.trigger == other.trigger && self.target == other.target && self.settings == other.settings
    }
}

/// What a transition waits for.
#[derive(Clone, Debug, PartialEq)]
pub enum Trigger {
    /// `on found`, `on reached(reach, 5 mm)`: something that happens.
    On(Value),
    /// `when x < 3 N for 3 s`: something that holds.
    When {
        /// What must hold.
        condition: Value,
        /// How long it must hold; at once where no time is said.
        hold: Option<Value>,
    },
    /// `after 10 s`: time in the state.
    After(Value),
    /// Nothing readable stands here; a diagnostic has said so.
    Missing,
}
