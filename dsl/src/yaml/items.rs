//! Reader of the sections of a spec: `hierarq`, `params`, `lets`, `robots`, `tasks`, `stacks`, `run`. The modules
//! beside this one read the others.

use super::Reader;
use super::events::{Kind, Node, NodeId};
use crate::diagnostic::Topic;
use crate::diagnostic::clip;
use crate::hq::{bad_version, no_header};
use crate::tree::{
    Allow, Block, BlockKind, Comments, Coverage, Item, ItemKind, Let, NamedBlock, Parameter, Robot, Run, Spec, Task,
    TaskDefinition, ValueKind,
};
use crate::vocabulary::{LISTS, SECTIONS};
use crate::words::nearest;
use crate::{Diagnostic, Span, Spanned};

/// A declaration of a section: its name, the span of its key, its parameters, and its node.
pub(super) type Head = (Spanned<String>, Span, Vec<Parameter>, NodeId);

impl Reader<'_> {
    pub(super) fn spec(&mut self) -> Spec {
        let mut spec = Spec::default();
        let top = Span::new(self.source, 0, 0);
        let Some(root) = self.document.root else {
            if self.diags.is_empty() {
                self.diags.push(no_header(top, "hierarq: 1"));
            }
            self.pool.before(usize::MAX, &mut spec.closing_comments.before);
            return spec;
        };
        if !matches!(self.node(root).kind, Kind::Mapping(_)) {
            if self.is_null(root) {
                self.diags.push(no_header(top, "hierarq: 1"));
            } else {
                self.wrong_shape(root, "a mapping with `hierarq`, `robots`, `tasks`, ..", "begin with `hierarq: 1`");
            }
            self.pool.before(usize::MAX, &mut spec.closing_comments.before);
            return spec;
        }
        let mut header = false;
        let pairs = self.distinct(root);
        // The last section if it is empty, and true if that was reported.
        let mut empty: Option<(Spanned<String>, bool)> = None;
        for (key, value) in pairs {
            if let Some((section, told)) = empty.take_if(|_| self.left_of_its_section(&key, value)) {
                if !told {
                    self.too_far_left(&section, key.span);
                }
                let at = key.span;
                self.one(&section.value, (key, at, Vec::new(), value), &mut spec.items);
                empty = Some((section, true));
                continue;
            }
            let is_empty = LISTS.contains(&key.value.as_str()) && self.is_null(value);
            empty = is_empty.then(|| (key.clone(), false));
            let plural = format!("{}s", key.value);
            let word = match key.value.as_str() {
                word if SECTIONS.contains(&word) => word.to_owned(),
                other => {
                    let meant = if SECTIONS.contains(&plural.as_str()) {
                        Some(plural.as_str())
                    } else {
                        nearest(other, SECTIONS)
                    };
                    let diagnostic = Diagnostic::unknown_key(
                        "HQ0132",
                        key.span,
                        format!("`{}` is not a key of a spec", clip(other)),
                    );
                    let Some(meant) = meant else {
                        let keys = names::list(SECTIONS.iter().copied(), SECTIONS.len());
                        self.diags.push(diagnostic.note(format!("a spec has the keys {keys}")));
                        continue;
                    };
                    self.diags.push(diagnostic.meant(meant));
                    meant.to_owned()
                }
            };
            match word.as_str() {
                "hierarq" => {
                    header = true;
                    self.version(&key, value, &mut spec);
                }
                "run" => {
                    let mut comments = self.key_comments(key.span);
                    let body = self.mapping(value, &key, "run");
                    let span = key.span.to(self.later(value, key.span));
                    self.pool.behind(span.range().end, &[], &mut comments.behind);
                    spec.items.push(Item { kind: ItemKind::Run(Run { body }), span, comments });
                }
                "coverage" => self.coverage(&key, value, &mut spec.items),
                "import" => self.imports(&key, value, &mut spec.items),
                "for" => self.repeats(value, &mut spec.items),
                "scenarios" => self.scenarios(&key, value, &mut spec.items),
                section => self.section(section, &key, value, &mut spec.items),
            }
        }
        if !header {
            self.diags.push(no_header(Span { end: self.span(root).start, ..self.span(root) }, "hierarq: 1"));
        }
        self.pool.before(usize::MAX, &mut spec.closing_comments.before);
        spec
    }

    /// Returns the span of a node, or `key` if the node is earlier in the text (an alias).
    pub(super) fn later(&self, id: NodeId, key: Span) -> Span {
        let span = self.span(id);
        if span.start >= key.start { span } else { key }
    }

    fn version(&mut self, key: &Spanned<String>, value: NodeId, spec: &mut Spec) {
        self.pool.before(key.span.range().start, &mut spec.opening_comments.before);
        let span = self.later(value, key.span);
        let written = self.scalar(value).map(|s| s.0.to_owned()).filter(|_| !self.is_null(value));
        match &written {
            Some(text) if text == "1" => {}
            Some(text) if !text.is_empty() => self.diags.push(bad_version(span, text)),
            _ => self.diags.push(
                Diagnostic::error("HQ0102", key.span, "`hierarq` has no version number")
                    .about(Topic::Header)
                    .help("write `hierarq: 1`"),
            ),
        }
        spec.version = written.and_then(|t| t.parse().ok()).map(|n| Spanned::new(n, span));
        self.pool.behind(span.range().end, &[], &mut spec.opening_comments.behind);
    }

    /// Reads `coverage`: a mapping, or a sequence of several.
    pub(super) fn coverage(&mut self, key: &Spanned<String>, value: NodeId, items: &mut Vec<Item>) {
        let Kind::Sequence(all) = &self.node(value).kind else {
            let mut comments = self.key_comments(key.span);
            let body = self.mapping(value, key, "coverage");
            let span = key.span.to(self.later(value, key.span));
            self.pool.behind(span.range().end, &[], &mut comments.behind);
            items.push(Item { kind: ItemKind::Coverage(Coverage { body }), span, comments });
            return;
        };
        let all = all.clone();
        if all.is_empty() {
            self.diags.push(
                Diagnostic::incomplete("HQ0117", key.span, "`coverage` says nothing")
                    .help("write its parts below it, indented, as `key: value`, or remove it"),
            );
        }
        for id in all {
            if self.depth >= crate::limits::MAX_DEPTH || !self.enter(id) {
                return;
            }
            let span = self.span(id);
            let mut comments = Comments::default();
            self.pool.before(span.range().start, &mut comments.before);
            let body = self.mapping(id, key, "coverage");
            self.pool.behind(span.range().end, &[','], &mut comments.behind);
            items.push(Item { kind: ItemKind::Coverage(Coverage { body }), span, comments });
        }
    }

    /// Reads a value that must be a mapping as a block.
    fn mapping(&mut self, id: NodeId, key: &Spanned<String>, what: &str) -> Block {
        if matches!(self.node(id).kind, Kind::Mapping(_)) {
            return self.block(id);
        }
        if self.is_null(id) {
            self.diags.push(
                Diagnostic::incomplete("HQ0117", key.span, format!("`{}` says nothing", clip(&key.value)))
                    .help("write its parts below it, indented, as `key: value`"),
            );
        } else {
            self.wrong_shape(
                id,
                &format!("a mapping with the parts of the {what}"),
                "write `key: value` lines below the name",
            );
        }
        Block { span: self.span(id), ..Block::default() }
    }

    pub(super) fn section(&mut self, section: &str, title: &Spanned<String>, id: NodeId, items: &mut Vec<Item>) {
        if self.is_null(id) {
            return;
        }
        if !matches!(self.node(id).kind, Kind::Mapping(_)) {
            let help = format!("write `NAME: ..` lines below `{}:`", clip(&title.value));
            self.wrong_shape(id, "a mapping of names", &help);
            return;
        }
        let all: Vec<Head> = match section {
            "tasks" | "stacks" => self.heads(id),
            _ => {
                let plain = |(name, value): (Spanned<String>, NodeId)| (name.clone(), name.span, Vec::new(), value);
                self.distinct(id).into_iter().map(plain).collect()
            }
        };
        let mut left: &[Head] = &all;
        while let [head, rest @ ..] = left {
            left = rest;
            // An `arm:` with nothing below it, whose parts have the same indentation.
            let of_blocks =
                matches!(section, "robots" | "stacks" | "machines") || BlockKind::of_section(section).is_some();
            let blocks = of_blocks && self.is_null(head.3);
            let parts = rest.iter().take_while(|h| blocks && !self.is_null(h.3)).count();
            let flat = rest[..parts].iter().any(|h| !matches!(self.node(h.3).kind, Kind::Mapping(_)));
            if let Some(first) = rest.first().filter(|_| flat) {
                self.too_far_left(&head.0, first.1);
                left = &rest[parts..];
                let span = first.1;
                let lines = span.start..=rest[parts - 1].1.start;
                let mut entries = self.pairs(id);
                entries.retain(|(key, _)| lines.contains(&self.span(*key).start));
                self.document.nodes.push(Node { kind: Kind::Mapping(entries), span, flow: false });
                let value = self.document.nodes.len() - 1;
                self.one(section, (head.0.clone(), head.1, head.2.clone(), value), items);
                continue;
            }
            self.one(section, head.clone(), items);
        }
    }

    /// Returns true for a top-level key after an empty section that is no section itself.
    fn left_of_its_section(&self, key: &Spanned<String>, value: NodeId) -> bool {
        let plural = format!("{}s", key.value);
        let known = SECTIONS.contains(&key.value.as_str()) || SECTIONS.contains(&plural.as_str());
        !known && nearest(&key.value, SECTIONS).is_none() && !self.is_null(value)
    }

    /// Reports that the lines from `first` on have the same indentation as the key that they belong to.
    pub(super) fn too_far_left(&mut self, owner: &Spanned<String>, first: Span) {
        self.diags.push(
            Diagnostic::incomplete("HQ0117", owner.span, format!("`{}` has nothing below it", clip(&owner.value)))
                .label(first, "this line must be indented below it")
                .help("indent the lines that belong to it by two more spaces"),
        );
    }

    /// Reads one declaration of a section.
    fn one(&mut self, section: &str, (name, key, parameters, value): Head, items: &mut Vec<Item>) {
        let mut comments = self.key_comments(key);
        let later = self.later(value, key);
        let kind = match section {
            "allow" => ItemKind::Allow(Allow { reason: self.reason(value, name.span), code: name }),
            "params" => ItemKind::Param(self.param(&name, value, &mut comments)),
            "lets" => ItemKind::Let(self.let_(&name, value, &mut comments)),
            "robots" => {
                let mut body = self.mapping(value, &name, "robot");
                let base = self.robot_base(&mut body, &mut comments);
                ItemKind::Robot(Robot { name, base, body })
            }
            "tasks" => {
                let read = self.definition(value, &name, &mut comments.behind).map(|(definition, _)| definition);
                let definition = read.unwrap_or_else(|| TaskDefinition::unread(key.to(later)));
                ItemKind::Task(Task { name, parameters, definition })
            }
            "signals" => ItemKind::Signal(self.signal(&name, value, &mut comments)),
            "variables" => ItemKind::Variable(self.variable(&name, value, &mut comments)),
            "machines" => ItemKind::Machine(self.machine(&name, value)),
            "missions" => ItemKind::Mission(self.mission(&name, value, &mut comments)),
            section => match BlockKind::of_section(section) {
                Some(kind) => {
                    let mut body = self.mapping(value, &name, kind.keyword());
                    crate::checks::reserved(&mut body, &[], kind.keyword(), &mut self.diags);
                    ItemKind::Block(NamedBlock { kind, name, body })
                }
                None => ItemKind::Stack(self.stack(value, &name, parameters)),
            },
        };
        self.pool.behind(later.range().end, &[','], &mut comments.behind);
        items.push(Item { kind, span: key.to(later), comments });
    }

    fn let_(&mut self, name: &Spanned<String>, id: NodeId, comments: &mut Comments) -> Let {
        let key = Some(name).filter(|n| !crate::words::is_text_key(&n.value));
        let mut value = self.value(id, key);
        if matches!(value.kind, ValueKind::Block(_)) {
            self.wrong_shape(id, "a value", "`lets` names single values, such as `pi * 1 rad`");
            value.kind = ValueKind::Missing;
        }
        self.pool.before(self.later(id, name.span).range().end, &mut comments.before);
        Let { name: name.clone(), value }
    }

    /// Reads `kind`, `kind(args)` or `{ kind: { .. } }`. The flag is true if the kind was followed by parentheses.
    pub(super) fn definition(
        &mut self,
        id: NodeId,
        owner: &Spanned<String>,
        behind: &mut Option<String>,
    ) -> Option<(TaskDefinition, bool)> {
        let span = self.span(id);
        let help = "write `KIND`, `KIND(..)` or `KIND: { .. }`";
        if self.is_null(id) {
            self.diags.push(
                Diagnostic::incomplete(
                    "HQ0107",
                    owner.span,
                    format!("the task `{}` is not defined", clip(&owner.value)),
                )
                .help(help),
            );
            return None;
        }
        match &self.node(id).kind {
            Kind::Scalar(..) => {
                let end = Span { start: span.end, ..span };
                self.task_head(id, Block { span: end, ..Block::default() })
            }
            Kind::Mapping(_) => {
                let pairs = self.pairs(id);
                let [(key, body), others @ ..] = pairs.as_slice() else {
                    self.wrong_shape(id, "a task", help);
                    return None;
                };
                let (key, body) = (*key, *body);
                if !others.is_empty() {
                    self.several_kinds(key, others);
                }
                let at = self.span(key);
                self.pool.behind(at.range().end, &[':', '{'], behind);
                let name = Spanned::new(self.scalar(key).map_or("this task", |s| s.0).to_owned(), at);
                let body = match &self.node(body).kind {
                    Kind::Mapping(_) => self.block(body),
                    _ if self.is_null(body) => {
                        let help =
                            format!("without parameters, write `{}` alone, without the colon", clip(&name.value));
                        self.diags.push(crate::explain::no_value(&name.value, at).help(help));
                        Block { span: at, ..Block::default() }
                    }
                    _ => {
                        self.wrong_shape(body, "a mapping with the parameters of the task", "write `{ key: value }`");
                        Block { span: at, ..Block::default() }
                    }
                };
                self.task_head(key, body)
            }
            _ => {
                self.wrong_shape(id, "a task", help);
                None
            }
        }
    }

    /// Reports keys beside the kind of a task. Their values stay unread: each may be a parameter, or a task of its own.
    fn several_kinds(&mut self, kind: NodeId, others: &[(NodeId, NodeId)]) {
        let first = self.span(kind);
        let keys = others.iter().map(|(key, _)| self.span(*key));
        self.unread.extend(keys.collect::<Vec<_>>());
        if let Some(second) = others.first().map(|(key, _)| self.span(*key)) {
            self.diags.push(
                Diagnostic::error("HQ0131", second, "a task has one kind")
                    .here("a second key")
                    .label(first, "read as the kind of the task")
                    .help("indent the parameters below the kind: `virtual_wall: { points: .., d_min: .. }`"),
            );
        }
    }
}
