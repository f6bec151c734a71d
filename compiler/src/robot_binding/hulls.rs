//! Links whose collision shapes are hulls in place of capsules.

use dsl::tree::Value;
use dsl::{Diagnostic, Help, Snippet, Spanned};
use robot::Model;

use super::lookup::unknown_link;
use crate::forms::text_of;

/// The word for all links.
const ALL: &str = "all";

/// Links that `hulls` names.
pub(super) struct Hulls(Vec<Spanned<String>>);

impl Hulls {
    /// Reads `hulls [base_link]` or `hulls all`.
    pub(super) fn read(value: Option<&Value>, diagnostics: &mut Vec<Diagnostic>) -> Hulls {
        let mut names = Vec::new();
        for item in value.map_or(&[][..], Value::items) {
            match text_of(item) {
                Some(name) => names.push(Spanned::new(name.to_string(), item.span)),
                None => {
                    let d = Diagnostic::error("HQ0304", item.span, "the name of a link is needed here");
                    diagnostics.push(d.help(Help::with(
                        "write for instance {} or {}",
                        [Snippet::entry("hulls", "[base_link]"), Snippet::entry("hulls", ALL)],
                    )));
                }
            }
        }
        Hulls(names)
    }

    /// The option of the reader of URDFs.
    pub(super) fn option(&self) -> robot::Hulls {
        match self.0.as_slice() {
            [] => robot::Hulls::None,
            names if names.iter().any(|n| n.value == ALL) => robot::Hulls::All,
            names => robot::Hulls::Of(names.iter().map(|n| n.value.clone()).collect()),
        }
    }

    /// Reports names that are those of no link.
    pub(super) fn check(&self, model: &Model, diagnostics: &mut Vec<Diagnostic>) {
        for name in self.0.iter().filter(|n| n.value != ALL) {
            if model.link(&name.value).is_none() {
                diagnostics.push(unknown_link(model, &name.value, name.span, &[]));
            }
        }
    }
}
