//! The sections of a spec: `hierarq`, `params`, `lets`, `robots`, `tasks`, `stacks`, `run`; the others stand in `reuse`.

use super::Reader;
use super::events::{Kind, NodeId};
use crate::explain::clip;
use crate::hq::{bad_version, no_header};
use crate::tree::{Block, Comments, Item, ItemKind, Let, Robot, Run, Spec, Task, TaskDefinition, ValueKind};
use crate::words::nearest;
use crate::{Diagnostic, Span, Spanned};

const SECTIONS: &[&str] = &["hierarq", "import", "params", "lets", "robots", "tasks", "stacks", "for", "run"];

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
        for (key, value) in self.distinct(root) {
            let plural = format!("{}s", key.value);
            let word = match key.value.as_str() {
                word if SECTIONS.contains(&word) => word.to_owned(),
                other => {
                    let meant = if SECTIONS.contains(&plural.as_str()) {
                        Some(plural.as_str())
                    } else {
                        nearest(other, SECTIONS)
                    };
                    let diagnostic =
                        Diagnostic::error("HQ0132", key.span, format!("`{}` is no part of a spec", clip(other)));
                    let Some(meant) = meant else {
                        self.diags
                            .push(diagnostic.note(
                                "a spec has the keys `hierarq`, `import`, `params`, `lets`, `robots`, `tasks`, `stacks`, `for` and `run`",
                            ));
                        continue;
                    };
                    self.diags.push(diagnostic.help(format!("did you mean `{meant}`?")));
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
                "import" => self.imports(&key, value, &mut spec.items),
                "for" => self.repeats(value, &mut spec.items),
                section => self.section(section, &key, value, &mut spec.items),
            }
        }
        if !header {
            self.diags.push(no_header(Span { end: self.span(root).start, ..self.span(root) }, "hierarq: 1"));
        }
        self.pool.before(usize::MAX, &mut spec.closing_comments.before);
        spec
    }

    /// The span of a node, or `key` where the node stands earlier (an alias).
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
            _ => self
                .diags
                .push(Diagnostic::error("HQ0102", key.span, "`hierarq` lacks its number").help("write `hierarq: 1`")),
        }
        spec.version = written.and_then(|t| t.parse().ok()).map(|n| Spanned::new(n, span));
        self.pool.behind(span.range().end, &[], &mut spec.opening_comments.behind);
    }

    /// A value that must be a mapping, as a block.
    fn mapping(&mut self, id: NodeId, key: &Spanned<String>, what: &str) -> Block {
        if matches!(self.node(id).kind, Kind::Mapping(_)) {
            return self.block(id);
        }
        if self.is_null(id) {
            self.diags.push(
                Diagnostic::error("HQ0117", key.span, format!("`{}` says nothing", clip(&key.value)))
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
        let all = match section {
            "tasks" | "stacks" => self.heads(id),
            _ => {
                let plain = |(name, value): (Spanned<String>, NodeId)| (name.clone(), name.span, Vec::new(), value);
                self.distinct(id).into_iter().map(plain).collect()
            }
        };
        for (name, key, parameters, value) in all {
            let mut comments = self.key_comments(key);
            let later = self.later(value, key);
            let kind = match section {
                "params" => Some(ItemKind::Param(self.param(&name, value, &mut comments))),
                "lets" => Some(ItemKind::Let(self.let_(&name, value, &mut comments))),
                "robots" => {
                    let mut body = self.mapping(value, &name, "robot");
                    let base = self.robot_base(&mut body, &mut comments);
                    Some(ItemKind::Robot(Robot { name: name.clone(), base, body }))
                }
                "tasks" => self
                    .definition(value, &name, &mut comments.behind)
                    .map(|(definition, _)| ItemKind::Task(Task { name: name.clone(), parameters, definition })),
                _ => Some(ItemKind::Stack(self.stack(value, &name, parameters))),
            };
            self.pool.behind(later.range().end, &[','], &mut comments.behind);
            if let Some(kind) = kind {
                items.push(Item { kind, span: key.to(later), comments });
            }
        }
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

    /// `kind`, `kind(args)` or `{ kind: { .. } }`. The flag tells whether parentheses stood behind the kind.
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
                Diagnostic::error("HQ0107", owner.span, format!("the task `{}` is not defined", clip(&owner.value)))
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
                let [(key, body)] = pairs.as_slice() else {
                    return self.several_kinds(id, &pairs, help);
                };
                let (key, body) = (*key, *body);
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

    fn several_kinds(&mut self, id: NodeId, pairs: &[(NodeId, NodeId)], help: &str) -> Option<(TaskDefinition, bool)> {
        match pairs {
            [] => self.wrong_shape(id, "a task", help),
            [(first, _), (second, _), ..] => {
                let (first, second) = (self.span(*first), self.span(*second));
                self.diags.push(
                    Diagnostic::error("HQ0131", second, "a task has one kind")
                        .here("a second key")
                        .label(first, "read as the kind of the task")
                        .help("indent the parameters below the kind: `virtual_wall: { points: .., d_min: .. }`"),
                );
            }
            _ => {}
        }
        None
    }
}
