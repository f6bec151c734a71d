//! The signal by which a robot is enabled.

use dsl::tree::{Value, ValueKind};
use dsl::{Diagnostic, Help, Snippet};
use names::list;

use super::Lowerer;
use crate::forms::{target, written};

impl Lowerer<'_> {
    /// Index of the signal that tells whether a robot takes commands. Reports a name of anything else.
    pub(super) fn enabling(&mut self, value: &Value) -> Option<usize> {
        let at = value.span;
        let flags = self.interface.signals.iter().filter(|s| s.kind == "flag" && !s.is_variable());
        let flags: Vec<String> = flags.map(|s| s.name.clone()).collect();
        let (shown, name) = match &value.kind {
            ValueKind::Missing => return None,
            ValueKind::Name(name) if !matches!(name.as_str(), "true" | "false") => (written(name), target(name)),
            ValueKind::Text(name) => (name.as_str(), name.as_str()),
            _ => {
                self.params.used.extend(flags);
                let d = Diagnostic::error("HQ0304", at, "a robot is enabled by a signal, and this is no name of one");
                self.push(d.help("write the name of a signal of the type `flag`, which others compute and send"));
                return None;
            }
        };
        let of = self.interface.signals.iter().position(|s| s.name == name);
        let declared = of.map(|of| &self.interface.signals[of]);
        if declared.is_some_and(|s| s.kind == "flag" && !s.is_variable()) {
            self.params.used.insert(name.to_string());
            return of;
        }
        let d = match declared {
            None if self.params.failed.contains(name) => return None,
            None if self.params.events.contains_key(name) => Diagnostic::error(
                "HQ0304",
                at,
                format!("`{shown}` is an event, and a robot is enabled by a signal that lasts"),
            ),
            None => Diagnostic::undeclared("signal", shown, at),
            Some(s) if s.is_variable() => {
                Diagnostic::error("HQ0304", at, format!("`{shown}` is a variable, which the machine sets itself"))
                    .note("a machine that stands still cannot let itself go on")
            }
            Some(s) => {
                let text =
                    format!("`{shown}` is a signal of the type `{}`, and a robot is enabled by a `flag`", s.kind);
                Diagnostic::error("HQ0304", at, text)
            }
        };
        // One of them was meant, or this one.
        self.params.used.extend(flags.iter().cloned().chain([name.to_string()]));
        let names = flags.iter().map(String::as_str);
        let is_taken = declared.is_some() || self.params.events.contains_key(name);
        self.push(match (flags.is_empty(), is_taken) {
            (true, false) => d.help(Help::with("declare it: {}", [Snippet::of_type("signal", shown, "flag")])),
            (true, true) => {
                d.help(Help::with("declare one that others send: {}", [Snippet::of_type("signal", "NAME", "flag")]))
            }
            (false, false) => d.one_of("flags are", shown, names),
            (false, true) => d.help(format!("flags are {}", list(names, 12))),
        });
        None
    }
}
