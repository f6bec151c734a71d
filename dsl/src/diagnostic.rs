//! Diagnostics: error, location, reason, and proposed corrections.
//!
//! A diagnostic is data. Its [`Topic`] tells later stages whether it follows from another one, its [`Fix`]es are
//! edits, and its [`Help`] names pieces of a spec that are written in the syntax of the file.

use ::names::{list, suggest};
use blocks::Help;

use crate::Syntax;
use crate::fix::Fix;
use crate::span::{Sources, Span};

/// Severity of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The spec is rejected.
    Error,
    /// The spec is accepted, but a part of it is probably a mistake.
    Warning,
}

/// Topic of a diagnostic, for code that decides whether it follows from another diagnostic.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Topic {
    /// Anything else.
    #[default]
    Other,
    /// The header of the file, which has no consequences.
    Header,
    /// A key that its block does not have; its value was not read.
    UnknownKey,
    /// A name that nothing declares.
    UnknownName,
    /// Keys that are required and missing.
    MissingKeys(Vec<String>),
    /// A robot, which the spec does not declare.
    MissingRobot,
    /// A stack, which the spec does not declare.
    MissingStack,
    /// The contents of a declaration: the levels of a stack, the members of a mission.
    MissingDeclaration,
    /// A declared name that nothing uses.
    Unused,
    /// A construct without its name, its value, its block or its entries.
    Incomplete,
    /// A bracket that is not closed.
    OpenBracket,
    /// A bracket that closes nothing.
    LooseBracket,
    /// Text in an expression that cannot be read there.
    Unreadable,
    /// A word after a number that is not a unit.
    UnknownUnit,
    /// An angle without a unit.
    BareAngle,
    /// A number whose unit measures another quantity.
    Dimension,
    /// A number whose size is unusual.
    UnusualSize,
}

/// A labelled location in a diagnostic.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// The location.
    pub span: Span,
    /// Text of the label; may be empty for the primary location.
    pub text: String,
}

/// One message.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// Stable code such as `HQ0301`; [`crate::codes`] and the compiler's table explain it.
    pub code: &'static str,
    /// Error or warning.
    pub severity: Severity,
    /// Its topic.
    pub topic: Topic,
    /// First line: the error, in the reader's terms.
    pub message: String,
    /// Location of the error.
    pub primary: Label,
    /// Other relevant locations, in any file.
    pub labels: Vec<Label>,
    /// Reasons.
    pub notes: Vec<String>,
    /// Proposed correction, in words.
    pub help: Option<Help>,
    /// Proposed corrections as edits, the most likely first.
    pub fixes: Vec<Fix>,
}

impl Diagnostic {
    /// Creates an error at a location.
    pub fn error(code: &'static str, span: Span, message: impl Into<String>) -> Self {
        Diagnostic {
            code,
            severity: Severity::Error,
            topic: Topic::Other,
            message: message.into(),
            primary: Label { span, text: String::new() },
            labels: Vec::new(),
            notes: Vec::new(),
            help: None,
            fixes: Vec::new(),
        }
    }

    /// Creates a warning at a location.
    pub fn warning(code: &'static str, span: Span, message: impl Into<String>) -> Self {
        Diagnostic { severity: Severity::Warning, ..Diagnostic::error(code, span, message) }
    }

    /// Creates the error for a name that nothing declares.
    pub fn unknown_name(span: Span, message: impl Into<String>) -> Self {
        Diagnostic::error("HQ0201", span, message).about(Topic::UnknownName)
    }

    /// Creates the error for the name of something that nothing declares: "there is no task `reech`".
    pub fn undeclared(what: &str, name: &str, span: Span) -> Self {
        Diagnostic::unknown_name(span, format!("there is no {what} `{name}`"))
    }

    /// Creates the error for a key that its block does not have.
    pub fn unknown_key(code: &'static str, span: Span, message: impl Into<String>) -> Self {
        Diagnostic::error(code, span, message).about(Topic::UnknownKey)
    }

    /// Creates the error for a construct that is incomplete.
    pub fn incomplete(code: &'static str, span: Span, message: impl Into<String>) -> Self {
        Diagnostic::error(code, span, message).about(Topic::Incomplete)
    }

