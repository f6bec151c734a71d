//! Reader of allowed warnings in `*.hq` texts: `allow HQ0606 "the tray is soft on purpose"`.

use super::Reader;
use crate::explain::After;
use crate::expr::{missing, unescape};
use crate::grammar::{Pair, Rule};
use crate::tree::{Allow, Block, Comments, Entry, Item, ItemKind, Value, ValueKind};
use crate::vocabulary::ALLOW;
use crate::{Spanned, checks};

impl Reader<'_> {
    /// Converts a node `allow` at the top of a file.
    pub(super) fn allowed(&mut self, pair: Pair<'_>, items: &mut Vec<Item>) {
        let (keyword, entry) = self.allowance(pair);
        let span = keyword.span.to(entry.value.span);
        items.push(Item {
            kind: ItemKind::Allow(Allow { code: entry.key, reason: entry.value }),
            span,
            comments: entry.comments,
        });
    }

    /// Converts a node `allow` in a block. The entry `allow` of the block has all its codes.
    pub(super) fn allow(&mut self, pair: Pair<'_>, entries: &mut Vec<Entry>) {
        let (key, entry) = self.allowance(pair);
        let span = key.span.to(entry.value.span);
        let known = entries.iter_mut().find_map(|known| match &mut known.value {
            Value { kind: ValueKind::Block(block), span } if known.key.value == ALLOW => Some((block, span)),
            _ => None,
        });
        match known {
            Some((block, whole)) => {
                if let Some(first) = block.get(&entry.key.value) {
                    self.diags.push(checks::duplicate(&entry.key.value, first.key.span, entry.key.span));
                }
                block.entries.push(entry);
                *whole = whole.to(span);
                block.span = *whole;
            }
            None => {
                let span = entry.key.span.to(entry.value.span);
                let block = Block { entries: vec![entry], span, ..Block::default() };
                let value = Value { kind: ValueKind::Block(block), span };
                entries.push(Entry { key, value, comments: Comments::default() });
            }
        }
    }

    /// Returns the keyword, and the code with its reason as an entry.
    fn allowance(&mut self, pair: Pair<'_>) -> (Spanned<String>, Entry) {
        let start = self.of(&pair).range().start;
        let mut key = Spanned::new(ALLOW.to_owned(), self.span(start, start + ALLOW.len()));
        let mut comments = Comments::default();
        self.pool.before(start, &mut comments.before);
        let (mut code, mut reason) = (Spanned::new(String::new(), key.span), missing(key.span));
        for part in pair.into_inner() {
            let span = self.of(&part);
            match part.as_rule() {
                Rule::allow_word => key.span = span,
                Rule::name => {
                    code = self.place().spanned(&part);
                    reason = missing(span);
                }
                Rule::text => {
                    let text = unescape(&part, self.place(), &mut self.diags);
                    reason = Value { kind: ValueKind::Text(text), span };
                }
                _ => {
                    self.unread.push(span);
                    self.junk(span, After::Value(&reason));
                    // The reason, with quotes that are missing.
                    let text = self.text[span.range()].trim_end().to_owned();
                    reason = Value { kind: ValueKind::Text(text), span };
                }
            }
        }
        self.pool.behind(reason.span.range().end, &[',', ';'], &mut comments.behind);
        (key, Entry { key: code, value: reason, comments })
    }
}
