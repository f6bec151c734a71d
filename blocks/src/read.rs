//! Reading of bound values into Rust types.
//!
//! A value that is wrong was reported, and one that is missing has a default. In both cases a value stands in, so that the
//! rest of the block can be checked: the default of the key, or else a usual value of the type.

use std::collections::BTreeSet;

use expressions::Function;

use crate::bound::{BinaryFile, Bound, BoundBlock, BoundEntry, FileWith, Located, Origin};
use crate::schema::{Key, ValueType};
use quantities::Presence;

/// A type that the value of a key can be read into.
pub trait FromBound: Sized {
    /// Reads a value of the type that the key declares.
    fn from_bound(bound: &Bound) -> Option<Self>;

    /// Returns the value of a key that is left out or wrong.
    fn stand_in(key: &Key) -> Self;

    /// Reads a value with its place.
    fn from_located(value: &Located<Bound>) -> Option<Self> {
        Self::from_bound(&value.value)
    }
}

impl BoundBlock {
    /// Reads the good value of a key, if it is written.
    pub fn read<T: FromBound>(&self, key: &str) -> Option<T> {
        self.get(key).and_then(T::from_located)
    }
}

impl FromBound for f64 {
    fn from_bound(bound: &Bound) -> Option<f64> {
        match bound {
            Bound::Number(x) => Some(*x),
            _ => None,
        }
    }

    fn stand_in(key: &Key) -> f64 {
        key.default_number().unwrap_or(1.0)
    }
}

impl FromBound for Function {
    fn from_bound(bound: &Bound) -> Option<Function> {
        match bound {
            Bound::Function(of) => Some(of.clone()),
            _ => None,
        }
    }

    fn stand_in(key: &Key) -> Function {
        Function::constant(f64::stand_in(key))
    }
}

impl FromBound for usize {
    fn from_bound(bound: &Bound) -> Option<usize> {
        // A number beyond what can be counted saturates, and is rejected as too many.
        f64::from_bound(bound).map(|x| x as usize)
    }

    fn stand_in(key: &Key) -> usize {
        f64::stand_in(key) as usize
    }
}

impl FromBound for bool {
    fn from_bound(bound: &Bound) -> Option<bool> {
        match bound {
            Bound::Flag(flag) => Some(*flag),
            _ => None,
        }
    }

    fn stand_in(key: &Key) -> bool {
        key.presence == Presence::Default("true")
    }
}

impl FromBound for [f64; 2] {
    fn from_bound(bound: &Bound) -> Option<[f64; 2]> {
        match bound {
            Bound::Range(two) | Bound::Spread(two) | Bound::Pair(two) => Some(*two),
            _ => None,
        }
    }

    fn stand_in(key: &Key) -> [f64; 2] {
        match key.value {
            ValueType::Range(_) => [1.0, 1.0],
            ValueType::Spread(_) => [1.0, 0.0],
            _ => key.default_pair().unwrap_or([0.0, 0.0]),
        }
    }
}

impl FromBound for [f64; 3] {
    fn from_bound(bound: &Bound) -> Option<[f64; 3]> {
        match bound {
            Bound::Vector(three) => Some(*three),
            _ => None,
        }
    }

    fn stand_in(_: &Key) -> [f64; 3] {
        [0.0; 3]
    }
}

impl FromBound for String {
    fn from_bound(bound: &Bound) -> Option<String> {
        match bound {
            Bound::Text(text) | Bound::File(text) => Some(text.clone()),
            _ => None,
        }
    }

    fn stand_in(_: &Key) -> String {
        String::new()
    }
}

impl FromBound for FileWith {
    fn from_bound(bound: &Bound) -> Option<FileWith> {
        match bound {
            Bound::FileWith(file) => Some(file.clone()),
            _ => None,
        }
    }

    fn stand_in(_: &Key) -> FileWith {
        FileWith { path: String::new(), text: String::new(), companion: None }
    }
}

impl FromBound for BinaryFile {
    fn from_bound(bound: &Bound) -> Option<BinaryFile> {
        match bound {
            Bound::Binary(file) => Some(file.clone()),
            _ => None,
        }
    }

    fn stand_in(_: &Key) -> BinaryFile {
        BinaryFile { path: String::new(), command: String::new(), bytes: None }
    }
}

/// One of the words of a key.
pub type Word = &'static str;

impl FromBound for Word {
    fn from_bound(bound: &Bound) -> Option<Word> {
        match bound {
            Bound::Word(word) => Some(word),
            _ => None,
        }
    }

    fn stand_in(key: &Key) -> Word {
        match (key.presence, key.value) {
            (Presence::Default(word), _) => word,
            (_, ValueType::Choice(words) | ValueType::NumberOr(_, words)) => words.first().copied().unwrap_or_default(),
            _ => "",
        }
    }
}

