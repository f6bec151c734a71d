//! Schema of a block: its keys with their types, units, ranges, defaults and texts.
//!
//! Refusals of unknown keys, the JSON schema, the editor and the page of keys derive from it.

use crate::snippet::Snippet;
use quantities::dimension::Dimension;
use quantities::{Presence, Quantity};

/// A block of the language with keys of its own.
#[derive(Debug)]
pub struct BlockSchema {
    /// Name of the block in messages, with its article: `a robot`.
    pub name: &'static str,
    /// Its keys, in the order in which they are offered.
    pub keys: &'static [Key],
}

/// A key of a block.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// As it is written.
    pub name: &'static str,
    /// Description of the key in Markdown. Unit, range and default are in the other fields.
    pub doc: &'static str,
    /// Type of its value.
    pub value: ValueType,
    /// Treatment of a block without this key.
    pub presence: Presence,
    /// True if its value is bound with its block; false if it is read from the tree, by what gives it a meaning.
    pub is_bound: bool,
    /// The key with a value, for messages; empty for the usual one of its type.
    pub example: &'static str,
    /// Syntaxes in which it is a key.
    pub place: Place,
}

/// Syntaxes in which a key exists.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// An entry of the block, the same in both syntaxes; the compiler reads it.
    Entry,
    /// A word of both syntaxes that their readers take.
    Word,
    /// A word of the native syntax alone.
    Hq,
    /// A key of YAML alone, in the place of words of the native syntax.
    Yaml,
}

