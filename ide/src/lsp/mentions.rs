//! Symbol index of a spec: the meaning and the place of each word. It serves hover, definition, references, rename,
//! completion and highlighting.

use std::collections::BTreeMap;
use std::ops::Range;

use compiler::expr::Trajectory;
use compiler::sections::{Key, Section};
use dsl::tree::Spec;
use dsl::{Span, Syntax};
use stdlib_tasks::params::ParamInfo;
use stdlib_tasks::task::{Actual, TaskKind, Told};

use super::library::Imported;
use super::origin::Elsewhere;
use super::urdf::Urdf;

/// Word that completion inserts at the cursor, to determine its meaning there.
pub(super) const MARKER: &str = "hqCursorHereqh";

/// Class of a declared symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Class {
    Param,
    /// A named expression.
    Let,
    /// A parameter of a declaration, or the variable of a repetition; its qualified name starts with its owner.
    Argument,
    Robot,
    Task,
    Stack,
    /// A level; its qualified name starts with that of its stack.
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
    /// A point of a person; its qualified name starts with that of the person.
    Tracked,
    /// A safety field.
    Field,
    /// A signal that is an event.
    Event,
    /// An event that is not a signal: a state raises it, or it is an outcome of an action.
    Raised,
    Machine,
    Mission,
    /// A member of a mission; its qualified name consists of the mission, its role, and the enclosing members.
    Member,
    /// A state; its qualified name consists of the machine and the enclosing states.
    State,
}

