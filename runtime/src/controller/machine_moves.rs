//! Moves of the machine: states that are left and entered by a transition, with their actions.

use super::machine::{Machine, Request, StateChange};
use crate::program::{BESIDE, StateProgram};

/// A transition that was taken.
pub(super) struct Moved {
    pub change: StateChange,
    /// True if all regions were left, or if there are none.
    pub left_regions: bool,
}

impl Machine {
    /// Takes a transition of the state `source`. Never allocates.
    pub(super) fn go(&mut self, source: usize, target: usize, blend: f64, time: f64) -> Moved {
        // Innermost state that is not exited: it contains both the transition and its target.
        let holds_target = |s: usize| s != target && self.program.path(target).any(|p| p == s);
        let stays = self.program.path(source).find(|&s| holds_target(s)).unwrap_or(0);
        let stood = self.stands();
        self.before.clear();
        self.before.extend_from_slice(&self.owners);
        // A region that contains both is the only one that changes.
        let region = self.program.region(source).filter(|&r| self.program.region(target) == Some(r));
        let changes = self.inner.iter().position(|&leaf| region.is_some() && self.program.region(leaf) == region);
        let mut left_owner = false;
        if let Some(k) = changes {
            left_owner |= self.leave(self.inner[k], stays);
            self.inner[k] = self.descend(stays, self.program.leaf(target), time);
            self.settle();
        } else {
            while let Some(leaf) = self.inner.pop() {
                left_owner |= self.leave(leaf, self.current);
            }
            left_owner |= self.leave(self.current, stays);
            self.current = stays;
            self.enter(target, time);
        }
        let same = self.owners == self.before && !left_owner;
        let resumes = stood && !self.stands();
        if resumes {
            // The stack begins anew, so that its blend starts at rest.
            self.resumed = time;
            self.waited.fill(0.0);
        }
        let stack = !same || resumes;
        if stack {
            self.stack_since = time;
        }
        Moved { change: StateChange { blend, stack, anew: resumes }, left_regions: changes.is_none() }
    }

    /// Leaves a state and those around it, up to `until`. Returns true if the stack of one of them ran.
    fn leave(&mut self, from: usize, until: usize) -> bool {
        let (mut state, mut owner) = (from, false);
        while state != until {
            if self.standing == Some(state) {
                self.standing = None;
            }
            owner |= self.owners.contains(&state);
            self.ask(state, |s| &s.activities, false);
            self.ask(state, |s| &s.exit, true);
            state = self.program.states[state].parent.unwrap_or(until);
        }
        owner
    }

    /// Enters a state inside the current one, with the states between them, its initial states and regions.
    pub(super) fn enter(&mut self, target: usize, time: f64) {
        if self.current == 0 && target == 0 {
            self.enter_one(0, time);
        }
        let spine = self.program.spine(self.program.leaf(target));
        self.current = self.descend(self.current, spine, time);
        let chosen = self.program.region(target);
        for k in 0..self.program.states[spine].regions.len() {
            let region = self.program.states[spine].regions[k];
            let leaf = self.program.leaf(if chosen == Some(region) { target } else { region });
            let leaf = self.descend(spine, leaf, time);
            self.inner.push(leaf);
        }
        self.settle();
    }

    /// Enters the states inside `from` that contain `to`, and this one. Returns `to`.
    fn descend(&mut self, from: usize, to: usize, time: f64) -> usize {
        let mut at = from;
        while let Some(next) = self.program.path(to).take_while(|&s| s != at).last() {
            self.enter_one(next, time);
            at = next;
        }
        to
    }

    /// Updates what follows from the active states: the states whose stacks run, and their text.
    fn settle(&mut self) {
        self.owners.clear();
        self.owners.extend(self.inner.iter().filter_map(|&leaf| self.program.region_owner(leaf)));
        if self.owners.is_empty() {
            let mut around = self.program.path(self.current);
            self.owners.push(around.find(|&s| self.program.states[s].stack.is_some()).unwrap_or(0));
        }
        self.text.clear();
        for (k, &leaf) in self.inner.iter().enumerate() {
            self.text.push_str(if k == 0 { "" } else { BESIDE });
            self.text.push_str(&self.program.states[leaf].name);
        }
    }

    fn enter_one(&mut self, state: usize, time: f64) {
        (self.entered[state], self.waited[state]) = (time, 0.0);
        self.entries[state] += 1;
        self.guards[state].enter();
        self.ask(state, |s| &s.enter, true);
        self.ask(state, |s| &s.activities, true);
    }

    fn ask(&mut self, state: usize, which: fn(&StateProgram) -> &Vec<usize>, begin: bool) {
        let Machine { program, requests, raised, pending, entered, .. } = self;
        for &action in which(&program.states[state]) {
            let asked = &program.actions[action];
            match asked.event {
                _ if asked.own.is_some() && !begin => {}
                _ if asked.own.is_some() && pending.len() < pending.capacity() => {
                    pending.push((action, entered[state]));
                }
                _ if asked.own.is_some() => {}
                Some(event) if begin => raised[1][event] = true,
                Some(_) => {}
                None if requests.len() < requests.capacity() => requests.push(Request { action, begin }),
                None => {}
            }
        }
    }
}
