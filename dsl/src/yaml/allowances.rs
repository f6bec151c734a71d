//! Reader of allowed warnings in YAML: `allow: { HQ0606: the tray is soft on purpose }`.

use super::Reader;
use super::events::{Kind, NodeId};
use crate::Span;
use crate::expr::missing;
use crate::tree::{Block, Value, ValueKind};

impl Reader<'_> {
    /// Reads codes with their reasons, which are texts.
    pub(super) fn allowances(&mut self, id: NodeId) -> Block {
        self.entries(id, Self::key, |reader, value, code| reader.reason(value, code.span))
    }

    /// Reads a reason. The compiler reports one that is missing.
    pub(super) fn reason(&mut self, id: NodeId, code: Span) -> Value {
        let span = self.later(id, code);
        match &self.node(id).kind {
            Kind::Scalar(..) if self.is_null(id) => missing(code),
            Kind::Scalar(text, _) => Value { kind: ValueKind::Text(text.clone()), span },
            _ => {
                self.wrong_shape(id, "a text", "write the reason after the code");
                missing(span)
            }
        }
    }
}
