//! Events of a scenario of a mission, and the feedback of people. The events of a kind are those of its entry.

use dsl::tree::{Block, Entry, Value, ValueKind};
use dsl::{Diagnostic, Spanned, Syntax};
use mission::kind::{Detail, Event, EventInfo, Replies};
use mission::kinds::KINDS;
use mission::numbers::MAX_NUMBER;
use names::{list, suggest};
use runtime::program::{Happens, MAX_HAPPENINGS};
use stdlib_tasks::dimension::TIME;
use stdlib_tasks::params::Quantity;

use super::super::Lowerer;
use super::executed::{Executed, Owner};
use super::reading::Keys;
use crate::forms::{block_of, check_keys, text_of};
use crate::sections::{APPROACHES, DISTANCES, HAPPENING, Holds, REPLY, WAITS};

/// True for the name of an event of some kind.
fn is_event(key: &str) -> bool {
    KINDS.iter().any(|kind| kind.event(key).is_some())
}

/// True for a further key of an event of some kind.
fn is_further(key: &str) -> bool {
    KINDS.iter().flat_map(|kind| kind.events).flat_map(|event| event.with).any(|further| further.key == key)
}

impl Lowerer<'_> {
    /// What happens, by time.
    pub(super) fn happenings(&mut self, keys: Keys, of: Executed, duration: f64) -> Vec<Happens> {
        let Some(e) = keys.entry("happens") else { return Vec::new() };
        let mut all: Vec<Happens> = Vec::new();
        let items = e.value.items();
        if items.len() > MAX_HAPPENINGS {
            let text = format!("{} events are more than a scenario may have", items.len());
            let d = Diagnostic::error("HQ0924", e.key.span, text);
            self.push(d.help(format!("write at most {MAX_HAPPENINGS}, or several scenarios")));
            return all;
        }
        for item in items {
            let Some(block) = block_of(item, "what happens", self.diagnostics) else { continue };
            check_keys(block, &HAPPENING, self.diagnostics);
            let keys = Keys { block, section: &HAPPENING, at: item.span };
            let at = self.happens_at(keys, duration);
            let what = self.event_of_mission(block, keys, of);
            if let (Some(at), Some(what)) = (at, what) {
                all.push(Happens { at, what });
            }
        }
        all.sort_by(|a, b| a.at.total_cmp(&b.at));
        all
    }

    fn happens_at(&mut self, keys: Keys, duration: f64) -> Option<f64> {
        let Some(e) = keys.entry("at") else {
            if keys.misspells("at") {
                return None;
            }
            let d = Diagnostic::error("HQ0206", keys.at, "nothing says when this happens");
            self.push(d.help("write for instance `at 120 s`"));
            return None;
        };
        let at = self.key_number(keys, "at").ok().flatten()?;
        if at > duration {
            let text =
                format!("this never happens, because the run is over after {} s", runtime::text::number(duration));
            let d = Diagnostic::warning("HQ0923", e.value.span, text);
            self.push(d.help("write an earlier time, or a longer `duration`"));
        }
        Some(at)
    }

    /// The event of a block.
    fn event_of_mission(&mut self, block: &Block, keys: Keys, of: Executed) -> Option<Event> {
        let kind = of.kind();
        let names: Vec<&str> = kind.events.iter().map(|event| event.name).collect();
        let e = self.said(block, keys, &names)?;
        let name = e.key.value.as_str();
        let Some(info) = kind.event(name) else {
            let d = Diagnostic::error("HQ0922", e.key.span, format!("`{name}` makes no sense in {}", kind.title));
            let why = kind.absent.iter().find(|absent| absent.0 == name).map(|absent| absent.1);
            let d = why.map_or(d.clone(), |why| d.note(why));
            self.push(d.help(format!("leave it out; there is {}", list(names.iter().copied(), 9))));
            return None;
        };
        if !self.no_further(block, e, info) {
            return None;
        }
        let (member, role) = self.member(&e.value, of)?;
        if let Some(not) = info.not_of.iter().find(|not| not.role == role) {
            let text = format!("`{name}` makes no sense for {}", not.who);
            let d = Diagnostic::error("HQ0922", e.value.span, text).note(not.why);
            self.push(d.help("name somebody else, or leave it out"));
            return None;
        }
        let mut event = Event::of(name, member);
        for further in info.with {
            if further.required.is_some_and(|example| self.lacks_further(e, keys, further.key, example)) {
                return None;
            }
            if let Some(detail) = self.detail(keys, further.key)? {
                event = event.and(further.key, detail);
            }
        }
        if !info.with.is_empty() && event.with.is_empty() {
            let d = Diagnostic::error("HQ0922", e.key.span, format!("this {name} says nothing"));
            self.push(d.help("say what of it was how: `wait too_long`, `approach very_fast`, `distance close`"));
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
        self.push(d.label(e.key.span, "what happens").help(has));
        false
    }

    /// Reports a further key that is missing; true then.
    fn lacks_further(&mut self, e: &Entry, keys: Keys, key: &str, example: &str) -> bool {
        if keys.entry(key).is_some() {
            return false;
        }
        if !keys.misspells(key) {
            let d = Diagnostic::error("HQ0206", e.key.span, format!("`{}` needs `{key}`", e.key.value));
            self.push(d.help(format!("write for instance `{example}` behind it")));
        }
        true
    }

    /// The value of a further key; `Some(None)` if it is left out.
    fn detail(&mut self, keys: Keys, key: &str) -> Option<Option<Detail>> {
        let Some(e) = keys.entry(key) else { return Some(None) };
        Some(Some(match HAPPENING.key(key, Syntax::Native).map(|key| &key.holds)? {
            Holds::Pair(_) => Detail::Point(self.key_pair(keys, key)?),
            Holds::Choice(_) => Detail::Number(f64::from(self.step(keys, key)?)),
            _ => Detail::Number(self.delay(e)?),
        }))
    }

    /// The one entry that says what happens. `names` are the events of the kind.
    fn said<'b>(&mut self, block: &'b Block, keys: Keys, names: &[&str]) -> Option<&'b Entry> {
        let event = |e: &&Entry| is_event(&e.key.value);
        let mut events = block.entries.iter().filter(event);
        let Some(e) = events.next() else {
            // A word that no event has was reported, and may be the one that is meant.
            if block.entries.iter().any(|e| HAPPENING.key(&e.key.value, Syntax::Native).is_none()) {
                return None;
            }
            let d = Diagnostic::error("HQ0922", keys.at, "nothing happens here");
            self.push(d.help(format!("say what, and to whom: {}", list(names.iter().copied(), 9))));
            return None;
        };
        if let Some(other) = events.next() {
            let d =
                Diagnostic::error("HQ0922", other.key.span, "two things happen here, and each has a time of its own");
            self.push(d.label(e.key.span, "the first").help("write it as an entry of its own, `{ at ..  .. }`"));
            return None;
        }
        Some(e)
    }

    /// By how much something is late, in s.
    fn delay(&mut self, by: &Entry) -> Option<f64> {
        let within = Quantity { min: -MAX_NUMBER, max: MAX_NUMBER, ..Quantity::any(TIME) };
        self.number_within(&by.value, "by", &within)
    }

    /// The member of a name: its index and role.
    fn member(&mut self, value: &Value, of: Executed) -> Option<(usize, &'static str)> {
        let name = self.somebody(value)?;
        self.participant(&name, of)
    }

    fn participant(&mut self, name: &Spanned<String>, of: Executed) -> Option<(usize, &'static str)> {
        match of.owner(&name.value) {
            Some(Owner::Member(member, role)) => Some((member, role)),
            _ => {
                self.nobody_called(name, of);
                None
            }
        }
    }

    /// A name where one is needed.
    fn somebody(&mut self, value: &Value) -> Option<Spanned<String>> {
        if let Some(name) = text_of(value) {
            return Some(Spanned::new(name.to_string(), value.span));
        }
        if !matches!(value.kind, ValueKind::Missing) {
            let d = Diagnostic::error("HQ0304", value.span, "the name of a robot or an agent is needed here");
            self.push(d.help("write it as the mission declares it"));
        }
        None
    }

    /// Reports a name that nobody has.
    fn nobody_called(&mut self, name: &Spanned<String>, of: Executed) {
        let members = of.members();
        let names = || members.iter().copied();
        let d = Diagnostic::error("HQ0201", name.span, format!("nobody in the mission is called `{}`", name.value));
        self.push(match suggest(&name.value, names()) {
            Some(near) => d.help(format!("did you mean `{near}`?")),
            None => d.help(format!("there are {}", list(names(), 12))),
        });
    }

    /// A step of feedback, from -2 to 2.
    fn step(&mut self, keys: Keys, key: &str) -> Option<i8> {
        let words = [("wait", WAITS), ("approach", APPROACHES), ("distance", DISTANCES)];
        let words = words.into_iter().find(|(name, _)| *name == key)?.1;
        let word = self.key_word(keys, key)?;
        let place = words.iter().position(|w| *w == word)?;
        Some(i8::try_from(place).ok()? - 2)
    }

    /// The feedback of a person about a service; `Some(None)` if it is empty.
    fn reply(&mut self, keys: Keys, member: usize) -> Option<Option<Event>> {
        let mut event = Event::of("feedback", member);
        let mut good = true;
        for key in ["wait", "approach", "distance"] {
            match self.detail(keys, key) {
                Some(Some(detail)) => event = event.and(key, detail),
                Some(None) => {}
                None => good = false,
            }
        }
        good.then(|| (!event.with.is_empty()).then_some(event))
    }

    /// The feedback of people after each service. Reports it for a kind that has none.
    pub(super) fn replies(&mut self, keys: Keys, of: Executed) -> Vec<Replies> {
        let mut all = Vec::new();
        let Some(e) = keys.entry("feedback") else { return all };
        let Some(info) = of.kind().event("feedback") else { return all };
        let Some(block) = block_of(&e.value, "`feedback`", self.diagnostics) else { return all };
        for e in &block.entries {
            let Some((member, role)) = self.participant(&e.key, of) else { continue };
            if let Some(not) = info.not_of.iter().find(|not| not.role == role) {
                let text = format!("`feedback` makes no sense for {}", not.who);
                self.push(Diagnostic::error("HQ0922", e.key.span, text).note(not.why).help("name a person"));
                continue;
            }
            let mut services = Vec::new();
            for item in e.value.items() {
                let Some(block) = block_of(item, "what is said of a service", self.diagnostics) else { continue };
                check_keys(block, &REPLY, self.diagnostics);
                let keys = Keys { block, section: &REPLY, at: item.span };
                services.extend(self.reply(keys, member));
            }
            if !services.is_empty() {
                all.push(Replies { member, services });
            }
        }
        all
    }

    /// Reports keys of scenarios that a kind does not have.
    pub(super) fn absent_keys(&mut self, keys: Keys, of: Executed) {
        let kind = of.kind();
        for (key, why) in kind.absent {
            let Some(e) = keys.entry(key) else { continue };
            let text = format!("a scenario of {} has no `{key}`", kind.title);
            let d = Diagnostic::error("HQ0921", e.key.span, text);
            let d = match keys.entry("mission") {
                Some(mission) => d.label(mission.value.span, format!("this is {}", kind.title)),
                None => d,
            };
            self.push(d.note(*why).help("leave it out"));
        }
    }
}
