//! Demands of a spec on the limits of its stacks, bound to the parts of the program.

use dsl::Span;
use robot::LinkId;

/// Demands of a `coverage` block.
#[derive(Debug)]
pub(crate) struct CoverageDemands {
    /// Span of the declaration's keyword.
    pub span: Span,
    /// Stacks that have to meet the demands; `None` for all that run and move the robot.
    pub stacks: Option<Vec<DemandedStack>>,
    /// The demands.
    pub demands: Vec<Demand>,
}

/// A stack that a `coverage` names, or a state.
#[derive(Debug)]
pub(crate) struct DemandedStack {
    /// Span of the name.
    pub span: Span,
    /// Stacks of the name; none for a state in which no stack runs.
    pub stacks: Vec<usize>,
}

/// A demand.
#[derive(Debug)]
pub(crate) struct Demand {
    /// Span of the entry that demands.
    pub span: Span,
    /// True if a soft level does not suffice.
    pub hard: bool,
    /// Content of the demand.
    pub of: Demanded,
}

/// Content of a demand.
#[derive(Debug)]
pub(crate) enum Demanded {
    /// Limits of joints; of those named, or of all that move.
    Joints(JointQuantity, Option<Vec<usize>>),
    /// Pairs of links that are kept apart.
    Apart(Vec<[LinkId; 2]>),
    /// Links that are kept from points of a person, by its index and the indices of its points' signals.
    Person {
        /// Index of the person.
        human: usize,
        /// Signals of the points that count.
        points: Vec<usize>,
        /// The links.
        links: Vec<LinkId>,
    },
    /// A limit, by the index of its task, with the links that it has to guard.
    Limit {
        /// Index of the task.
        task: usize,
        /// The links; none if it only has to be there.
        links: Vec<LinkId>,
    },
}

/// Quantity of a joint that limits bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum JointQuantity {
    /// Velocity.
    Velocity,
    /// Position.
    Position,
    /// Acceleration.
    Acceleration,
}

impl JointQuantity {
    /// All quantities.
    pub const ALL: [JointQuantity; 3] = [JointQuantity::Velocity, JointQuantity::Position, JointQuantity::Acceleration];

    /// Name of the quantity, which is that of its key in a `coverage`.
    pub fn word(self) -> &'static str {
        match self {
            JointQuantity::Velocity => "velocity",
            JointQuantity::Position => "position",
            JointQuantity::Acceleration => "acceleration",
        }
    }
}
