//! Indexes humans: their points in declarations, in expressions, and in scenarios.

use compiler::sections::{HUMAN, HUMAN_SCRIPT};
use dsl::tree::{Entry, Human, Item, Value, ValueKind};
use dsl::{Span, Spanned};

use super::mentions::{Class, MARKER, Slot, Walker, What};
use super::walk::{items, word};

impl Walker<'_> {
    pub(super) fn declared_human(&mut self, h: &Human, item: &Item) {
        let before = &item.comments.before;
        self.declare((Class::Human, h.name.value.clone()), &h.name, item.span, before);
        for point in h.body.get("points").map_or(&[][..], |e| items(&e.value)) {
            if let Some(name) = word(point).filter(|n| *n != MARKER) {
                let key = format!("{}.{name}", h.name.value);
                self.declare((Class::Tracked, key), &Spanned::new(name.to_string(), point.span), point.span, &[]);
            }
        }
    }

    pub(super) fn human(&mut self, h: &Human) {
        self.section(&h.body, &HUMAN);
        for point in h.body.get("points").map_or(&[][..], |e| items(&e.value)) {
            self.marked(word(point).unwrap_or(""), || Slot::Nothing);
        }
        for pair in h.body.get("links").map_or(&[][..], |e| items(&e.value)) {
            for end in items(pair) {
                let Some(name) = word(end) else { continue };
                self.tracked_name(&h.name.value, name, end.span);
            }
        }
    }

    /// Names of the points of a human.
    fn points_of(&self, human: &str) -> Vec<(String, &'static str)> {
        let own = |key: &str| key.strip_prefix(human)?.strip_prefix('.').map(str::to_string);
        self.found.names(Class::Tracked).filter_map(own).map(|n| (n, Class::Tracked.word())).collect()
    }

    /// Indexes a point of a human.
    fn tracked_name(&mut self, human: &str, point: &str, span: Span) {
        let known = self.points_of(human);
        if !self.marked(point, || Slot::Offered(known)) {
            self.note(point, span, What::Declared(Class::Tracked, format!("{human}.{point}")));
        }
    }

    /// Indexes `operator.chest` and `operator.chest.velocity`; returns false for other values.
    pub(super) fn human_field(&mut self, inner: &Value, field: &Spanned<String>) -> bool {
        match &inner.kind {
            ValueKind::Name(name) if self.has(Class::Human, name) => {
                self.note(name, inner.span, What::Declared(Class::Human, name.clone()));
                self.tracked_name(name, &field.value, field.span);
                true
            }
            ValueKind::Field(outer, point) => match &outer.kind {
                ValueKind::Name(name) if self.has(Class::Human, name) => {
                    self.marked(&field.value, || Slot::Words(&["velocity", "x", "y", "z"]));
                    self.human_field(outer, point)
                }
                _ => false,
            },
            _ => false,
        }
    }

    /// Indexes a human or one of its points in `uncertainty(..)`, `present(..)` and `stale(..)`; returns false for
    /// other values.
    pub(super) fn human_name(&mut self, value: &Value) -> bool {
        match &value.kind {
            ValueKind::Name(name) if self.has(Class::Human, name) => {
                self.note(name, value.span, What::Declared(Class::Human, name.clone()));
                true
            }
            ValueKind::Field(inner, field) => self.human_field(inner, field),
            _ => false,
        }
    }

    /// Indexes the argument of `uncertainty(operator)`.
    pub(super) fn uncertain(&mut self, value: &Value) {
        if !self.human_name(value) {
            self.marked(word(value).unwrap_or(""), || Slot::Human);
        }
    }

    /// Indexes the scripts of people in a scenario.
    pub(super) fn human_scripts(&mut self, value: &Value) {
        let ValueKind::Block(block) = &value.kind else { return };
        for e in &block.entries {
            if self.marked(&e.key.value, || Slot::Human) {
                continue;
            }
            let human = &e.key.value;
            self.note(human, e.key.span, What::Declared(Class::Human, human.clone()));
            let ValueKind::Block(script) = &e.value.kind else { continue };
            self.section(script, &HUMAN_SCRIPT);
            for key in ["shape", "points"] {
                let Some(ValueKind::Block(points)) = script.get(key).map(|e| &e.value.kind) else { continue };
                for Entry { key, .. } in &points.entries {
                    self.tracked_name(human, &key.value, key.span);
                }
            }
        }
    }
}
