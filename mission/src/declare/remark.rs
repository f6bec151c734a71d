//! Errors and warnings about a declaration, with the places of their texts.

use std::ops::Range;

use blocks::{Help, Origin};
use names::{list, suggest};

/// An error or a warning about a declared mission.
#[derive(Clone, Debug)]
pub struct Remark {
    /// Code of the diagnostic, such as `HQ0901`.
    pub code: &'static str,
    /// True for an error, false for a warning.
    pub is_error: bool,
    /// Place of the text that it is about.
    pub at: Origin,
    /// Bytes of the file that is named there, if it is about the content of the file.
    pub within: Option<Range<usize>>,
    /// Its subject.
    pub about: About,
    /// The mistake, in a sentence.
    pub text: String,
    /// Other places.
    pub labels: Vec<RemarkLabel>,
    /// Reasons.
    pub notes: Vec<String>,
    /// A way out.
    pub help: Option<Advice>,
}

/// Topic of a remark, which decides whether it follows from a syntax error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum About {
    /// A name that nothing declares.
    UnknownName,
    /// Members that the mission lacks.
    Nothing,
    /// Anything else.
    Other,
}

/// Another place that a remark shows.
#[derive(Clone, Debug)]
pub struct RemarkLabel {
    /// The place.
    pub at: Origin,
    /// Words for it.
    pub text: String,
}

/// A way out of a mistake.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Advice {
    /// In words.
    Text(Help),
    /// This name was meant at the place of the remark.
    Meant(String),
}

impl Remark {
    /// Creates an error.
    pub fn error(code: &'static str, at: Origin, text: impl Into<String>) -> Remark {
        let text = text.into();
        Remark {
            code,
            is_error: true,
            at,
            within: None,
            about: About::Other,
            text,
            labels: Vec::new(),
            notes: Vec::new(),
            help: None,
        }
    }

    /// Creates a warning.
    pub fn warning(code: &'static str, at: Origin, text: impl Into<String>) -> Remark {
        Remark { is_error: false, ..Remark::error(code, at, text) }
    }

    /// Creates the error for a name that nothing has. `what` is a noun, with ` of ` and a whole behind it if there is one.
    pub fn unknown(what: &str, name: &str, at: Origin, known: &[&str]) -> Remark {
        let text = match what.split_once(" of ") {
            Some((what, whole)) => format!("there is no {what} `{name}` of {whole}"),
            None => format!("there is no {what} `{name}`"),
        };
        let remark = Remark { about: About::UnknownName, ..Remark::error("HQ0201", at, text) };
        match suggest(name, known.iter().copied()) {
            Some(near) => remark.meant(near),
            None if known.is_empty() => remark.help(format!("this spec declares no {what}")),
            None => remark.help(format!("declared are {}", list(known.iter().copied(), 12))),
        }
    }

    /// The same remark about these bytes of the file that is named at its place.
    pub fn inside(self, within: Range<usize>) -> Remark {
        Remark { within: Some(within), ..self }
    }

    /// Adds another place.
    pub fn label(mut self, at: Origin, text: impl Into<String>) -> Remark {
        self.labels.push(RemarkLabel { at, text: text.into() });
        self
    }

    /// Adds a reason.
    pub fn note(mut self, text: impl Into<String>) -> Remark {
        self.notes.push(text.into());
        self
    }

    /// Creates the error for a mission that lacks members.
    pub fn lacking(code: &'static str, at: Origin, text: impl Into<String>) -> Remark {
        Remark { about: About::Nothing, ..Remark::error(code, at, text) }
    }

    /// Sets the way out, in words.
    pub fn help(mut self, text: impl Into<Help>) -> Remark {
        self.help = Some(Advice::Text(text.into()));
        self
    }

    /// Sets the way out: another name.
    pub fn meant(mut self, name: &str) -> Remark {
        self.help = Some(Advice::Meant(name.into()));
        self
    }

    /// Sets the way out: the name that is near, or else words.
    pub fn meant_or(self, near: Option<&str>, otherwise: impl Into<Help>) -> Remark {
        match near {
            Some(near) => self.meant(near),
            None => self.help(otherwise),
        }
    }
}

/// Everything that is wrong with a declared mission, or hardly meant.
#[derive(Clone, Debug, Default)]
pub struct Remarks {
    /// In the order found.
    pub all: Vec<Remark>,
}

impl Remarks {
    /// Adds a remark.
    pub fn push(&mut self, remark: Remark) {
        self.all.push(remark);
    }

    /// Returns true if there is an error.
    pub fn has_error(&self) -> bool {
        self.all.iter().any(|remark| remark.is_error)
    }
}