    /// Creates the error for text in an expression that cannot be read.
    pub fn unreadable(code: &'static str, span: Span, message: impl Into<String>) -> Self {
        Diagnostic::error(code, span, message).about(Topic::Unreadable)
    }

    /// Creates the warning for a declared name that nothing uses.
    pub fn unused(span: Span, message: impl Into<String>) -> Self {
        Diagnostic::warning("HQ0203", span, message).about(Topic::Unused)
    }

    /// Creates the error for required keys that are missing.
    pub fn missing_keys<'k>(keys: impl IntoIterator<Item = &'k str>, span: Span, message: impl Into<String>) -> Self {
        let keys = keys.into_iter().map(str::to_string).collect();
        Diagnostic::error("HQ0206", span, message).about(Topic::MissingKeys(keys))
    }

    /// Sets the topic.
    pub fn about(mut self, topic: Topic) -> Self {
        self.topic = topic;
        self
    }

    /// Sets the text of the primary label.
    pub fn here(mut self, text: impl Into<String>) -> Self {
        self.primary.text = text.into();
        self
    }

    /// Adds a label at another location.
    pub fn label(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(Label { span, text: text.into() });
        self
    }

    /// Adds a reason.
    pub fn note(mut self, text: impl Into<String>) -> Self {
        self.notes.push(text.into());
        self
    }

    /// Sets the proposed correction in words.
    pub fn help(mut self, help: impl Into<Help>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Adds a correction as edits.
    pub fn fix(mut self, fix: Fix) -> Self {
        // Of the many diagnostics that a text can have, most have one fix or none.
        self.fixes.reserve_exact(1);
        self.fixes.push(fix);
        self
    }

    /// Proposes the name that was probably meant at the primary location, in words and as an edit.
    pub fn meant(self, name: impl Into<String>) -> Self {
        let name = name.into();
        let span = self.primary.span;
        self.help(format!("did you mean `{name}`?")).fix(Fix::name(span, name))
    }

    /// Proposes the known name that was probably meant. If none is near enough, the help stays as it is.
    pub fn nearest<'n>(self, name: &str, known: impl IntoIterator<Item = &'n str>) -> Self {
        match suggest(name, known) {
            Some(near) => self.meant(near),
            None => self,
        }
    }

    /// Proposes the known name that was probably meant, or else all of them after some words: "declared are `a` and `b`".
    /// If there are none, a help that it has stays as it is.
    pub fn one_of<'n>(self, words: &str, name: &str, known: impl IntoIterator<Item = &'n str>) -> Self {
        let known: Vec<&str> = known.into_iter().collect();
        match known.is_empty() && self.help.is_some() {
            true => self,
            false => self.help(format!("{words} {}", list(known.iter().copied(), 12))).nearest(name, known),
        }
    }

    /// Proposes a name for the primary location that is the name of something else: "did you mean the group `arm`?".
    pub fn meant_as(self, what: &str, name: impl Into<String>) -> Self {
        let name = name.into();
        let span = self.primary.span;
        self.help(format!("did you mean {what} `{name}`?")).fix(Fix::name(span, name))
    }

    /// Proposes a text for the primary location, in words and as an edit.
    pub fn write(self, text: impl Into<String>) -> Self {
        let text = text.into();
        let span = self.primary.span;
        self.help(format!("write `{text}`")).fix(Fix::replace(span, text))
    }

    /// Marks the last correction as the one that the author certainly means.
    pub fn certain(mut self) -> Self {
        let last = self.fixes.pop().map(Fix::certain);
        self.fixes.extend(last);
        self
    }

    /// Writes the help in a syntax, and computes the edits of the fixes. Fixes without a place in the original text are
    /// dropped.
    pub fn settle(&mut self, sources: &Sources, syntax: Syntax) {
        self.help = self.help.take().map(|help| match syntax {
            Syntax::Native => help.in_native(),
            Syntax::Yaml => help.in_yaml(),
        });
        let fixes = std::mem::take(&mut self.fixes);
        self.fixes = fixes.into_iter().filter_map(|fix| fix.settled(sources, syntax)).collect();
    }
}

/// Shortens a piece of text for quoting in a message.
pub(crate) fn clip(text: &str) -> String {
    let line = text.lines().next().unwrap_or("");
    if line.chars().count() <= 40 { line.to_owned() } else { line.chars().take(37).chain("...".chars()).collect() }
}
