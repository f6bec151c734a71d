//! What the words of a spec mean, each with its place: the one table that hover, definition, references, rename,
//! completion and highlighting look into.

use std::collections::BTreeMap;
use std::ops::Range;

use compiler::expr::Trajectory;
use compiler::sections::{Key, Section};
use dsl::tree::Spec;
use dsl::{Span, Spelling};
use stdlib_tasks::params::ParamInfo;
use stdlib_tasks::task::{Actual, TaskKind, Told};

use super::library::Imported;
use super::origin::Elsewhere;
use super::urdf::Urdf;

/// The word that completion puts where the cursor is, to see what it would mean.
pub(super) const MARKER: &str = "hqCursorHereqh";

/// What can be declared in a spec.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Class {
    Param,
    /// A named expression.
    Let,
    /// A parameter of a declaration, or what a repetition runs over; its name is looked up together with its owner.
    Argument,
    Robot,
    Task,
    Stack,
    /// A level; its name is looked up together with that of its stack.
    Level,
    Arm,
    Point,
    Segment,
    Group,
    JointGroup,
    /// A signal with a value.
    Signal,
    /// A person.
    Human,
    /// A point of a person; its name is looked up together with that of the person.
    Tracked,
    /// A safety field.
    Field,
    /// A signal that is an event.
    Event,
    /// An event that no signal declares: a state raises it, or it is how an action came out.
    Raised,
    Machine,
    Mission,
    /// A member of a mission; its name is looked up together with the mission, its role, and those of what it stands in.
    Member,
    /// A state; its name is looked up together with those of the machine and the states that it stands in.
    State,
}

impl Class {
    /// What a person calls it.
    pub fn word(self) -> &'static str {
        match self {
            Class::Param => "param",
            Class::Let => "let",
            Class::Argument => "parameter",
            Class::Robot => "robot",
            Class::Task => "task",
            Class::Stack => "stack",
            Class::Level => "level",
            Class::Arm => "arm",
            Class::Point => "point",
            Class::Segment => "segment",
            Class::Group => "group",
            Class::JointGroup => "group of joints",
            Class::Signal => "signal",
            Class::Human => "human",
            Class::Tracked => "point of a human",
            Class::Field => "safety field",
            Class::Event | Class::Raised => "event",
            Class::Machine => "machine",
            Class::Mission => "mission",
            Class::Member => "member of a mission",
            Class::State => "state",
        }
    }
}

