//! Conversion of the events of the YAML library to an arena of nodes with byte spans. No other file uses the library.
//!
//! A YAML parser stops at its first error. To find the next one, the faulty line and all following lines with a deeper
//! indentation are replaced by spaces, which preserves all byte positions, and the text is parsed again.

use super::{quotes, syntax};
use crate::comments::Comment;
use crate::fix::Fix;
use crate::limits::{MAX_DEPTH, MAX_TOKENS, too_deep, too_many_words};
use crate::{Diagnostic, SourceId, Span};
use granit_parser::{Event, Parser, ScalarStyle};
use std::collections::BTreeMap;

/// Index of a node in [`Document::nodes`].
pub(super) type NodeId = usize;

/// Style of a scalar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Style {
    /// Without quotes.
    Plain,
    /// In single or double quotes.
    Quoted,
    /// `|` or `>`.
    Block,
}

/// Content of a node.
#[derive(Clone, Debug)]
pub(super) enum Kind {
    /// A single value, decoded.
    Scalar(String, Style),
    /// `[..]` or `- ..`
    Sequence(Vec<NodeId>),
    /// `{..}` or `key: ..`
    Mapping(Vec<(NodeId, NodeId)>),
    /// An invalid node that has been reported.
    Broken,
}

/// One node.
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// Content.
    pub kind: Kind,
    /// Its bytes, without anchor and tag.
    pub span: Span,
    /// True if written with `[` or `{`.
    pub flow: bool,
}

/// A text as nodes. Aliases share the node that they refer to.
#[derive(Debug, Default)]
pub(super) struct Document {
    /// All nodes.
    pub nodes: Vec<Node>,
    /// The root of the first document.
    pub root: Option<NodeId>,
    /// Comments in the order of the text.
    pub comments: Vec<Comment>,
    /// Ranges that were blanked because of a syntax error.
    pub left_out: Vec<std::ops::Range<usize>>,
}

/// Maximum number of syntax errors that are searched for.
const MAX_ERRORS: usize = 16;

/// Reads a text. Returns diagnostics for all YAML syntax errors that could be found.
pub(super) fn read(source: SourceId, text: &str) -> (Document, Vec<Diagnostic>) {
    let mut diags: Vec<Diagnostic> = Vec::new();
    let mut patched: Option<String> = None;
    let mut left_out = Vec::new();
    for _ in 0..MAX_ERRORS {
        let current = patched.as_deref().unwrap_or(text);
        let mut build = Build::new(source, current);
        match build.run() {
            Ok(()) => {
                diags.extend(build.diags);
                return (Document { left_out, ..build.document }, diags);
            }
            Err(Stop::Refused(diagnostic)) => {
                diags.push(*diagnostic);
                return (Document::default(), diags);
            }
            Err(Stop::Syntax { at, message }) => {
                let (diagnostic, blank) = match quotes::missing(source, current, at) {
                    Some((diagnostic, Some(next))) => {
                        diags.push(diagnostic);
                        patched = Some(next);
                        continue;
                    }
                    Some((diagnostic, None)) => {
                        let line = diagnostic.primary.span.range().start;
                        (diagnostic, line)
                    }
                    None => syntax::explain(source, text, current, at, &message),
                };
                let known = diags.iter().any(|d| d.primary.span == diagnostic.primary.span);
                if !known {
                    diags.push(diagnostic);
                }
                let Some((next, gone)) = syntax::blank(current, blank) else { break };
                patched = Some(next);
                left_out.push(gone);
            }
        }
    }
    (Document::default(), diags)
}

enum Stop {
    Syntax { at: usize, message: String },
    Refused(Box<Diagnostic>),
}

/// A collection that is still open.
struct Open {
    node: NodeId,
    anchor: usize,
    /// Key of a mapping that still needs its value.
    key: Option<NodeId>,
}

struct Build<'t> {
    source: SourceId,
    text: &'t str,
    document: Document,
    diags: Vec<Diagnostic>,
    open: Vec<Open>,
    anchors: BTreeMap<usize, NodeId>,
    documents: usize,
}

impl<'t> Build<'t> {
    fn new(source: SourceId, text: &'t str) -> Self {
        let document = Document::default();
        Build { source, text, document, diags: Vec::new(), open: Vec::new(), anchors: BTreeMap::new(), documents: 0 }
    }

    fn run(&mut self) -> Result<(), Stop> {
        let options = granit_parser::options! {
            emit_unresolved_aliases: true,
            max_buffered_comment_events: MAX_TOKENS,
            simple_key_max_lookahead: 4096,
            flow_nesting_limit: MAX_DEPTH + 1,
            block_nesting_limit: MAX_DEPTH + 1,
        };
        for (count, event) in Parser::new_from_str_with_options(self.text, options).enumerate() {
            let (event, at) = event.map_err(|error| {
                let at = error.marker().byte_offset().unwrap_or(0).min(self.text.len());
                match error.kind() {
                    granit_parser::ErrorKind::RecursionLimitExceeded => {
                        Stop::Refused(Box::new(too_deep(Span::new(self.source, at, at))))
                    }
                    _ => Stop::Syntax { at, message: error.info() },
                }
            })?;
            let range = at.byte_range().unwrap_or(0..0);
            if count > MAX_TOKENS {
                return Err(Stop::Refused(Box::new(too_many_words(self.source, range.start))));
            }
            let span = Span::new(self.source, range.start, range.end);
            self.event(event, span)?;
        }
        Ok(())
    }

