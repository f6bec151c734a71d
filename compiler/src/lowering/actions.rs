//! Actions of a state, addressed to the outside world or to the controller itself.

use dsl::Diagnostic;
use dsl::tree::Action;
use names::{list, suggest};

use crate::diagnostics::refused::Refused;

/// A verb of actions.
#[derive(Debug)]
pub struct Verb {
    /// Name.
    pub name: &'static str,
    /// Syntax, for messages.
    pub form: &'static str,
    /// Number of arguments.
    pub takes: std::ops::RangeInclusive<usize>,
    /// Names of the outcomes, which are events.
    pub outcomes: &'static [&'static str],
    /// True if the controller itself raises the event that the action names.
    pub raises: bool,
    /// True if the controller itself performs the action.
    pub own: bool,
    /// Description for users.
    pub doc: &'static str,
    /// Permitted words of the first argument, if it is restricted to some words.
    pub words: &'static [&'static str],
}

/// All verbs.
pub static VERBS: &[Verb] = &[
    Verb {
        name: "say",
        form: "say \"text\"",
        takes: 1..=1,
        outcomes: &[],
        raises: false,
        own: false,
        doc: "Speaks a text.",
        words: &[],
    },
    Verb {
        name: "capture",
        form: "capture(SENSOR)",
        takes: 1..=1,
        outcomes: &["found", "not_found"],
        raises: false,
        own: false,
        doc: "Starts perception with a sensor.",
        words: &[],
    },
    Verb {
        name: "gripper",
        form: "gripper close",
        takes: 1..=2,
        outcomes: &["done", "failed"],
        raises: false,
        own: false,
        doc: "Opens or closes a gripper; followed by its name if there are several.",
        words: &["open", "close"],
    },
    Verb {
        name: "tool",
        form: "tool cut",
        takes: 1..=2,
        outcomes: &["done", "failed"],
        raises: false,
        own: false,
        doc: "Operates a tool.",
        words: &[],
    },
    Verb {
        name: "call",
        form: "call(NAME, ..)",
        takes: 1..=8,
        outcomes: &["done", "failed"],
        raises: false,
        own: false,
        doc: "Any other action of the host, by name.",
        words: &[],
    },
    Verb {
        name: "emit",
        form: "emit EVENT",
        takes: 1..=1,
        outcomes: &[],
        raises: true,
        own: false,
        doc: "Raises an event, which transitions see at the next tick.",
        words: &[],
    },
    Verb {
        name: "log",
        form: "log \"text\"",
        takes: 1..=1,
        outcomes: &[],
        raises: false,
        own: false,
        doc: "Writes a text to the log.",
        words: &[],
    },
    Verb {
        name: "set",
        form: "set(NAME, VALUE)",
        takes: 2..=2,
        outcomes: &[],
        raises: false,
        own: true,
        doc: "Gives a variable of the machine a value, worked out at this tick; stacks see it at once, triggers at the next tick.",
        words: &[],
    },
    Verb {
        name: "clear",
        form: "clear(NAME)",
        takes: 1..=1,
        outcomes: &[],
        raises: false,
        own: true,
        doc: "Makes a variable absent that is declared with `?`.",
        words: &[],
    },
    Verb {
        name: "tare",
        form: "tare(SIGNAL)",
        takes: 1..=1,
        outcomes: &[],
        raises: false,
        own: true,
        doc: "Makes the present reading of a wrench its bias, so that it reads zero.",
        words: &[],
    },
];

/// Looks up the verb of an action and checks its arguments.
///
/// # Errors
/// The verb is unknown or has wrong arguments; `None` if that was reported.
pub(super) fn verb(a: &Action) -> Result<&'static Verb, Refused> {
    if a.verb.value.is_empty() {
        return Err(None);
    }
    let names = || VERBS.iter().map(|v| v.name);
    let Some(verb) = VERBS.iter().find(|v| v.name == a.verb.value) else {
        let text = format!("there is no action `{}`", a.verb.value);
        let d = Diagnostic::unknown_name(a.verb.span, text);
        return Err(Some(Box::new(
            d.help(format!(
                "actions are {}; `call({}, ..)` asks the host for anything else",
                list(names(), 12),
                a.verb.value
            ))
            .nearest(&a.verb.value, names()),
        )));
    };
    if let Some(named) = a.named.first() {
        let d = Diagnostic::error("HQ0310", named.key.span, format!("`{}` takes nothing by name", verb.name));
        return Err(Some(Box::new(d.help(format!("write `{}`", verb.form)))));
    }
    if !verb.takes.contains(&a.args.len()) {
        let text = format!("`{}` has another form", verb.name);
        return Err(Some(Box::new(Diagnostic::error("HQ0310", a.span, text).help(format!("write `{}`", verb.form)))));
    }
    let word = crate::forms::text_of(&a.args[0]);
    if !verb.words.is_empty() && !word.is_some_and(|w| verb.words.contains(&w)) {
        let words: Vec<String> = verb.words.iter().map(|w| format!("`{w}`")).collect();
        let text = format!("`{}` is followed by {}", verb.name, words.join(" or "));
        let d = Diagnostic::error("HQ0304", a.args[0].span, text);
        return Err(Some(Box::new(match word.and_then(|w| suggest(w, verb.words.iter().copied())) {
            Some(near) => d.meant(near),
            None => d.help(format!("write `{}`", verb.form)),
        })));
    }
    Ok(verb)
}
