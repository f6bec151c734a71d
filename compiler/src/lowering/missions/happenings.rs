//! What happens in a scenario of a mission, and what people say in it.

use dsl::tree::{Block, Entry, Value, ValueKind};
use dsl::{Diagnostic, Spanned, Spelling};
use mission::kinds::schedule::execution::Event;
use mission::kinds::schedule::problem::{AgentKind, Distances, Problem};
use mission::numbers::MAX_NUMBER;
use mission::plan::Actor;
use names::{list, suggest};
use runtime::program::{Happens, MAX_HAPPENINGS, Occurrence, Replies, Reply};
use stdlib_tasks::dimension::TIME;
use stdlib_tasks::params::Quantity;

use super::super::Lowerer;
use super::executed::Executed;
use super::reading::Keys;
use crate::forms::{block_of, check_keys, items_of, text_of};
use crate::sections::{APPROACHES, DISTANCES, HAPPENING, REPLY, WAITS};

/// What can happen, each with the keys that say more of it.
const EVENTS: [(&str, &[&str]); 9] = [
    ("begun", &[]),
    ("done", &[]),
    ("late", &["by"]),
    ("served", &[]),
    ("failed", &[]),
    ("moved", &["to"]),
    ("feedback", &["wait", "approach", "distance"]),
    ("lost", &[]),
    ("back", &[]),
];

