//! Indexes signals, machines and their states.

use compiler::sections::{Key, MACHINE, SIGNAL, STATE, Section, TRANSITION};
use compiler::{VERBS, Verb, signal_types};
use dsl::tree::{
    Action, Block, Call, Item, Machine, Signal, State, StateBody, Transition, Trigger, Value, ValueKind, Variable,
};
use dsl::{Span, Spanned, Syntax};

use super::mentions::{Class, MARKER, Slot, Walker, What};
use super::walk::word;

/// Verb of that name.
pub(super) fn verb(name: &str) -> Option<&'static Verb> {
    VERBS.iter().find(|v| v.name == name)
}

/// Verbs with this outcome.
pub(super) fn outcome_of(event: &str) -> impl Iterator<Item = &'static Verb> {
    VERBS.iter().filter(move |v| v.outcomes.contains(&event))
}

impl Walker<'_> {
    pub(super) fn declared_signal(&mut self, s: &Signal, item: &Item) {
        let class = if s.ty.value == "event" { Class::Event } else { Class::Signal };
        self.found.types.entry(s.name.value.clone()).or_insert_with(|| s.ty.value.clone());
        self.declare((class, s.name.value.clone()), &s.name, item.span, &item.comments.before);
    }

    pub(super) fn declared_variable(&mut self, v: &Variable, item: &Item) {
        self.found.types.entry(v.name.value.clone()).or_insert_with(|| v.ty.value.clone());
        self.declare((Class::Signal, v.name.value.clone()), &v.name, item.span, &item.comments.before);
    }

    pub(super) fn declared_machine(&mut self, m: &Machine, item: &Item) {
        self.declare((Class::Machine, m.name.value.clone()), &m.name, item.span, &item.comments.before);
        self.declared_states(&m.body, &m.name.value);
        // Events that states raise. Only after all declarations are read is it known whether a signal declares them.
        self.raised(&m.body);
    }

    fn declared_states(&mut self, body: &StateBody, path: &str) {
        for s in &body.states {
            let inner = format!("{path}.{}", s.name.value);
            self.declare((Class::State, inner.clone()), &s.name, s.span, &s.comments.before);
            self.declared_states(&s.body, &inner);
        }
    }

    /// Records the events that actions raise.
    fn raised(&mut self, body: &StateBody) {
        for a in &body.actions {
            let Some(verb) = verb(&a.verb.value) else { continue };
            let (place, _) = self.place(&a.verb.value, a.verb.span);
            for outcome in verb.outcomes {
                self.found.raised.entry((*outcome).to_string()).or_insert_with(|| place.clone());
            }
            let named = a.args.first().filter(|_| verb.raises).and_then(|v| Some((word(v)?, v.span)));
            if let Some((event, span)) = named.filter(|(event, _)| *event != MARKER) {
                let (place, _) = self.place(event, span);
                self.found.raised.entry(event.to_string()).or_insert(place);
            }
        }
        body.states.iter().for_each(|s| self.raised(&s.body));
    }

    pub(super) fn signal(&mut self, s: &Signal) {
        let types = || Slot::Offered(signal_types().map(|t| (t.to_string(), "type of a signal")).collect());
        self.marked(&s.ty.value, types);
        self.section(&s.settings, &SIGNAL);
    }

    pub(super) fn variable(&mut self, v: &Variable) {
        let types = || {
            let held = signal_types().filter(|t| !matches!(*t, "event" | "wrench"));
            Slot::Offered(held.map(|t| (t.to_string(), "type of a variable")).collect())
        };
        self.marked(&v.ty.value, types);
        if let Some(value) = &v.value {
            self.expression(value);
        }
    }

    pub(super) fn machine(&mut self, m: &Machine) {
        self.state_body(&m.body, &m.name.value, &MACHINE);
    }

    fn state_body(&mut self, body: &StateBody, path: &str, section: &'static Section) {
        if let Some(call) = &body.stack {
            self.word_before("stack", call.name.span, STATE.key("stack", self.syntax));
            self.stack_call(call);
        }
        self.settings(&body.settings, path, section);
        for a in &body.actions {
            self.action(a);
        }
        for t in &body.transitions {
            self.transition(t, path);
        }
        for s in &body.states {
            self.state(s, path);
        }
    }

    fn state(&mut self, s: &State, path: &str) {
        if self.syntax == Syntax::Native {
            self.word_before("state", s.name.span, STATE.key("state", self.syntax));
            if let Some(at) = s.final_ {
                self.key_at("final", at, STATE.key("final", self.syntax));
            }
        } else if let Some(at) = s.final_ {
            self.key_at("final", at, STATE.key("final", self.syntax));
        }
        self.state_body(&s.body, &format!("{path}.{}", s.name.value), &STATE);
    }

    fn settings(&mut self, settings: &Block, path: &str, section: &'static Section) {
        self.section(settings, section);
        let Some(name) = settings.get("initial").map(|e| &e.value) else { return };
        let Some(said) = word(name) else { return };
        let own = || Slot::Offered(self.children(path).map(|s| (s, Class::State.word())).collect());
        if said == MARKER {
            self.found.slot = Some(own());
            return;
        }
        self.note(said, name.span, What::Declared(Class::State, format!("{path}.{said}")));
    }

    /// Direct inner states of a state or machine.
    fn children(&self, path: &str) -> impl Iterator<Item = String> {
        let inside = self.inside(path);
        inside.into_iter().filter(|name| !name.contains('.'))
    }

    /// All inner states of a state, as relative paths.
    pub(super) fn inside(&self, path: &str) -> Vec<String> {
        let names = self.found.names(Class::State);
        names.filter_map(|n| n.strip_prefix(path)?.strip_prefix('.')).map(str::to_string).collect()
    }

    fn stack_call(&mut self, call: &Call) {
        if !self.marked(&call.name.value, || Slot::Stack) {
            self.note(&call.name.value, call.name.span, What::Declared(Class::Stack, call.name.value.clone()));
        }
        self.arguments(&format!("stack {}", call.name.value), &call.args, &call.named);
    }

    fn action(&mut self, a: &Action) {
        self.key_at(a.moment.value.word(), a.moment.span, STATE.key(a.moment.value.word(), self.syntax));
        if self.marked(&a.verb.value, || Slot::Verbs) {
            return;
        }
        let Some(verb) = verb(&a.verb.value) else { return };
        self.note(verb.name, a.verb.span, What::Verb(verb));
        for (i, value) in a.args.iter().enumerate() {
            if verb.own {
                match i {
                    0 => self.signal_name(value),
                    _ => self.condition(value),
                }
                continue;
            }
            match word(value) {
                Some(MARKER) => {
                    self.found.slot = Some(match i {
                        0 if verb.raises => Slot::Events { whole: false },
                        0 => Slot::Words(verb.words),
                        _ => Slot::Nothing,
                    });
                }
                Some(event) if i == 0 && verb.raises => self.event(event, value.span),
                Some(_) => {}
                None => self.expression(value),
            }
        }
    }

    /// Indexes the name of an event.
    pub(super) fn event(&mut self, name: &str, span: Span) {
        let class = if self.has(Class::Event, name) { Class::Event } else { Class::Raised };
        let (place, _) = self.place(name, span);
        let own = class == Class::Raised && outcome_of(name).next().is_none();
        if own && self.found.raised.get(name) == Some(&place) {
            return self.declare((class, name.to_string()), &Spanned::new(name.to_string(), span), span, &[]);
        }
        self.note(name, span, What::Declared(class, name.to_string()));
    }

    fn transition(&mut self, t: &Transition, path: &str) {
        let syntax = self.syntax;
        let key = |name: &str| STATE.key(name, syntax).or_else(|| TRANSITION.key(name, syntax));
        match &t.trigger {
            Trigger::On(value) => {
                self.word_before("on", value.span, key("on"));
                self.happening(value);
            }
            Trigger::When { condition, hold } => {
                self.word_before("when", condition.span, key("when"));
                self.condition(condition);
                if let Some(hold) = hold {
                    self.word_before("for", hold.span, TRANSITION.key("for", Syntax::Yaml));
                    self.expression(hold);
                }
            }
            Trigger::After(value) => {
                self.word_before("after", value.span, key("after"));
                self.expression(value);
            }
            Trigger::Missing => {}
        }
        self.word_before("to", t.target.span, TRANSITION.key("to", syntax));
        self.target(&t.target, path);
        self.section(&t.settings, &TRANSITION);
    }

    /// Indexes a condition, which may depend on the robot's current state.
    fn condition(&mut self, value: &Value) {
        let before = (self.state, self.condition);
        (self.state, self.condition) = (true, true);
        self.expression(value);
        (self.state, self.condition) = before;
    }

    /// Indexes the trigger after `on`.
    fn happening(&mut self, value: &Value) {
        match &value.kind {
            ValueKind::Call(function, args) => {
                self.note(&function.value, function.span, What::BuiltIn(function.value.clone()));
                match (function.value.as_str(), args.as_slice()) {
                    ("reached", [task, tolerances @ ..]) => {
                        self.task_name(task);
                        tolerances.iter().for_each(|v| self.expression(v));
                    }
                    ("fault", [pattern]) => self.fault(pattern),
                    (_, args) => args.iter().for_each(|v| self.expression(v)),
                }
            }
            _ => {
                let Some(name) = word(value) else { return };
                if !self.marked(name, || Slot::Events { whole: true }) {
                    self.event(name, value.span);
                }
            }
        }
    }

    fn fault(&mut self, pattern: &Value) {
        match &pattern.kind {
            ValueKind::Call(kind, args) => {
                self.note(&kind.value, kind.span, What::BuiltIn(kind.value.clone()));
                let Some(first) = args.first() else { return };
                match kind.value.as_str() {
                    "stale" => self.signal_name(first),
                    "limit" => self.task_name(first),
                    "infeasible" => {
                        let levels = self.found.names(Class::Level).filter_map(|n| n.rsplit('.').next());
                        let mut levels: Vec<_> = levels.map(|n| (n.to_string(), Class::Level.word())).collect();
                        levels.dedup();
                        self.marked(word(first).unwrap_or(""), || Slot::Offered(levels));
                    }
                    _ => {}
                }
            }
            _ => {
                let Some(kind) = word(pattern) else { return };
                if !self.marked(kind, || Slot::Faults) {
                    self.note(kind, pattern.span, What::BuiltIn(kind.to_string()));
                }
            }
        }
    }

    fn task_name(&mut self, value: &Value) {
        let Some(name) = word(value) else { return };
        if !self.marked(name, || Slot::Task) {
            self.note(name, value.span, What::Declared(Class::Task, name.to_string()));
        }
    }

    /// Indexes the name of a signal or human, in `present(..)` and `stale(..)`.
    pub(super) fn signal_name(&mut self, value: &Value) {
        if self.human_name(value) {
            return;
        }
        let Some(name) = word(value) else { return };
        if !self.marked(name, || Slot::Signal) {
            self.note(name, value.span, What::Declared(Class::Signal, name.to_string()));
        }
    }

    /// Indexes the target of a transition: searched inside its state first, then in each enclosing state. Each word of
    /// the path refers to a state.
    fn target(&mut self, target: &Spanned<String>, path: &str) {
        let parts: Vec<&str> = target.value.split('.').collect();
        let around = || std::iter::successors(Some(path), |p| p.rsplit_once('.').map(|(outer, _)| outer));
        let first = parts.first().copied().unwrap_or("");
        let found = around().find(|p| self.has(Class::State, &format!("{p}.{first}")));
        if target.value.ends_with(MARKER) {
            let mut names: Vec<String> = Vec::new();
            match parts.split_last().filter(|(_, before)| !before.is_empty()) {
                Some((_, before)) => {
                    let holder = found.map(|p| format!("{p}.{}", before.join(".")));
                    names.extend(holder.iter().flat_map(|h| self.inside(h)));
                }
                None => {
                    for name in around().flat_map(|p| self.inside(p)) {
                        if !names.contains(&name) {
                            names.push(name);
                        }
                    }
                }
            }
            self.found.slot = Some(Slot::Offered(names.into_iter().map(|n| (n, Class::State.word())).collect()));
            return;
        }
        let Some(found) = found else { return };
        let (place, exact) = self.place(&target.value, target.span);
        let (mut key, mut start) = (found.to_string(), place.start);
        for part in parts {
            key = format!("{key}.{part}");
            let span = match exact {
                true => Span::new(target.span.source, start, start + part.len()),
                false => target.span,
            };
            self.note(part, span, What::Declared(Class::State, key.clone()));
            start += part.len() + 1;
        }
    }

    /// Indexes the name of a machine.
    pub(super) fn machine_name(&mut self, value: &Value) {
        let Some(name) = word(value) else { return };
        if !self.marked(name, || Slot::Machine) {
            self.note(name, value.span, What::Declared(Class::Machine, name.to_string()));
        }
    }

    /// Records a keyword, if it is at this span.
    fn key_at(&mut self, name: &str, span: Span, key: Option<&'static Key>) {
        let stands = self.text.get(span.range()).is_some_and(|t| t == name);
        if let Some(key) = key.filter(|_| stands) {
            self.note(name, span, What::Key(key));
        }
    }

    /// Records a keyword, if it precedes a value.
    fn word_before(&mut self, name: &str, value: Span, key: Option<&'static Key>) {
        let before = self.text.get(..value.range().start).unwrap_or("");
        let before = before.trim_end_matches(|c: char| c.is_whitespace() || matches!(c, ':' | '"' | '\'' | '('));
        let start = before.len().saturating_sub(name.len());
        let bounds = before.get(..start).is_some_and(|b| !b.ends_with(|c: char| c.is_ascii_alphanumeric() || c == '_'));
        if let Some(key) = key.filter(|_| before.ends_with(name) && bounds) {
            self.note(name, Span::new(value.source, start, before.len()), What::Key(key));
        }
    }
}
