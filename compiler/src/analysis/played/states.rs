//! States that the machine may enter in a scenario, with the earliest time of each.

use std::collections::{BTreeMap, BTreeSet};

use runtime::FaultKind;
use runtime::program::{FaultPattern, MachineProgram, Trigger};

use super::{Played, ROUNDING};

/// Rounds of the search; each round makes an entry earlier, or is the last.
const ROUNDS: usize = 10_000;

/// Reason why a transition is not taken in a scenario.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Missing {
    /// Nothing raises the event while the machine waits for it.
    Event(usize),
    /// The condition never holds.
    Condition,
    /// The run ends before.
    Time,
}

/// A transition that leads into a state, with the reason why it is not taken.
#[derive(Clone, Debug)]
pub(crate) struct Untaken {
    /// The state that has the transition.
    pub state: usize,
    /// Its index there.
    pub index: usize,
    /// The reason.
    pub missing: Missing,
}

impl Played<'_> {
    /// True if the machine may be in a state, or inside it.
    pub fn enters(&self, state: usize) -> bool {
        let machine = self.program.machine.as_ref();
        machine.is_none_or(|m| self.entered.keys().any(|&leaf| m.path(leaf).any(|s| s == state)))
    }

    /// Earliest time (s) at which the machine may be in a state, or inside it.
    pub fn earliest(&self, state: usize) -> Option<f64> {
        let m = self.program.machine.as_ref()?;
        let inside = self.entered.iter().filter(|(leaf, _)| m.path(**leaf).any(|s| s == state));
        inside.map(|(_, time)| *time).reduce(f64::min)
    }

    /// Transitions of states that may be entered which would lead into a state that is not.
    pub fn untaken(&self, state: usize) -> Vec<Untaken> {
        let Some(m) = &self.program.machine else { return Vec::new() };
        let mut out: Vec<Untaken> = Vec::new();
        for (&leaf, &since) in &self.entered {
            for s in m.path(leaf) {
                for (index, t) in m.states[s].transitions.iter().enumerate().filter(|(_, t)| m.permits(leaf, s, t)) {
                    let inside = m.leaves(t.target).iter().any(|&leaf| m.path(leaf).any(|p| p == state));
                    if inside
                        && !out.iter().any(|u| u.state == s && u.index == index)
                        && let Err(missing) = self.taken(m, leaf, since, s, index, &self.entered)
                    {
                        out.push(Untaken { state: s, index, missing });
                    }
                }
            }
        }
        out
    }

    /// Innermost states that may be entered, with the earliest time (s).
    pub(super) fn reached(&self) -> BTreeMap<usize, f64> {
        let mut entered = BTreeMap::new();
        let Some(m) = self.program.machine.as_ref().filter(|_| self.is_of_machine()) else { return entered };
        entered.extend(m.leaves(0).into_iter().map(|leaf| (leaf, 0.0)));
        for _ in 0..ROUNDS {
            let mut changed = false;
            for (leaf, since) in entered.clone() {
                for s in m.path(leaf) {
                    for (index, t) in m.states[s].transitions.iter().enumerate().filter(|(_, t)| m.permits(leaf, s, t))
                    {
                        let Ok(time) = self.taken(m, leaf, since, s, index, &entered) else { continue };
                        for next in m.leaves(t.target) {
                            let known = entered.entry(next).or_insert(f64::INFINITY);
                            if time < *known - ROUNDING {
                                *known = time;
                                changed = true;
                            }
                        }
                    }
                }
            }
            if !changed {
                break;
            }
        }
        entered
    }

    /// Earliest time (s) at which a transition of state `s` is taken in the innermost state `leaf`, which is entered at `since` at
    /// the earliest.
    fn taken(
        &self,
        m: &MachineProgram,
        leaf: usize,
        since: f64,
        s: usize,
        index: usize,
        entered: &BTreeMap<usize, f64>,
    ) -> Result<f64, Missing> {
        let end = self.scenario.run.duration + ROUNDING;
        // Only of the innermost state is the time of the entry known.
        let after = |time: f64| if s == leaf { since + time } else { since };
        let time = match &m.states[s].transitions[index].trigger {
            Trigger::Event(event) => self.raised(m, *event, since, entered).ok_or(Missing::Event(*event))?,
            Trigger::When { hold, .. } => {
                let places = self.source_map.machine.as_ref();
                let node = places.and_then(|p| p.transitions.get(s)?.get(index)?.condition);
                if node.is_some_and(|node| !self.condition(node).holds) {
                    return Err(Missing::Condition);
                }
                after(*hold)
            }
            Trigger::After(time) => after(*time),
            Trigger::Fault(FaultPattern::Kind(FaultKind::Deadline)) if !self.misses_the_deadline() => {
                return Err(Missing::Condition);
            }
            Trigger::Reached(_) | Trigger::Ended(_) | Trigger::Fault(_) => since,
        };
        if time <= end { Ok(time) } else { Err(Missing::Time) }
    }

    /// Earliest time (s), from `since` on, at which an event may be raised.
    fn raised(&self, m: &MachineProgram, event: usize, since: f64, entered: &BTreeMap<usize, f64>) -> Option<f64> {
        let reached: BTreeSet<usize> = entered.keys().flat_map(|&leaf| m.path(leaf)).collect();
        let actions = reached.iter().flat_map(|&s| {
            let state = &m.states[s];
            state.enter.iter().chain(&state.activities).chain(&state.exit)
        });
        let by_machine = actions.into_iter().any(|&a| {
            let action = &m.actions[a];
            action.event == Some(event) || action.outcomes.iter().any(|o| o.1 == event && self.ends_with(a, &o.0))
        });
        if by_machine {
            return Some(since);
        }
        // An event is seen at the tick at which it is raised, or at the next one.
        let least = since - self.program.robot.period - ROUNDING;
        let scripted = self.scenario.world.events.iter().filter(|e| e.0 == event).flat_map(|e| &e.1);
        scripted.copied().filter(|time| *time >= least).reduce(f64::min).map(|time| time.max(since))
    }

    /// True if an action may end with an outcome.
    fn ends_with(&self, action: usize, word: &str) -> bool {
        let Some(action) = self.program.machine.as_ref().and_then(|m| m.actions.get(action)) else { return true };
        let scripts = &self.scenario.world.outcomes;
        let keys = action.arguments.first().into_iter().chain([&action.verb]);
        let script = keys.into_iter().find_map(|key| scripts.iter().find(|s| s.key == *key));
        match script {
            Some(script) => script.requests.iter().any(|r| r.outcome.as_deref() == Some(word)),
            // Without a script an action ends with the first of its outcomes.
            None => action.outcomes.first().is_some_and(|o| o.0 == word),
        }
    }
}
