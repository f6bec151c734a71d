//! The keys of the language that no task type declares, written once: what each is called, holds and says, whether it may
//! be left out, and in which syntax it stands. The compiler's refusals of unknown keys, the schema, the language server
//! and the page of keys derive from it.
//!
//! A new block is one more [`Section`], named in [`ALL`] and by the key that holds it.

mod field;
mod happening;
mod human;
mod layers;
mod machine;
mod mission;
mod robot;
mod scenario;
mod spec;
mod stack;

use dsl::Syntax;
use stdlib_tasks::dimension::Dimension;
use stdlib_tasks::params::{Presence, Quantity};

pub use field::SAFETY_FIELD;
pub use happening::{APPROACHES, DISTANCES, HAPPENING, REPLY, WAITS};
pub use human::{HUMAN, HUMAN_POINT, HUMAN_SCRIPT};
pub use layers::{LAYER, LAYERS, LAYERS_HUMAN, LAYERS_PLACE, LAYERS_ROBOT, LAYERS_TASK, LAYERS_WEIGHTS, OBJECT};
pub use machine::{MACHINE, SIGNAL, STATE, TRANSITION, VARIABLE, WRENCH};
pub use mission::{
    ADAPTATION, APPROACH, ENERGY, MISSION, RUNS, SCHEDULE, SCHEDULE_HUMAN, SCHEDULE_ROBOT, SCHEDULE_WEIGHTS,
    SCHEDULE_WORKER,
};
pub use robot::{ARM, BASES, LIMIT, POINT, ROBOT, SEGMENT};
pub use scenario::{
    LATE, LOST, OF_ALL_SCENARIOS, OF_MISSIONS, OUTCOME, PUSH, SCENARIO, SCENARIO_SIMULATOR, SIGNAL_SCRIPT, WAYPOINT,
};
pub use spec::{PARAM, REPEAT, RUN, SIMULATOR, SPEC};
pub use stack::{CHANGE, LEVEL, MEMBER, STACK};

/// All sections, in the order of a reader who goes from the outside in.
pub static ALL: &[&Section] = &[
    &SPEC,
    &PARAM,
    &ROBOT,
    &ARM,
    &POINT,
    &SEGMENT,
    &LIMIT,
    &STACK,
    &CHANGE,
    &LEVEL,
    &MEMBER,
    &SIGNAL,
    &HUMAN,
    &SAFETY_FIELD,
    &WRENCH,
    &VARIABLE,
    &MACHINE,
    &STATE,
    &TRANSITION,
    &REPEAT,
    &RUN,
    &SIMULATOR,
    &SCENARIO,
    &SCENARIO_SIMULATOR,
    &SIGNAL_SCRIPT,
    &WAYPOINT,
    &HUMAN_SCRIPT,
    &HUMAN_POINT,
    &OUTCOME,
    &PUSH,
    &LATE,
    &LOST,
    &HAPPENING,
    &REPLY,
    &MISSION,
    &SCHEDULE,
    &SCHEDULE_WEIGHTS,
    &ADAPTATION,
    &SCHEDULE_ROBOT,
    &ENERGY,
    &SCHEDULE_HUMAN,
    &SCHEDULE_WORKER,
    &RUNS,
    &APPROACH,
    &LAYERS,
    &LAYERS_WEIGHTS,
    &LAYERS_ROBOT,
    &LAYERS_HUMAN,
    &OBJECT,
    &LAYERS_PLACE,
    &LAYER,
    &LAYERS_TASK,
];

/// A block of the language with keys of its own.
#[derive(Debug)]
pub struct Section {
    /// What a message calls it, with its article: `a robot`.
    pub name: &'static str,
    /// Its keys, in the order in which they are offered.
    pub keys: &'static [Key],
}

/// A key of a section.
#[derive(Debug)]
pub struct Key {
    /// As it is written.
    pub name: &'static str,
    /// What it is for, in Markdown. Unit, range and default stand in the other fields.
    pub doc: &'static str,
    /// What may stand behind it.
    pub holds: Holds,
    /// Whether it may be left out.
    pub presence: Presence,
    /// Where it is a key.
    pub place: Place,
}

/// Where a key is one.
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

