//! References to parts of the robot: links, joints, arms, points, segments and groups.

use dsl::Span;
use dsl::tree::{Value, ValueKind};

use super::context::used;
use super::symbols::{SymbolId, SymbolKind as K};
use super::walk::place_of;
use super::{CompletionContext as C, Resolver};
use crate::expand::Class;

impl Resolver<'_> {
    fn link(&self, name: &str) -> Option<SymbolId> {
        self.links.as_ref()?.get(name).copied()
    }

    /// Resolves a link, or an arm for its tip; a link takes precedence.
    pub(super) fn frame(&mut self, value: &Value, offered: &'static [K]) {
        if let Some(name) = value.word() {
            self.frame_name(name, value.span, offered);
        }
    }

    pub(super) fn frame_name(&mut self, name: &str, span: Span, offered: &'static [K]) {
        if !self.is_cursor(name, |_| C::Symbols(offered)) && !self.is_bound(name, span) {
            let found = self.link(name).or_else(|| self.part(K::Arm, name));
            self.refer(name, span, K::Link, found);
        }
    }

    pub(super) fn arm(&mut self, value: &Value) {
        if let Some(name) = value.word() {
            self.arm_name(name, value.span);
        }
    }

    pub(super) fn arm_name(&mut self, name: &str, span: Span) {
        if !self.is_cursor(name, |_| C::Symbols(&[K::Arm])) && !self.is_bound(name, span) {
            let found = self.part(K::Arm, name);
            self.refer(name, span, K::Arm, found);
        }
    }

    /// Resolves links, arms for all of theirs, and parts for the links that carry them.
    pub(super) fn links(&mut self, value: &Value) {
        for item in value.items() {
            match item.word() {
                Some(name) if self.part(K::Arm, name).is_some() => self.arm_name(name, item.span),
                _ => self.geometries(item, C::Geometry { arms: true, people: false }),
            }
        }
    }

    /// Resolves points, segments, groups, `arms`, `arms.NAME`, and links.
    pub(super) fn geometries(&mut self, value: &Value, context: C) {
        for item in value.items() {
            if let ValueKind::Field(inner, field) = &item.kind {
                match inner.word() {
                    Some("arms") => self.arm_name(&field.value, field.span),
                    Some(other) => self.refer(other, inner.span, K::Group, None),
                    None => {}
                }
                continue;
            }
            let Some(name) = item.word() else { continue };
            if self.is_cursor(name, |_| context.clone()) || self.is_bound(name, item.span) {
                continue;
            }
            // In YAML, `arms.left` may be a single word.
            if let Some(arm) = name.strip_prefix("arms.") {
                let (place, exact) = place_of(self.text, name, item.span);
                let start = if exact { place.start + "arms.".len() } else { place.start };
                self.arm_name(arm, Span::new(item.span.source, start, place.end));
                continue;
            }
            let all_links = name == "all";
            let all_arms = name == "arms" && self.scopes[0].parts.keys().any(|(kind, _)| *kind == K::Arm);
            let part = [K::Group, K::Point, K::Segment].into_iter().find_map(|kind| self.part(kind, name));
            if !(all_arms || all_links) || part.is_some() {
                let found = part.or_else(|| self.link(name));
                self.refer(name, item.span, K::Point, found);
            }
        }
    }

    /// Resolves joints, groups of joints, and patterns.
    pub(super) fn joints(&mut self, value: &Value) {
        for item in value.items() {
            if let Some(name) = item.word()
                && !self.is_cursor(name, |_| C::Joint(Vec::new()))
            {
                self.joint(name, item.span);
            }
        }
    }

    fn joint(&mut self, name: &str, span: Span) {
        if name.contains(['*', '?']) || self.is_bound(name, span) {
            return;
        }
        let joint = self.joints.as_ref().and_then(|joints| joints.get(name).copied());
        let found = joint.or_else(|| self.part(K::JointGroup, name));
        let of_base = self.base_names.contains(name) || (name == "base" && !self.base_names.is_empty());
        if found.is_some() || !(name == "all" || of_base) {
            self.refer(name, span, K::Joint, found);
        }
    }

    /// True if the URDF is known and has no joint of this name.
    pub(super) fn is_no_joint(&self, name: &str) -> bool {
        let of_all = name == "all" || (name == "base" && !self.base_names.is_empty());
        !of_all
            && self.joints.as_ref().is_some_and(|joints| !joints.contains_key(name))
            && self.part(K::JointGroup, name).is_none()
    }

    /// Resolves positions by joint, or a posture; `f` resolves other values.
    pub(super) fn positions(&mut self, value: &Value, mut f: impl FnMut(&mut Self, &Value)) {
        match value.block() {
            Some(_) => self.joint_block(value, |r, v| {
                if !r.posture(v) {
                    f(r, v);
                }
            }),
            None if self.posture(value) => {}
            None => f(self, value),
        }
    }

    /// Resolves the name of a posture; false if a value is none. A declared value takes precedence.
    fn posture(&mut self, value: &Value) -> bool {
        let Some(name) = value.word().filter(|name| self.declared(Class::Value, name).is_none()) else { return false };
        let found = self.part(K::Posture, name);
        if found.is_some() {
            self.refer(name, value.span, K::Posture, found);
        }
        found.is_some()
    }

    /// Resolves a block with joints as keys.
    pub(super) fn joint_block(&mut self, value: &Value, mut f: impl FnMut(&mut Self, &Value)) {
        let Some(block) = value.block() else { return self.offer(value, |_| C::Nothing) };
        for e in &block.entries {
            if !self.is_cursor(&e.key.value, |_| C::Joint(used(block))) {
                self.joint(&e.key.value, e.key.span);
                f(self, &e.value);
            }
        }
    }
}
