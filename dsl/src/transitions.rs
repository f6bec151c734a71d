//! What both readers look for in states and transitions.

use crate::diagnostic::clip;
use crate::limits::MAX_STATE_NESTING;
use crate::tree::{Block, State};
use crate::{Diagnostic, Span, checks};

/// The words that begin a part of a state, and its keys in YAML: none can be a setting.
pub(crate) const STATE_WORDS: &[&str] =
    &["state", "states", "final", "stack", "enter", "do", "exit", "on", "when", "after", "transitions"];

/// The keys of a transition in YAML that are no settings either.
pub(crate) const TRANSITION_WORDS: &[&str] = &["for", "to"];

/// Settings of a state or a machine that mean something else in one of the spellings.
pub(crate) fn settings(settings: &mut Block, what: &str, diags: &mut Vec<Diagnostic>) {
    checks::duplicates(&settings.entries, diags);
    checks::reserved(settings, STATE_WORDS, what, diags);
}

/// The same for a transition.
pub(crate) fn transition_settings(settings: &mut Block, diags: &mut Vec<Diagnostic>) {
    checks::duplicates(&settings.entries, diags);
    settings.entries.retain(|entry| {
        let (key, at) = (entry.key.value.as_str(), entry.key.span);
        let reserved = STATE_WORDS.contains(&key) || TRANSITION_WORDS.contains(&key);
        if key == "for" {
            let text = "`for` stands behind the condition that holds so long, before `->`";
            diags.push(Diagnostic::error("HQ0141", at, text).help("write `when CONDITION for 3 s -> STATE`"));
        } else if reserved {
            let text = format!("`{key}` cannot be a setting of a transition");
            let note = "the word has a meaning of its own there in one of the two spellings";
            diags.push(Diagnostic::error("HQ0121", at, text).note(note));
        }
        !reserved
    });
    checks::reserved(settings, &[], "transition", diags);
}

/// Reports names that two states beside each other share; the second is left out.
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

/// States inside states inside states.
pub(crate) fn too_deep(span: Span) -> Diagnostic {
    Diagnostic::error("HQ0191", span, format!("states stand more than {MAX_STATE_NESTING} deep inside each other"))
        .here("one too many")
        .help("move an inner state out, or close a brace that was left open")
}

/// `for` behind a trigger that waits for no condition.
pub(crate) fn no_hold(word: &str, span: Span) -> Diagnostic {
    let diagnostic = Diagnostic::error("HQ0141", span, format!("`for` has no meaning behind `{word}`"));
    diagnostic
        .note("`on` waits for an event, `after` for a time in the state; only a condition can hold for a time")
        .help("write `when CONDITION for 3 s -> STATE`")
}

/// A trigger without what it waits for.
pub(crate) fn no_condition(word: &str, span: Span) -> Diagnostic {
    let example = match word {
        "on" => "on found",
        "when" => "when x < 3 N",
        _ => "after 10 s",
    };
    Diagnostic::error("HQ0141", span, format!("`{word}` does not say what it waits for"))
        .help(format!("write for instance `{example} -> STATE`"))
}

/// A transition without its next state.
pub(crate) fn no_target(span: Span) -> Diagnostic {
    Diagnostic::error("HQ0141", span, "this transition names no next state")
        .help("write `-> STATE` behind what it waits for, in YAML `to: STATE`")
}

/// What stands where the type of a signal should.
pub(crate) fn bad_type(text: &str, span: Span) -> Diagnostic {
    let diagnostic = Diagnostic::error("HQ0140", span, format!("`{}` is no type of a signal", clip(text)));
    diagnostic
        .help("write for instance `point`, `force` or `event`, with a `?` behind it where it may be absent: `point?`")
}

/// A variable without a type.
pub(crate) fn no_variable_type(name: &str, span: Span) -> Diagnostic {
    let name = clip(name);
    Diagnostic::error("HQ0140", span, format!("the variable `{name}` has no type")).help(format!(
        "write what it holds: `variable {name} : number = 0`, in YAML `{name}: {{ type: number, value: 0 }}`"
    ))
}

/// A signal without a type.
pub(crate) fn no_type(name: &str, span: Span) -> Diagnostic {
    Diagnostic::error("HQ0140", span, format!("the signal `{}` has no type", clip(name))).help(format!(
        "write what it carries: `signal {} : point`, in YAML `{}: point`",
        clip(name),
        clip(name)
    ))
}
