//! Reader of the YAML syntax: it has the same words and expressions as the native one, and builds the same tree.

mod allowances;
mod events;
mod items;
mod levels;
mod machines;
mod missions;
mod quotes;
mod repeat;
mod reuse;
mod scalars;
mod scenarios;
mod signals;
mod syntax;
mod transitions;

use crate::comments::Pool;
use crate::diagnostic::Topic;
use crate::diagnostic::clip;
use crate::explain;
use crate::expr::missing;
use crate::limits::{MAX_DEPTH, MAX_NODES, check_size, too_deep};
use crate::tree::{Block, Comments, Entry, Spec, Value, ValueKind};
use crate::vocabulary::ALLOW;
use crate::words::{is_name, is_quoted_key, is_text_key};
use crate::{Diagnostic, Help, SourceId, Span, Spanned, checks};
use events::{Document, Kind, Node, NodeId, Style};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

/// Reads a text.
pub(crate) fn parse(source: SourceId, text: &str) -> (Spec, Vec<Diagnostic>) {
    if let Some(refusal) = check_size(source, text) {
        return (Spec::default(), vec![refusal]);
    }
    let (mut document, diags) = events::read(source, text);
    let pool = Pool::new(text, std::mem::take(&mut document.comments));
    let mut broken: Vec<u32> = diags.iter().map(|d| d.primary.span.start).collect();
    broken.sort_unstable();
    let mut reader =
        Reader { source, text, document, pool, diags, broken, unread: Vec::new(), visited: 0, depth: 0, states: 0 };
    let mut spec = reader.spec();
    let left_out = std::mem::take(&mut reader.document.left_out);
    spec.unread = std::mem::take(&mut reader.unread);
    spec.unread.extend(left_out.iter().map(|gone| Span::new(source, gone.start, gone.end)));
    let gaps: Vec<Gap> = left_out.iter().filter_map(|gone| Gap::before(text, gone.start)).collect();
    reader.diags.retain(|d| !gaps.iter().any(|gap| gap.explains(d, text)));
    let mut diags = checks::finish(reader.diags);
    for d in &mut diags {
        d.help = d.help.take().map(Help::in_yaml);
    }
    (spec, diags)
}

/// The last line with content above a range of lines that could not be read.
struct Gap {
    line: Range<usize>,
    /// Indentation of that line.
    indent: usize,
    /// Indentation of the unreadable lines.
    below: usize,
    /// Start of the unreadable lines.
    end: usize,
}

impl Gap {
    /// Returns the gap that ends at byte `end`, which must be the first byte of a line.
    fn before(text: &str, end: usize) -> Option<Gap> {
        let indent = |rest: &str| rest.len() - rest.trim_start_matches([' ', '\t']).len();
        let line = syntax::line_of(text, text.get(..end)?.trim_end().len());
        Some(Gap { indent: indent(&text[line.start..]), below: indent(&text[end..]), line, end })
    }

    /// Returns true if a diagnostic reports an element as missing only because the lines after it could not be read.
    fn explains(&self, diagnostic: &Diagnostic, text: &str) -> bool {
        let at = diagnostic.primary.span.range();
        if !matches!(diagnostic.topic, Topic::Header | Topic::Incomplete)
            || !(self.line.start..self.end).contains(&at.start)
        {
            return false;
        }
        let behind = text.get(at.end.min(self.line.end)..self.line.end);
        let alone = behind.is_some_and(|t| t.trim().trim_end_matches(':').is_empty());
        alone || self.below > self.indent
    }
}

/// State while reading one text.
struct Reader<'t> {
    source: SourceId,
    text: &'t str,
    document: Document,
    pool: Pool<'t>,
    diags: Vec<Diagnostic>,
    /// Positions of the YAML syntax errors, in the order of the text.
    broken: Vec<u32>,
    /// Text that could not be interpreted.
    unread: Vec<Span>,
    /// Nodes visited so far, aliases counted every time.
    visited: usize,
    depth: usize,
    /// Number of nested `states`.
    states: usize,
}

