//! Reader of signals and variables in YAML.

use super::Reader;
use super::events::{Kind, NodeId};
use crate::diagnostic::clip;
use crate::tree::{Block, Comments, Signal, Value, ValueKind, Variable};
use crate::words::{is_name, nearest};
use crate::{Diagnostic, Span, Spanned, calls, checks, transitions};

impl Reader<'_> {
    /// Reads `point?`, or `{ type: point?, timeout: 0.5 s }`.
    pub(super) fn signal(&mut self, name: &Spanned<String>, id: NodeId, comments: &mut Comments) -> Signal {
        let mut settings = Block { span: self.span(id), ..Block::default() };
        let mut ty = None;
        if matches!(self.node(id).kind, Kind::Mapping(_)) {
            for (key, value) in self.distinct(id) {
                if key.value == "type" {
                    self.pool.before(key.span.range().start, &mut comments.before);
                    ty = Some(value);
                    self.pool.behind(self.later(value, key.span).range().end, &[','], &mut comments.behind);
                } else {
                    let entry = self.setting(key, value);
                    settings.entries.push(entry);
                }
            }
            self.closing(id, &mut settings.closing_comments);
            checks::reserved(&mut settings, &[], "signal", &mut self.diags);
        } else {
            ty = Some(id);
        }
        let read = ty.filter(|id| !self.is_null(*id)).map(|id| self.signal_type(id));
        if read.is_none() {
            self.diags.push(transitions::no_type(&name.value, name.span));
        }
        let (ty, optional) = read.flatten().unwrap_or_else(|| (calls::nameless(name.span), None));
        Signal { name: name.clone(), ty, optional, settings }
    }

    /// Reads `point?`, or `{ type: number, value: 0 }`.
    pub(super) fn variable(&mut self, name: &Spanned<String>, id: NodeId, comments: &mut Comments) -> Variable {
        let (mut ty, mut value) = (None, None);
        if matches!(self.node(id).kind, Kind::Mapping(_)) {
            for (key, node) in self.distinct(id) {
                match key.value.as_str() {
                    "type" | "value" => {
                        self.pool.before(key.span.range().start, &mut comments.before);
                        if key.value == "type" {
                            ty = Some(node);
                        } else {
                            let read = self.value(node, Some(&key));
                            value = (!self.is_null(node)).then_some(read);
                        }
                        self.pool.behind(self.later(node, key.span).range().end, &[','], &mut comments.behind);
                    }
                    other => {
                        value.get_or_insert(Value { kind: ValueKind::Missing, span: key.span });
                        let text = format!("`{}` is not a key of a variable", clip(other));
                        let d = Diagnostic::error("HQ0121", key.span, text);
                        self.diags.push(match nearest(other, &["type", "value"]) {
                            Some(near) => d.meant(near),
                            None => d.help("write `{ type: number, value: 0 }`"),
                        });
                    }
                }
            }
        } else {
            ty = Some(id);
        }
        let read = ty.filter(|id| !self.is_null(*id)).map(|id| self.signal_type(id));
        if read.is_none() {
            self.diags.push(transitions::no_variable_type(&name.value, name.span));
        }
        let (ty, optional) = read.flatten().unwrap_or_else(|| (calls::nameless(name.span), None));
        if let Some(Value { kind: kind @ ValueKind::Block(_), span }) = &mut value {
            let d = Diagnostic::error("HQ0104", *span, "a variable holds a value, and these are keys");
            self.diags.push(d.help("write the initial value, such as `value: 0`"));
            *kind = ValueKind::Missing;
        }
        Variable { name: name.clone(), ty, optional, value }
    }

    /// Reads `point` or `point?`: the type, and the location of the `?`.
    fn signal_type(&mut self, id: NodeId) -> Option<(Spanned<String>, Option<Span>)> {
        if self.scalar(id).is_none() {
            self.wrong_shape(id, "the type of a signal", "write for instance `point` or `point?`");
            return None;
        }
        let (text, place) = self.spelled(id);
        let word = text.strip_suffix('?').unwrap_or(&text);
        if !is_name(word) {
            self.diags.push(transitions::bad_type(&text, self.span(id)));
            return None;
        }
        let optional = (word.len() < text.len()).then(|| place.span(word.len(), text.len()));
        Some((Spanned::new(word.to_owned(), place.span(0, word.len())), optional))
    }
}
