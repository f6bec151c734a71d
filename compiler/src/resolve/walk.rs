//! References in the declarations of the spec.

use std::ops::Range;

use dsl::tree::{BlockKind, Item, ItemKind, Parameter, Repeat, Spec, Value, Values};
use dsl::{Span, Spanned};
use mission::kinds::find;

use super::context::Offered;
use super::declare::New;
use super::sections::acting;
use super::symbols::{FileId, SymbolId, SymbolKind};
use super::{Around, CompletionContext, Meaning, Reference, Resolver};
use crate::expand::{Class, parameter_types};
use crate::lowering::signal_types;
use crate::sections::{
    COVERAGE, FIELD_DISTANCE, HUMAN, InSyntax, Key, OBSTACLE, PARAM, ROBOT, RUN, SAFETY_FIELD, SCENARIO, SIGNAL, SPEC,
};

/// Range of a word inside its span, which may include quotes or be a whole scalar; with true if the range is exactly
/// the word.
pub(super) fn place_of(text: &str, word: &str, span: Span) -> (Range<usize>, bool) {
    let range = span.range();
    let Some(written) = text.get(range.clone()) else { return (range, false) };
    if written == word {
        return (range, true);
    }
    let inner = range.start + 1..range.end.saturating_sub(1).max(range.start + 1);
    if written.starts_with(['"', '\'']) && text.get(inner.clone()) == Some(word) {
        return (inner, true);
    }
    (range, false)
}

