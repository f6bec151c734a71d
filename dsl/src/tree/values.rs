//! Values: expressions as written, and the blocks of keys that contain them.

use super::Comments;
use crate::span::{Span, Spanned};

/// `{ key value .. }`.
#[derive(Clone, Debug, Default)]
pub struct Block {
    /// Entries in the order written. A key may occur twice here; the readers report it.
    pub entries: Vec<Entry>,
    /// Span including the braces.
    pub span: Span,
    /// True if written as `tag { .. }` instead of `{ tag { .. } }`; the two are equivalent.
    pub tagged: bool,
    /// Comments before the closing brace, and after the block if it is an item of a list.
    pub closing_comments: Comments,
}

equal_by!(Block: entries);

impl Block {
    /// Returns the first entry with this key.
    pub fn get(&self, key: &str) -> Option<&Entry> {
        self.entries.iter().find(|e| e.key.value == key)
    }
}

/// `key value`.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The key.
    pub key: Spanned<String>,
    /// The value; [`ValueKind::Missing`] if none was written.
    pub value: Value,
    /// Comments before the key, and after the value on its line.
    pub comments: Comments,
}

/// An expression or a structured value.
#[derive(Clone, Debug)]
pub struct Value {
    /// Content.
    pub kind: ValueKind,
    /// Location.
    pub span: Span,
}

equal_by!(Value: kind);

impl Value {
    /// Returns the name or text of a value that is one.
    pub fn word(&self) -> Option<&str> {
        match &self.kind {
            ValueKind::Name(word) | ValueKind::Text(word) => Some(word),
            _ => None,
        }
    }

    /// Returns the items of a list, or the value itself.
    pub fn items(&self) -> &[Value] {
        match &self.kind {
            ValueKind::List(items) => items,
            _ => std::slice::from_ref(self),
        }
    }

    /// Returns the block of a value that is one.
    pub fn block(&self) -> Option<&Block> {
        match &self.kind {
            ValueKind::Block(block) => Some(block),
            _ => None,
        }
    }

    /// Returns the entries of a block, none for other values.
    pub fn entries(&self) -> &[Entry] {
        self.block().map_or(&[], |block| &block.entries)
    }

    /// Returns the direct parts of a value.
    pub fn parts(&self) -> Vec<&Value> {
        match &self.kind {
            ValueKind::Unit(of, _)
            | ValueKind::Field(of, _)
            | ValueKind::In(of, _)
            | ValueKind::Named(_, of)
            | ValueKind::Negate(of)
            | ValueKind::Not(of) => vec![of],
            ValueKind::Call(_, all) | ValueKind::List(all) => all.iter().collect(),
            ValueKind::Binary(_, left, right) => vec![left, right],
            ValueKind::Block(block) => block.entries.iter().map(|e| &e.value).collect(),
            ValueKind::Number(_) | ValueKind::Text(_) | ValueKind::Name(_) | ValueKind::Missing => Vec::new(),
        }
    }
}

/// The kinds of value.
#[derive(Clone, Debug, PartialEq)]
pub enum ValueKind {
    /// `0.15`
    Number(Number),
    /// A value with a unit: `0.15 m`, `[1, 2] rad`, `(a + b) m/s`.
    Unit(Box<Value>, Unit),
    /// `"robots/canopies.urdf"`
    Text(String),
    /// `left_tool`, `pi`, `t`, `true`, `${side}_tool`
    Name(String),
    /// `initial(x)`, `sin(x)`, `hold(left)`
    Call(Spanned<String>, Vec<Value>),
    /// `speed: 0.2 m/s`, allowed only among the arguments of a call.
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
    /// No readable value; a diagnostic has reported it.
    Missing,
}

/// A number with its text in the source.
#[derive(Clone, Debug)]
pub struct Number {
    /// Its value; finite.
    pub value: f64,
    /// Its text.
    pub text: String,
}

equal_by!(Number: value);

/// Binary operators, in rising precedence: `or`, `and`, comparisons, sums, products, powers (right-associative, above
/// unary minus). The precedence of `not` is between `and` and the comparisons.
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
    /// Returns the operator as it is written.
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

    /// Returns true for `<`, `<=`, `>` and `>=`.
    pub fn compares(self) -> bool {
        matches!(self, BinaryOp::Less | BinaryOp::LessEqual | BinaryOp::Greater | BinaryOp::GreaterEqual)
    }

    /// Returns true for `and` and `or`, which are words and allowed only inside brackets.
    pub fn is_word(self) -> bool {
        matches!(self, BinaryOp::And | BinaryOp::Or)
    }
}

/// A product of powers of unit symbols: `N s/m` is `N^1 s^1 m^-1`. The symbols are those of
/// [`crate::vocabulary::UNITS`], or unknown ones if only a unit is allowed there.
#[derive(Clone, Debug)]
pub struct Unit {
    /// Symbols with their exponents, in the order written.
    pub factors: Vec<(String, i32)>,
    /// Location.
    pub span: Span,
}

equal_by!(Unit: factors);

impl std::fmt::Display for Unit {
    /// The unit as it is written: `N s/m`, `/s`. A `min` next to other symbols is joined by `*`: after a space it would be the
    /// key of a limit.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut last: Option<&str> = None;
        for (symbol, power) in &self.factors {
            match last {
                _ if *power < 0 => f.write_str("/")?,
                Some(last) => f.write_str(if symbol == "min" || last == "min" { "*" } else { " " })?,
                None => {}
            }
            last = Some(symbol);
            f.write_str(symbol)?;
            if power.unsigned_abs() != 1 {
                write!(f, "^{}", power.unsigned_abs())?;
            }
        }
        Ok(())
    }
}
