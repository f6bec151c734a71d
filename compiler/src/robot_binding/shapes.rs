//! Kinds of the collision shapes of links: capsules, hulls or pieces.

use blocks::{Located, Unbound};
use dsl::tree::Value;
use dsl::{Diagnostic, Help, Snippet, Spanned};
use robot::{Model, ShapeKind};

use super::lookup::unknown_link;
use crate::block_binding::Origins;
use crate::forms::text_of;
use crate::sections::RobotBlock;

/// The word for all links.
const ALL: &str = "all";

/// A link, or all links, with the key that names it.
struct NamedLink {
    name: Spanned<String>,
    key: &'static str,
    kind: ShapeKind,
}

/// Kinds that a robot's block gives to its links.
pub(super) struct Shapes {
    links: Vec<NamedLink>,
    pieces_within: f64,
}

impl Shapes {
    /// Reads `capsules [..]`, `hulls [..]` and `pieces [..]`, each with names of links or `all`.
    pub(super) fn read(block: &RobotBlock, origins: &Origins, diagnostics: &mut Vec<Diagnostic>) -> Shapes {
        let mut shapes = Shapes { links: Vec::new(), pieces_within: block.pieces_within.value };
        let unbound = |of: &Option<Located<Unbound>>| origins.unbound(of.as_ref()?);
        for (key, kind, of) in [
            ("capsules", ShapeKind::Capsules, &block.capsules),
            ("hulls", ShapeKind::Hulls, &block.hulls),
            ("pieces", ShapeKind::Pieces, &block.pieces),
        ] {
            let items = unbound(of).map_or(&[][..], Value::items);
            items.iter().for_each(|item| shapes.add(item, key, kind, diagnostics));
        }
        shapes
    }

    fn add(&mut self, item: &Value, key: &'static str, kind: ShapeKind, diagnostics: &mut Vec<Diagnostic>) {
        let Some(name) = text_of(item) else {
            let d = Diagnostic::error("HQ0304", item.span, "the name of a link is needed here");
            diagnostics.push(d.help(Help::with(
                "write for instance {} or {}",
                [Snippet::entry(key, "[base_link]"), Snippet::entry(key, ALL)],
            )));
            return;
        };
        let other = self.links.iter().find(|other| other.name.value == name && other.kind != kind);
        if let Some(other) = other {
            let of = if name == ALL { "all links get".to_string() } else { format!("link `{name}` gets") };
            let text = format!("{of} two kinds of shapes, `{}` and `{key}`", other.key);
            let d = Diagnostic::error("HQ0207", item.span, text).label(other.name.span, "the other one");
            diagnostics.push(d.help("keep one of them; a link that is named alone has precedence over `all`"));
            return;
        }
        self.links.push(NamedLink { name: Spanned::new(name.to_string(), item.span), key, kind });
    }

    /// The option of the reader of URDFs.
    pub(super) fn option(&self) -> robot::Shapes {
        let all = self.links.iter().find(|link| link.name.value == ALL);
        robot::Shapes {
            default: all.map_or(ShapeKind::default(), |link| link.kind),
            of: self.links.iter().map(|link| (link.name.value.clone(), link.kind)).collect(),
            pieces_within: self.pieces_within,
        }
    }

    /// Reports names that are those of no link.
    pub(super) fn check(&self, model: &Model, diagnostics: &mut Vec<Diagnostic>) {
        for name in self.links.iter().map(|link| &link.name).filter(|name| name.value != ALL) {
            if model.link(&name.value).is_none() {
                diagnostics.push(unknown_link(model, &name.value, name.span, &[]));
            }
        }
    }
}