impl Lowerer<'_> {
    /// What happens, by time.
    pub(super) fn happenings(&mut self, keys: Keys, of: Executed, duration: f64) -> Vec<Happens> {
        let Some(e) = keys.entry("happens") else { return Vec::new() };
        let mut all: Vec<Happens> = Vec::new();
        let items = items_of(&e.value);
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
            let what = match of {
                Executed::Schedule(problem) => self.happening(block, keys, problem),
                Executed::Layers(problem) => self.happening_of_layers(block, keys, problem),
            };
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

    /// What happens, of which a block says one thing.
    fn happening(&mut self, block: &Block, keys: Keys, problem: &Problem) -> Option<Occurrence> {
        let names: Vec<&str> = EVENTS.iter().map(|(name, _)| *name).collect();
        let e = self.said(block, keys, &names)?;
        let actor = self.actor(&e.value, problem)?;
        self.event_of(e, actor, keys, problem)
    }

    /// The one entry that says what happens. `names` are the events that there are.
    pub(super) fn said<'b>(&mut self, block: &'b Block, keys: Keys, names: &[&str]) -> Option<&'b Entry> {
        let event = |e: &&Entry| EVENTS.iter().any(|(name, _)| e.key.value == *name);
        let mut events = block.entries.iter().filter(event);
        let Some(e) = events.next() else {
            // A word that no event has was reported, and may be the one that is meant.
            if block.entries.iter().any(|e| HAPPENING.key(&e.key.value, Spelling::Hq).is_none()) {
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
        let name = e.key.value.as_str();
        let parts = EVENTS.iter().find(|(n, _)| *n == name).map_or(&[][..], |(_, parts)| parts);
        let of_others = |entry: &&Entry| {
            let key = entry.key.value.as_str();
            !parts.contains(&key) && EVENTS.iter().any(|(_, parts)| parts.contains(&key))
        };
        if let Some(wrong) = block.entries.iter().find(of_others) {
            let d = Diagnostic::error("HQ0922", wrong.key.span, format!("`{name}` has no `{}`", wrong.key.value));
            let has = match parts {
                [] => "leave it out".to_string(),
                parts => format!("it says more with {}", list(parts.iter().copied(), 4)),
            };
            self.push(d.label(e.key.span, "what happens").help(has));
            return None;
        }
        Some(e)
    }

    /// The event of an actor, where that makes sense for it.
    fn event_of(&mut self, e: &Entry, actor: Actor, keys: Keys, problem: &Problem) -> Option<Occurrence> {
        let agent = match (e.key.value.as_str(), actor) {
            ("lost", who) => return Some(Occurrence::Event(Event::Lost { who })),
            ("back", who) => return Some(Occurrence::Event(Event::Back { who })),
            ("failed", Actor::Robot(robot)) => return Some(Occurrence::FailedBy { robot }),
            ("late", Actor::Robot(robot)) => {
                let Some(by) = keys.entry("by") else {
                    self.needs(e, keys, "by", "by 10 s");
                    return None;
                };
                return Some(Occurrence::LateBy { robot, by: self.delay(by)? });
            }
            (_, Actor::Agent(agent)) => agent,
            (name, Actor::Robot(_)) => {
                let why = match name {
                    "feedback" => "only people say what a service was like",
                    "moved" => "where a robot is comes from its plan",
                    _ => "it has no operations: it serves those of agents",
                };
                self.senseless(e, "a robot that serves", why);
                return None;
            }
        };
        let event = match e.key.value.as_str() {
            "begun" => Event::Begun { agent },
            "done" => Event::Done { agent },
            "served" => Event::Served { agent },
            "failed" => Event::Failed { agent },
            "late" => {
                let Some(by) = keys.entry("by") else {
                    self.needs(e, keys, "by", "by 60 s");
                    return None;
                };
                Event::Late { agent, by: self.delay(by)? }
            }
            "moved" => {
                if keys.entry("to").is_none() {
                    self.needs(e, keys, "to", "to [2, 0] m");
                    return None;
                }
                let place = self.key_pair(keys, "to")?;
                if problem.distances != Distances::Straight {
                    let d = Diagnostic::error("HQ0922", e.key.span, "nobody moves in this mission")
                        .note("the lengths of the ways come from `distances`, and say nothing of other places");
                    self.push(d.help("leave it out, or leave `distances` out of the mission for straight lines"));
                    return None;
                }
                Event::Moved { agent, place }
            }
            _ => {
                if !self.is_person(e, agent, problem) {
                    return None;
                }
                let Some(reply) = self.reply(keys)? else {
                    let d = Diagnostic::error("HQ0922", e.key.span, "this feedback says nothing");
                    self.push(
                        d.help("say what of it was how: `wait too_long`, `approach very_fast`, `distance close`"),
                    );
                    return None;
                };
                reply.of(agent)
            }
        };
        Some(Occurrence::Event(event))
    }

    fn senseless(&mut self, e: &Entry, who: &str, why: &str) {
        let text = format!("`{}` makes no sense for {who}", e.key.value);
        self.push(
            Diagnostic::error("HQ0922", e.value.span, text)
                .note(why.to_string())
                .help("name somebody else, or leave it out"),
        );
    }

    pub(super) fn needs(&mut self, e: &Entry, keys: Keys, part: &str, example: &str) {
        if keys.misspells(part) {
            return;
        }
        let d = Diagnostic::error("HQ0206", e.key.span, format!("`{}` needs `{part}`", e.key.value));
        self.push(d.help(format!("write for instance `{example}` behind it")));
    }

    fn is_person(&mut self, e: &Entry, agent: usize, problem: &Problem) -> bool {
        let person = problem.agents.get(agent).is_some_and(|a| a.kind == AgentKind::Human);
        if !person {
            self.senseless(e, "a working robot", "only people say what a service was like");
        }
        person
    }

    /// By how much something is late, in s.
    pub(super) fn delay(&mut self, by: &Entry) -> Option<f64> {
        let within = Quantity { min: -MAX_NUMBER, max: MAX_NUMBER, ..Quantity::any(TIME) };
        self.number_within(&by.value, "by", &within)
    }

    /// Who is named.
    fn actor(&mut self, value: &Value, problem: &Problem) -> Option<Actor> {
        let name = self.somebody(value)?;
        self.actor_named(&name, problem)
    }

    /// A name where one is needed.
    pub(super) fn somebody(&mut self, value: &Value) -> Option<Spanned<String>> {
        if let Some(name) = text_of(value) {
            return Some(Spanned::new(name.to_string(), value.span));
        }
        if !matches!(value.kind, ValueKind::Missing) {
            let d = Diagnostic::error("HQ0304", value.span, "the name of a robot or an agent is needed here");
            self.push(d.help("write it as the mission declares it"));
        }
        None
    }

    fn actor_named(&mut self, name: &Spanned<String>, problem: &Problem) -> Option<Actor> {
        let robot = problem.robots.iter().position(|m| m.name == name.value).map(Actor::Robot);
        let agent = || problem.agents.iter().position(|a| a.name == name.value).map(Actor::Agent);
        let found = robot.or_else(agent);
        if found.is_none() {
            self.nobody_called(name, Executed::Schedule(problem));
        }
        found
    }

    /// Reports a name that nobody has.
    pub(super) fn nobody_called(&mut self, name: &Spanned<String>, of: Executed) {
        let members = of.members();
        let names = || members.iter().map(|member| member.0);
        let d = Diagnostic::error("HQ0201", name.span, format!("nobody in the mission is called `{}`", name.value));
        self.push(match suggest(&name.value, names()) {
            Some(near) => d.help(format!("did you mean `{near}`?")),
            None => d.help(format!("there are {}", list(names(), 12))),
        });
    }

    /// What is said of a service; `Some(None)` where nothing is.
    fn reply(&mut self, keys: Keys) -> Option<Option<Reply>> {
        let mut step = |name: &str, words: &[&str]| -> Option<Option<i8>> {
            if keys.entry(name).is_none() {
                return Some(None);
            }
            let word = self.key_word(keys, name)?;
            let place = words.iter().position(|w| *w == word)?;
            Some(Some(i8::try_from(place).ok()? - 2))
        };
        let (wait, approach) = (step("wait", WAITS), step("approach", APPROACHES));
        let distance = step("distance", DISTANCES);
        let (wait, approach, distance) = (wait?, approach?, distance?);
        if wait.or(approach).or(distance).is_none() {
            return Some(None);
        }
        let right = |said: Option<i8>| said.unwrap_or(0);
        Some(Some(Reply { wait: right(wait), approach: right(approach), distance: right(distance) }))
    }

    /// What people say after they were served.
    pub(super) fn replies(&mut self, keys: Keys, problem: &Problem) -> Vec<Replies> {
        let mut all = Vec::new();
        let Some(e) = keys.entry("feedback") else { return all };
        let Some(block) = block_of(&e.value, "`feedback`", self.diagnostics) else { return all };
        for e in &block.entries {
            let agent = match self.actor_named(&e.key, problem) {
                Some(Actor::Agent(agent)) => agent,
                Some(Actor::Robot(_)) => {
                    let d =
                        Diagnostic::error("HQ0922", e.key.span, "`feedback` makes no sense for a robot that serves");
                    self.push(d.note("only people say what a service was like").help("name a person"));
                    continue;
                }
                None => continue,
            };
            let person = problem.agents.get(agent).is_some_and(|a| a.kind == AgentKind::Human);
            if !person {
                let d = Diagnostic::error("HQ0922", e.key.span, "`feedback` makes no sense for a working robot");
                self.push(d.note("only people say what a service was like").help("name a person"));
                continue;
            }
            let mut services = Vec::new();
            for item in items_of(&e.value) {
                let Some(block) = block_of(item, "what is said of a service", self.diagnostics) else { continue };
                check_keys(block, &REPLY, self.diagnostics);
                let keys = Keys { block, section: &REPLY, at: item.span };
                services.extend(self.reply(keys));
            }
            if !services.is_empty() {
                all.push(Replies { agent, services });
            }
        }
        all
    }
}