    fn event(&mut self, event: Event<'_>, span: Span) -> Result<(), Stop> {
        let add = |this: &mut Self, kind: Kind, flow: bool| {
            this.document.nodes.push(Node { kind, span, flow });
            this.document.nodes.len() - 1
        };
        match event {
            Event::DocumentStart(..) => {
                self.documents += 1;
                if self.documents == 2 {
                    self.diags.push(
                        Diagnostic::error("HQ0133", span, "a second YAML document begins here")
                            .note("a spec is one document; the rest is not read")
                            .help("delete the `---`, or move the rest to a file of its own"),
                    );
                }
            }
            Event::Comment(comment, _) => {
                let start = span.range().start;
                let line = self.text[..start].rfind('\n').map_or(0, |n| n + 1);
                let whole_line = self.text[line..start].trim_start_matches('\u{feff}').trim().is_empty();
                self.document.comments.push(Comment::new(start, span.range().end, whole_line, &comment));
            }
            Event::Scalar(value, style, anchor, tag) => {
                self.tag(tag.is_some(), span);
                let style = match style {
                    ScalarStyle::Plain => Style::Plain,
                    ScalarStyle::SingleQuoted | ScalarStyle::DoubleQuoted => Style::Quoted,
                    _ => Style::Block,
                };
                let node = add(self, Kind::Scalar(value.into_owned(), style), false);
                self.finished(node, anchor);
            }
            Event::SequenceStart(style, anchor, tag) | Event::MappingStart(style, anchor, tag)
                if self.open.len() >= MAX_DEPTH =>
            {
                let _ = (style, anchor, tag);
                return Err(Stop::Refused(Box::new(too_deep(span))));
            }
            Event::SequenceStart(style, anchor, tag) => {
                self.tag(tag.is_some(), span);
                let flow = style == granit_parser::StructureStyle::Flow;
                let node = add(self, Kind::Sequence(Vec::new()), flow);
                self.open.push(Open { node, anchor, key: None });
            }
            Event::MappingStart(style, anchor, tag) => {
                self.tag(tag.is_some(), span);
                let flow = style == granit_parser::StructureStyle::Flow;
                let node = add(self, Kind::Mapping(Vec::new()), flow);
                self.open.push(Open { node, anchor, key: None });
            }
            Event::SequenceEnd | Event::MappingEnd => {
                if let Some(open) = self.open.pop() {
                    self.close(&open, span);
                    self.finished(open.node, open.anchor);
                }
            }
            Event::Alias(id) => match self.anchors.get(&id) {
                Some(&node) => self.attach(node),
                None => {
                    self.diags.push(
                        Diagnostic::error("HQ0134", span, "this alias is inside the node that it repeats")
                            .help("write out the repeated node"),
                    );
                    let node = add(self, Kind::Broken, false);
                    self.attach(node);
                }
            },
            Event::UnresolvedAlias(name) => {
                self.diags.push(
                    Diagnostic::error("HQ0134", span, format!("no anchor `&{name}` precedes this alias"))
                        .note("a value that begins with `*` is an alias of YAML")
                        .help(format!("put a text such as `\"*{name}\"` in quotes, or mark a node with `&{name}`")),
                );
                let node = add(self, Kind::Broken, false);
                self.attach(node);
            }
            _ => {}
        }
        Ok(())
    }

    fn tag(&mut self, present: bool, span: Span) {
        if present {
            // The tag precedes its node.
            let before = self.text[..span.range().start].trim_end();
            let word = before.rfind(|c: char| c.is_ascii_whitespace() || "[{,".contains(c)).map_or(0, |n| n + 1);
            let own = before[word..].starts_with('!').then(|| Span::new(self.source, word, before.len()));
            let span = own.unwrap_or(span);
            self.diags.push(
                Diagnostic::error("HQ0136", span, "YAML tags have no meaning in a spec")
                    .help("delete the `!tag`")
                    .fix(Fix::edit("Delete the tag", span, "")),
            );
        }
    }

    /// Sets the span of a collection: to the closing bracket, or to the end of its last part.
    fn close(&mut self, open: &Open, end: Span) {
        let last = match &self.document.nodes[open.node].kind {
            Kind::Sequence(items) => items.last().copied(),
            Kind::Mapping(entries) => entries.last().map(|e| e.1),
            _ => None,
        };
        let last_end = last.map(|id| self.document.nodes[id].span.end);
        let node = &mut self.document.nodes[open.node];
        node.span.end = if node.flow { end.end } else { last_end.unwrap_or(node.span.end) };
        node.span.end = node.span.end.max(node.span.start);
        self.diags.extend(quotes::mend(self.source, self.text, &mut self.document.nodes, open.node));
    }

    fn finished(&mut self, node: NodeId, anchor: usize) {
        if anchor != 0 {
            self.anchors.insert(anchor, node);
        }
        self.attach(node);
    }

    fn attach(&mut self, node: NodeId) {
        let Some(open) = self.open.last_mut() else {
            if self.documents <= 1 && self.document.root.is_none() {
                self.document.root = Some(node);
            }
            return;
        };
        match &mut self.document.nodes[open.node].kind {
            Kind::Sequence(items) => items.push(node),
            Kind::Mapping(entries) => match open.key.take() {
                Some(key) => entries.push((key, node)),
                None => open.key = Some(node),
            },
            _ => {}
        }
    }
}