/// Type of the value of a key.
#[derive(Clone, Copy, Debug)]
pub enum ValueType {
    /// A constant number.
    Number(Quantity),
    /// A constant whole number.
    Count(Quantity),
    /// A constant number, or one of these words.
    NumberOr(Quantity, &'static [&'static str]),
    /// One constant number, or a list of them.
    Numbers(Quantity),
    /// Three constant numbers, each of this unit and range.
    Vector(Quantity),
    /// A position of a mission (m), or the name of a place.
    Spot,
    /// A number that may depend on these arguments.
    Function(&'static FunctionType),
    /// Two constant numbers: a point of the ground.
    Pair(Dimension),
    /// One constant number, or the least and the greatest of a range.
    Range(Quantity),
    /// A constant number, or the mean and the standard deviation of a normal distribution.
    Spread(Quantity),
    /// A position of a joint in rad or m, or with `speed` its speed in rad/s or m/s.
    OfJoint {
        /// A speed, not a position.
        speed: bool,
    },
    /// A number of the unit that the value beside it has.
    Bound,
    /// A number, a vector, an orientation.
    Value,
    /// Humans, points of them, other positions.
    People,
    /// A constant value of a signal: a number, a vector, an orientation, or the parts of a wrench.
    Sent,
    /// Values of a repetition: a list, or a range of whole numbers.
    Values,
    /// A text.
    Text,
    /// The path of a text file, which the compiler reads.
    File,
    /// The path of a text file that names another file; the compiler reads both.
    FileWith(&'static Companion),
    /// The path of a file of bytes, which the compiler reads.
    Binary(&'static BinaryFormat),
    /// The path of a URDF.
    Urdf,
    /// The path of an SRDF.
    Srdf,
    /// The path of a spec.
    Spec,
    /// True or false.
    Flag,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// One of these words, one that is called, or an expression.
    WordOr(&'static [&'static str]),
    /// A name that is given here.
    NewName,
    /// The name of something declared.
    Name(Named),
    /// A link.
    Link,
    /// Points, segments, links, groups of them.
    Geometries,
    /// Links, arms for all of theirs, points, segments and groups for those that carry them.
    Links,
    /// Joints, groups of them, patterns.
    Joints,
    /// The same, or a position for each.
    Locks,
    /// Positions by joint, group or pattern.
    Positions,
    /// A block.
    Block(&'static BlockSchema),
    /// A block, or a list of blocks.
    Blocks(&'static BlockSchema),
    /// A link, or a block.
    LinkOr(&'static BlockSchema),
    /// Names that the user chooses, each with one of these.
    Each(&'static ValueType),
    /// Names of declared things, each with one of these.
    Of(Named, &'static ValueType),
    /// Joints, groups or patterns, each with one of these.
    PerJoint(&'static ValueType),
    /// A list of these; the readers take it.
    List(&'static ValueType),
    /// Tasks: names, or tasks in place.
    Tasks,
    /// A declaration, or several; the readers take them.
    Declarations,
}

/// Type of a function: an expression in which certain names are its arguments.
#[derive(Debug)]
pub struct FunctionType {
    /// Its arguments. Their numbers are counted through.
    pub arguments: &'static [Argument],
    /// Unit and range of its value; the range is that of a value that is constant.
    pub result: Quantity,
}

/// An argument of a function.
#[derive(Debug)]
pub struct Argument {
    /// Its name.
    pub name: &'static str,
    /// Three numbers; else one.
    pub is_vector: bool,
    /// Its unit.
    pub dimension: Dimension,
    /// Description in Markdown, without the unit.
    pub doc: &'static str,
}

impl FunctionType {
    /// Returns the names of its arguments.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + Clone + use<> {
        self.arguments.iter().map(|argument| argument.name)
    }
}

/// A file that a text file names, such as the image of a map.
#[derive(Debug)]
pub struct Companion {
    /// Code of the error if one of the two cannot be read.
    pub code: &'static str,
    /// Returns the path of it, relative to the folder of the text file.
    pub path: fn(&str) -> Option<String>,
    /// Its maximum size, in bytes.
    pub most: u64,
    /// A way out if it is larger.
    pub if_larger: &'static str,
    /// A way out if the text file is no text.
    pub if_no_text: &'static str,
}

/// A format of files of bytes.
#[derive(Debug)]
pub struct BinaryFormat {
    /// Code of the error if a file cannot be read.
    pub code: &'static str,
    /// The maximum size, in bytes.
    pub most: u64,
    /// A way out if a file is larger.
    pub if_larger: &'static str,
    /// The command that makes a file, with `{spec}` and `{mission}` for the ones that name it, and `{file}` for its path.
    pub command: &'static str,
}

/// Kind of the entity that a name refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Named {
    /// A robot.
    Robot,
    /// A task.
    Task,
    /// A stack.
    Stack,
    /// A level of the stack that this one is made from.
    Level,
    /// A machine.
    Machine,
    /// A state of the machine or state around.
    State,
    /// A state of a machine, by its path.
    StatePath,
    /// A mission.
    Mission,
    /// A member of the mission that a scenario executes.
    Member,
    /// A member of the mission that the key is a part of.
    Own(&'static Members),
    /// A person of the mission that a scenario executes.
    Person,
    /// A signal or a variable.
    Signal,
    /// A signal that is true or false.
    Flag,
    /// An event.
    Event,
    /// A human.
    Human,
    /// An obstacle.
    Obstacle,
    /// A point of the human that the block is of.
    Point,
    /// A signal of this type of the spec that is named beside it.
    SignalThere(&'static str),
    /// A human of the spec that is named beside it.
    HumanThere,
    /// A state of the spec that is named beside it.
    StateThere,
}

/// Members of a mission with certain roles, numbered through: those of the first role in the order written, then those of
/// the next.
#[derive(Debug, PartialEq, Eq)]
pub struct Members {
    /// Noun for one of them: `robot`, `agent`.
    pub noun: &'static str,
    /// Roles: words that declare members.
    pub roles: &'static [&'static str],
}

impl Key {
    const fn new(name: &'static str, value: ValueType, presence: Presence, doc: &'static str) -> Key {
        Key { name, doc, value, presence, place: Place::Entry, is_bound: true, example: "" }
    }

    /// Creates a key that must be written.
    pub const fn required(name: &'static str, value: ValueType, doc: &'static str) -> Key {
        Key::new(name, value, Presence::Required, doc)
    }

    /// Creates a key that may be left out.
    pub const fn optional(name: &'static str, value: ValueType, doc: &'static str) -> Key {
        Key::new(name, value, Presence::Optional, doc)
    }

    /// Creates a key for which a text of the language stands in.
    pub const fn or(name: &'static str, value: ValueType, default: &'static str, doc: &'static str) -> Key {
        Key::new(name, value, Presence::Default(default), doc)
    }

    /// The same key at a place of the language.
    pub const fn at(self, place: Place) -> Key {
        Key { place, ..self }
    }

    /// The same key with another example: its value, or one entry of a block of entries.
    pub const fn example(self, example: &'static str) -> Key {
        Key { example, ..self }
    }

    /// The same key, whose value is not bound with its block.
    pub const fn elsewhere(self) -> Key {
        Key { is_bound: false, ..self }
    }

    /// Returns true for a key of the native syntax.
    pub fn is_native(&self) -> bool {
        self.place != Place::Yaml
    }

    /// Returns true for a key of YAML.
    pub fn is_yaml(&self) -> bool {
        self.place != Place::Hq
    }

    /// Returns true for an entry of the block, which the compiler reads.
    pub fn is_entry(&self) -> bool {
        self.place == Place::Entry
    }

    /// Returns the number of the default, which is written in SI.
    pub fn default_number(&self) -> Option<f64> {
        match self.presence {
            Presence::Default(text) => text.split(' ').next()?.parse().ok(),
            Presence::Required | Presence::Optional => None,
        }
    }

    /// Returns the two numbers of the default, which are written in SI: `[0.5, 0.5] m`.
    pub fn default_pair(&self) -> Option<[f64; 2]> {
        let Presence::Default(text) = self.presence else { return None };
        let (one, other) = text.strip_prefix('[')?.split(']').next()?.split_once(',')?;
        Some([one.trim().parse().ok()?, other.trim().parse().ok()?])
    }

    /// Returns the key with a value that fits.
    pub fn written(&self) -> Snippet {
        if let ValueType::Each(_) = self.value {
            let (name, value) = self.example.split_once(' ').unwrap_or(("NAME", ".."));
            return Snippet::block(self.name, [Snippet::entry(name, value)]);
        }
        let value = match self.value {
            _ if !self.example.is_empty() => self.example,
            ValueType::Range(_) => "[0.05, 0.2] m/s",
            ValueType::Spread(_) => "normal(204 s, 20 s)",
            ValueType::Spot | ValueType::Vector(_) => "[0.4, 0, 0.1] m",
            ValueType::Pair(_) => "[4, -1.5] m",
            ValueType::Text | ValueType::File | ValueType::Binary(_) | ValueType::Spec => "\"..\"",
            ValueType::Choice(words) => words.first().copied().unwrap_or_default(),
            _ => "..",
        };
        Snippet::entry(self.name, value)
    }
}

impl BlockSchema {
    /// Returns the entry of this name.
    pub fn entry(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.is_entry() && key.name == name)
    }

    /// Returns the names of the entries, which the compiler reads.
    pub fn entries(&self) -> impl Iterator<Item = &'static str> + Clone + use<> {
        self.keys.iter().filter(|key| key.is_entry()).map(|key| key.name)
    }

    /// Returns the members that the block may have: the words of the native syntax that declare them, with their blocks.
    pub fn roles(&self) -> impl Iterator<Item = Role> + use<> {
        self.keys.iter().filter(|key| key.place == Place::Hq).filter_map(|key| match key.value {
            ValueType::Block(schema) => Some(Role { name: key.name, schema }),
            _ => None,
        })
    }

    /// Returns the blocks that its keys hold.
    pub fn inner(&self) -> impl Iterator<Item = &'static BlockSchema> + use<> {
        self.keys.iter().filter_map(|key| key.value.block())
    }
}

/// A role of members.
#[derive(Clone, Copy, Debug)]
pub struct Role {
    /// Word that declares a member.
    pub name: &'static str,
    /// Block of such a member.
    pub schema: &'static BlockSchema,
}

impl ValueType {
    /// Returns the block that stands inside a value.
    pub fn block(&self) -> Option<&'static BlockSchema> {
        match self {
            ValueType::Block(schema) | ValueType::Blocks(schema) | ValueType::LinkOr(schema) => Some(schema),
            ValueType::Each(inner) | ValueType::PerJoint(inner) | ValueType::Of(_, inner) | ValueType::List(inner) => {
                inner.block()
            }
            _ => None,
        }
    }
}
