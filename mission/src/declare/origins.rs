//! Origins of the entries of a problem in the declaration that it was built from.

use std::collections::{BTreeMap, BTreeSet};

use blocks::{BoundBlock, Origin};

use super::DeclaredMission;

/// Origins of the entries `I` of a problem. A key of an entry is given by the names of the keys of its block that it was
/// read from, the most specific first.
#[derive(Debug)]
pub struct Origins<'m, I> {
    mission: &'m DeclaredMission,
    blocks: BTreeMap<I, &'m BoundBlock>,
    /// Parts of entries that are no keys.
    parts: BTreeMap<(I, &'static str), Origin>,
    /// Keys with a mistake that was found while the problem was built.
    wrong: BTreeSet<(I, &'static str)>,
}

impl<'m, I: Copy + Ord> Origins<'m, I> {
    /// Knows the entry that stands for the whole mission.
    pub fn new(mission: &'m DeclaredMission, whole: I) -> Self {
        let blocks = BTreeMap::from([(whole, &mission.settings)]);
        Origins { mission, blocks, parts: BTreeMap::new(), wrong: BTreeSet::new() }
    }

    /// Adds an entry with its block.
    pub fn add(&mut self, entry: I, block: &'m BoundBlock) {
        self.blocks.insert(entry, block);
    }

    /// Adds a part of an entry that is no key of its block.
    pub fn add_part(&mut self, entry: I, part: &'static str, at: Origin) {
        self.parts.insert((entry, part), at);
    }

    /// Marks a key, or a part, in which a mistake was reported.
    pub fn mark_wrong(&mut self, entry: I, key: &'static str) {
        self.wrong.insert((entry, key));
    }

    /// Returns the block of an entry.
    pub fn block(&self, entry: I) -> Option<&'m BoundBlock> {
        self.blocks.get(&entry).copied()
    }

    /// Returns the place of the first of these keys that is written.
    pub fn written(&self, entry: I, keys: &[&'static str]) -> Option<Origin> {
        let one = |key: &&'static str| {
            let part = self.parts.get(&(entry, *key)).copied();
            part.or_else(|| self.blocks.get(&entry)?.origin(key))
        };
        keys.iter().find_map(one)
    }

    /// Returns the place of the first of these keys that is written; else of the entry.
    pub fn of(&self, entry: I, keys: &[&'static str]) -> Origin {
        let entry_at = || self.blocks.get(&entry).map_or(self.mission.at, |block| block.at);
        self.written(entry, keys).unwrap_or_else(entry_at)
    }

    /// Returns the place of a key itself; if it is not written, of the entry.
    pub fn key(&self, entry: I, key: &str) -> Origin {
        let block = self.blocks.get(&entry);
        block.map_or(self.mission.at, |block| block.key_origin(key).unwrap_or(block.at))
    }

    /// Returns true if a mistake was reported in one of these keys; without keys, anywhere in the entry.
    pub fn is_wrong(&self, entry: I, keys: &[&'static str]) -> bool {
        let block = self.blocks.get(&entry);
        if keys.is_empty() {
            return block.is_some_and(|block| block.has_wrong()) || self.wrong.iter().any(|(of, _)| *of == entry);
        }
        keys.iter().any(|key| block.is_some_and(|b| b.is_wrong(key)) || self.wrong.contains(&(entry, *key)))
    }

    /// Returns true if a mistake was reported anywhere in the mission.
    pub fn any_wrong(&self) -> bool {
        self.mission.incomplete || !self.wrong.is_empty() || self.blocks.values().any(|block| block.has_wrong())
    }
}
