//! Where the parts of a program were written, for checks that look at the finished program.

use dsl::Span;

use crate::binding::BoundTask;

/// Where the parts of a program were written, for checks that look at the finished program.
pub(crate) struct SourceMap {
    /// For each task of the program.
    pub tasks: Vec<BoundTask>,
    /// For each stack, its name; for each level of it, its name.
    pub stacks: Vec<(Span, Vec<Span>)>,
    /// The machine.
    pub machine: Option<MachinePlaces>,
    /// The robot's rate and home.
    pub rate: Span,
    /// See `rate`.
    pub home: Span,
    /// For each scenario its `start`, or its name.
    pub scenario_starts: Vec<Span>,
}

/// Where the parts of a machine were written, and what checks want to know of them.
#[derive(Debug, Default)]
pub(crate) struct MachinePlaces {
    /// For each state its name.
    pub states: Vec<Span>,
    /// For each state the place that names its stack.
    pub stacks: Vec<Option<Span>>,
    /// For each state its transitions.
    pub transitions: Vec<Vec<TransitionPlace>>,
}

/// Where a transition was written, and what is known of it.
#[derive(Debug)]
pub(crate) struct TransitionPlace {
    /// Its trigger.
    pub trigger: Span,
    /// Its target.
    pub target: Span,
    /// Whether it, or what is around it, says how the command goes over.
    pub blend: bool,
    /// The value of a condition that never changes.
    pub constant: Option<bool>,
    /// Signals that are present when it is taken.
    pub demands: Vec<usize>,
}
