//! What surrounds an expression: what names mean where it stands, and what may be asked there.

use dsl::tree::Value;
use dsl::{Diagnostic, Span, Spanned};

use super::present::Now;
use super::trajectories::needs_from;
use super::{Frame, Graph, Start, Typed};
use crate::expr::constants::Human;

/// Something that a name in an expression can mean.
#[derive(Clone, Debug)]
pub struct Symbol {
    /// Its value.
    pub value: Typed,
    /// Where it was declared.
    pub declared: Span,
}

/// What a name means.
#[derive(Clone, Debug)]
pub enum Meaning {
    /// A value.
    Value(Symbol),
    /// A declaration that was wrong, and reported; who uses it stays silent.
    Failed,
    /// A named expression of what the robot does, which has no value before the robot is known.
    Later,
    /// A signal with a force and a moment.
    Wrench,
    /// A person, whose points are tracked.
    Human(Human),
    /// A safety field, whose value is asked for by `field(NAME)`.
    Field,
    /// An event, which is no value.
    Event,
    /// Nothing.
    Unknown,
}

/// What names mean where an expression stands.
pub trait Scope {
    /// What a name means that is not built in.
    fn name(&mut self, name: &str) -> Meaning;
    /// Names that could have been meant.
    fn names(&self) -> Vec<String>;
    /// The number of the table of signals that says whether a signal is present; none where a name is that of no signal.
    fn presence(&mut self, name: &str) -> Option<usize>;
    /// Whether a value may depend on time here.
    fn moves(&self) -> bool {
        true
    }
    /// Whether what the robot does now may stand here; elsewhere only what it did when the stack was entered.
    fn follows(&self) -> bool {
        true
    }
    /// What to write where the name is that of a part of the robot, or no value for another reason.
    fn instead(&self, _name: &str) -> Option<String> {
        None
    }
    /// The value that `initial(ARGUMENT)` captures. `None` where nothing can be captured; the diagnostics say why.
    fn initial(
        &mut self,
        graph: &mut Graph,
        argument: &Value,
        span: Span,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Typed>;
    /// Where a trajectory begins, whose argument `from` is given or not. `None` where that has no meaning here; the
    /// diagnostics say why.
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
    /// The axes that a name behind `in` means. `None` where it means none here; the diagnostics say why.
    fn frame(&mut self, name: &Spanned<String>, diagnostics: &mut Vec<Diagnostic>) -> Option<Frame>;
    /// What the robot does now. `None` where it has no meaning here; the diagnostics say why.
    fn now(&mut self, graph: &mut Graph, what: &Now, span: Span, diagnostics: &mut Vec<Diagnostic>) -> Option<Typed>;
    /// What a name has behind a dot, `h1.waited`. The outer `None` where a name has no parts of this scope's own, the inner
    /// one where it has none of that name; the diagnostics say why.
    fn part(
        &mut self,
        _graph: &mut Graph,
        _of: (&str, Span),
        _field: &Spanned<String>,
        _diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Option<Typed>> {
        None
    }
    /// What is measured in a scenario: a call of one of [`MEASURES`]. `None` where it has no meaning here; the
    /// diagnostics say why.
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

/// The diagnostic for a measure where nothing measures it.
pub(crate) fn not_measured(function: &Spanned<String>, span: Span) -> Diagnostic {
    let d = Diagnostic::error("HQ0312", span, format!("`{}(..)` has no meaning here", function.value));
    if MOTION.contains(&function.value.as_str()) {
        return d
            .note("it is measured in scenarios, and by the controller for the conditions of its machine")
            .help("write it behind `expect` in a scenario, or behind `when` in a machine");
    }
    d.note("it is measured from outside while a scenario runs, and no controller knows it")
        .help("write it behind `expect` in a scenario")
}

/// The functions that expectations know, of what is measured while a scenario runs.
pub const MEASURES: &[&str] = &["margin", "error", "in", "fault", "speed", "acceleration", "reversals"];

/// Those of [`MEASURES`] that conditions of a machine know too: of the motion that the controller chooses.
pub const MOTION: &[&str] = &["speed", "acceleration", "reversals"];

/// A value cannot be typed; the diagnostics say why.
pub struct Failed;
