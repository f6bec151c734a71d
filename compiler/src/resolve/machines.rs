//! References in machines: states, events, actions and triggers.

use dsl::tree::{Action, Entry, Expect, Machine, State, StateBody, Transition, Trigger, Value, ValueKind};
use dsl::{Span, Spanned, Syntax};

use super::symbols::{FileId, SymbolId, SymbolKind as K};
use super::walk::place_of;
use super::{Around, CompletionContext as C, Meaning, Offered, Reference, Resolver};
use crate::expand::Class;
use crate::expr::REACHED;
use crate::lowering::VERBS;
use crate::sections::{BlockSchema, InSyntax, MACHINE, STATE, TRANSITION};

/// Names of a path such as `outer.inner`, each with its span.
pub(super) fn path_of(value: &Value) -> Vec<Spanned<String>> {
    let (mut parts, mut rest) = (Vec::new(), value);
    while let ValueKind::Field(inner, field) = &rest.kind {
        parts.push(field.clone());
        rest = inner;
    }
    parts.extend(rest.word().map(|first| Spanned::new(first.to_string(), rest.span)));
    parts.reverse();
    parts
}

impl Resolver<'_> {
    pub(super) fn machine(&mut self, m: &Machine) {
        let holder = self.declared(Class::Machine, &m.name.value);
        self.with(Around { holder, ..self.around.clone() }, |r| r.state_body(&m.body, &MACHINE));
    }

    fn state_body(&mut self, body: &StateBody, section: &'static BlockSchema) {
        if let Some(call) = &body.stack {
            self.keyword_before("stack", call.name.span, STATE.key("stack", self.syntax));
            self.stack_call(call);
        }
        self.section(&body.settings, section);
        body.actions.iter().for_each(|a| self.action(a));
        body.transitions.iter().for_each(|t| self.transition(t));
        body.properties.iter().for_each(|p| self.property(p));
        body.states.iter().for_each(|s| self.state(s));
    }

    /// Resolves `check always FORMULA`; its states are those of the whole machine.
    fn property(&mut self, p: &Expect) {
        if self.syntax == Syntax::Native {
            self.keyword("check", p.span.range().start, STATE.key("check", self.syntax));
        }
        let mut outermost = self.around.holder;
        while let Some(outer) = outermost.and_then(|id| self.out.symbol(id).container) {
            outermost = Some(outer);
        }
        self.with(Around { holder: outermost, ..self.around.clone() }, |r| r.formula(&p.formula));
    }

    fn state(&mut self, s: &State) {
        if self.syntax == Syntax::Native {
            self.keyword_before(s.word(), s.name.span, STATE.key(s.word(), self.syntax));
        }
        if let Some(at) = s.final_ {
            self.keyword("final", at.range().start, STATE.key("final", self.syntax));
        }
        let holder = self.around.holder.and_then(|outer| self.inside(outer, K::State, &s.name.value));
        self.with(Around { holder, ..self.around.clone() }, |r| r.state_body(&s.body, &STATE));
    }

    /// Resolves the initial state of the machine or state.
    pub(super) fn initial_state(&mut self, name: &str, span: Span) {
        let Some(holder) = self.around.holder else { return };
        let own = |r: &Self| r.offering(&r.all_inside(holder, K::State), |s| s.kind.word());
        if !self.is_cursor(name, own) {
            let found = self.inside(holder, K::State, name);
            self.refer(name, span, K::State, found);
        }
    }

    fn action(&mut self, a: &Action) {
        let moment = a.moment.value.word();
        self.keyword(moment, a.moment.span.range().start, STATE.key(moment, self.syntax));
        if self.is_cursor(&a.verb.value, |_| C::Verbs) {
            return;
        }
        let Some(verb) = VERBS.iter().find(|v| v.name == a.verb.value) else { return };
        self.note(verb.name, a.verb.span, Meaning::Verb(verb));
        for (i, value) in a.args.iter().enumerate() {
            match (i, value.word()) {
                (0, _) if verb.own => self.signal_or_human(value),
                _ if verb.own => self.condition(value),
                (0, Some(event)) if verb.raises => self.event_name(event, value.span, false),
                (0, Some(word)) => {
                    self.is_cursor(word, |_| C::Words(verb.words));
                }
                (_, Some(word)) => {
                    self.is_cursor(word, |_| C::Nothing);
                }
                (_, None) => self.expression(value),
            }
        }
    }

    /// Resolves the name of an event.
    pub(super) fn event_name(&mut self, name: &str, span: Span, triggers: bool) {
        if self.is_cursor(name, |_| C::Events { triggers }) {
            return;
        }
        let found = self.event(name);
        // The first action that raises an event declares it.
        let (place, _) = place_of(self.text, name, span);
        let declares = |id: SymbolId| self.out.symbol(id).kind == K::RaisedEvent && self.out.symbol(id).place == place;
        if !found.is_some_and(declares) {
            self.refer(name, span, K::Event, found);
        }
    }

    fn transition(&mut self, t: &Transition) {
        let syntax = self.syntax;
        let key = |name: &str| STATE.key(name, syntax).or_else(|| TRANSITION.key(name, syntax));
        match &t.trigger {
            Trigger::On(value) => {
                self.keyword_before("on", value.span, key("on"));
                self.trigger(value);
            }
            Trigger::When { condition, hold } => {
                self.keyword_before("when", condition.span, key("when"));
                self.condition(condition);
                if let Some(hold) = hold {
                    self.keyword_before("for", hold.span, TRANSITION.key("for", Syntax::Yaml));
                    self.expression(hold);
                }
            }
            Trigger::After(value) => {
                self.keyword_before("after", value.span, key("after"));
                self.expression(value);
            }
            Trigger::Missing => {}
        }
        self.keyword_before("to", t.target.span, TRANSITION.key("to", syntax));
        self.target(&t.target);
        self.section(&t.settings, &TRANSITION);
    }

    /// Resolves a condition, which may depend on the robot's current state.
    fn condition(&mut self, value: &Value) {
        self.with(Around { state: true, condition: true, ..self.around.clone() }, |r| r.expression(value));
    }

    /// Resolves the trigger after `on`.
    fn trigger(&mut self, value: &Value) {
        match &value.kind {
            ValueKind::Call(function, args) => {
                self.note_built_in(function);
                match (function.value.as_str(), args.as_slice()) {
                    (REACHED, [task, bounds @ ..]) => self.target_task(task, bounds),
                    ("fault", [pattern]) => self.fault(pattern),
                    ("ended", regions) => regions.iter().for_each(|r| self.region(r)),
                    (_, args) => args.iter().for_each(|v| self.expression(v)),
                }
            }
            _ => {
                if let Some(name) = value.word() {
                    self.event_name(name, value.span, true);
                }
            }
        }
    }

    /// Resolves a region in `ended(..)`: one of the state that has the trigger, or of a state around it.
    fn region(&mut self, value: &Value) {
        let around: Vec<SymbolId> =
            std::iter::successors(self.around.holder, |id| self.out.symbol(*id).container).collect();
        let Some(name) = value.word() else { return };
        let offer = |r: &Self| {
            let mut offered = Vec::new();
            around.iter().flat_map(|h| r.all_inside(*h, K::State)).for_each(|id| {
                offered.push(Offered { name: r.out.symbol(id).name.clone(), about: K::State.word() });
            });
            C::Offered(offered)
        };
        if self.is_cursor(name, offer) {
            return;
        }
        if let Some(found) = around.iter().find_map(|h| self.inside(*h, K::State, name)) {
            self.refer(name, value.span, K::State, Some(found));
        }
    }

    /// Resolves the arguments of `reached(..)`: a task, or a use of one with parameters, and numbers.
    pub(super) fn target_task(&mut self, task: &Value, bounds: &[Value]) {
        match &task.kind {
            ValueKind::Call(function, args) => {
                let owner = self.declared(Class::Task, &function.value);
                self.spanned_name(&function.value, function.span, Class::Task, K::Task, &[K::Task]);
                let (named, positional): (Vec<&Value>, Vec<&Value>) =
                    args.iter().partition(|a| matches!(a.kind, ValueKind::Named(..)));
                let entry = |value: &Value| match &value.kind {
                    ValueKind::Named(key, value) => {
                        Some(Entry { key: key.clone(), value: (**value).clone(), comments: Default::default() })
                    }
                    _ => None,
                };
                let named: Vec<Entry> = named.into_iter().filter_map(entry).collect();
                let positional: Vec<Value> = positional.into_iter().cloned().collect();
                self.arguments(owner, &positional, &named);
            }
            // The name of a use, `reach.left`.
            ValueKind::Field(inner, _) if inner.word().is_some() => {
                self.name_in(inner, Class::Task, K::Task, &[K::Task]);
            }
            _ => self.name_in(task, Class::Task, K::Task, &[K::Task]),
        }
        bounds.iter().for_each(|v| self.expression(v));
    }

    /// Resolves the kind of a fault, with its argument.
    pub(super) fn fault(&mut self, pattern: &Value) {
        match &pattern.kind {
            ValueKind::Call(kind, args) => {
                self.note_built_in(kind);
                let Some(first) = args.first() else { return };
                match kind.value.as_str() {
                    "stale" => self.signal_or_human(first),
                    "limit" => self.name_in(first, Class::Task, K::Task, &[K::Task]),
                    "infeasible" => self.any_level(first),
                    _ => {}
                }
            }
            _ => {
                if let Some(kind) = pattern.word()
                    && !self.is_cursor(kind, |_| C::Faults)
                {
                    self.note(kind, pattern.span, Meaning::BuiltIn(kind.to_string()));
                }
            }
        }
    }

    /// Offers the levels of all stacks. A level of this name may stand in several stacks, so that it is no reference.
    fn any_level(&mut self, value: &Value) {
        let levels = |r: &Self| {
            let own = r.out.symbols.iter().filter(|s| s.kind == K::Level);
            let mut names: Vec<&str> = own.map(|s| s.name.as_str()).collect();
            names.sort_unstable();
            names.dedup();
            let one = |name: &&str| Offered { name: (*name).to_string(), about: K::Level.word() };
            C::Offered(names.iter().map(one).collect())
        };
        self.cursor_in(value, levels);
    }

    /// Paths of the states inside a state or machine.
    fn states_below(&self, holder: SymbolId, before: &str, out: &mut Vec<Offered>) {
        for id in self.all_inside(holder, K::State) {
            let name = format!("{before}{}", self.out.symbol(id).name);
            self.states_below(id, &format!("{name}."), out);
            if out.iter().all(|o| o.name != name) {
                out.push(Offered { name, about: K::State.word() });
            }
        }
    }

    /// Resolves a path of states from a holder, as far as states have these names.
    fn state_path(&self, holder: SymbolId, parts: &[&str]) -> Vec<SymbolId> {
        let mut found = Vec::new();
        for part in parts {
            let Some(id) = self.inside(found.last().copied().unwrap_or(holder), K::State, part) else { break };
            found.push(id);
        }
        found
    }

    /// Resolves the target of a transition: searched inside its state first, then in each enclosing state. Each word of
    /// the path refers to a state.
    fn target(&mut self, target: &Spanned<String>) {
        let parts: Vec<&str> = target.value.split('.').collect();
        let around: Vec<SymbolId> =
            std::iter::successors(self.around.holder, |id| self.out.symbol(*id).container).collect();
        let holder = around.iter().copied().find(|h| self.inside(*h, K::State, parts[0]).is_some());
        if target.value.ends_with(super::CURSOR) {
            let mut offered = Vec::new();
            match parts.split_last().filter(|(_, before)| !before.is_empty()) {
                Some((_, before)) => {
                    let path = holder.map(|h| self.state_path(h, before)).unwrap_or_default();
                    if let Some(last) = path.get(before.len() - 1) {
                        self.states_below(*last, "", &mut offered);
                    }
                }
                None => around.iter().for_each(|h| self.states_below(*h, "", &mut offered)),
            }
            self.out.context = Some(C::Offered(offered));
            return;
        }
        let path = holder.map(|h| self.state_path(h, &parts)).unwrap_or_default();
        self.dotted(target, &path, K::State);
    }

    /// Records the words of a path that is a single word of the tree.
    fn dotted(&mut self, path: &Spanned<String>, found: &[SymbolId], kind: K) {
        let (place, exact) = place_of(self.text, &path.value, path.span);
        let mut start = place.start;
        for (i, part) in path.value.split('.').enumerate().filter(|(_, part)| !part.is_empty()) {
            let meaning = match found.get(i) {
                Some(id) => Meaning::Symbol(*id),
                None => Meaning::Unknown(kind, part.to_string()),
            };
            let place = if exact { start..start + part.len() } else { place.clone() };
            self.out.references.push(Reference { place, exact, declares: false, meaning });
            start += part.len() + 1;
        }
    }

    /// Resolves a state in `in(..)`, by its path from a machine or by the end of that path.
    pub(super) fn state_of_machine(&mut self, value: &Value) {
        let machines = self.around.holder.map_or_else(|| self.machines_of(FileId(0)), |machine| vec![machine]);
        self.states_of(&machines, &path_of(value));
    }

    /// Resolves states of machines by a path, or by the end of one. A complete path has precedence.
    pub(super) fn states_of(&mut self, machines: &[SymbolId], parts: &[Spanned<String>]) {
        let words: Vec<&str> = parts.iter().map(|p| p.value.as_str()).collect();
        if let Some(at) = words.iter().position(|w| *w == super::CURSOR) {
            let mut offered = Vec::new();
            for machine in machines {
                let path = self.state_path(*machine, &words[..at]);
                if path.len() == at {
                    self.states_below(path.last().copied().unwrap_or(*machine), "", &mut offered);
                }
            }
            self.out.context = Some(C::Offered(offered));
            return;
        }
        // Holders from the outside in.
        let mut open: Vec<SymbolId> = machines.to_vec();
        let mut at = 0;
        let mut best = Vec::new();
        while let Some(holder) = open.get(at).copied() {
            let path = self.state_path(holder, &words);
            if path.len() == words.len() {
                best = path;
                break;
            }
            open.extend(self.all_inside(holder, K::State));
            at += 1;
        }
        for (i, part) in parts.iter().enumerate() {
            self.refer(&part.value, part.span, K::State, best.get(i).copied());
        }
    }
}
