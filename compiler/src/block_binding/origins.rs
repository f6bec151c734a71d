//! Places of bound texts: the spans behind the numbers that bound blocks carry, and the values that are bound elsewhere.

use std::collections::BTreeMap;

use blocks::{Located, Origin, Unbound};
use dsl::tree::Value;
use dsl::{SourceId, Span};

/// Places of bound texts.
#[derive(Debug, Default)]
pub(crate) struct Origins {
    spans: Vec<Span>,
    /// Sources of the files that are named at a place.
    files: BTreeMap<Origin, SourceId>,
    /// Values that are bound elsewhere.
    unbound: BTreeMap<Origin, Value>,
}

impl Origins {
    /// Adds a place.
    pub fn add(&mut self, span: Span) -> Origin {
        self.spans.push(span);
        Origin((self.spans.len() - 1) as u32)
    }

    /// Adds a place that names a file.
    pub fn add_file(&mut self, span: Span, source: SourceId) -> Origin {
        let at = self.add(span);
        self.files.insert(at, source);
        at
    }

    /// Adds the place of a value that is bound elsewhere.
    pub fn add_unbound(&mut self, value: &Value) -> Origin {
        let at = self.add(value.span);
        self.unbound.insert(at, value.clone());
        at
    }

    /// Returns the value at a place that is bound elsewhere.
    pub fn unbound(&self, of: &Located<Unbound>) -> Option<&Value> {
        self.unbound.get(&of.at)
    }

    /// Returns the span of a place.
    pub fn span(&self, at: Origin) -> Span {
        self.spans.get(at.0 as usize).copied().unwrap_or_default()
    }

    /// Returns the source of the file that is named at a place.
    pub fn file(&self, at: Origin) -> Option<SourceId> {
        self.files.get(&at).copied()
    }
}
