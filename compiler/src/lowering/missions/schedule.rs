//! A mission of the kind `schedule`, as a problem of its planner.

use std::collections::BTreeMap;

use dsl::Diagnostic;
use dsl::tree::{Block, Mission, MissionMember};
use mission::kinds::schedule::Schedule;
use mission::kinds::schedule::adapt::Adaptation;
use mission::kinds::schedule::check::{Item, Key};
use mission::kinds::schedule::problem::{Agent, AgentKind, Distances, Problem, Robot, Weights};
use mission::numbers::MAX_BATCH;
use names::list;
use runtime::program::Running;
use stdlib_tasks::dimension::LENGTH;
use stdlib_tasks::params::Quantity;

use super::super::Lowerer;
use super::super::declared::twice;
use super::places::OfSchedule as Places;
use super::reading::Keys;
use crate::forms::{block_of, check_keys};
use crate::sections::{ADAPTATION, SCHEDULE, SCHEDULE_WEIGHTS, Section};

/// So many ways that are missing from a table are named.
const MOST_NAMED: usize = 6;

impl Lowerer<'_> {
    /// A schedule. `None` where it cannot be planned; the diagnostics say why.
    pub(super) fn schedule(&mut self, m: &Mission) -> Option<(Schedule, Running)> {
        let before = self.errors();
        let mut places = Places::new(m.name.span);
        places.note(Item::Mission, None, m.name.span);
        check_keys(&m.settings, &SCHEDULE, self.diagnostics);
        let keys = Keys { block: &m.settings, section: &SCHEDULE, at: m.name.span };
        for (name, key) in [("confidence", Key::Confidence), ("weights", Key::Weights), ("distances", Key::Distances)] {
            keys.entry(name).iter().for_each(|e| places.note(Item::Mission, Some(key), e.value.span));
        }
        let confidence = self.key_number(keys, "confidence").ok().flatten();
        if confidence.is_none() {
            places.spoil(Item::Mission, Key::Confidence);
        }
        let weights = self.weights(keys, &mut places);
        let adaptation = self.adaptation(keys);
        let reallocate_above = self.key_number(keys, "reallocate_above").ok().flatten();
        let batch = self.batch(keys);
        let (robots, agents) = self.team(m, &mut places);
        let distances = self.distances(keys, &robots, &agents, &mut places);
        let labels = self.labels(m, &[]);
        self.mistaken_labels(m, robots.iter().map(|r| &r.name).chain(agents.iter().map(|a| &a.name)), &labels);
        let problem = Problem {
            robots,
            agents,
            labels,
            distances,
            confidence: confidence.unwrap_or(0.5),
            weights,
            start: 0.0,
            begun: Vec::new(),
            absent: Vec::new(),
            scales: None,
        };
        let running = self.running(m, &problem);
        self.mistakes(m, &problem, &places);
        if self.errors() > before {
            return None;
        }
        self.schedule_warnings(m, &problem, &places);
        let (adaptation, reallocate_above, batch) = (adaptation?, reallocate_above?, batch?);
        Some((Schedule { problem, adaptation, reallocate_above, batch }, running))
    }

    /// Who takes part: robots, then people, then working robots, each in the order written.
    fn team(&mut self, m: &Mission, places: &mut Places) -> (Vec<Robot>, Vec<Agent>) {
        let mut names: BTreeMap<&str, &MissionMember> = BTreeMap::new();
        let mut known: Vec<&MissionMember> = Vec::new();
        for member in &m.members {
            if !self.roles(member, &SCHEDULE, None) {
                places.lose();
                continue;
            }
            match names.get(member.name.value.as_str()) {
                // Two of one role were reported when repetitions were unrolled.
                Some(first) if first.role == member.role => places.lose(),
                Some(first) => {
                    self.push(twice(&member.name, first.name.span));
                    places.lose();
                }
                None => {
                    names.insert(&member.name.value, member);
                    known.push(member);
                }
            }
        }
        let of = |role: &str| known.iter().filter(|k| k.role.value == role).copied().collect::<Vec<_>>();
        let mut robots = Vec::new();
        for member in of("robot") {
            robots.push(self.schedule_robot(robots.len(), member, places));
        }
        let mut agents = Vec::new();
        for (role, kind) in [("human", AgentKind::Human), ("worker", AgentKind::Worker)] {
            for member in of(role) {
                agents.push(self.schedule_agent((agents.len(), kind), member, &robots, places));
            }
        }
        (robots, agents)
    }

    /// A block behind a key of the mission; `Some(None)` where it is left out.
    pub(super) fn inner_or_nothing<'b>(
        &mut self,
        keys: Keys<'b>,
        name: &str,
        section: &'static Section,
    ) -> Option<Option<Keys<'b>>> {
        match keys.entry(name) {
            Some(_) => self.inner(keys, name, section).map(Some),
            None => Some(None),
        }
    }

    /// A block behind a key of the mission, or nothing where it is left out.
    fn inner<'b>(&mut self, keys: Keys<'b>, name: &str, section: &'static Section) -> Option<Keys<'b>> {
        let e = keys.entry(name)?;
        let block = block_of(&e.value, &format!("`{name}`"), self.diagnostics)?;
        check_keys(block, section, self.diagnostics);
        Some(Keys { block, section, at: e.key.span })
    }

    fn weights(&mut self, keys: Keys, places: &mut Places) -> Weights {
        let nothing = Block::default();
        let none = Keys { block: &nothing, section: &SCHEDULE_WEIGHTS, at: keys.at };
        let keys = self.inner(keys, "weights", &SCHEDULE_WEIGHTS).unwrap_or(none);
        let mut one = |name: &str| {
            let weight = self.key_number(keys, name).ok().flatten();
            if weight.is_none() {
                places.spoil(Item::Mission, Key::Weights);
            }
            weight.unwrap_or(1.0)
        };
        Weights { worker_wait: one("worker_wait"), energy: one("energy"), makespan: one("makespan") }
    }

    fn adaptation(&mut self, keys: Keys) -> Option<Adaptation> {
        if keys.entry("adaptation").is_none() {
            return Some(Adaptation::default());
        }
        let keys = self.inner(keys, "adaptation", &ADAPTATION)?;
        let mut one = |name: &str| self.key_number(keys, name).ok().flatten();
        let (memory, wait_gain) = (one("memory"), one("wait_gain"));
        let (approach_gain, margin) = (one("approach_gain"), one("margin"));
        let wait_step = one("wait_step")?;
        Some(Adaptation {
            memory: memory?,
            wait_gain: wait_gain?,
            approach_gain: approach_gain?,
            margin: margin?,
            wait_step,
        })
    }

    pub(super) fn batch(&mut self, keys: Keys) -> Option<usize> {
        let batch = self.key_count(keys, "batch").ok()?;
        if batch <= MAX_BATCH {
            return Some(batch);
        }
        let at = keys.entry("batch").map_or(keys.at, |e| e.value.span);
        let d =
            Diagnostic::error("HQ0904", at, format!("a batch has at most {MAX_BATCH} operations, and this is {batch}"));
        self.push(d.help("a few at a time are planned best: leave it out, or write `batch 4`"));
        None
    }

    /// The table of lengths, where there is one.
    fn distances(&mut self, keys: Keys, robots: &[Robot], agents: &[Agent], places: &mut Places) -> Distances {
        let Some(e) = keys.entry("distances") else { return Distances::Straight };
        let mut table = vec![vec![None; agents.len()]; robots.len()];
        let names: Vec<&str> = agents.iter().map(|a| a.name.as_str()).collect();
        let before = self.errors();
        let block = block_of(&e.value, "`distances`", self.diagnostics);
        for row in block.map_or(&[][..], |b| &b.entries) {
            let robot = self.robot_named(&row.key, robots);
            let Some(block) = block_of(&row.value, "the ways of a robot", self.diagnostics) else { continue };
            for way in &block.entries {
                let agent = self.one_of("agent of this mission", &way.key.value, way.key.span, &names);
                let length = self.number_within(&way.value, &way.key.value, &Quantity::at_least(LENGTH, 0.0));
                let slot = robot.zip(agent).and_then(|(m, a)| table.get_mut(m)?.get_mut(a));
                slot.into_iter().for_each(|slot| *slot = length);
            }
        }
        if self.errors() == before {
            let ways = robots.iter().zip(&table).flat_map(|(m, row)| row.iter().zip(&names).map(move |w| (m, w)));
            let missing: Vec<String> =
                ways.filter(|(_, w)| w.0.is_none()).map(|(m, w)| format!("{} to {}", m.name, w.1)).collect();
            if !missing.is_empty() {
                let text = "this table lacks ways";
                let d = Diagnostic::error("HQ0906", e.key.span, text);
                let d = d.note(format!(
                    "nothing says how long these are: {}",
                    list(missing.iter().map(String::as_str), MOST_NAMED)
                ));
                self.push(d.help("write all of them, or leave `distances` out for straight lines"));
            }
        }
        if self.errors() > before || block.is_none() {
            places.spoil(Item::Mission, Key::Distances);
        }
        Distances::Table(table.into_iter().map(|row| row.into_iter().map(|l| l.unwrap_or(1.0)).collect()).collect())
    }
}
