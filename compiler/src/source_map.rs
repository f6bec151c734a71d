//! Source spans of the parts of a program, for checks of the finished program.

use dsl::Span;
use robot::LinkMesh;
use runtime::program::Measure;

use crate::binding::BoundTask;
use crate::demands::CoverageDemands;
use crate::robot_binding::RobotSrdf;

/// Source spans of the parts of a program, for checks of the finished program.
pub(crate) struct SourceMap {
    /// Bound tasks, by the task's index.
    pub tasks: Vec<BoundTask>,
    /// For each stack, the span of its name, and those of its levels' names.
    pub stacks: Vec<(Span, Vec<Span>)>,
    /// Spans of the machine.
    pub machine: Option<MachinePlaces>,
    /// Span of the robot's rate.
    pub rate: Span,
    /// Span of the robot's home.
    pub home: Span,
    /// The robot's SRDF.
    pub srdf: Vec<RobotSrdf>,
    /// Meshes of the collision shapes of its links.
    pub meshes: Vec<LinkMesh>,
    /// Demands on limits.
    pub coverage: Vec<CoverageDemands>,
    /// Places of the scenarios.
    pub scenarios: Vec<ScenarioPlaces>,
    /// Measures of runs that predicates of scenarios read; their numbers in the graph follow those of the signals.
    pub scenario_measures: Vec<Measure>,
}

/// Source spans of the parts of a scenario, with the nodes of its predicates.
#[derive(Debug)]
pub(crate) struct ScenarioPlaces {
    /// Span of its `start`, or of its name.
    pub start: Span,
    /// Its index among the scenarios as written.
    pub written: usize,
    /// Node of the number of each predicate.
    pub nodes: Vec<usize>,
    /// The comparisons and truth values of its expectations.
    pub atoms: Vec<Atom>,
}

/// A comparison or a truth value of an expectation.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Atom {
    /// Its span.
    pub at: Span,
    /// Its index among the predicates of the scenario.
    pub predicate: usize,
}

/// Source spans of the parts of a machine, with facts for its checks.
#[derive(Clone, Debug, Default)]
pub(crate) struct MachinePlaces {
    /// For each state, the span of its name.
    pub states: Vec<Span>,
    /// For each state, its whole span.
    pub wholes: Vec<Span>,
    /// For each state, the span of its stack's name.
    pub stacks: Vec<Option<Span>>,
    /// For each state, its transitions.
    pub transitions: Vec<Vec<TransitionPlace>>,
    /// For each action, its span.
    pub actions: Vec<Span>,
    /// Properties that must hold.
    pub properties: Vec<PropertyPlace>,
    /// Measures of a run that properties read; their numbers follow those of the signals.
    pub measures: Vec<Measure>,
    /// Number of events that are declared; the others are outcomes of actions, or raised by the machine.
    pub declared_events: usize,
}

/// A property of a machine.
#[derive(Clone, Debug)]
pub(crate) struct PropertyPlace {
    /// Its label, or its formula.
    pub name: String,
    /// Span of the formula.
    pub span: Span,
    /// State in which it holds; 0 for the whole machine.
    pub state: usize,
    /// The formula that holds at every tick, or the span of a part that speaks of other ticks.
    pub formula: Result<Property, Span>,
}

/// A formula without time.
#[derive(Clone, Debug)]
pub(crate) enum Property {
    /// Node of a truth value.
    Value(usize),
    /// Negation.
    Not(Box<Property>),
    /// Both.
    And(Box<[Property; 2]>),
    /// At least one of both.
    Or(Box<[Property; 2]>),
}

/// Source spans of a transition, with facts about it.
#[derive(Clone, Debug)]
pub(crate) struct TransitionPlace {
    /// Span of the trigger.
    pub trigger: Span,
    /// Span of the target.
    pub target: Span,
    /// True if the transition, or an enclosing state, sets a blend time.
    pub blend: bool,
    /// Node of the condition in the graph.
    pub condition: Option<usize>,
    /// Value of the condition, if it is constant.
    pub constant: Option<bool>,
    /// Signals that are present when the transition is taken.
    pub demands: Vec<usize>,
}