/// What a word means.
#[derive(Clone, Debug)]
pub(super) enum What {
    /// Something that the spec declares, here or elsewhere. Of a level, the name is `STACK.LEVEL`.
    Declared(Class, String),
    /// What an import brings under another name: the name before `as`.
    Brought(Class, Box<Elsewhere>),
    /// A link of the URDF.
    Link(String),
    /// A joint of the URDF.
    Joint(String),
    /// The URDF itself.
    File,
    /// A file that is imported, as written.
    Spec(String),
    /// A task type.
    Kind(&'static TaskKind),
    /// A parameter of a task type.
    Parameter(&'static TaskKind, &'static ParamInfo),
    /// What a task of a type tells.
    Told(&'static TaskKind, &'static Told),
    /// A key or a word of the language.
    Key(&'static Key),
    /// A function or a name that is built in.
    BuiltIn(String),
    /// What a state asks the outside world to do.
    Verb(&'static compiler::Verb),
    /// A unit.
    Unit(dsl::tree::Unit),
}

/// A word with its meaning.
#[derive(Clone, Debug)]
pub(super) struct Mention {
    /// Its bytes.
    pub place: Range<usize>,
    /// False where the place is that of a whole YAML scalar, of which the word is a part.
    pub exact: bool,
    /// True where this is the declaration.
    pub declares: bool,
    /// Its meaning.
    pub what: What,
}

/// A declaration.
#[derive(Clone, Debug)]
pub(super) struct Declaration {
    /// The name.
    pub name: Range<usize>,
    /// All of it.
    pub whole: Range<usize>,
    /// Comments before it.
    pub comments: Vec<String>,
    /// Where it is declared, for a name that an import brings.
    pub elsewhere: Option<Elsewhere>,
}

/// What could stand where the cursor is.
#[derive(Clone, Debug)]
pub(super) enum Slot {
    /// Keys of the language, without those that are there.
    Keys(&'static Section, Vec<String>),
    /// Parameters of a task type, without those that are there.
    Parameters(&'static [ParamInfo], Vec<String>),
    /// Parameters of a task type as arguments with a name, without those that are there.
    Named(&'static [ParamInfo], Vec<String>),
    /// An argument of a trajectory: its goal, or one of its limits by name, without those that are there.
    Limits(&'static Trajectory, Vec<String>),
    /// Words, as keys or values.
    Words(&'static [&'static str]),
    /// A part of the robot, or a person.
    PartOrPerson,
    /// What a task tells.
    Tells(&'static [Told]),
    /// A task type.
    Kind,
    /// A member of a level.
    Member,
    /// A stack.
    Stack,
    /// Names that are known, each with a word about it.
    Offered(Vec<(String, &'static str)>),
    /// What a declaration with parameters takes: a value of this type, or one of these parameters by name.
    Given(Option<String>, Vec<Taken>),
    /// An expression.
    Expression {
        /// `auto` may stand in its place.
        auto: bool,
        /// What the robot does now may stand in it.
        state: bool,
    },
    /// An expectation: an expression, and what is measured while a scenario runs.
    Expected,
    /// A condition of a machine, which knows measures of the motion.
    Condition,
    /// What `initial(..)` can capture, behind this prefix.
    Captured(&'static [Actual], String),
    /// What a frame has.
    FrameField,
    /// What a pose or a vector has.
    ValueField,
    /// A unit.
    Unit,
    /// A link.
    Link,
    /// A link, or an arm.
    Frame,
    /// An arm.
    Arm,
    /// Points, segments, groups, links.
    Geometry,
    /// Arms, points, segments, groups, links.
    Links,
    /// Joints and their groups.
    Joint,
    /// Joints and their groups, as keys, without those that are there.
    JointKey(Vec<String>),
    /// A signal with a value, or a person.
    Signal,
    /// A person.
    Human,
    /// A safety field.
    Field,
    /// An event.
    Events {
        /// Faults and completion of tasks may stand in its place.
        whole: bool,
    },
    /// A kind of fault.
    Faults,
    /// A declared task.
    Task,
    /// A verb.
    Verbs,
    /// A machine.
    Machine,
    /// Nothing that could be offered: a new name, a text.
    Nothing,
}

/// A parameter of a declaration.
#[derive(Clone, Debug)]
pub(super) struct Taken {
    /// Its name.
    pub name: String,
    /// Its type, as written.
    pub ty: String,
    /// True where it may be left out.
    pub optional: bool,
}

/// All that was found.
#[derive(Debug, Default)]
pub(super) struct Mentions {
    /// In the order of the text.
    pub all: Vec<Mention>,
    /// What is declared.
    pub declared: BTreeMap<(Class, String), Declaration>,
    /// What declarations with parameters take, by `task NAME` or `stack NAME`.
    pub takes: BTreeMap<String, Vec<Taken>>,
    /// The types of signals.
    pub types: BTreeMap<String, String>,
    /// The types of tasks.
    pub kinds: BTreeMap<String, String>,
    /// The specs that workers run, as written, by what the workers are looked up by.
    pub runs: BTreeMap<String, String>,
    /// The kinds of missions.
    pub missions: BTreeMap<String, String>,
    /// Events that actions raise, each with the place where that is written first.
    pub raised: BTreeMap<String, Range<usize>>,
    /// What the marker stands for.
    pub slot: Option<Slot>,
}

impl Mentions {
    /// The word at a byte, or the one that ends there; the shortest where several overlap.
    pub fn at(&self, byte: usize) -> Option<&Mention> {
        let holds = |m: &&Mention| m.place.start <= byte && byte <= m.place.end;
        self.all.iter().filter(holds).min_by_key(|m| (m.place.len(), usize::from(m.place.end == byte)))
    }

    /// All words with the same meaning as a declared name, link or joint.
    pub fn same<'m>(&'m self, what: &'m What) -> impl Iterator<Item = &'m Mention> {
        self.all.iter().filter(move |m| match (&m.what, what) {
            (What::Declared(a, n), What::Declared(b, k)) => a == b && n == k,
            (What::Link(n), What::Link(k)) | (What::Joint(n), What::Joint(k)) => n == k,
            _ => false,
        })
    }

    /// Names declared in a class.
    pub fn names(&self, class: Class) -> impl Iterator<Item = &str> {
        self.declared.keys().filter(move |k| k.0 == class).map(|k| k.1.as_str())
    }
}

/// Reads a tree.
pub(super) fn of(spec: &Spec, text: &str, spelling: Spelling, urdf: Option<&Urdf>, imports: &[Imported]) -> Mentions {
    let found = Mentions::default();
    let (mission, there, scope) = (None, None, Vec::new());
    let (state, expected, condition) = (false, false, false);
    let mut walker = Walker { text, spelling, urdf, state, expected, condition, mission, there, imports, scope, found };
    walker.spec(spec);
    let mut found = walker.found;
    found.all.sort_by_key(|m| (m.place.start, m.place.end));
    found
}

/// The state of reading a tree.
pub(super) struct Walker<'t> {
    pub text: &'t str,
    pub spelling: Spelling,
    pub urdf: Option<&'t Urdf>,
    /// True inside an expression in which the robot's present state may stand.
    pub state: bool,
    /// True inside an expectation.
    pub expected: bool,
    /// True inside a condition of a machine.
    pub condition: bool,
    /// The mission that the scenario around executes.
    pub mission: Option<String>,
    /// The spec that the worker around runs, as written.
    pub there: Option<String>,
    /// The files that it imports, and those that workers of its missions run.
    pub imports: &'t [Imported],
    /// Parameters and what repetitions run over, each with what it is looked up by; the innermost last.
    pub scope: Vec<(String, String)>,
    pub found: Mentions,
}

impl Walker<'_> {
    /// The bytes of a word inside its span, which may have quotes around it or be a scalar that contains it; and whether
    /// they are just the word.
    pub fn place(&self, word: &str, span: Span) -> (Range<usize>, bool) {
        let range = span.range();
        let Some(said) = self.text.get(range.clone()) else { return (range, false) };
        if said == word {
            return (range, true);
        }
        let inner = range.start + 1..range.end.saturating_sub(1).max(range.start + 1);
        if said.starts_with(['"', '\'']) && self.text.get(inner.clone()) == Some(word) {
            return (inner, true);
        }
        (range, false)
    }

    /// Notes a word.
    pub fn note(&mut self, word: &str, span: Span, what: What) {
        let (place, exact) = self.place(word, span);
        self.found.all.push(Mention { place, exact, declares: false, what });
    }

    /// Notes the declaration of a name. `looked_up` is what it is looked up by.
    pub fn declare(
        &mut self,
        (class, looked_up): (Class, String),
        name: &dsl::Spanned<String>,
        whole: Span,
        comments: &[String],
    ) {
        if name.value == MARKER {
            self.found.slot = Some(Slot::Nothing);
            return;
        }
        let (place, exact) = self.place(&name.value, name.span);
        let range = whole.range();
        let whole = range.start.min(place.start)..range.end.max(place.end);
        let declaration = Declaration { name: place.clone(), whole, comments: comments.to_vec(), elsewhere: None };
        self.found.declared.entry((class, looked_up.clone())).or_insert(declaration);
        self.found.all.push(Mention { place, exact, declares: true, what: What::Declared(class, looked_up) });
    }

    /// Notes what the marker could be, where this is the marker.
    pub fn marked(&mut self, word: &str, slot: impl FnOnce() -> Slot) -> bool {
        let found = word == MARKER;
        if found {
            self.found.slot = Some(slot());
        }
        found
    }

    /// Notes a word that is a parameter of a declaration around it, where it is one.
    pub fn scoped(&mut self, word: &str, span: Span) -> bool {
        let found = self.scope.iter().rev().find(|s| s.0 == word).map(|s| s.1.clone());
        if let Some(key) = &found {
            self.note(word, span, What::Declared(Class::Argument, key.clone()));
        }
        found.is_some()
    }

    /// True for a declared name.
    pub fn has(&self, class: Class, name: &str) -> bool {
        self.found.declared.contains_key(&(class, name.to_string()))
    }
}
