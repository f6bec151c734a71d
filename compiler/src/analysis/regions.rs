//! A machine whose states have regions, seen one region at a time: as a machine in which one region of each such state
//! is an ordinary state, and the others are left out.
//!
//! Regions that are left out may do anything at any tick: they set their variables to any value, raise their
//! events, and leave the state that contains them. A property of such a machine therefore holds in the whole one as well, as
//! far as it speaks of states that it contains. Something that never happens must be found in each of them.

use std::collections::{BTreeMap, BTreeSet};

use dsl::{Diagnostic, Span};
use runtime::program::{MachineAction, MachineProgram, TransitionProgram, Trigger};

use crate::source_map::{MachinePlaces, TransitionPlace};

/// Effects that the regions that are left out may have.
#[derive(Debug, Default)]
pub(crate) struct Elsewhere {
    /// Variables that they set.
    pub variables: BTreeSet<usize>,
    /// Events that they raise, and outcomes of their actions.
    pub raised: BTreeSet<usize>,
    /// Events that they wait for.
    pub awaited: BTreeSet<usize>,
    /// Their states.
    pub states: BTreeSet<usize>,
    /// For each region that is seen, the stacks that the others name.
    pub stacks: BTreeMap<usize, Vec<usize>>,
    /// States of the regions that are seen in which these end.
    pub ends: BTreeSet<usize>,
    /// True if the machine has regions.
    pub has_regions: bool,
}

impl Elsewhere {
    /// Stacks that regions beside an innermost state name.
    pub fn beside<'e>(&'e self, machine: &'e MachineProgram, leaf: usize) -> impl Iterator<Item = usize> + 'e {
        machine.path(leaf).filter_map(|s| self.stacks.get(&s)).flatten().copied()
    }
}

/// A machine with one region of each state.
pub(crate) struct View {
    pub machine: MachineProgram,
    pub places: MachinePlaces,
    pub elsewhere: Elsewhere,
    /// Spans of the regions that are left out.
    hidden: Vec<Span>,
}

impl View {
    /// True if something is not in a region that is left out.
    fn shows(&self, at: Span) -> bool {
        !self.hidden.iter().any(|h| h.source == at.source && h.start <= at.start && at.end <= h.end)
    }
}

/// The views of a machine: the first one has the first region of each state, and so on.
pub(crate) fn views(machine: &MachineProgram, places: &MachinePlaces) -> Vec<View> {
    let count = machine.states.iter().map(|s| s.regions.len()).max().unwrap_or(0);
    (0..count).map(|k| view(machine, places, k)).collect()
}

fn view(machine: &MachineProgram, places: &MachinePlaces, k: usize) -> View {
    let mut out = View {
        machine: machine.clone(),
        places: places.clone(),
        elsewhere: Elsewhere { has_regions: true, ..Elsewhere::default() },
        hidden: Vec::new(),
    };
    for (p, state) in machine.states.iter().enumerate().filter(|(_, s)| !s.regions.is_empty()) {
        let shown = state.regions[k.min(state.regions.len() - 1)];
        out.machine.states[p].initial = Some(shown);
        out.machine.states[p].regions.clear();
        out.see(machine, shown);
        for &region in state.regions.iter().filter(|r| **r != shown) {
            out.leave_out(machine, places, [p, shown, region]);
        }
    }
    out
}

impl View {
    /// Makes an ordinary state of a region.
    fn see(&mut self, machine: &MachineProgram, region: usize) {
        let inside: Vec<usize> = (0..machine.states.len()).filter(|&s| machine.region(s) == Some(region)).collect();
        for &s in &inside {
            if std::mem::replace(&mut self.machine.states[s].is_final, false) {
                self.elsewhere.ends.insert(s);
            }
        }
        // The other regions are taken to be in their initial states.
        for &s in inside.iter().filter(|&&s| s == region || machine.states[s].stack.is_some()) {
            self.machine.states[s].stack = machine.stack(s);
        }
    }

    /// Notes what a region that is left out may do. The transitions that leave it become ones of the state around it.
    fn leave_out(&mut self, machine: &MachineProgram, places: &MachinePlaces, [outer, shown, region]: [usize; 3]) {
        self.hidden.push(places.wholes[region]);
        for s in (0..machine.states.len()).filter(|&s| machine.region(s) == Some(region)) {
            let state = &machine.states[s];
            self.elsewhere.states.insert(s);
            self.elsewhere.stacks.entry(shown).or_default().extend(state.stack);
            for &a in state.enter.iter().chain(&state.activities).chain(&state.exit) {
                let action = &machine.actions[a];
                self.elsewhere.raised.extend(action.outcomes.iter().map(|o| o.1).chain(action.event));
                if let Some(MachineAction::Set { variable, .. } | MachineAction::Clear(variable)) = &action.own {
                    self.elsewhere.variables.insert(*variable);
                }
            }
            for (t, place) in state.transitions.iter().zip(&places.transitions[s]) {
                if let Trigger::Event(event) = t.trigger {
                    self.elsewhere.awaited.insert(event);
                }
                if machine.region(t.target) != Some(region) {
                    let any = TransitionProgram { trigger: Trigger::Ended(Vec::new()), ..t.clone() };
                    self.machine.states[outer].transitions.push(any);
                    let TransitionPlace { trigger, target, blend, .. } = *place;
                    let (condition, constant, demands) = (None, None, Vec::new());
                    let at = TransitionPlace { trigger, target, blend, condition, constant, demands };
                    self.places.transitions[outer].push(at);
                }
            }
        }
    }
}

/// Diagnostics on which all views agree that show their place.
pub(crate) fn agreed(views: &[View], found: Vec<Vec<Diagnostic>>) -> Vec<Diagnostic> {
    let mut out: Vec<Diagnostic> = Vec::new();
    let same = |a: &Diagnostic, b: &Diagnostic| a.code == b.code && a.primary.span == b.primary.span;
    let all = |d: &Diagnostic| {
        let mut showing = views.iter().zip(&found).filter(|(view, _)| view.shows(d.primary.span)).peekable();
        showing.peek().is_some() && showing.all(|(_, found)| found.iter().any(|f| same(f, d)))
    };
    for d in found.iter().flatten() {
        if !out.iter().any(|o| same(o, d)) && all(d) {
            out.push(d.clone());
        }
    }
    out
}
