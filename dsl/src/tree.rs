//! The tree that both syntaxes build: declarations exactly as written, with source locations.
//!
//! A `*.hq` file and a `*.yaml` file with the same content produce trees that compare equal: equality ignores spans,
//! comments, the text of a number and the braces around a tagged value. The tree does not know the meaning of tasks,
//! frames or units; the compiler does.

/// Implements equality of a node by these parts alone: spans, comments and other traces of its text do not take part.
macro_rules! equal_by {
    ($node:ty: $($part:ident $(. $call:ident ())?),+) => {
        impl PartialEq for $node {
            fn eq(&self, other: &Self) -> bool {
                $(self.$part $(.$call())? == other.$part $(.$call())?)&&+
            }
        }
    };
}

mod comments;
mod machines;
mod missions;
mod named_blocks;
mod reuse;
mod scenarios;
mod values;

use crate::span::{Span, Spanned};

pub use comments::Comments;
pub use machines::{Action, Machine, Moment, Signal, State, StateBody, Transition, Trigger, Variable};
pub use missions::{Mission, MissionMember, MissionRepeat};
pub use named_blocks::{BlockKind, NamedBlock};
pub use reuse::{
    Beside, Call, Change, Import, ImportName, Let, Parameter, Removal, Repeat, RepeatItems, RepeatMembers, Values,
};
pub use scenarios::{Expect, Formula, FormulaKind, Scenario, Window};
pub use values::{BinaryOp, Block, Entry, Number, Unit, Value, ValueKind};

/// One file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spec {
    /// Comments before and after the header.
    pub opening_comments: Comments,
    /// The number after `hierarq`; `None` if the header is missing.
    pub version: Option<Spanned<u32>>,
    /// Declarations in the order written.
    pub items: Vec<Item>,
    /// Comments after the last declaration.
    pub closing_comments: Comments,
    /// Text that could not be read, and that may contain declarations; empty if no error was found.
    pub unread: Vec<Span>,
}

/// A top-level declaration.
#[derive(Clone, Debug)]
pub struct Item {
    /// Content.
    pub kind: ItemKind,
    /// The whole declaration.
    pub span: Span,
    /// Comments before it, and at the end of its first line.
    pub comments: Comments,
}

equal_by!(Item: kind);

/// The kinds of declaration.
#[derive(Clone, Debug, PartialEq)]
pub enum ItemKind {
    /// `import "common/safety.hq" { deck }`
    Import(Import),
    /// `allow HQ0707 "the cell is caged"`
    Allow(Allow),
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
    /// `human operator { points [chest]  timeout 0.2 s }`, and others of this form
    Block(NamedBlock),
    /// `variable attempts : number = 0`
    Variable(Variable),
    /// `machine harvest { state look { .. } }`
    Machine(Machine),
    /// `mission vineyard : schedule { robot m1 { .. } }`
    Mission(Mission),
    /// `scenario "bunch hidden by leaves" { .. }`
    Scenario(Scenario),
    /// `for side in [left, right] { task touch_${side} = .. }`
    For(RepeatItems),
    /// `coverage { velocity hard }`
    Coverage(Coverage),
    /// `run { .. }`
    Run(Run),
}

/// A warning that is intended anywhere in the file. Inside a block, the entry `allow` has a block of codes and reasons.
#[derive(Clone, Debug, PartialEq)]
pub struct Allow {
    /// The code of the warning.
    pub code: Spanned<String>,
    /// The reason, a text; [`ValueKind::Missing`] if none was written.
    pub reason: Value,
}

/// A named number that the command line may override.
#[derive(Clone, Debug, PartialEq)]
pub struct Param {
    /// Its name.
    pub name: Spanned<String>,
    /// Its value.
    pub value: Value,
    /// `{ min 0.05 m  max 0.3 m }`, empty if there is no range.
    pub range: Block,
}

/// A robot.
#[derive(Clone, Debug, PartialEq)]
pub struct Robot {
    /// Its name.
    pub name: Spanned<String>,
    /// The base robot: `from canopies`.
    pub base: Option<Spanned<String>>,
    /// Its settings.
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
    /// Arguments in parentheses by name, after those by position.
    pub named: Vec<Entry>,
    /// Parameters; empty if no braces were written.
    pub body: Block,
    /// The whole definition.
    pub span: Span,
}

impl TaskDefinition {
    /// Creates a placeholder with an empty kind for a definition that could not be read, so that the task keeps its
    /// name.
    pub(crate) fn unread(span: Span) -> TaskDefinition {
        let kind = Spanned::new(String::new(), span);
        TaskDefinition { kind, args: Vec::new(), named: Vec::new(), body: Block { span, ..Block::default() }, span }
    }
}

equal_by!(TaskDefinition: kind, args, named, body);

/// An ordered hierarchy of levels.
#[derive(Clone, Debug, PartialEq)]
pub struct Stack {
    /// Its name.
    pub name: Spanned<String>,
    /// `(side: arm)`
    pub parameters: Vec<Parameter>,
    /// The base stack: `from autonomous`.
    pub base: Option<Call>,
    /// Settings that are not levels (`lock [torso]`).
    pub settings: Block,
    /// Levels, the most important first.
    pub levels: Vec<Level>,
    /// Changes to its base.
    pub changes: Vec<Change>,
}

/// One priority level.
#[derive(Clone, Debug)]
pub struct Level {
    /// Its name.
    pub name: Spanned<String>,
    /// Location of `hard`, if it was written. (`hard: false` in YAML is `None`.)
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

equal_by!(Level: name, hard.is_some(), settings, members);

/// A task in a level.
#[derive(Clone, Debug)]
pub struct Member {
    /// The task, by name or inline.
    pub task: MemberTask,
    /// `weight 2`.
    pub weight: Option<Value>,
    /// The whole member.
    pub span: Span,
    /// Comments before it.
    pub comments: Comments,
}

equal_by!(Member: task, weight);

/// Reference of a level to a task.
#[derive(Clone, Debug, PartialEq)]
pub enum MemberTask {
    /// The name of a declared task.
    Name(Spanned<String>),
    /// A task without a name of its own: it has arguments or a block.
    Inline(TaskDefinition),
    /// `for side in [left, right] { hold(side) }`
    For(Box<RepeatMembers>),
}

/// Demands on the limits of stacks.
#[derive(Clone, Debug, PartialEq)]
pub struct Coverage {
    /// The demands, and the stacks that they are about.
    pub body: Block,
}

/// The run of `hierarq run`.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Settings of the run.
    pub body: Block,
}
