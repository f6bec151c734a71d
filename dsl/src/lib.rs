//! The Hierarq language: two syntaxes, one tree with source locations.
//!
//! [`parse`] reads a `*.hq` or `*.yaml` text into a [`tree::Spec`] together with all diagnostics; [`print`] writes a
//! tree in either syntax. No other crate uses pest or a YAML library.

mod actions;
mod calls;
mod checks;
pub mod codes;
mod comments;
pub mod diagnostic;
mod explain;
mod expr;
pub mod fix;
mod formulas;
mod grammar;
pub mod holes;
mod hq;
pub mod limits;
mod missions;
mod normalised;
mod numbers;
mod print;
pub mod span;
mod transitions;
pub mod tree;
pub mod vocabulary;
mod words;
mod yaml;

pub use blocks::{Help, Snippet};
pub use diagnostic::{Diagnostic, Label, Severity, Topic};
pub use fix::{Applicability, Change, Edit, Fix};
pub use span::{SourceId, SourceText, Sources, Span, Spanned};

/// The two syntaxes of the language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Syntax {
    /// The native language, `*.hq`.
    Native,
    /// YAML, `*.yaml` or `*.yml`.
    Yaml,
}

impl Syntax {
    /// Returns the syntax for the extension of a file name.
    pub fn of_path(path: &std::path::Path) -> Option<Syntax> {
        match path.extension()?.to_str()? {
            "hq" => Some(Syntax::Native),
            "yaml" | "yml" => Some(Syntax::Yaml),
            _ => None,
        }
    }
}

/// Reads a text. The tree contains everything that could be read, with [`tree::ValueKind::Missing`] for invalid values.
/// The diagnostics contain every syntactic error that was found, in the order of the text.
pub fn parse(source: SourceId, text: &str, syntax: Syntax) -> (tree::Spec, Vec<Diagnostic>) {
    match syntax {
        Syntax::Native => hq::parse(source, text),
        Syntax::Yaml => yaml::parse(source, text),
    }
}

/// Formats the trigger of a transition on one line, in the native syntax: `when norm(right_ft.force) < 3 N for 3 s`.
pub fn trigger_text(transition: &tree::Transition) -> String {
    print::trigger_text(transition)
}

/// Prints a tree in a syntax, including its comments.
pub fn print(spec: &tree::Spec, syntax: Syntax) -> String {
    match syntax {
        Syntax::Native => print::hq(spec),
        Syntax::Yaml => print::yaml(spec),
    }
}

/// Formats an expression on one line, as the printer of `*.hq` files writes it.
pub fn expression_text(value: &tree::Value) -> String {
    print::expression(value)
}

/// Formats a formula on one line, as the printers write it in either syntax.
pub fn formula_text(formula: &tree::Formula) -> String {
    print::formula(formula)
}
