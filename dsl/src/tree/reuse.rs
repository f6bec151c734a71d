//! What lets one spec use another, and one declaration many times: imports, named expressions, parameters of
//! declarations, repetition, and stacks and robots that are made from others.

use super::{Comments, Entry, Item, Level, Member, Value};
use crate::span::{Span, Spanned};

/// `import "common/safety.hq" { deck, canopies as robot }`
#[derive(Clone, Debug)]
pub struct Import {
    /// The file, as written: relative to the file that imports it.
    pub path: Spanned<String>,
    /// What is imported, in the order written.
    pub names: Vec<ImportName>,
    /// Comments before the closing brace.
    pub closing_comments: Comments,
}

impl PartialEq for Import {
    fn eq(&self, other: &Self) -> bool {
        self.path == other.path && self.names == other.names
    }
}

/// `deck`, or `deck as table`.
#[derive(Clone, Debug)]
pub struct ImportName {
    /// The name that the imported file declares.
    pub name: Spanned<String>,
    /// The name it has in this file, where that is another one.
    pub alias: Option<Spanned<String>>,
    /// Comments before it and behind it.
    pub comments: Comments,
}

impl PartialEq for ImportName {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.alias == other.alias
    }
}

impl ImportName {
    /// The name it has in the file that imports it.
    pub fn visible(&self) -> &Spanned<String> {
        self.alias.as_ref().unwrap_or(&self.name)
    }
}

/// `let half_turn = pi * 1 rad`: a named expression.
#[derive(Clone, Debug, PartialEq)]
pub struct Let {
    /// Its name.
    pub name: Spanned<String>,
    /// Its value; it may move.
    pub value: Value,
}

/// `gain: rate = 5 /s`: a parameter of a task or stack.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Its name.
    pub name: Spanned<String>,
    /// What may be given for it.
    pub ty: Spanned<String>,
    /// Its value where none is given.
    pub default: Option<Value>,
    /// The whole parameter.
    pub span: Span,
}

impl PartialEq for Parameter {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.ty == other.ty && self.default == other.default
    }
}

/// `guarded(left, gain: 2 /s)`: a declaration that is used, with arguments.
#[derive(Clone, Debug)]
pub struct Call {
    /// The name of the declaration.
    pub name: Spanned<String>,
    /// Arguments by position.
    pub args: Vec<Value>,
    /// Arguments by name, behind those by position.
    pub named: Vec<Entry>,
    /// All of it.
    pub span: Span,
}

impl PartialEq for Call {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.args == other.args && self.named == other.named
    }
}

/// What a stack changes in the one that it is made from.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// `replace motion { .. }`: another level of this name in the same place.
    Replace(Level),
    /// `add extra { .. } before posture`: one more level; the last one where no place is said.
    Add(Level, Option<Beside>),
    /// `remove posture`
    Remove(Removal),
}

/// `before posture`, `after limits`.
#[derive(Clone, Debug, PartialEq)]
pub struct Beside {
    /// Before the level, or behind it.
    pub before: bool,
    /// The level.
    pub level: Spanned<String>,
}

/// `remove posture`
#[derive(Clone, Debug)]
pub struct Removal {
    /// The level.
    pub level: Spanned<String>,
    /// All of it.
    pub span: Span,
    /// Comments before it and behind it.
    pub comments: Comments,
}

impl PartialEq for Removal {
    fn eq(&self, other: &Self) -> bool {
        self.level == other.level
    }
}

/// `for side in [left, right] { .. }`
#[derive(Clone, Debug)]
pub struct Repeat<T> {
    /// The name that takes each value in turn; `${side}` in names and texts.
    pub variable: Spanned<String>,
    /// The values.
    pub values: Values,
    /// What is repeated.
    pub body: Vec<T>,
    /// Comments before the closing brace.
    pub closing_comments: Comments,
}

impl<T: PartialEq> PartialEq for Repeat<T> {
    fn eq(&self, other: &Self) -> bool {
        self.variable == other.variable && self.values == other.values && self.body == other.body
    }
}

/// Declarations that are repeated.
pub type RepeatItems = Repeat<Item>;
/// Members of a level that are repeated.
pub type RepeatMembers = Repeat<Member>;

/// What a repetition runs over.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// `[left, right]`
    List(Value),
    /// `1..4`: whole numbers, both ends among them.
    Range(Value, Value),
}

impl Values {
    /// Where it was written.
    pub fn span(&self) -> Span {
        match self {
            Values::List(list) => list.span,
            Values::Range(first, last) => first.span.to(last.span),
        }
    }
}
