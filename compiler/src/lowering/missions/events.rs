//! Events of a scenario of a mission, and the feedback of people. The events of a kind are those of its entry.

use blocks::{Bound, BoundBlock, Located};
use dsl::tree::{Block, Entry};
use dsl::{Diagnostic, Help, Snippet, Span};
use mission::kind::{Detail, Event, EventInfo, Replies};
use mission::kinds::KINDS;
use names::list;
use runtime::program::{MAX_EVENTS, TimedEvent};

use super::super::Lowerer;
use super::executed::{Executed, Owner};
use crate::block_binding::Scope;
use crate::forms::block_of;
use crate::sections::{APPROACHES, DISTANCES, EVENT, REPLY, WAITS};

/// True for the name of an event of some kind.
fn is_event(key: &str) -> bool {
    KINDS.iter().any(|kind| kind.event(key).is_some())
}

/// True for a further key of an event of some kind.
fn is_further(key: &str) -> bool {
    KINDS.iter().flat_map(|kind| kind.events).flat_map(|event| event.with).any(|further| further.key == key)
}

impl Lowerer<'_> {
    /// Lowers the events of a scenario, sorted by time.
    pub(super) fn mission_events(&mut self, body: &Block, of: Executed, duration: f64) -> Vec<TimedEvent> {
        let Some(e) = body.get("happens") else { return Vec::new() };
        let mut all: Vec<TimedEvent> = Vec::new();
        let items = e.value.items();
        if items.len() > MAX_EVENTS {
            let text = format!("{} events are more than a scenario may have", items.len());
            let d = Diagnostic::error("HQ0924", e.key.span, text);
            self.push(d.help(format!("write at most {MAX_EVENTS}, or several scenarios")));
            return all;
        }
        for item in items {
            let Some(block) = block_of(item, "the event", self.diagnostics) else { continue };
            let bound = self.block_binder(&Scope::default()).block(block, &EVENT, item.span);
            let at = self.happens_at(&bound, duration);
            let what = self.event_of_mission(block, &bound, of);
            if let (Some(at), Some(what)) = (at, what) {
                all.push(TimedEvent { at, what });
            }
        }
        all.sort_by(|a, b| a.at.total_cmp(&b.at));
        all
    }

    fn happens_at(&mut self, bound: &BoundBlock, duration: f64) -> Option<f64> {
        let at: Located<f64> = bound.read("at")?;
        if at.value > duration {
            let text = format!("this event is after the end of the run at {} s", runtime::text::number(duration));
            let d = Diagnostic::warning("HQ0923", self.origins.span(at.at), text);
            self.push(d.help("write an earlier time, or a longer `duration`"));
        }
        Some(at.value)
    }

    /// The event of a block.
    fn event_of_mission(&mut self, block: &Block, bound: &BoundBlock, of: Executed) -> Option<Event> {
        let kind = of.kind();
        let names: Vec<&str> = kind.events.iter().map(|event| event.name).collect();
        let e = self.said(block, bound, &names)?;
        let name = e.key.value.as_str();
        let Some(info) = kind.event(name) else {
            let d = Diagnostic::error("HQ0922", e.key.span, format!("`{name}` is not an event of {}", kind.title));
            let why = kind.absent.iter().find(|absent| absent.0 == name).map(|absent| absent.1);
            let d = why.map_or(d.clone(), |why| d.note(why));
            self.push(d.help(format!("leave it out; there is {}", list(names.iter().copied(), 9))));
            return None;
        };
        if !self.no_further(block, e, info) {
            return None;
        }
        let who: Located<String> = bound.read(name)?;
        let (member, role) = self.participant(&who.value, e.value.span, of)?;
        if let Some(not) = info.not_of.iter().find(|not| not.role == role) {
            let text = format!("`{name}` is not possible for {}", not.who);
            let d = Diagnostic::error("HQ0922", e.value.span, text).note(not.why);
            self.push(d.help("name another member, or remove it"));
            return None;
        }
        if let Some(why) = info.not_driven.filter(|_| of.driven.contains(&member)) {
            let text = format!("`{name}` is not possible for a robot that a controller drives");
            let d = Diagnostic::error("HQ0922", e.value.span, text).note(why);
            self.push(d.help(Help::with(
                "remove it, or let nobody run a controller: {}",
                [Snippet::entry("operations", "planned")],
            )));
            return None;
        }
        let mut event = Event::of(name, member);
        for further in info.with {
            if further.required.is_some_and(|example| self.lacks_further(e, bound, further.key, example)) {
                return None;
            }
            if let Some(detail) = detail(bound, further.key)? {
                event = event.and(further.key, detail);
            }
        }
        if !info.with.is_empty() && event.with.is_empty() {
            let d = Diagnostic::error("HQ0922", e.key.span, format!("this {name} says nothing"));
            self.push(
                d.help(Help::with(
                    "rate at least one part: {}, {}, {}",
                    [("wait", "too_long"), ("approach", "very_fast"), ("distance", "close")]
                        .map(|(k, v)| Snippet::entry(k, v)),
                )),
            );
            return None;
        }
        if let Err(not) = of.mission.check_event(&event) {
            let d = Diagnostic::error("HQ0922", e.key.span, not.text);
            let d = not.note.map_or(d.clone(), |note| d.note(note));
            self.push(not.help.map_or(d.clone(), |help| d.help(help)));
            return None;
        }
        Some(event)
    }

    /// Reports a further key that the event does not have.
    fn no_further(&mut self, block: &Block, e: &Entry, info: &EventInfo) -> bool {
        let has = |key: &str| info.with.iter().any(|further| further.key == key);
        let of_others = |entry: &&Entry| !has(&entry.key.value) && is_further(&entry.key.value);
        let Some(wrong) = block.entries.iter().find(of_others) else { return true };
        let text = format!("`{}` has no `{}`", info.name, wrong.key.value);
        let d = Diagnostic::error("HQ0922", wrong.key.span, text);
        let has = match info.with {
            [] => "leave it out".to_string(),
            with => format!("it says more with {}", list(with.iter().map(|further| further.key), 4)),
        };
        self.push(d.label(e.key.span, "the event").help(has));
        false
    }

    /// Reports a further key that is missing; true then.
    fn lacks_further(&mut self, e: &Entry, bound: &BoundBlock, key: &str, example: &str) -> bool {
        if bound.get(key).is_some() {
            return false;
        }
        if !bound.is_wrong(key) {
            let d = Diagnostic::missing_keys([key], e.key.span, format!("`{}` needs `{key}`", e.key.value));
            self.push(d.help(Help::with("write for instance {} after it", [Snippet::entry(key, example)])));
        }
        true
    }

    /// The one entry that says what happens. `names` are the events of the kind.
    fn said<'b>(&mut self, block: &'b Block, bound: &BoundBlock, names: &[&str]) -> Option<&'b Entry> {
        let event = |e: &&Entry| is_event(&e.key.value);
        let mut events = block.entries.iter().filter(event);
        let Some(e) = events.next() else {
            // A word that no event has was reported, and may be the one that is meant.
            if block.entries.iter().any(|e| EVENT.entry(&e.key.value).is_none()) {
                return None;
            }
            let d = Diagnostic::error("HQ0922", self.origins.span(bound.at), "nothing happens here");
            self.push(d.help(format!("write an event with its member: {}", list(names.iter().copied(), 9))));
            return None;
        };
        if let Some(other) = events.next() {
            let d = Diagnostic::error("HQ0922", other.key.span, "write one event per entry");
            self.push(d.label(e.key.span, "the first").help(Help::with(
                "write it as an entry of its own, {}",
                [Snippet::braces([Snippet::entry("at", ".."), Snippet::dots()])],
            )));
            return None;
        }
        Some(e)
    }

    /// The member of a name: its index and role.
    fn participant(&mut self, name: &str, at: Span, of: Executed) -> Option<(usize, &'static str)> {
        match of.owner(name) {
            Some(Owner::Member(member, role)) => Some((member, role)),
            _ => {
                self.nobody_called(name, at, of);
                None
            }
        }
    }

    /// Reports a name that nobody has.
    fn nobody_called(&mut self, name: &str, at: Span, of: Executed) {
        let members = of.members();
        let names = || members.iter().copied();
        let d = Diagnostic::unknown_name(at, format!("the mission has no member `{name}`"));
        self.push(d.one_of("there are", name, names()));
    }

    /// The feedback of people after each service. Reports it for a kind that has none.
    pub(super) fn replies(&mut self, body: &Block, of: Executed) -> Vec<Replies> {
        let mut all = Vec::new();
        let Some(e) = body.get("feedback") else { return all };
        let Some(info) = of.kind().event("feedback") else { return all };
        let Some(block) = block_of(&e.value, "`feedback`", self.diagnostics) else { return all };
        for e in &block.entries {
            let Some((member, role)) = self.participant(&e.key.value, e.key.span, of) else { continue };
            if let Some(not) = info.not_of.iter().find(|not| not.role == role) {
                let text = format!("`feedback` is not possible for {}", not.who);
                self.push(Diagnostic::error("HQ0922", e.key.span, text).note(not.why).help("name a person"));
                continue;
            }
            let mut services = Vec::new();
            for item in e.value.items() {
                let Some(block) = block_of(item, "feedback of a service", self.diagnostics) else { continue };
                let bound = self.block_binder(&Scope::default()).block(block, &REPLY, item.span);
                services.extend(reply(&bound, member));
            }
            if !services.is_empty() {
                all.push(Replies { member, services });
            }
        }
        all
    }

    /// Reports keys of scenarios that a kind does not have.
    pub(super) fn absent_keys(&mut self, body: &Block, of: Executed) {
        let kind = of.kind();
        for (key, why) in kind.absent {
            let Some(e) = body.get(key) else { continue };
            let text = format!("a scenario of {} has no `{key}`", kind.title);
            let d = Diagnostic::error("HQ0921", e.key.span, text);
            let d = match body.get("mission") {
                Some(mission) => d.label(mission.value.span, format!("this is {}", kind.title)),
                None => d,
            };
            self.push(d.note(*why).help("leave it out"));
        }
    }
}

/// The value of a further key; `Some(None)` if it is left out, `None` if it is wrong.
fn detail(bound: &BoundBlock, key: &str) -> Option<Option<Detail>> {
    let Some(value) = bound.get(key) else { return (!bound.is_wrong(key)).then_some(None) };
    Some(Some(match &value.value {
        Bound::Pair(point) => Detail::Point(*point),
        Bound::Number(x) => Detail::Number(*x),
        Bound::Word(word) => {
            // A step of feedback, from -2 to 2.
            let words = [WAITS, APPROACHES, DISTANCES].into_iter().find_map(|w| w.iter().position(|w| w == word));
            Detail::Number(f64::from(i8::try_from(words?).ok()? - 2))
        }
        _ => return None,
    }))
}

/// The feedback of a person about a service; `Some(None)` if it is empty, `None` if it is wrong.
fn reply(bound: &BoundBlock, member: usize) -> Option<Option<Event>> {
    let mut event = Event::of("feedback", member);
    for key in REPLY.entries() {
        if let Some(detail) = detail(bound, key)? {
            event = event.and(key, detail);
        }
    }
    Some((!event.with.is_empty()).then_some(event))
}
