//! Diagnostics: error, location, reason, and proposed correction.

use crate::span::Span;

/// Severity of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The spec is rejected.
    Error,
    /// The spec is accepted, but a part of it is probably a mistake.
    Warning,
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
    /// First line: the error, in the reader's terms.
    pub message: String,
    /// Location of the error.
    pub primary: Label,
    /// Other relevant locations, in any file.
    pub labels: Vec<Label>,
    /// Reasons.
    pub notes: Vec<String>,
    /// Proposed correction.
    pub help: Option<String>,
}

impl Diagnostic {
    /// Creates an error at a location.
    pub fn error(code: &'static str, span: Span, message: impl Into<String>) -> Self {
        Diagnostic {
            code,
            severity: Severity::Error,
            message: message.into(),
            primary: Label { span, text: String::new() },
            labels: Vec::new(),
            notes: Vec::new(),
            help: None,
        }
    }

    /// Creates a warning at a location.
    pub fn warning(code: &'static str, span: Span, message: impl Into<String>) -> Self {
        Diagnostic { severity: Severity::Warning, ..Diagnostic::error(code, span, message) }
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

    /// Sets the proposed correction.
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }
}

/// Shortens a piece of text for quoting in a message.
pub(crate) fn clip(text: &str) -> String {
    let line = text.lines().next().unwrap_or("");
    if line.chars().count() <= 40 { line.to_owned() } else { line.chars().take(37).chain("...".chars()).collect() }
}
