//! Pairs of links whose collisions an SRDF disables: one by one, or all pairs of a link but those that are enabled again.

use std::collections::BTreeMap;
use std::ops::Range;

use roxmltree::Node;

use super::read::{FirstUse, Reader};
use super::{DisabledPair, SrdfCode, SrdfMessage};
use crate::LinkId;
use crate::urdf::cx::{self, attribute, children};

/// Maximum number of pairs.
const MAX_PAIRS: usize = 500_000;

/// Reason of the pairs of a link that are disabled all at once.
const BY_DEFAULT: &str = "Default";

/// Reason and place of a pair.
type Why = (String, Range<usize>);

impl Reader<'_, '_> {
    /// Reads the disabled pairs.
    pub(super) fn disabled(&mut self, root: Node) -> Vec<DisabledPair> {
        let mut pairs: BTreeMap<[LinkId; 2], Why> = BTreeMap::new();
        for node in children(root, "disable_default_collisions") {
            let span = cx::tag(self.text, node);
            let Some(link) = self.known(node, "link") else { continue };
            if pairs.len() + self.model.links.len() > MAX_PAIRS {
                let text = format!("more than {MAX_PAIRS} pairs of links are disabled");
                self.error(SrdfMessage::new(SrdfCode::TooLarge, span, text));
                return Vec::new();
            }
            for other in (0..self.model.links.len() as u32).map(LinkId).filter(|other| *other != link) {
                pairs.entry(ordered(link, other)).or_insert((BY_DEFAULT.to_string(), span.clone()));
            }
        }
        for node in children(root, "enable_collisions") {
            if let Some(pair) = self.pair(node) {
                pairs.remove(&pair);
            }
        }
        for node in children(root, "disable_collisions") {
            let Some(pair) = self.pair(node) else { continue };
            let reason = attribute(node, "reason").map(|a| a.value.trim().to_string()).unwrap_or_default();
            pairs.insert(pair, (reason, cx::tag(self.text, node)));
        }
        pairs.into_iter().map(|(links, (reason, span))| DisabledPair { links, reason, span }).collect()
    }

    fn pair(&mut self, node: Node) -> Option<[LinkId; 2]> {
        let (a, b) = (self.known(node, "link1"), self.known(node, "link2"));
        let (a, b) = (a?, b?);
        if a == b {
            let text = format!("link `{}` is named twice", self.model.link_ref(a).name);
            let message = SrdfMessage::new(SrdfCode::Ignored, cx::tag(self.text, node), text);
            self.warn(message.help("name two links, or remove the element"));
            return None;
        }
        Some(ordered(a, b))
    }

    /// Link of an attribute. An unknown one is a warning at its first use: the pair takes no check away.
    fn known(&mut self, node: Node, name: &str) -> Option<LinkId> {
        let written = self.need(node, name)?;
        match self.link_or_none(&written.value) {
            Ok(link) => Some(link),
            Err(FirstUse(first)) => {
                if first {
                    let text = format!("the URDF has no link `{}`, and pairs with it are left out", written.value);
                    let message = SrdfMessage::new(SrdfCode::UnknownLink, written.span, text);
                    self.warn(message.unknown(&written.value));
                }
                None
            }
        }
    }
}

/// The pair with the smaller index first.
fn ordered(a: LinkId, b: LinkId) -> [LinkId; 2] {
    [a.min(b), a.max(b)]
}
