//! The spanned tree that both spellings build: declarations exactly as written.
//!
//! A `*.hq` file and a `*.yaml` file that say the same thing give trees that compare equal: equality looks at
//! what was said, not at spans, comments, the text of a number or the braces around a tagged value. Nothing here
//! knows what a task, a frame or a unit means; the compiler does.

mod comments;
mod machines;
mod reuse;
mod scenarios;

use crate::span::{Span, Spanned};

pub use comments::Comments;
pub use machines::{
    Action, Human, Machine, Moment, SafetyField, Signal, State, StateBody, Transition, Trigger, Variable,
};
pub use reuse::{
    Beside, Call, Change, Import, ImportName, Let, Parameter, Removal, Repeat, RepeatItems, RepeatMembers, Values,
};
pub use scenarios::{Expect, Formula, FormulaKind, Scenario, Window};

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

/// `{ key value .. }`.
#[derive(Clone, Debug, Default)]
pub struct Block {
    /// Entries in the order written. A key may occur twice here; the readers report it.
    pub entries: Vec<Entry>,
    /// With the braces.
    pub span: Span,
    /// Written as `tag { .. }` instead of `{ tag { .. } }`: a matter of spelling only.
    pub tagged: bool,
    /// Comments before the closing brace.
    pub closing_comments: Comments,
}

impl PartialEq for Block {
    fn eq(&self, other: &Self) -> bool {
        self.entries == other.entries
    }
}

impl Block {
    /// The value of the first entry with this key.
    pub fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|e| e.key.value == key)
    }
}

/// `key value`.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The key.
    pub key: Spanned<String>,
    /// The value; [`ValueKind::Missing`] where none was written.
    pub value: Value,
    /// Comments before the key, and behind the value on its line.
    pub comments: Comments,
}

impl PartialEq for Entry {
    fn eq(&self, other: &Self) -> bool {
        self.key == other.key && self.value == other.value
    }
}

/// An expression or a structured value.
#[derive(Clone, Debug)]
pub struct Value {
    /// What it is.
    pub kind: ValueKind,
    /// Where it was written.
    pub span: Span,
}

impl PartialEq for Value {
    fn eq(&self, other: &Self) -> bool {
        self.kind == other.kind
    }
}

/// The kinds of value.
#[derive(Clone, Debug, PartialEq)]
pub enum ValueKind {
    /// `0.15`
    Number(Number),
    /// A value with a unit behind it: `0.15 m`, `[1, 2] rad`, `(a + b) m/s`.
    Unit(Box<Value>, Unit),
    /// `"robots/canopies.urdf"`
    Text(String),
    /// `left_tool`, `pi`, `t`, `true`, `${side}_tool`
    Name(String),
    /// `initial(x)`, `sin(x)`, `hold(left)`
    Call(Spanned<String>, Vec<Value>),
    /// `speed: 0.2 m/s`, which stands among the arguments of a call alone.
    Named(Spanned<String>, Box<Value>),
    /// `frame(left_tool).position`, `left.position`
    Field(Box<Value>, Spanned<String>),
    /// `[1, 2, 3]`
    List(Vec<Value>),
    /// `{ key value }`
    Block(Block),
    /// `v in left_tool`: expressed in the axes of a frame.
    In(Box<Value>, Spanned<String>),
    /// `-x`
    Negate(Box<Value>),
    /// `not x`
    Not(Box<Value>),
    /// `a + b`
    Binary(Spanned<BinaryOp>, Box<Value>, Box<Value>),
    /// Nothing readable stands here; a diagnostic has said so.
    Missing,
}

/// A number and how it was written.
#[derive(Clone, Debug)]
pub struct Number {
    /// Its value; finite.
    pub value: f64,
    /// Its text.
    pub text: String,
}

impl PartialEq for Number {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

/// Binary operators, in rising precedence: `or`, `and`, comparisons, sums, products, powers (right-associative, above
/// unary minus). `not` holds between `and` and the comparisons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BinaryOp {
    /// `or`
    Or,
    /// `and`
    And,
    /// `<`
    Less,
    /// `<=`
    LessEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterEqual,
    /// `+`
    Add,
    /// `-`
    Sub,
    /// `*`
    Mul,
    /// `/`
    Div,
    /// `^`
    Pow,
}

impl BinaryOp {
    /// As it is written.
    pub fn text(self) -> &'static str {
        match self {
            BinaryOp::Or => "or",
            BinaryOp::And => "and",
            BinaryOp::Less => "<",
            BinaryOp::LessEqual => "<=",
            BinaryOp::Greater => ">",
            BinaryOp::GreaterEqual => ">=",
            BinaryOp::Add => "+",
            BinaryOp::Sub => "-",
            BinaryOp::Mul => "*",
            BinaryOp::Div => "/",
            BinaryOp::Pow => "^",
        }
    }

    /// True for `<`, `<=`, `>` and `>=`.
    pub fn compares(self) -> bool {
        matches!(self, BinaryOp::Less | BinaryOp::LessEqual | BinaryOp::Greater | BinaryOp::GreaterEqual)
    }

    /// True for `and` and `or`, which are words and stand inside brackets only.
    pub fn is_word(self) -> bool {
        matches!(self, BinaryOp::And | BinaryOp::Or)
    }
}

/// A product of powers of unit symbols: `N s/m` is `N^1 s^1 m^-1`. The symbols are those of
/// [`crate::vocabulary::UNITS`], or unknown where only a unit can stand.
#[derive(Clone, Debug)]
pub struct Unit {
    /// Symbols with their exponents, in the order written.
    pub factors: Vec<(String, i32)>,
    /// Where it was written.
    pub span: Span,
}

impl PartialEq for Unit {
    fn eq(&self, other: &Self) -> bool {
        self.factors == other.factors
    }
}
