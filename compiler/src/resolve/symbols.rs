//! Symbols: the declared names of a spec and of the files that it reads.

use std::ops::Range;

/// Index of a symbol in [`super::Resolution::symbols`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SymbolId(pub usize);

/// Index of a file in [`super::Resolution::files`]; the spec itself is the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FileId(pub usize);

/// Kind of a symbol.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum SymbolKind {
    /// A param.
    Param,
    /// A named expression.
    Let,
    /// A parameter of a declaration, or the variable of a repetition.
    Parameter,
    /// A robot.
    Robot,
    /// A task.
    Task,
    /// A stack.
    Stack,
    /// A level of a stack.
    Level,
    /// An arm.
    Arm,
    /// A point of the robot.
    Point,
    /// A segment of the robot.
    Segment,
    /// A group of points, segments and links.
    Group,
    /// A group of joints.
    JointGroup,
    /// A posture of the SRDF.
    Posture,
    /// A signal with a value.
    Signal,
    /// A variable of the machine.
    Variable,
    /// A human.
    Human,
    /// A point of a human.
    HumanPoint,
    /// A safety field.
    SafetyField,
    /// An obstacle.
    Obstacle,
    /// A signal that is an event.
    Event,
    /// An event that an action raises by its name.
    RaisedEvent,
    /// An event that is an outcome of an action; its place is that of the verb.
    Outcome,
    /// A machine.
    Machine,
    /// A state.
    State,
    /// A mission.
    Mission,
    /// A member of a mission.
    Member,
    /// A link of the URDF.
    Link,
    /// A joint of the URDF.
    Joint,
}

impl SymbolKind {
    /// Returns the name of the kind for users.
    pub fn word(self) -> &'static str {
        match self {
            SymbolKind::Param => "param",
            SymbolKind::Let => "let",
            SymbolKind::Parameter => "parameter",
            SymbolKind::Robot => "robot",
            SymbolKind::Task => "task",
            SymbolKind::Stack => "stack",
            SymbolKind::Level => "level",
            SymbolKind::Arm => "arm",
            SymbolKind::Point => "point",
            SymbolKind::Segment => "segment",
            SymbolKind::Group => "group",
            SymbolKind::JointGroup => "group of joints",
            SymbolKind::Posture => "posture",
            SymbolKind::Signal => "signal",
            SymbolKind::Variable => "variable",
            SymbolKind::Human => "human",
            SymbolKind::HumanPoint => "point of a human",
            SymbolKind::SafetyField => "safety field",
            SymbolKind::Obstacle => "obstacle",
            SymbolKind::Event | SymbolKind::RaisedEvent | SymbolKind::Outcome => "event",
            SymbolKind::Machine => "machine",
            SymbolKind::State => "state",
            SymbolKind::Mission => "mission",
            SymbolKind::Member => "member of a mission",
            SymbolKind::Link => "link",
            SymbolKind::Joint => "joint",
        }
    }
}

/// A declared name.
#[derive(Clone, Debug)]
pub struct Symbol {
    /// Kind.
    pub kind: SymbolKind,
    /// Name, as written; a name with holes, `touch_${side}`, is that of several declarations.
    pub name: String,
    /// File.
    pub file: FileId,
    /// Range of the name in the file (bytes).
    pub place: Range<usize>,
    /// Range of the whole declaration in the file (bytes).
    pub whole: Range<usize>,
    /// Enclosing symbol: the machine of a state, the task of a parameter.
    pub container: Option<SymbolId>,
    /// Comments before the declaration, or a description of the link or joint.
    pub doc: Vec<String>,
    /// Type of a signal, variable, parameter, joint or task; role of a member; kind of a mission.
    pub ty: String,
    /// Parameters of a task or stack.
    pub parameters: Vec<Formal>,
    /// For an import under another name, the symbol that it names.
    pub imported: Option<SymbolId>,
}

/// A parameter of a task or stack.
#[derive(Clone, Debug)]
pub struct Formal {
    /// Name.
    pub name: String,
    /// Type, as written.
    pub ty: String,
    /// True if it can be omitted.
    pub optional: bool,
}

/// The declared symbol behind imports that rename it. An import names an earlier symbol, so that the loop ends.
pub(super) fn origin(symbols: &[Symbol], id: SymbolId) -> SymbolId {
    let mut id = id;
    while let Some(further) = symbols[id.0].imported {
        id = further;
    }
    id
}
