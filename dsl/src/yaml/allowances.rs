//! Reader of allowed warnings in YAML: `allow: { HQ0606: the tray is soft on purpose }`.

use super::Reader;
use super::events::{Kind, NodeId};
use crate::expr::missing;
use crate::tree::{Block, Entry, Value, ValueKind};
use crate::{Span, checks};

impl Reader<'_> {
    /// Reads codes with their reasons, which are texts.
    pub(super) fn allowances(&mut self, id: NodeId) -> Block {
        let mut block = Block { span: self.span(id), ..Block::default() };
        if !self.enter(id) {
            return block;
        }
        self.depth += 1;
        for (code, value) in self.pairs(id) {
            let Some(key) = self.key(code) else { continue };
            let mut comments = self.key_comments(key.span);
            let end = self.later(value, key.span).range().end;
            let value = self.reason(value, key.span);
            self.pool.before(end, &mut comments.before);
            self.pool.behind(end, &[','], &mut comments.behind);
            block.entries.push(Entry { key, value, comments });
        }
        self.depth -= 1;
        self.closing(id, &mut block.closing_comments);
        checks::duplicates(&block.entries, &mut self.diags);
        block
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
