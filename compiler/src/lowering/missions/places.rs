//! Where each declaration of a mission's problem was written, so that what a planner says of one can be underlined.

use std::collections::{BTreeMap, BTreeSet};

use dsl::Span;

/// Where the declarations of a schedule were written.
pub(super) type OfSchedule = Places<mission::kinds::schedule::check::Item, mission::kinds::schedule::check::Key>;

/// Where the declarations of a mission of layers were written.
pub(super) type OfLayers = Places<mission::kinds::layers::check::Item, mission::kinds::layers::check::Key>;

/// Where the declarations of a problem were written: its entries `I`, and their keys `K`.
#[derive(Debug)]
pub(super) struct Places<I, K> {
    /// The mission's name.
    mission: Span,
    /// Entries and keys that were written.
    written: BTreeMap<(I, Option<K>), Span>,
    /// What an agent of a schedule says of the approach of a robot, by agent and robot.
    approaches: BTreeMap<(usize, usize), Span>,
    /// Those in which something was wrong already; what follows from it is not said.
    wrong: BTreeSet<(I, K)>,
    /// Somebody who was written takes no part.
    incomplete: bool,
}

impl<I: Copy + Ord, K: Copy + Ord> Places<I, K> {
    pub fn new(mission: Span) -> Self {
        Places {
            mission,
            written: BTreeMap::new(),
            approaches: BTreeMap::new(),
            wrong: BTreeSet::new(),
            incomplete: false,
        }
    }

    /// Notes where an entry, or a key of it, was written.
    pub fn note(&mut self, item: I, key: Option<K>, at: Span) {
        self.written.insert((item, key), at);
    }

    /// Notes that something is wrong with a key.
    pub fn spoil(&mut self, item: I, key: K) {
        self.wrong.insert((item, key));
    }

    /// Notes that somebody who was written takes no part, because something is wrong.
    pub fn lose(&mut self) {
        self.incomplete = true;
    }

    /// Notes where the speed of a robot's approach to an agent was written.
    pub fn note_approach(&mut self, (agent, robot): (usize, usize), at: Span) {
        self.approaches.insert((agent, robot), at);
    }

    /// Where the speed of a robot's approach to an agent was written, if it was.
    pub fn approach(&self, agent: usize, robot: usize) -> Option<Span> {
        self.approaches.get(&(agent, robot)).copied()
    }

    /// True where something is wrong with a key, or with some key of an entry.
    pub fn is_wrong(&self, item: I, key: Option<K>) -> bool {
        match key {
            Some(key) => self.wrong.contains(&(item, key)),
            None => self.wrong.iter().any(|w| w.0 == item),
        }
    }

    /// True where something is wrong anywhere.
    pub fn any_wrong(&self) -> bool {
        self.incomplete || !self.wrong.is_empty()
    }

    /// Where an entry or a key of it was written; of a key that was left out, where its entry was.
    pub fn of(&self, item: I, key: Option<K>) -> Span {
        let found = self.written.get(&(item, key)).or_else(|| self.written.get(&(item, None)));
        found.copied().unwrap_or(self.mission)
    }

    /// Where a key was written, if it was.
    pub fn key(&self, item: I, key: K) -> Option<Span> {
        self.written.get(&(item, Some(key))).copied()
    }
}