/// A number for all, or one for each.
#[derive(Clone, Debug, PartialEq)]
pub enum OneOrEach {
    /// One for all.
    One(f64),
    /// One for each.
    Each(Vec<f64>),
}

impl OneOrEach {
    /// Returns the numbers.
    pub fn numbers(&self) -> &[f64] {
        match self {
            OneOrEach::One(x) => std::slice::from_ref(x),
            OneOrEach::Each(all) => all,
        }
    }
}

impl FromBound for OneOrEach {
    fn from_bound(bound: &Bound) -> Option<OneOrEach> {
        match bound {
            Bound::One(x) => Some(OneOrEach::One(*x)),
            Bound::Several(all) => Some(OneOrEach::Each(all.clone())),
            _ => None,
        }
    }

    fn stand_in(key: &Key) -> OneOrEach {
        OneOrEach::One(f64::stand_in(key))
    }
}

/// A number, or one of the words of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NumberOrWord {
    /// A number.
    Number(f64),
    /// A word.
    Word(Word),
}

impl FromBound for NumberOrWord {
    fn from_bound(bound: &Bound) -> Option<NumberOrWord> {
        match bound {
            Bound::Number(x) => Some(NumberOrWord::Number(*x)),
            Bound::Word(word) => Some(NumberOrWord::Word(word)),
            _ => None,
        }
    }

    fn stand_in(key: &Key) -> NumberOrWord {
        match key.default_number() {
            Some(x) => NumberOrWord::Number(x),
            None => NumberOrWord::Word(Word::stand_in(key)),
        }
    }
}

/// Index of a member of the mission.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemberIndex(pub usize);

impl FromBound for MemberIndex {
    fn from_bound(bound: &Bound) -> Option<MemberIndex> {
        match bound {
            Bound::Member(index) => Some(MemberIndex(*index)),
            _ => None,
        }
    }

    fn stand_in(_: &Key) -> MemberIndex {
        MemberIndex(0)
    }
}

/// A value that is bound elsewhere; present.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unbound;

impl FromBound for Unbound {
    fn from_bound(_: &Bound) -> Option<Unbound> {
        Some(Unbound)
    }

    fn stand_in(_: &Key) -> Unbound {
        Unbound
    }
}

impl<T: FromBound> FromBound for Option<T> {
    fn from_bound(bound: &Bound) -> Option<Option<T>> {
        T::from_bound(bound).map(Some)
    }

    fn stand_in(_: &Key) -> Option<T> {
        None
    }

    fn from_located(value: &Located<Bound>) -> Option<Option<T>> {
        T::from_located(value).map(Some)
    }
}

impl<T: FromBound> FromBound for Located<T> {
    fn from_bound(bound: &Bound) -> Option<Located<T>> {
        T::from_bound(bound).map(|value| Located { at: Origin::default(), value })
    }

    fn stand_in(key: &Key) -> Located<T> {
        Located { at: Origin::default(), value: T::stand_in(key) }
    }

    fn from_located(value: &Located<Bound>) -> Option<Located<T>> {
        T::from_located(value).map(|read| Located { at: value.at, value: read })
    }
}

impl<T: FromBound> FromBound for Vec<T> {
    fn from_bound(bound: &Bound) -> Option<Vec<T>> {
        match bound {
            Bound::List(items) => items.iter().map(T::from_located).collect(),
            _ => None,
        }
    }

    fn stand_in(_: &Key) -> Vec<T> {
        Vec::new()
    }
}

impl<T: FromBound + Ord> FromBound for BTreeSet<T> {
    fn from_bound(bound: &Bound) -> Option<BTreeSet<T>> {
        Vec::from_bound(bound).map(|items| items.into_iter().collect())
    }

    fn stand_in(_: &Key) -> BTreeSet<T> {
        BTreeSet::new()
    }
}

/// A value by name.
#[derive(Clone, Debug)]
pub struct ByName<T> {
    /// The name.
    pub name: Located<String>,
    /// Index of the member of this name, if the names are those of members.
    pub member: usize,
    /// The value.
    pub value: Located<T>,
}

impl<T: FromBound> FromBound for Vec<ByName<T>> {
    fn from_bound(bound: &Bound) -> Option<Vec<ByName<T>>> {
        let Bound::Each(entries) = bound else { return None };
        let one = |e: &BoundEntry| {
            let value = Located { at: e.value.at, value: T::from_located(&e.value)? };
            Some(ByName { name: e.name.clone(), member: e.member.unwrap_or_default(), value })
        };
        entries.iter().map(one).collect()
    }

    fn stand_in(_: &Key) -> Vec<ByName<T>> {
        Vec::new()
    }
}
