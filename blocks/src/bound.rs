//! A block after binding: values in SI, names resolved, each with the place of its text. The compiler binds any block by
//! its schema; the structs of [`block!`](crate::block!) are read from the result.

use std::collections::BTreeSet;
use std::sync::Arc;

use expressions::Function;

use crate::schema::BlockSchema;

/// Place of a text in a spec: a number that the compiler gives, and that it alone can look up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Origin(pub u32);

/// A value with the place of its text.
#[derive(Clone, Debug)]
pub struct Located<T> {
    /// The place.
    pub at: Origin,
    /// The value.
    pub value: T,
}

/// A bound block.
#[derive(Clone, Debug)]
pub struct BoundBlock {
    /// Its keys.
    pub schema: &'static BlockSchema,
    /// Place at which the block is named, for keys that are left out.
    pub at: Origin,
    /// Keys that are written.
    keys: Vec<BoundKey>,
    /// Keys with a mistake, which was reported: a wrong value, a misspelt name, or a required key that is missing.
    wrong: BTreeSet<&'static str>,
}

/// A key that is written.
#[derive(Clone, Debug)]
struct BoundKey {
    key: &'static str,
    /// Place of the key.
    at: Origin,
    /// Value, unless nothing of it is good.
    value: Option<Located<Bound>>,
}

/// A bound value.
#[derive(Clone, Debug)]
pub enum Bound {
    /// A number; a whole one if the schema says so.
    Number(f64),
    /// A number that may depend on arguments.
    Function(Function),
    /// One number for all.
    One(f64),
    /// A number for each.
    Several(Vec<f64>),
    /// The least and the greatest.
    Range([f64; 2]),
    /// Mean and standard deviation.
    Spread([f64; 2]),
    /// Two numbers.
    Pair([f64; 2]),
    /// Three numbers.
    Vector([f64; 3]),
    /// A text, or a name that stands in another spec.
    Text(String),
    /// One of the words of the schema.
    Word(&'static str),
    /// True or false.
    Flag(bool),
    /// Index of a member.
    Member(usize),
    /// Content of a file.
    File(String),
    /// A text file with the file that it names.
    FileWith(FileWith),
    /// A file of bytes.
    Binary(BinaryFile),
    /// A list.
    List(Vec<Located<Bound>>),
    /// Values by name.
    Each(Vec<BoundEntry>),
    /// A block.
    Block(BoundBlock),
    /// An expression that is bound elsewhere.
    Unbound,
}

/// A text file with the file that it names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileWith {
    /// Path of the text file, as it is written.
    pub path: String,
    /// Its text.
    pub text: String,
    /// Content of the other file; none: the text names none.
    pub companion: Option<Arc<[u8]>>,
}

/// A file of bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BinaryFile {
    /// Path, as it is written.
    pub path: String,
    /// The command that makes it.
    pub command: String,
    /// Content; none: whoever compiles the spec needs none, since it is about to make such files.
    pub bytes: Option<Arc<[u8]>>,
}

/// A value by name.
#[derive(Clone, Debug)]
pub struct BoundEntry {
    /// The name.
    pub name: Located<String>,
    /// Index of the member of this name, if the names are those of members.
    pub member: Option<usize>,
    /// The value.
    pub value: Located<Bound>,
}

impl BoundBlock {
    /// Creates a block without entries that is named at a place.
    pub fn new(schema: &'static BlockSchema, at: Origin) -> BoundBlock {
        BoundBlock { schema, at, keys: Vec::new(), wrong: BTreeSet::new() }
    }

    /// Adds a key that is written at a place. Without a value it is wrong.
    pub fn put(&mut self, key: &'static str, at: Origin, value: Option<Located<Bound>>) {
        if value.is_none() {
            self.mark_wrong(key);
        }
        self.keys.push(BoundKey { key, at, value });
    }

    /// Marks a key in which a mistake was reported.
    pub fn mark_wrong(&mut self, key: &'static str) {
        self.wrong.insert(key);
    }

    /// Returns the good value of a key, if it is written.
    pub fn get(&self, key: &str) -> Option<&Located<Bound>> {
        self.keys.iter().find(|of| of.key == key)?.value.as_ref()
    }

    /// Returns the place of a key itself, if it is written.
    pub fn key_origin(&self, key: &str) -> Option<Origin> {
        self.keys.iter().find(|of| of.key == key).map(|of| of.at)
    }

    /// Returns the place of a key's value, if it is written and good.
    pub fn origin(&self, key: &str) -> Option<Origin> {
        self.get(key).map(|value| value.at)
    }

    /// Returns true if a mistake was reported in a key.
    pub fn is_wrong(&self, key: &str) -> bool {
        self.wrong.contains(key)
    }

    /// Returns true if a mistake was reported in some key.
    pub fn has_wrong(&self) -> bool {
        !self.wrong.is_empty()
    }

    /// Returns the items of a list, or nothing.
    pub fn items(&self, key: &str) -> &[Located<Bound>] {
        match self.get(key).map(|value| &value.value) {
            Some(Bound::List(items)) => items,
            _ => &[],
        }
    }

    /// Returns the values by name behind a key, or nothing.
    pub fn each(&self, key: &str) -> &[BoundEntry] {
        match self.get(key).map(|value| &value.value) {
            Some(Bound::Each(entries)) => entries,
            _ => &[],
        }
    }

    /// Returns the block behind a key.
    pub fn block(&self, key: &str) -> Option<&BoundBlock> {
        match &self.get(key)?.value {
            Bound::Block(block) => Some(block),
            _ => None,
        }
    }
}
