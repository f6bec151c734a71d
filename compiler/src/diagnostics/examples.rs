//! Declarations that several diagnostics show as an example.

use std::fmt::Display;

use dsl::{Diagnostic, Help, Snippet, Span};

/// The arm of a robot.
pub(crate) fn arms() -> Snippet {
    Snippet::block("arms", [Snippet::block("left", [Snippet::entry("tip", "left_tool")])])
}

/// A safety field of a person.
pub(crate) fn safety_field(name: impl Display, of: impl Into<String>) -> Snippet {
    Snippet::declared("safety_field", name, [Snippet::entry("of", of)])
}

/// A task.
pub(crate) fn task() -> Snippet {
    Snippet::typed("task", "NAME", "TYPE", [Snippet::dots()])
}

/// A machine of one state.
pub(crate) fn machine(state: Snippet) -> Snippet {
    Snippet::each(
        format!("machine NAME {{ initial STATE  state STATE {{ {} }} }}", state.native()),
        format!("machines: {{ NAME: {{ initial: STATE, states: {{ STATE: {{ {} }} }} }} }}", state.yaml()),
    )
}

/// A signal that becomes stale.
pub(crate) fn signal(ty: &str) -> Snippet {
    Snippet::each(
        format!("signal NAME : {ty}  timeout 0.5 s"),
        format!("signals: {{ NAME: {{ type: {ty}, timeout: 0.5 s }} }}"),
    )
}

/// Diagnostic for an unknown obstacle.
pub(crate) fn unknown_obstacle<'n>(name: &str, span: Span, known: impl Iterator<Item = &'n str> + Clone) -> Diagnostic {
    let example = Snippet::declared(
        "obstacle",
        "NAME",
        [Snippet::entry("box", "[1, 1, 1] m"), Snippet::entry("position", "[1, 0, 0.5] m")],
    );
    let d = Diagnostic::undeclared("obstacle", name, span);
    d.help(Help::with("declare it: {}", [example])).one_of("declared are", name, known)
}