impl Resolver<'_> {
    /// Records an occurrence of a word.
    pub(super) fn note(&mut self, word: &str, span: Span, meaning: Meaning) {
        let (place, exact) = place_of(self.text, word, span);
        self.out.references.push(Reference { place, exact, declares: false, meaning });
    }

    /// Records a reference to a symbol, or an unknown name where a symbol of this kind is expected.
    pub(super) fn refer(&mut self, name: &str, span: Span, kind: SymbolKind, found: Option<SymbolId>) {
        match found {
            Some(id) => self.note(name, span, Meaning::Symbol(id)),
            // The expansion fills the holes.
            None if name.contains("${") || self.refer_to_robot(name, span) => {}
            None => self.note(name, span, Meaning::Unknown(kind, name.to_string())),
        }
    }

    /// Symbol that the spec declares or imports under a name.
    pub(super) fn declared(&self, class: Class, name: &str) -> Option<SymbolId> {
        self.scopes[0].declared.get(&(class, name.to_string())).copied()
    }

    /// Value of this kind that the spec sees under a name.
    pub(super) fn value_of(&self, kinds: &[SymbolKind], name: &str) -> Option<SymbolId> {
        self.declared(Class::Value, name).filter(|id| kinds.contains(&self.out.symbol(*id).kind))
    }

    /// Part of the robot.
    pub(super) fn part(&self, kind: SymbolKind, name: &str) -> Option<SymbolId> {
        self.scopes[0].parts.get(&(kind, name.to_string())).copied()
    }

    /// Event: a signal, or one that an action raises.
    pub(super) fn event(&self, name: &str) -> Option<SymbolId> {
        self.value_of(&[SymbolKind::Event], name).or_else(|| self.scopes[0].raised.get(name).copied())
    }

    /// Symbol of a kind inside another one.
    pub(super) fn inside(&self, container: SymbolId, kind: SymbolKind, name: &str) -> Option<SymbolId> {
        let container = self.out.origin(container);
        let found = self.inside.get(&(container, name.to_string()))?;
        found.iter().copied().find(|id| self.out.symbol(*id).kind == kind)
    }

    /// All symbols of a kind inside another one, in source order.
    pub(super) fn all_inside(&self, container: SymbolId, kind: SymbolKind) -> Vec<SymbolId> {
        let all = self.children.get(&self.out.origin(container)).into_iter().flatten();
        all.copied().filter(|id| self.out.symbol(*id).kind == kind).collect()
    }

    /// Records a parameter in scope. Returns true if the word is one.
    pub(super) fn is_bound(&mut self, word: &str, span: Span) -> bool {
        let found = self.bound.iter().rev().find(|b| b.0 == word).map(|b| b.1);
        if let Some(id) = found {
            self.note(word, span, Meaning::Symbol(id));
        }
        found.is_some()
    }

    /// Resolves a value that names a declaration of a class.
    pub(super) fn name_in(&mut self, value: &Value, class: Class, kind: SymbolKind, offered: &'static [SymbolKind]) {
        let Some(name) = value.word() else { return };
        self.spanned_name(name, value.span, class, kind, offered);
    }

    pub(super) fn spanned_name(
        &mut self,
        name: &str,
        span: Span,
        class: Class,
        kind: SymbolKind,
        offered: &'static [SymbolKind],
    ) {
        if !self.is_cursor(name, |_| CompletionContext::Symbols(offered)) && !self.is_bound(name, span) {
            let found = self.declared(class, name);
            self.refer(name, span, kind, found);
        }
    }

    /// Records the keyword at a byte, if it is there.
    pub(super) fn keyword(&mut self, name: &str, start: usize, key: Option<&'static Key>) {
        let there = self.text.get(start..).is_some_and(|t| t.starts_with(name));
        if let Some(key) = key.filter(|_| there) {
            let place = start..start + name.len();
            self.out.references.push(Reference { place, exact: true, declares: false, meaning: Meaning::Key(key) });
        }
    }

    /// Records a keyword, if it precedes a value.
    pub(super) fn keyword_before(&mut self, name: &str, value: Span, key: Option<&'static Key>) {
        let before = self.text.get(..value.range().start).unwrap_or("");
        let before = before.trim_end_matches(|c: char| c.is_whitespace() || matches!(c, ':' | '=' | '"' | '\'' | '('));
        let start = before.len().saturating_sub(name.len());
        let bounds = before.get(..start).is_some_and(|b| !b.ends_with(|c: char| c.is_ascii_alphanumeric() || c == '_'));
        if before.ends_with(name) && bounds {
            self.keyword(name, start, key);
        }
    }

    /// Resolves the references of the spec.
    pub(super) fn spec(&mut self, spec: &Spec) {
        spec.items.iter().for_each(|item| self.declare_raised(item));
        for item in &spec.items {
            if let ItemKind::Mission(m) = &item.kind
                && let Some(mission) = self.declared(Class::Mission, &m.name.value)
            {
                self.controllers(mission, &m.members, &m.repeats);
            }
        }
        if let Some(version) = &spec.version {
            self.keyword_before("hierarq", version.span, SPEC.key("hierarq", self.syntax));
        }
        spec.items.iter().for_each(|item| self.item(item));
    }

    fn item(&mut self, item: &Item) {
        let word = match &item.kind {
            ItemKind::Import(_) => "import",
            ItemKind::Allow(_) => "allow",
            ItemKind::Param(_) => "param",
            ItemKind::Let(_) => "let",
            ItemKind::Robot(_) => "robot",
            ItemKind::Task(_) => "task",
            ItemKind::Stack(_) => "stack",
            ItemKind::Signal(_) => "signal",
            ItemKind::Block(b) => b.kind.keyword(),
            ItemKind::Variable(_) => "variable",
            ItemKind::Machine(_) => "machine",
            ItemKind::Mission(_) => "mission",
            ItemKind::Scenario(_) => "scenario",
            ItemKind::For(_) => "for",
            ItemKind::Coverage(_) => "coverage",
            ItemKind::Run(_) => "run",
        };
        self.keyword(word, item.span.range().start, SPEC.key(word, self.syntax));
        let (bound, around) = (self.bound.len(), self.around.clone());
        match &item.kind {
            ItemKind::Import(_) | ItemKind::Allow(_) => {}
            ItemKind::Param(p) => {
                self.expression(&p.value);
                self.section(&p.range, &PARAM);
            }
            ItemKind::Let(l) => {
                self.around.state = true;
                self.expression(&l.value);
            }
            ItemKind::For(repeat) => self.repeat(repeat, item.span, |r, item| r.item(item)),
            ItemKind::Robot(r) => {
                if let Some(base) = &r.base {
                    let robots = &[SymbolKind::Robot];
                    self.spanned_name(&base.value, base.span, Class::Robot, SymbolKind::Robot, robots);
                }
                self.section(&r.body, &ROBOT);
            }
            ItemKind::Task(t) => {
                self.formals((Class::Task, &t.name.value), &t.parameters, item.span);
                self.definition(&t.definition);
            }
            ItemKind::Stack(s) => {
                self.formals((Class::Stack, &s.name.value), &s.parameters, item.span);
                self.stack(s);
            }
            ItemKind::Signal(s) => {
                let types = || signal_types().map(|t| Offered { name: t.to_string(), about: "type of a signal" });
                self.is_cursor(&s.ty.value, |_| CompletionContext::Offered(types().collect()));
                self.section(&s.settings, &SIGNAL);
            }
            ItemKind::Block(b) => match b.kind {
                BlockKind::Human => {
                    self.around.human = self.declared(Class::Value, &b.name.value);
                    self.section(&b.body, &HUMAN);
                }
                BlockKind::SafetyField => {
                    self.around.arguments = FIELD_DISTANCE;
                    self.section(&b.body, &SAFETY_FIELD);
                }
                BlockKind::Obstacle => self.section(&b.body, &OBSTACLE),
            },
            ItemKind::Variable(v) => {
                let held = || signal_types().filter(|t| !matches!(*t, "event" | "wrench"));
                let types = || held().map(|t| Offered { name: t.to_string(), about: "type of a variable" });
                self.is_cursor(&v.ty.value, |_| CompletionContext::Offered(types().collect()));
                v.value.iter().for_each(|value| self.expression(value));
            }
            ItemKind::Machine(m) => self.machine(m),
            ItemKind::Mission(m) => self.mission(m),
            ItemKind::Scenario(s) => {
                let mission = s.body.get("mission");
                self.around.of_mission = mission.is_some();
                let machine = s.body.get("machine");
                self.around.holder = machine.and_then(|e| self.declared(Class::Machine, e.value.word()?));
                self.around.mission = mission.and_then(|e| self.declared(Class::Mission, e.value.word()?));
                self.around.roles = acting(self.around.mission.and_then(|m| find(&self.out.symbol(m).ty)));
                self.section(&s.body, &SCENARIO);
                s.expects.iter().for_each(|e| self.formula(&e.formula));
            }
            ItemKind::Coverage(c) => self.section(&c.body, &COVERAGE),
            ItemKind::Run(r) => self.section(&r.body, &RUN),
        }
        self.bound.truncate(bound);
        self.around = around;
    }

    /// Resolves with another context, which is restored.
    pub(super) fn with(&mut self, around: Around, f: impl FnOnce(&mut Self)) {
        let before = std::mem::replace(&mut self.around, around);
        f(self);
        self.around = before;
    }

    /// Resolves the parameters of a declaration, and adds them to the scope.
    fn formals(&mut self, (class, owner): (Class, &str), all: &[Parameter], within: Span) {
        let owner = self.declared(class, owner);
        for p in all {
            let types = || parameter_types().map(|(name, about)| Offered { name: name.to_string(), about });
            self.is_cursor(&p.ty.value, |_| CompletionContext::Offered(types().collect()));
            if let Some(default) = &p.default {
                self.argument(Some(&p.ty.value), default);
            }
            if let Some(id) = owner.and_then(|owner| self.inside(owner, SymbolKind::Parameter, &p.name.value)) {
                self.bind(&p.name.value, id, within);
            }
        }
    }

    /// Resolves a repetition; `f` resolves each part of it.
    pub(super) fn repeat<T>(&mut self, repeat: &Repeat<T>, within: Span, mut f: impl FnMut(&mut Self, &T)) {
        let outer = self.bound.len();
        self.repeated_over(&repeat.variable, &repeat.values, within);
        repeat.body.iter().for_each(|part| f(self, part));
        self.bound.truncate(outer);
    }

    /// Resolves the values of a repetition, and adds its variable to the scope; the caller truncates the scope.
    pub(super) fn repeated_over(&mut self, variable: &Spanned<String>, values: &Values, within: Span) {
        match values {
            Values::List(list) => self.anything(list),
            Values::Range(first, last) => {
                self.anything(first);
                self.anything(last);
            }
        }
        let new = New::of(SymbolKind::Parameter, variable, variable.span);
        if let Some(id) = self.declare(FileId(0), &new) {
            self.bind(&variable.value, id, within);
        }
    }

    fn bind(&mut self, name: &str, id: SymbolId, within: Span) {
        self.bound.push((name.to_string(), id));
        self.holes.push((within.range(), name.to_string(), id));
    }

    /// Resolves the names in holes, `${side}`, by the text: they may stand in every name and text.
    pub(super) fn holes(&mut self) {
        let letter = |c: char| c.is_ascii_alphanumeric() || c == '_';
        for (at, _) in self.text.match_indices("${") {
            let line = self.text[..at].rsplit('\n').next().unwrap_or("").trim_start();
            let inner = self.text[at + 2..].split('}').next().unwrap_or("");
            if line.starts_with("//") || line.starts_with('#') {
                continue;
            }
            let (mut start, mut rest) = (at + 2, inner);
            while let Some(first) = rest.find(letter) {
                let word = &rest[first..];
                let word = &word[..word.find(|c| !letter(c)).unwrap_or(word.len())];
                let place = start + first..start + first + word.len();
                (start, rest) = (place.end, &rest[first + word.len()..]);
                // Of nested scopes, the inner one is added last.
                let mut around = self.holes.iter().rev().filter(|(range, name, _)| range.contains(&at) && name == word);
                if let Some((_, _, id)) = around.next() {
                    let meaning = Meaning::Symbol(*id);
                    self.out.references.push(Reference { place, exact: true, declares: false, meaning });
                }
            }
        }
    }
}
