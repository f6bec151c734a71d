//! Scope of an expression: the meaning of names, and the permitted operations.

use dsl::tree::Value;
use dsl::{Diagnostic, Help, Span, Spanned};

use super::robot_state::RobotStateTerm;
use super::trajectories::needs_from;
use super::{Frame, Graph, Start, Typed};
use crate::expr::constants::Human;

/// A value that a name in an expression refers to.
#[derive(Clone, Debug)]
pub struct Symbol {
    /// Value.
    pub value: Typed,
    /// Span of the declaration.
    pub declared: Span,
}

/// Meaning of a name.
#[derive(Clone, Debug)]
pub enum Meaning {
    /// A value.
    Value(Symbol),
    /// A declaration with a reported error; its uses are not reported.
    Failed,
    /// A named expression of the robot's state, which has no value before the robot is bound.
    Later,
    /// A signal with a force and a moment.
    Wrench,
    /// A person with tracked points.
    Human(Human),
    /// A safety field; `field(NAME)` is its value.
    Field,
    /// An obstacle, which has no value.
    Obstacle,
    /// An event, which is not a value.
    Event,
    /// Unknown name.
    Unknown,
}

/// Scope of an expression.
pub trait Scope {
    /// Meaning of a name that is not built in.
    fn name(&mut self, name: &str) -> Meaning;
    /// Names in scope, for suggestions.
    fn names(&self) -> Vec<String>;
    /// Number of a signal's presence in the table of signals; `None` if the name is not that of a signal.
    fn presence(&mut self, name: &str) -> Option<usize>;
    /// First number of the age of a signal, or of a point of a person, in the table of signals; `None` if the name is not
    /// that of a signal.
    fn age(&mut self, _name: &str) -> Option<usize> {
        None
    }
    /// True if a value may depend on time.
    fn moves(&self) -> bool {
        true
    }
    /// True if a value may depend on the robot's current state. Otherwise it may depend only on the state when the
    /// stack was entered.
    fn follows(&self) -> bool {
        true
    }
    /// Help for a name that is that of a part of the robot, or for another reason not a value.
    fn instead(&self, _name: &str) -> Option<Help> {
        None
    }
    /// Lowers `initial(ARGUMENT)`. Returns `None` if nothing can be captured, with diagnostics.
    fn initial(
        &mut self,
        graph: &mut Graph,
        argument: &Value,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed>;
    /// Start of a trajectory, with or without the argument `from`. Returns `None` if it is not permitted here, with
    /// diagnostics.
    fn start(
        &mut self,
        _graph: &mut Graph,
        from: Option<&Value>,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Start> {
        if from.is_some() {
            return Some(Start::Written);
        }
        diagnostics.push(needs_from(span));
        None
    }
    /// Axes that the name behind `in` selects. Returns `None` if there are none here, with diagnostics.
    fn frame(&mut self, name: &Spanned<String>, diagnostics: &mut Vec<Diagnostic>) -> Option<Frame>;
    /// Lowers a part of the robot's current state. Returns `None` if that is not permitted here, with diagnostics.
    fn now(
        &mut self,
        graph: &mut Graph,
        what: &RobotStateTerm,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed>;
    /// Lowers a part of a name, `h1.waited`. The outer `None` means that names have no parts in this scope; the inner
    /// one, that the name has no such part, with diagnostics.
    fn part(
        &mut self,
        _graph: &mut Graph,
        _of: (&str, Span),
        _field: &Spanned<String>,
        _diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Option<Typed>> {
        None
    }
    /// Lowers a call of one of [`MEASURES`], which are measured in a scenario. Returns `None` if that is not permitted
    /// here, with diagnostics.
    fn measured(
        &mut self,
        _graph: &mut Graph,
        function: &Spanned<String>,
        _args: &[Value],
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed> {
        diagnostics.push(not_measured(function, span));
        None
    }
}

/// Diagnostic for a measure outside of its context.
pub(crate) fn not_measured(function: &Spanned<String>, span: Span) -> Diagnostic {
    let d = Diagnostic::error("HQ0312", span, format!("`{}(..)` has no meaning here", function.value));
    if function.value == REACHED {
        return d.note("the controller measures it for the transitions of its machine").help(
            "use it after `on` or `when` in a machine; in an expectation compare the error: `error(TASK) < 5 mm`",
        );
    }
    if MOTION.contains(&function.value.as_str()) {
        return d
            .note("it is measured in scenarios, and by the controller for the conditions of its machine")
            .help("use it after `expect` in a scenario, or after `when` in a machine");
    }
    d.note("it is measured from outside while a scenario runs, and no controller knows it")
        .help("use it after `expect` in a scenario")
}

/// Functions in expectations that are measured while a scenario runs.
pub const MEASURES: &[&str] = &["margin", "error", "in", "fault", "speed", "acceleration", "reversals", SETTLED];

/// Those of [`MEASURES`] that conditions of a machine may use too: measures of the motion that the controller chooses.
pub const MOTION: &[&str] = &["speed", "acceleration", "reversals", SETTLED];

/// Truth value that joints are slower than bounds, one of [`MOTION`].
pub const SETTLED: &str = "settled";

/// Truth value that a target is reached, in triggers and conditions of a machine.
pub const REACHED: &str = "reached";

/// A value that cannot be typed; the diagnostics report the reason.
pub struct Failed;
