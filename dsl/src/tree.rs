//! The spanned tree that both spellings build: declarations exactly as written.
//!
//! A `*.hq` file and a `*.yaml` file that say the same thing give trees that compare equal: equality looks at
//! what was said, not at spans, comments, the text of a number or the braces around a tagged value. Nothing here
//! knows what a task, a frame or a unit means; the compiler does.

mod comments;
mod machines;
mod missions;
mod reuse;
mod scenarios;
mod values;

use crate::span::{Span, Spanned};

pub use comments::Comments;
pub use machines::{
    Action, Human, Machine, Moment, SafetyField, Signal, State, StateBody, Transition, Trigger, Variable,
};
pub use missions::{Mission, MissionMember, MissionRepeat};
pub use reuse::{
    Beside, Call, Change, Import, ImportName, Let, Parameter, Removal, Repeat, RepeatItems, RepeatMembers, Values,
};
pub use scenarios::{Expect, Formula, FormulaKind, Scenario, Window};
pub use values::{BinaryOp, Block, Entry, Number, Unit, Value, ValueKind};

/// One file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spec {
    /// Comments before the header, and behind it.
    pub opening_comments: Comments,
    /// The number after `hierarq`; `None` where the header is missing.
    pub version: Option<Spanned<u32>>,
    /// Declarations in the order written.
    pub items: Vec<Item>,
    /// Comments after the last declaration.
    pub closing_comments: Comments,
    /// Text that could not be read, and might have declared anything; empty where no mistake was found.
    pub unread: Vec<Span>,
}

/// A top-level declaration.
#[derive(Clone, Debug)]
pub struct Item {
    /// What is declared.
    pub kind: ItemKind,
    /// The whole declaration.
    pub span: Span,
    /// Comments before it, and behind its first line.
    pub comments: Comments,
}

impl PartialEq for Item {
    fn eq(&self, other: &Self) -> bool {
        self.kind == other.kind
    }
}

/// The kinds of declaration.
#[derive(Clone, Debug, PartialEq)]
pub enum ItemKind {
    /// `import "common/safety.hq" { deck }`
    Import(Import),
    /// `param approach = 0.15 m`
    Param(Param),
    /// `let half_turn = pi * 1 rad`
    Let(Let),
    /// `robot canopies { .. }`
    Robot(Robot),
    /// `task reach = frame_pose { .. }`
    Task(Task),
    /// `stack autonomous { level .. }`
    Stack(Stack),
    /// `signal peduncle : point?  timeout 0.5 s`
    Signal(Signal),
    /// `human operator { points [chest]  timeout 0.2 s }`
    Human(Human),
    /// `safety_field nearness { of operator }`
    SafetyField(SafetyField),
    /// What the machine keeps.
    Variable(Variable),
    /// `machine harvest { state look { .. } }`
    Machine(Machine),
    /// `mission vineyard : schedule { robot m1 { .. } }`
    Mission(Mission),
    /// `scenario "bunch hidden by leaves" { .. }`
    Scenario(Scenario),
    /// `for side in [left, right] { task touch_${side} = .. }`
    For(RepeatItems),
    /// `run { .. }`
    Run(Run),
}

/// A named number that the command line may override.
#[derive(Clone, Debug, PartialEq)]
pub struct Param {
    /// Its name.
    pub name: Spanned<String>,
    /// Its value.
    pub value: Value,
    /// `{ min 0.05 m  max 0.3 m }`, empty where no range is given.
    pub range: Block,
}

/// A robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Its name.
    pub name: Spanned<String>,
    /// The robot that it is made from: `from canopies`.
    pub base: Option<Spanned<String>>,
    /// What is said of it.
    pub body: Block,
}

/// A named task.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// Its name.
    pub name: Spanned<String>,
    /// `(side: arm, gain: rate = 5 /s)`
    pub parameters: Vec<Parameter>,
    /// Type, arguments and parameters.
    pub definition: TaskDefinition,
}

/// `kind(args) { parameters }`.
#[derive(Clone, Debug)]
pub struct TaskDefinition {
    /// The task type.
    pub kind: Spanned<String>,
    /// Arguments in parentheses, by position.
    pub args: Vec<Value>,
    /// Arguments in parentheses by name, behind those by position.
    pub named: Vec<Entry>,
    /// Parameters; empty where no braces were written.
    pub body: Block,
    /// The whole definition.
    pub span: Span,
}

impl TaskDefinition {
    /// Stands where a definition was and could not be read, so that the task keeps its name; its kind is empty.
    pub(crate) fn unread(span: Span) -> TaskDefinition {
        let kind = Spanned::new(String::new(), span);
        TaskDefinition { kind, args: Vec::new(), named: Vec::new(), body: Block { span, ..Block::default() }, span }
    }
}

impl PartialEq for TaskDefinition {
    fn eq(&self, other: &Self) -> bool {
        self.kind == other.kind && self.args == other.args && self.named == other.named && self.body == other.body
    }
}

/// An ordered hierarchy of levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Stack {
    /// Its name.
    pub name: Spanned<String>,
    /// `(side: arm)`
    pub parameters: Vec<Parameter>,
    /// The stack that it is made from: `from autonomous`.
    pub base: Option<Call>,
    /// Settings that are not levels (`lock [torso]`).
    pub settings: Block,
    /// Levels, the most important first.
    pub levels: Vec<Level>,
    /// What it changes in its base.
    pub changes: Vec<Change>,
}

/// One priority level.
#[derive(Clone, Debug)]
pub struct Level {
    /// Its name.
    pub name: Spanned<String>,
    /// Where `hard` was written, if it was. (`hard: false` in YAML is `None`.)
    pub hard: Option<Span>,
    /// Settings other than `hard` (`damping 0.01`).
    pub settings: Block,
    /// The tasks of the level.
    pub members: Vec<Member>,
    /// The whole level.
    pub span: Span,
    /// Comments before it.
    pub comments: Comments,
}

impl PartialEq for Level {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
            && self.hard.is_some() == other.hard.is_some()
            && self.settings == other.settings
            && self.members == other.members
    }
}

/// A task in a level.
#[derive(Clone, Debug)]
pub struct Member {
    /// By name, or written in place.
    pub task: MemberTask,
    /// `weight 2`.
    pub weight: Option<Value>,
    /// The whole member.
    pub span: Span,
    /// Comments before it.
    pub comments: Comments,
}

impl PartialEq for Member {
    fn eq(&self, other: &Self) -> bool {
        self.task == other.task && self.weight == other.weight
    }
}

/// How a level names a task.
#[derive(Clone, Debug, PartialEq)]
pub enum MemberTask {
    /// The name of a declared task.
    Name(Spanned<String>),
    /// A task without a name of its own: it has arguments or a block.
    Inline(TaskDefinition),
    /// `for side in [left, right] { hold(side) }`
    For(Box<RepeatMembers>),
}

/// What `hierarq run` does.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Settings of the run.
    pub body: Block,
}
