//! Values: expressions as they were written, and the blocks of keys that hold them.

use super::Comments;
use crate::span::{Span, Spanned};

/// `{ key value .. }`.
#[derive(Clone, Debug, Default)]
pub struct Block {
    /// Entries in the order written. A key may occur twice here; the readers report it.
    pub entries: Vec<Entry>,
    /// With the braces.
    pub span: Span,
    /// Written as `tag { .. }` instead of `{ tag { .. } }`: a matter of spelling only.
    pub tagged: bool,
    /// Comments before the closing brace, and behind the block where it is an item of a list.
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
