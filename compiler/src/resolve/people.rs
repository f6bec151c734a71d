//! References to humans and their points, and to signals.

use dsl::Spanned;
use dsl::tree::{Value, ValueKind};

use super::symbols::{SymbolId, SymbolKind as K};
use super::{CompletionContext as C, Resolver};
use crate::expand::Class;

impl Resolver<'_> {
    /// Resolves a point of the human that the block is of.
    pub(super) fn human_point(&mut self, point: &Spanned<String>) {
        if let Some(human) = self.around.human {
            self.point_of(human, point);
        }
    }

    fn point_of(&mut self, human: SymbolId, point: &Spanned<String>) {
        let points = |r: &Self| r.offering(&r.all_inside(human, K::HumanPoint), |s| s.kind.word());
        if !self.is_cursor(&point.value, points) && !self.is_bound(&point.value, point.span) {
            let found = self.inside(human, K::HumanPoint, &point.value);
            self.refer(&point.value, point.span, K::HumanPoint, found);
        }
    }

    fn human(&self, value: &Value) -> Option<SymbolId> {
        match &value.kind {
            ValueKind::Name(name) => self.value_of(&[K::Human], name),
            _ => None,
        }
    }

    /// Resolves `operator.chest` and `operator.chest.velocity`; returns false for other values.
    pub(super) fn human_field(&mut self, inner: &Value, field: &Spanned<String>) -> bool {
        if let (Some(human), Some(name)) = (self.human(inner), inner.word()) {
            self.refer(name, inner.span, K::Human, Some(human));
            self.point_of(human, field);
            return true;
        }
        match &inner.kind {
            ValueKind::Field(outer, point) if self.human(outer).is_some() => {
                self.is_cursor(&field.value, |_| C::Words(&["velocity", "x", "y", "z"]));
                self.human_field(outer, point)
            }
            _ => false,
        }
    }

    /// Resolves a human or one of its points; returns false for other values.
    pub(super) fn is_human(&mut self, value: &Value) -> bool {
        match &value.kind {
            ValueKind::Field(inner, field) => self.human_field(inner, field),
            _ => {
                let found = self.human(value);
                if let (Some(_), Some(name)) = (found, value.word()) {
                    self.refer(name, value.span, K::Human, found);
                }
                found.is_some()
            }
        }
    }

    /// Resolves the argument of `uncertainty(operator)`.
    pub(super) fn uncertain(&mut self, value: &Value) {
        if !self.is_human(value) {
            self.name_in(value, Class::Value, K::Human, &[K::Human]);
        }
    }

    /// Resolves a signal, variable or human, in `present(..)`, `stale(..)` and the actions on variables.
    pub(super) fn signal_or_human(&mut self, value: &Value) {
        if !self.is_human(value) {
            self.name_in(value, Class::Value, K::Signal, &[K::Signal, K::Variable, K::Human]);
        }
    }
}