impl Class {
    /// Name of the class for users.
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

/// Meaning of a word.
#[derive(Clone, Debug)]
pub(super) enum What {
    /// A declared symbol, in this file or another one, by its qualified name. For a level, that is `STACK.LEVEL`.
    Declared(Class, String),
    /// A symbol that an import renames: the name before `as`.
    Brought(Class, Box<Elsewhere>),
    /// A link of the URDF.
    Link(String),
    /// A joint of the URDF.
    Joint(String),
    /// The URDF.
    File,
    /// An imported file, by its path as written.
    Spec(String),
    /// A task type.
    Kind(&'static TaskKind),
    /// A parameter of a task type.
    Parameter(&'static TaskKind, &'static ParamInfo),
    /// An output of a task type.
    Told(&'static TaskKind, &'static Told),
    /// A key or keyword.
    Key(&'static Key),
    /// A built-in function or name.
    BuiltIn(String),
    /// A verb of an action.
    Verb(&'static compiler::Verb),
    /// A unit.
    Unit(dsl::tree::Unit),
}

/// An occurrence of a word, with its meaning.
#[derive(Clone, Debug)]
pub(super) struct Mention {
    /// Byte range.
    pub place: Range<usize>,
    /// False if the range is a whole YAML scalar, of which the word is only a part.
    pub exact: bool,
    /// True if this is the declaration.
    pub declares: bool,
    /// Meaning.
    pub what: What,
}

/// A declaration.
#[derive(Clone, Debug)]
pub(super) struct Declaration {
    /// Range of the name.
    pub name: Range<usize>,
    /// Range of the whole declaration.
    pub whole: Range<usize>,
    /// Comments before the declaration.
    pub comments: Vec<String>,
    /// Declaration in another file, for an imported name.
    pub elsewhere: Option<Elsewhere>,
}

/// Completion context: the kinds of words that fit at the cursor.
#[derive(Clone, Debug)]
pub(super) enum Slot {
    /// Keys of a section, except for those present.
    Keys(&'static Section, Vec<String>),
    /// Parameters of a task type, except for those present.
    Parameters(&'static [ParamInfo], Vec<String>),
    /// Parameters of a task type as named arguments, except for those present.
    Named(&'static [ParamInfo], Vec<String>),
    /// An argument of a trajectory: its goal, or one of its named limits, except for those present.
    Limits(&'static Trajectory, Vec<String>),
    /// Keywords, as keys or values.
    Words(&'static [&'static str]),
    /// A part of the robot, or a person.
    PartOrPerson,
    /// Outputs of a task.
    Tells(&'static [Told]),
    /// A task type.
    Kind,
    /// A member of a level.
    Member,
    /// A stack.
    Stack,
    /// Names, each with a short description.
    Offered(Vec<(String, &'static str)>),
    /// Argument of a declaration with parameters: a value of this type, or one of these parameters by name.
    Given(Option<String>, Vec<Taken>),
    /// An expression.
    Expression {
        /// True if `auto` is permitted.
        auto: bool,
        /// True if the robot's current state is permitted.
        state: bool,
    },
    /// An expectation: an expression that may also use measures of a scenario.
    Expected,
    /// A condition of a machine, which may also use measures of the motion.
    Condition,
    /// Values that `initial(..)` can capture, after this prefix.
    Captured(&'static [Actual], String),
    /// Fields of a frame.
    FrameField,
    /// Fields of a pose or a vector.
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
    /// Joints and their groups as keys, except for those present.
    JointKey(Vec<String>),
    /// A signal with a value, or a person.
    Signal,
    /// A person.
    Human,
    /// A safety field.
    Field,
    /// An event.
    Events {
        /// True if other triggers are permitted too, such as faults and the completion of tasks.
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
    /// No candidates: a new name, or a text.
    Nothing,
}

/// A parameter of a declaration.
#[derive(Clone, Debug)]
pub(super) struct Taken {
    /// Name.
    pub name: String,
    /// Type, as written.
    pub ty: String,
    /// True if it can be omitted.
    pub optional: bool,
}

/// Symbol index of a spec.
#[derive(Debug, Default)]
pub(super) struct Mentions {
    /// All occurrences, in source order.
    pub all: Vec<Mention>,
    /// Declarations, by class and qualified name.
    pub declared: BTreeMap<(Class, String), Declaration>,
    /// Parameters of declarations, by `task NAME` or `stack NAME`.
    pub takes: BTreeMap<String, Vec<Taken>>,
    /// Types of signals.
    pub types: BTreeMap<String, String>,
    /// Types of tasks.
    pub kinds: BTreeMap<String, String>,
    /// Specs that workers run, as written, by the worker's qualified name.
    pub runs: BTreeMap<String, String>,
    /// Kinds of missions.
    pub missions: BTreeMap<String, String>,
    /// Events that actions raise, each with its first occurrence.
    pub raised: BTreeMap<String, Range<usize>>,
    /// Completion context at the marker.
    pub slot: Option<Slot>,
}

impl Mentions {
    /// Returns the word that contains a byte or ends there; the shortest if several overlap.
    pub fn at(&self, byte: usize) -> Option<&Mention> {
        let holds = |m: &&Mention| m.place.start <= byte && byte <= m.place.end;
        self.all.iter().filter(holds).min_by_key(|m| (m.place.len(), usize::from(m.place.end == byte)))
    }

    /// All occurrences of a declared name, link or joint.
    pub fn same<'m>(&'m self, what: &'m What) -> impl Iterator<Item = &'m Mention> {
        self.all.iter().filter(move |m| match (&m.what, what) {
            (What::Declared(a, n), What::Declared(b, k)) => a == b && n == k,
            (What::Link(n), What::Link(k)) | (What::Joint(n), What::Joint(k)) => n == k,
            _ => false,
        })
    }

    /// Declared names of a class.
    pub fn names(&self, class: Class) -> impl Iterator<Item = &str> {
        self.declared.keys().filter(move |k| k.0 == class).map(|k| k.1.as_str())
    }
}

/// Builds the index from a syntax tree.
pub(super) fn of(spec: &Spec, text: &str, syntax: Syntax, urdf: Option<&Urdf>, imports: &[Imported]) -> Mentions {
    let found = Mentions::default();
    let (mission, there, scope) = (None, None, Vec::new());
    let (state, expected, condition) = (false, false, false);
    let mut walker = Walker { text, syntax, urdf, state, expected, condition, mission, there, imports, scope, found };
    walker.spec(spec);
    let mut found = walker.found;
    found.all.sort_by_key(|m| (m.place.start, m.place.end));
    found
}

/// State of the traversal of a syntax tree.
pub(super) struct Walker<'t> {
    pub text: &'t str,
    pub syntax: Syntax,
    pub urdf: Option<&'t Urdf>,
    /// True inside an expression that may depend on the robot's current state.
    pub state: bool,
    /// True inside an expectation.
    pub expected: bool,
    /// True inside a condition of a machine.
    pub condition: bool,
    /// Mission of the enclosing scenario.
    pub mission: Option<String>,
    /// Spec that the enclosing worker runs, as written.
    pub there: Option<String>,
    /// Imported files, followed by the specs that workers of missions run.
    pub imports: &'t [Imported],
    /// Parameters and variables of repetitions in scope, each with its qualified name; innermost last.
    pub scope: Vec<(String, String)>,
    pub found: Mentions,
}

impl Walker<'_> {
    /// Byte range of a word inside its span, which may include quotes or be a whole scalar. The flag is true if the
    /// range is exactly the word.
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

    /// Records an occurrence of a word.
    pub fn note(&mut self, word: &str, span: Span, what: What) {
        let (place, exact) = self.place(word, span);
        self.found.all.push(Mention { place, exact, declares: false, what });
    }

    /// Records the declaration of a name. `looked_up` is its qualified name.
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

    /// Records the completion context, if the word is the marker. Returns true if it is.
    pub fn marked(&mut self, word: &str, slot: impl FnOnce() -> Slot) -> bool {
        let found = word == MARKER;
        if found {
            self.found.slot = Some(slot());
        }
        found
    }

    /// Records a word that is a parameter in scope. Returns true if it is one.
    pub fn scoped(&mut self, word: &str, span: Span) -> bool {
        let found = self.scope.iter().rev().find(|s| s.0 == word).map(|s| s.1.clone());
        if let Some(key) = &found {
            self.note(word, span, What::Declared(Class::Argument, key.clone()));
        }
        found.is_some()
    }

    /// True if a name is declared.
    pub fn has(&self, class: Class, name: &str) -> bool {
        self.found.declared.contains_key(&(class, name.to_string()))
    }
}