impl Reader<'_> {
    fn node(&self, id: NodeId) -> &Node {
        &self.document.nodes[id]
    }

    fn span(&self, id: NodeId) -> Span {
        self.document.nodes[id].span
    }

    /// Returns true if a span contains a YAML syntax error.
    fn broken_in(&self, span: Span) -> bool {
        let first = self.broken.partition_point(|&start| start < span.start);
        self.broken.get(first).is_some_and(|&start| start < span.end)
    }

    /// Counts a visit of a node; returns false if the text exceeds the limits.
    fn enter(&mut self, id: NodeId) -> bool {
        self.visited += 1;
        if self.visited == MAX_NODES + 1 {
            self.diags.push(
                Diagnostic::error(
                    "HQ0134",
                    self.span(id),
                    format!("the aliases expand to more than {MAX_NODES} nodes"),
                )
                .here("read up to here")
                .help("repeat less, or name the repeated part with `params` or `tasks`"),
            );
        }
        if self.depth >= MAX_DEPTH {
            self.diags.push(too_deep(self.span(id)));
            return false;
        }
        self.visited <= MAX_NODES
    }

    /// Returns the span of a node's first character, the location of messages about missing parts of the whole node.
    fn first_character(&self, id: NodeId) -> Span {
        let span = self.span(id);
        let length = self.text.get(span.range()).and_then(|t| t.chars().next()).map_or(0, char::len_utf8);
        Span { end: span.start + length as u32, ..span }
    }

    /// Returns the text of a scalar.
    fn scalar(&self, id: NodeId) -> Option<(&str, Style)> {
        match &self.node(id).kind {
            Kind::Scalar(text, style) => Some((text, *style)),
            _ => None,
        }
    }

    /// Returns true for an empty value, and for `~` and `null` without quotes.
    fn is_null(&self, id: NodeId) -> bool {
        matches!(self.scalar(id), Some(("" | "~" | "null" | "Null" | "NULL", Style::Plain)))
    }

    fn wrong_shape(&mut self, id: NodeId, expected: &str, help: &str) {
        let found = match &self.node(id).kind {
            Kind::Scalar(..) if self.is_null(id) => "nothing",
            Kind::Scalar(..) => "a single value",
            Kind::Sequence(_) => "a sequence",
            Kind::Mapping(_) => "a mapping",
            Kind::Broken => return,
        };
        let mut span = self.span(id);
        if !matches!(self.node(id).kind, Kind::Scalar(..)) {
            let length = self.text.get(span.range()).and_then(|t| t.find('\n')).unwrap_or(span.len());
            span = Span::new(self.source, span.range().start, span.range().start + length);
        }
        self.diags.push(
            Diagnostic::error("HQ0131", span, format!("{expected} is expected here"))
                .here(format!("this is {found}"))
                .help(help),
        );
    }

    /// Returns the entries of a mapping, with `<<` merged in: its own keys take precedence, then earlier merges.
    fn pairs(&mut self, id: NodeId) -> Vec<(NodeId, NodeId)> {
        let Kind::Mapping(own) = &self.node(id).kind else { return Vec::new() };
        let own = own.clone();
        let is_merge = |reader: &Self, key: NodeId| matches!(reader.scalar(key), Some(("<<", Style::Plain)));
        if !own.iter().any(|(key, _)| is_merge(self, *key)) {
            return own;
        }
        let name = |reader: &Self, key: NodeId| reader.scalar(key).map(|s| s.0.to_owned());
        let mut known: BTreeSet<String> =
            own.iter().filter(|(k, _)| !is_merge(self, *k)).filter_map(|(k, _)| name(self, *k)).collect();
        let mut all = Vec::new();
        for (key, value) in own {
            if !is_merge(self, key) {
                all.push((key, value));
                continue;
            }
            let sources = match &self.node(value).kind {
                Kind::Mapping(_) => vec![value],
                Kind::Sequence(items) => items.clone(),
                _ => {
                    self.wrong_shape(
                        value,
                        "a mapping, or a sequence of mappings,",
                        "`<<` merges `*name`, where `&name` marks a mapping",
                    );
                    Vec::new()
                }
            };
            for source in sources {
                if !self.enter(source) {
                    return all;
                }
                if !matches!(self.node(source).kind, Kind::Mapping(_)) {
                    self.wrong_shape(source, "a mapping", "`<<` merges mappings only");
                    continue;
                }
                self.depth += 1;
                let merged = self.pairs(source);
                self.depth -= 1;
                for (key, value) in merged {
                    let Some(name) = name(self, key) else { continue };
                    if known.insert(name) {
                        all.push((key, value));
                    }
                    self.visited += 1;
                }
            }
        }
        all
    }

    /// Returns the entries of a mapping with distinct keys; the second of two equal keys is reported and skipped.
    fn distinct(&mut self, id: NodeId) -> Vec<(Spanned<String>, NodeId)> {
        let mut seen: BTreeMap<String, Span> = BTreeMap::new();
        let mut out = Vec::new();
        for (key, value) in self.pairs(id) {
            let Some(name) = self.key(key) else { continue };
            if let Some(first) = seen.get(&name.value) {
                self.diags.push(checks::duplicate(&name.value, *first, name.span));
                continue;
            }
            seen.insert(name.value.clone(), name.span);
            out.push((name, value));
        }
        out
    }

    /// Reads a key of a block: a name, a pattern of names, or a quoted name with other characters.
    fn block_key(&mut self, id: NodeId) -> Option<Spanned<String>> {
        match self.scalar(id) {
            Some((text, style)) if is_quoted_key(text) && (style == Style::Quoted || text.contains(['*', '?'])) => {
                Some(Spanned::new(text.to_owned(), self.span(id)))
            }
            Some((text, Style::Plain)) if is_quoted_key(text) => {
                let help = format!("quote the name of a joint: `\"{text}\"`");
                let name = self.key(id);
                if let Some(d) = self.diags.last_mut().filter(|_| name.is_none()) {
                    d.help = Some(help.into());
                }
                name
            }
            _ => self.key(id),
        }
    }

    /// Reads a key that must be a name.
    fn key(&mut self, id: NodeId) -> Option<Spanned<String>> {
        let span = self.span(id);
        match self.scalar(id) {
            Some((name, _)) if is_name(name) => Some(Spanned::new(name.to_owned(), span)),
            Some((other, _)) => {
                let message = format!("`{}` is not a name", clip(other));
                self.diags.push(
                    Diagnostic::error("HQ0135", span, message)
                        .note("a name has letters, digits and `_`, and does not begin with a digit"),
                );
                None
            }
            None => {
                self.wrong_shape(id, "a name", "a key is a single word");
                None
            }
        }
    }

    /// Reads a scalar that must be a name.
    fn name(&mut self, id: NodeId, what: &str) -> Option<Spanned<String>> {
        if self.scalar(id).is_none() || self.is_null(id) {
            self.wrong_shape(id, &format!("the name of {what}"), "write a single word");
            return None;
        }
        self.key(id)
    }

    /// Takes the comments around a key: those before it, and one after `key:` if the value is on later lines.
    fn key_comments(&mut self, key: Span) -> Comments {
        let mut comments = Comments::default();
        self.pool.before(key.range().start, &mut comments.before);
        self.pool.behind(key.range().end, &[':', '{', '['], &mut comments.behind);
        comments
    }

    /// Reads a mapping as a block.
    fn block(&mut self, id: NodeId) -> Block {
        self.entries(id, Self::block_key, |reader, value, key| reader.value(value, Some(key)))
    }

    /// Reads a mapping as a block, its keys and values by these readers.
    fn entries(
        &mut self,
        id: NodeId,
        read_key: impl Fn(&mut Self, NodeId) -> Option<Spanned<String>>,
        read_value: impl Fn(&mut Self, NodeId, &Spanned<String>) -> Value,
    ) -> Block {
        let mut block = Block { span: self.span(id), ..Block::default() };
        if !self.enter(id) {
            return block;
        }
        self.depth += 1;
        for (key, value) in self.pairs(id) {
            let Some(key) = read_key(self, key) else { continue };
            let mut comments = self.key_comments(key.span);
            let end = self.later(value, key.span).range().end;
            let value = read_value(self, value, &key);
            if !matches!(value.kind, ValueKind::Block(_)) {
                self.pool.before(end, &mut comments.before);
            }
            self.pool.behind(end, &[','], &mut comments.behind);
            block.entries.push(Entry { key, value, comments });
        }
        self.depth -= 1;
        self.closing(id, &mut block.closing_comments);
        checks::duplicates(&block.entries, &mut self.diags);
        block
    }

    /// Takes the comments at the end of a mapping: before its brace, or indented at least as far as its keys.
    fn closing(&mut self, id: NodeId, comments: &mut Comments) {
        let Node { span, flow, .. } = *self.node(id);
        if flow {
            self.pool.before(span.range().end.saturating_sub(1), &mut comments.before);
        } else {
            let start = span.range().start;
            let column = start - self.text[..start].rfind('\n').map_or(0, |n| n + 1);
            self.pool.indented(span.range().end, column, &mut comments.before);
        }
    }

    /// Reads an item of a sequence, with the comment after it.
    fn item(&mut self, id: NodeId, key: Option<&Spanned<String>>) -> Value {
        let mut value = self.value(id, key);
        if let ValueKind::Block(block) = &mut value.kind {
            let end = self.span(id).range().end;
            self.pool.behind(end, &[','], &mut block.closing_comments.behind);
        }
        value
    }

    /// Reads any value; `key` is the key that it belongs to.
    fn value(&mut self, id: NodeId, key: Option<&Spanned<String>>) -> Value {
        let span = self.span(id);
        let text_key = key.is_some_and(|k| is_text_key(&k.value));
        if !self.enter(id) {
            return missing(span);
        }
        match &self.node(id).kind {
            Kind::Broken => missing(span),
            Kind::Scalar(..) if self.is_null(id) => {
                let name = key.map_or("this item", |k| k.value.as_str());
                let at = if span.is_empty() { key.map_or(span, |k| k.span) } else { span };
                let help = "write the value after the colon, or delete the line";
                self.diags.push(explain::no_value(name, at).help(help));
                missing(at)
            }
            Kind::Scalar(text, _) if text_key => Value { kind: ValueKind::Text(text.clone()), span },
            Kind::Scalar(..) => self.expression(id, key),
            Kind::Sequence(items) => {
                let items = items.clone();
                self.depth += 1;
                let items = items.into_iter().map(|item| self.item(item, key)).collect();
                self.depth -= 1;
                Value { kind: ValueKind::List(items), span }
            }
            Kind::Mapping(_) if key.is_some_and(|k| k.value == ALLOW) => {
                Value { kind: ValueKind::Block(self.allowances(id)), span }
            }
            Kind::Mapping(_) if text_key => {
                self.diags.push(quotes::no_text(key.map_or("", |k| &k.value), self.text, span));
                missing(span)
            }
            Kind::Mapping(_) => Value { kind: ValueKind::Block(self.block(id)), span },
        }
    }
}