/// What may stand behind a key.
#[derive(Debug)]
pub enum Holds {
    /// A constant number.
    Number(Quantity),
    /// A constant number, or one of these words.
    NumberOr(Quantity, &'static [&'static str]),
    /// One constant number, or a list of them.
    Numbers(Quantity),
    /// Three constant numbers.
    Vector(Dimension),
    /// A position of a mission (m), or the name of a place.
    Spot,
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
    /// What a repetition runs over: a list, or whole numbers.
    Values,
    /// A text.
    Text,
    /// The path of a URDF.
    Urdf,
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
    Block(&'static Section),
    /// A block, or several in an order.
    Blocks(&'static Section),
    /// A link, or a block.
    LinkOr(&'static Section),
    /// Names that the user chooses, each with one of these.
    Each(&'static Holds),
    /// Names of declared things, each with one of these.
    Of(Named, &'static Holds),
    /// Joints, groups or patterns, each with one of these.
    PerJoint(&'static Holds),
    /// Some of these in an order; the readers take it.
    List(&'static Holds),
    /// Tasks: names, or tasks in place.
    Tasks,
    /// A declaration, or several; the readers take them.
    Declarations,
}

/// What can be named by a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Named {
    /// A robot.
    Robot,
    /// A stack.
    Stack,
    /// A level of the stack that this one is made from.
    Level,
    /// A machine.
    Machine,
    /// A state of the machine.
    State,
    /// A mission.
    Mission,
    /// A member of the mission, or of the one that a scenario executes.
    Member,
    /// A person of the mission that a scenario executes.
    Person,
    /// A signal of the spec that is named beside it.
    SignalThere,
    /// A state of the spec that is named beside it.
    StateThere,
    /// A signal or a variable.
    Signal,
    /// An event.
    Event,
    /// A human.
    Human,
    /// A point of the human that the block is of.
    Point,
}

impl Key {
    const fn new(name: &'static str, holds: Holds, presence: Presence, doc: &'static str) -> Key {
        Key { name, doc, holds, presence, place: Place::Entry }
    }

    /// One that must be there.
    const fn required(name: &'static str, holds: Holds, doc: &'static str) -> Key {
        Key::new(name, holds, Presence::Required, doc)
    }

    /// One that may be absent.
    const fn optional(name: &'static str, holds: Holds, doc: &'static str) -> Key {
        Key::new(name, holds, Presence::Optional, doc)
    }

    /// One for which a text of the language stands in.
    const fn or(name: &'static str, holds: Holds, default: &'static str, doc: &'static str) -> Key {
        Key::new(name, holds, Presence::Default(default), doc)
    }

    const fn at(self, place: Place) -> Key {
        let Key { name, doc, holds, presence, .. } = self;
        Key { name, doc, holds, presence, place }
    }

    /// True where this is a key of a syntax.
    pub fn stands_in(&self, syntax: Syntax) -> bool {
        match self.place {
            Place::Entry | Place::Word => true,
            Place::Hq => syntax == Syntax::Native,
            Place::Yaml => syntax == Syntax::Yaml,
        }
    }
}

impl Section {
    /// The keys of a syntax.
    pub fn written(&self, syntax: Syntax) -> impl Iterator<Item = &'static Key> + use<> {
        self.keys.iter().filter(move |k| k.stands_in(syntax))
    }

    /// The key of this name in a syntax.
    pub fn key(&self, name: &str, syntax: Syntax) -> Option<&'static Key> {
        self.written(syntax).find(|k| k.name == name)
    }

    /// The names that the compiler reads as entries of the block.
    pub fn entries(&self) -> impl Iterator<Item = &'static str> + Clone + use<> {
        self.keys.iter().filter(|k| k.place == Place::Entry).map(|k| k.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_stands_once_in_each_syntax_and_says_what_it_is() {
        for section in ALL {
            for syntax in [Syntax::Native, Syntax::Yaml] {
                let mut names: Vec<&str> = section.written(syntax).map(|k| k.name).collect();
                let count = names.len();
                names.sort_unstable();
                names.dedup();
                assert_eq!(names.len(), count, "{}", section.name);
            }
            for key in section.keys {
                assert!(key.doc.len() > 5 && !key.doc.ends_with(' '), "{}: `{}`", section.name, key.name);
            }
        }
    }

    fn reaches(holds: &Holds, wanted: &Section) -> bool {
        match holds {
            Holds::Block(s) | Holds::Blocks(s) | Holds::LinkOr(s) => std::ptr::eq(*s, wanted),
            Holds::Each(h) | Holds::Of(_, h) | Holds::PerJoint(h) | Holds::List(h) => reaches(h, wanted),
            _ => false,
        }
    }

    #[test]
    fn a_section_that_a_key_holds_is_one_of_all() {
        let held = |s: &Section| ALL.iter().any(|o| o.keys.iter().any(|k| reaches(&k.holds, s)));
        for section in ALL.iter().filter(|s| !std::ptr::eq(**s, &SPEC)) {
            assert!(held(section), "no key holds {}", section.name);
        }
    }

    #[test]
    fn words_of_missions_are_those_of_the_readers() {
        let names = |section: &Section| section.keys.iter().map(|k| k.name).collect::<Vec<_>>();
        assert_eq!(names(&MISSION), dsl::vocabulary::MISSION_KINDS);
        assert_eq!(names(&LAYERS_TASK), dsl::vocabulary::TASK_SETTINGS);
    }

    /// The readers leave these as text, and they say so in a list of their own.
    #[test]
    fn texts_are_those_of_the_readers() {
        let all = ALL.iter().flat_map(|s| s.keys).filter(|k| k.place == Place::Entry);
        let is_text =
            |holds: &Holds| matches!(holds, Holds::Text | Holds::Urdf | Holds::Spec | Holds::List(Holds::Text));
        let mut texts: Vec<&str> = all.filter(|k| is_text(&k.holds)).map(|k| k.name).collect();
        let mut readers = dsl::vocabulary::TEXT_KEYS.to_vec();
        // A key of several sections is one word.
        texts.sort_unstable();
        texts.dedup();
        readers.sort_unstable();
        assert_eq!(texts, readers);
    }
}
