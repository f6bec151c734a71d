//! Reuse of declarations: imports, named expressions, parameters of declarations, repetition, and stacks and robots
//! that are derived from others.

use super::{Comments, Entry, Item, Level, Member, Value};
use crate::span::{Span, Spanned};

/// `import "common/safety.hq" { deck, canopies as robot }`
#[derive(Clone, Debug, PartialEq)]
pub struct Import {
    /// The file, as written: relative to the file that imports it.
    pub path: Spanned<String>,
    /// Imported names, in the order written.
    pub names: Vec<ImportName>,
    /// Comments before the closing brace.
    pub closing_comments: Comments,
}

/// `deck`, or `deck as table`.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportName {
    /// Name of the declaration in the imported file.
    pub name: Spanned<String>,
    /// Name in this file, if it differs.
    pub alias: Option<Spanned<String>>,
    /// Comments before and after it.
    pub comments: Comments,
}

impl ImportName {
    /// Returns the name in the importing file.
    pub fn visible(&self) -> &Spanned<String> {
        self.alias.as_ref().unwrap_or(&self.name)
    }
}

/// `let half_turn = pi * 1 rad`: a named expression.
#[derive(Clone, Debug, PartialEq)]
pub struct Let {
    /// Its name.
    pub name: Spanned<String>,
    /// Its value; it may vary in time.
    pub value: Value,
}

/// `gain: rate = 5 /s`: a parameter of a task or stack.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Its name.
    pub name: Spanned<String>,
    /// Type of its arguments.
    pub ty: Spanned<String>,
    /// Default value.
    pub default: Option<Value>,
    /// The whole parameter.
    pub span: Span,
}

equal_by!(Parameter: name, ty, default);

/// `guarded(left, gain: 2 /s)`: a use of a declaration, with arguments.
#[derive(Clone, Debug)]
pub struct Call {
    /// The name of the declaration.
    pub name: Spanned<String>,
    /// Arguments by position.
    pub args: Vec<Value>,
    /// Arguments by name, after those by position.
    pub named: Vec<Entry>,
    /// The whole call.
    pub span: Span,
}

equal_by!(Call: name, args, named);

/// A change that a stack makes to its base stack.
#[derive(Clone, Debug, PartialEq)]
pub enum Change {
    /// `replace motion { .. }`: replaces the level with this name, at the same position.
    Replace(Level),
    /// `add extra { .. } before posture`: adds a level; at the end if no position is given.
    Add(Level, Option<Beside>),
    /// `remove posture`
    Remove(Removal),
}

/// `before posture`, `after limits`.
#[derive(Clone, Debug, PartialEq)]
pub struct Beside {
    /// True for a position before the level, false for one after it.
    pub before: bool,
    /// The level.
    pub level: Spanned<String>,
}

/// `remove posture`
#[derive(Clone, Debug)]
pub struct Removal {
    /// The level.
    pub level: Spanned<String>,
    /// The whole change.
    pub span: Span,
    /// Comments before and after it.
    pub comments: Comments,
}

equal_by!(Removal: level);

/// `for side in [left, right] { .. }`
#[derive(Clone, Debug, PartialEq)]
pub struct Repeat<T> {
    /// Variable that takes each value in turn; `${side}` in names and texts.
    pub variable: Spanned<String>,
    /// The values.
    pub values: Values,
    /// Repeated declarations or members.
    pub body: Vec<T>,
    /// Comments before the closing brace.
    pub closing_comments: Comments,
}

/// Repeated declarations.
pub type RepeatItems = Repeat<Item>;
/// Repeated members of a level.
pub type RepeatMembers = Repeat<Member>;

/// Values of the variable of a repetition.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// `[left, right]`
    List(Value),
    /// `1..4`: integers, including both ends.
    Range(Value, Value),
}

impl Values {
    /// Returns the location of the values.
    pub fn span(&self) -> Span {
        match self {
            Values::List(list) => list.span,
            Values::Range(first, last) => first.span.to(last.span),
        }
    }
}
