//! Checks of states and transitions that both readers share.

use crate::diagnostic::clip;
use crate::limits::MAX_STATE_NESTING;
use crate::tree::{Block, State};
use crate::vocabulary::ALLOW;
use crate::{Diagnostic, Help, Snippet, Span, checks};

/// The words that begin a part of a state, and its keys in YAML: none of them can be the name of a setting.
pub(crate) const STATE_WORDS: &[&str] = &[
    "state",
    "states",
    "region",
    "regions",
    "final",
    "stack",
    "enter",
    "do",
    "exit",
    "on",
    "when",
    "after",
    "check",
    "transitions",
];

/// The keys of a transition in YAML that cannot be names of settings either.
pub(crate) const TRANSITION_WORDS: &[&str] = &["for", "to"];

/// Checks the settings of a state or a machine: reports duplicates, and names with another meaning in one of the
/// syntaxes.
pub(crate) fn settings(settings: &mut Block, what: &str, diags: &mut Vec<Diagnostic>) {
    checks::duplicates(&settings.entries, diags);
    checks::reserved(settings, STATE_WORDS, what, diags);
}

/// Checks the settings of a transition like [`settings`].
pub(crate) fn transition_settings(settings: &mut Block, diags: &mut Vec<Diagnostic>) {
    checks::duplicates(&settings.entries, diags);
    settings.entries.retain(|entry| {
        let (key, at) = (entry.key.value.as_str(), entry.key.span);
        let reserved = STATE_WORDS.contains(&key) || TRANSITION_WORDS.contains(&key) || key == ALLOW;
        if key == "for" {
            let text = "`for` belongs between its condition and `->`";
            diags.push(Diagnostic::error("HQ0141", at, text).help(held()));
        } else if key == ALLOW {
            let text = "a transition allows nothing";
            diags.push(Diagnostic::error("HQ0121", at, text).help("allow the warning in the state around it"));
        } else if reserved {
            let text = format!("`{key}` cannot be a setting of a transition");
            let note = "the word is a keyword there in one of the two syntaxes";
            diags.push(Diagnostic::error("HQ0121", at, text).note(note));
        }
        !reserved
    });
    checks::reserved(settings, &[], "transition", diags);
}

/// Reports names that sibling states share; removes the second state.
pub(crate) fn distinct_states(states: &mut Vec<State>, diags: &mut Vec<Diagnostic>) {
    let mut seen = std::collections::BTreeMap::new();
    states.retain(|state| match seen.get(&state.name.value) {
        Some(first) => {
            diags.push(checks::duplicate(&state.name.value, *first, state.name.span));
            false
        }
        None => {
            seen.insert(state.name.value.clone(), state.name.span);
            true
        }
    });
}

/// Returns the diagnostic for states that are nested too deeply.
pub(crate) fn too_deep(span: Span) -> Diagnostic {
    Diagnostic::error("HQ0191", span, format!("states are nested more than {MAX_STATE_NESTING} deep"))
        .here("one too many")
        .help("move an inner state out, or close a brace that was left open")
}

/// Returns the diagnostic for `for` after a trigger without a condition.
pub(crate) fn no_hold(word: &str, span: Span) -> Diagnostic {
    let diagnostic = Diagnostic::error("HQ0141", span, format!("`for` is not allowed after `{word}`"));
    diagnostic
        .note("`on` waits for an event, `after` for a time in the state; only a condition can hold for a time")
        .help(held())
}

/// Help that shows a condition which holds for a time.
fn held() -> Help {
    let yaml = "{ when: CONDITION, for: 3 s, to: STATE }";
    Help::write(Snippet::each("when CONDITION for 3 s -> STATE", yaml))
}

/// Returns the diagnostic for a trigger without an event, a condition or a duration.
pub(crate) fn no_condition(word: &str, span: Span) -> Diagnostic {
    let example = match word {
        "on" => "found",
        "when" => "x < 3 N",
        _ => "10 s",
    };
    let example = Snippet::each(format!("{word} {example} -> STATE"), format!("{{ {word}: {example}, to: STATE }}"));
    Diagnostic::error("HQ0141", span, format!("`{word}` has no trigger")).help(Help::write_for_instance(example))
}

/// Returns the diagnostic for a transition without a target state.
pub(crate) fn no_target(span: Span) -> Diagnostic {
    Diagnostic::error("HQ0141", span, "this transition names no next state")
        .help(Help::with("write {} after the trigger", [Snippet::each("-> STATE", "to: STATE")]))
}

/// Returns the diagnostic for text in place of the type of a signal.
pub(crate) fn bad_type(text: &str, span: Span) -> Diagnostic {
    let diagnostic = Diagnostic::error("HQ0140", span, format!("`{}` is no type of a signal", clip(text)));
    diagnostic.help("write for instance `point`, `force` or `event`, with a `?` after it if it may be absent: `point?`")
}

/// Returns the diagnostic for a variable without a type.
pub(crate) fn no_variable_type(name: &str, span: Span) -> Diagnostic {
    let name = clip(name);
    let example =
        Snippet::each(format!("variable {name} : number = 0"), format!("{name}: {{ type: number, value: 0 }}"));
    Diagnostic::error("HQ0140", span, format!("the variable `{name}` has no type"))
        .help(Help::with("write its type and initial value: {}", [example]))
}

/// Returns the diagnostic for a signal without a type.
pub(crate) fn no_type(name: &str, span: Span) -> Diagnostic {
    let name = clip(name);
    Diagnostic::error("HQ0140", span, format!("the signal `{name}` has no type")).help(Help::with(
        "write its type: {}",
        [Snippet::each(format!("signal {name} : point"), format!("{name}: point"))],
    ))
}
