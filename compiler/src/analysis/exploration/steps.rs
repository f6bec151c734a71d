//! Transitions that can be taken at a node: conditions that must hold, and those that must not, so that no transition before it
//! is taken.

use std::collections::{BTreeMap, BTreeSet};

use runtime::program::{Reached, Trigger};

use super::{Exploration, Way};
use crate::analysis::conditions::{CLOCK, Claim, Formula, Key, Value};
use crate::expr::Interval;

/// The question if a transition can be taken.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Question {
    /// The innermost state.
    leaf: usize,
    /// The transition.
    way: Way,
    /// True for the tick after the entry alone.
    first: bool,
    /// Values that are known, by variable, as bits.
    read: Vec<(usize, u64)>,
}

/// Conditions of others that do not hold while a transition takes time.
#[derive(Default)]
pub(super) struct Meanwhile {
    /// Those that would be taken at once.
    pub at_once: Vec<Formula>,
    /// Those that must hold for a time themselves.
    pub later: Vec<Formula>,
}

/// Reason why a transition is not taken in an innermost state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Refusal {
    /// Its event does not occur there.
    Event,
    /// Its target is active.
    Active,
    /// The task that it waits for does not run there.
    Task,
    /// Its condition does not hold for what is known there.
    Condition,
    /// Other transitions are always taken first.
    Precedence,
}

/// Factor for the rounding of a time that is a sum of periods.
pub(super) const ROUNDING: f64 = 1.0 + 1e-6;

/// Demands of a transition on the values at a tick.
#[derive(Debug, Default)]
pub(super) struct Demands {
    /// Formulas that hold, its own condition first.
    pub holds: Vec<Formula>,
    /// Formulas that do not.
    pub fails: Vec<Formula>,
    /// Conditions that have not held for as long as its own.
    pub held: Vec<Formula>,
}

impl Demands {
    /// The formulas of this tick.
    pub fn all(&self) -> impl Iterator<Item = &Formula> {
        self.holds.iter().chain(&self.fails)
    }

    /// The requirements of this tick.
    pub fn claims(&self) -> Vec<Claim<'_>> {
        self.holds.iter().map(Claim::Holds).chain(self.fails.iter().map(Claim::Fails)).collect()
    }
}

/// Time for which a condition must have held (s).
fn hold(trigger: &Trigger) -> f64 {
    match trigger {
        Trigger::When { hold, .. } => *hold,
        _ => 0.0,
    }
}

fn bits(value: Value) -> u64 {
    match value {
        Value::Number(x) => x.to_bits(),
        Value::Truth(yes) => u64::from(yes),
        Value::Absent => f64::NAN.to_bits(),
    }
}

impl Exploration<'_> {
    /// Transitions that have priority over another one in an innermost state.
    pub(super) fn blockers(&self, leaf: usize, way: Way) -> Vec<Way> {
        let event = matches!(self.trigger(way), Trigger::Event(_));
        let mut out = Vec::new();
        for other in self.ways(leaf) {
            if other == way {
                break;
            }
            if matches!(self.trigger(other), Trigger::Fault(_)) {
                continue;
            }
            let keeps = self.stays(leaf, other);
            // One that keeps the machine in its target blocks those behind it in the same state, except for events; a
            // time is then blocked itself.
            let passes =
                keeps && (other.state != way.state || event || matches!(self.trigger(other), Trigger::After(_)));
            if !passes {
                out.push(other);
            }
        }
        out
    }

    /// True if a transition keeps the machine in its target, which is active.
    pub(super) fn stays(&self, leaf: usize, way: Way) -> bool {
        let t = &self.machine.states[way.state].transitions[way.index];
        self.machine.keeps(way.state, t) && self.machine.path(leaf).any(|s| s == t.target)
    }

    /// Transitions behind one of the same state that keeps the machine in its target.
    pub(super) fn behind_keeping(&self, leaf: usize) -> BTreeSet<Way> {
        let (mut out, mut of, mut keeps) = (BTreeSet::new(), None, false);
        for way in self.ways(leaf) {
            keeps &= of == Some(way.state);
            of = Some(way.state);
            if keeps {
                out.insert(way);
            }
            keeps |= self.stays(leaf, way);
        }
        out
    }

    /// True if a transition may be blocked until its condition has been false.
    pub(super) fn may_wait(&self, Way { state, index }: Way) -> bool {
        let t = &self.machine.states[state].transitions[index];
        // A condition that must hold for a time does not hold at the entry.
        match t.trigger {
            Trigger::After(_) => self.machine.keeps(state, t),
            _ => self.machine.restarts(state, t) && hold(&t.trigger) == 0.0,
        }
    }

    /// The condition of a transition, or that its time has passed; `None` for events, `reached` and faults.
    pub(super) fn condition(&self, way: Way) -> Option<&Formula> {
        self.conditions.triggers[way.state][way.index].as_ref()
    }

    /// True if a transition can be taken at a node; also if that is not known.
    pub(super) fn can_take(&mut self, node: usize, way: Way) -> bool {
        let (leaf, environment) = (self.nodes[node].leaf, self.nodes[node].environment);
        let target = self.machine.states[way.state].transitions[way.index].target;
        let raised = &self.nodes[node].raised;
        match self.trigger(way) {
            // A fault never re-enters an active state.
            Trigger::Fault(_) => return !self.machine.path(leaf).any(|s| s == target),
            Trigger::Event(e) if !raised.contains(e) && !self.may_occur(leaf, *e) => return false,
            Trigger::Reached(Reached { task, .. }) if self.is_elsewhere(leaf, way, *task) => return false,
            _ if self.stays(leaf, way) => return false,
            _ => {}
        }
        let blockers = self.blockers(leaf, way);
        if blockers.iter().any(|b| matches!(self.trigger(*b), Trigger::Event(e) if raised.contains(e))) {
            return false;
        }
        let values = self.environments.values(environment);
        let read: Vec<(usize, u64)> = values.iter().enumerate().filter_map(|(v, x)| Some((v, bits((*x)?)))).collect();
        let question = Question { leaf, way, first: !raised.is_empty(), read };
        if let Some(&answer) = self.known.get(&question) {
            return answer;
        }
        let answer = self.is_possible(node, way);
        self.known.insert(question, answer);
        answer
    }

    /// Why a transition that is never taken in an innermost state is not.
    pub fn refusal(&self, leaf: usize, way: Way) -> Refusal {
        let mut nodes = self.nodes_of(leaf).map(|n| &self.nodes[n]);
        match self.trigger(way) {
            Trigger::Event(e) if !self.may_occur(leaf, *e) && !nodes.any(|n| n.raised.contains(e)) => Refusal::Event,
            Trigger::Reached(Reached { task, .. }) if self.is_elsewhere(leaf, way, *task) => Refusal::Task,
            _ if self.stays(leaf, way) => Refusal::Active,
            _ => {
                let never = |node: &super::Node| {
                    let values = self.environments.values(node.environment);
                    let own = self.condition(way).map(|f| f.given(&|v| values[v]));
                    own.is_some_and(|f| self.conditions.search(&[Claim::Holds(&f)]).is_impossible())
                };
                if nodes.all(never) { Refusal::Condition } else { Refusal::Precedence }
            }
        }
    }

    /// Demands of a transition on the values at a tick, for what is known at a node.
    pub(super) fn demands(&self, node: usize, way: Way) -> Demands {
        // At a fault, only transitions for faults are examined.
        if matches!(self.trigger(way), Trigger::Fault(_)) {
            return Demands::default();
        }
        let values = self.environments.values(self.nodes[node].environment);
        let given = |f: &Formula| f.given(&|v| values[v]);
        let own = self.condition(way).map(given);
        let lasting = given(&self.conditions.lasting[way.state][way.index]);
        let mut out = Demands { holds: own.into_iter().chain([lasting]).collect(), ..Demands::default() };
        for b in self.blockers(self.nodes[node].leaf, way).into_iter().filter(|b| !self.may_wait(*b)) {
            let Some(condition) = self.condition(b) else { continue };
            match hold(self.trigger(b)) {
                0.0 => out.fails.push(given(condition)),
                // Inside, a state may have been entered since the condition began to hold.
                time if time <= hold(self.trigger(way)) && b.state == way.state => out.held.push(given(condition)),
                _ => {}
            }
        }
        out
    }

    /// Conditions of others while a transition takes time; `None` if it takes none.
    pub(super) fn meanwhile(&self, node: usize, way: Way) -> Option<Meanwhile> {
        let takes_time = match self.trigger(way) {
            Trigger::After(time) => *time > self.program.robot.period * ROUNDING,
            Trigger::When { hold, .. } => *hold > 0.0,
            _ => false,
        };
        if !takes_time {
            return None;
        }
        let leaf = self.nodes[node].leaf;
        let values = self.environments.values(self.nodes[node].environment);
        let (mut at_once, mut later) = (Vec::new(), Vec::new());
        let behind = self.behind_keeping(leaf);
        for other in self.ways(leaf).into_iter().filter(|o| *o != way && !self.stays(leaf, *o) && !self.may_wait(*o)) {
            let Trigger::When { hold, .. } = self.trigger(other) else { continue };
            // One behind a transition that keeps the machine in its target may be blocked by that.
            if behind.contains(&other) {
                continue;
            }
            let Some(condition) = self.condition(other) else { continue };
            let list = if *hold == 0.0 { &mut at_once } else { &mut later };
            list.push(condition.given(&|v| values[v]));
        }
        Some(Meanwhile { at_once, later })
    }

    /// True unless no values permit a transition at a node.
    fn is_possible(&mut self, node: usize, way: Way) -> bool {
        let demands = self.demands(node, way);
        let ranges = self.clock_at(node, way);
        let conditions = self.conditions;
        let mut left = self.left;
        let mut possible = |claims: &[Claim]| !conditions.search_within(claims, &ranges, &mut left).is_impossible();
        let mut claims = demands.claims();
        let mut answer = possible(&claims);
        // A condition that has held for as long would have been first, unless it was false meanwhile.
        for f in &demands.held {
            if answer {
                claims.push(Claim::Fails(f));
                answer = possible(&claims);
                claims.pop();
            }
        }
        // A transition that re-enters its state has been false since.
        if answer && self.may_wait(way) && matches!(self.trigger(way), Trigger::When { .. }) {
            answer = possible(&[Claim::Fails(&demands.holds[0])]);
        }
        // While its time passes in its own state, no other one is taken.
        let held = matches!(self.trigger(way), Trigger::When { .. });
        if answer
            && way.state == self.nodes[node].leaf
            && let Some(Meanwhile { at_once: others, .. }) = self.meanwhile(node, way)
        {
            let own = demands.holds.iter().take(usize::from(held)).map(Claim::Holds);
            answer = possible(&own.chain(others.iter().map(Claim::Fails)).collect::<Vec<_>>());
        }
        self.left = left;
        answer
    }

    /// True if a task does not run in an innermost state, and does in another one where this transition is examined. If
    /// it runs in none, that is an error of its own.
    fn is_elsewhere(&self, leaf: usize, way: Way, task: usize) -> bool {
        let m = self.machine;
        let inside = |l: &usize| m.states[*l].initial.is_none() && m.path(*l).any(|s| s == way.state);
        !self.runs(leaf, task) && (0..m.states.len()).filter(inside).any(|l| self.runs(l, task))
    }

    /// Range of the time in the innermost state of a node when a transition is taken.
    pub(super) fn clock_at(&self, node: usize, way: Way) -> BTreeMap<usize, Interval> {
        self.clock(self.nodes[node].leaf, way, !self.nodes[node].raised.is_empty())
    }

    /// Range of the time in an innermost state, which another `after` of it, or of a state around it, ends; `first` for
    /// the tick after the entry.
    fn clock(&self, leaf: usize, way: Way, first: bool) -> BTreeMap<usize, Interval> {
        // One that keeps the machine in its target has priority over a time behind it.
        let behind = self.behind_keeping(leaf);
        let ends = self.ways(leaf).into_iter().filter(|&end| {
            let ends = matches!(self.trigger(end), Trigger::After(_)) && end != way && !self.may_wait(end);
            ends && !behind.contains(&end)
        });
        let ends = ends.filter_map(|end| match self.trigger(end) {
            Trigger::After(time) => Some(*time),
            _ => None,
        });
        let end = ends.chain(first.then_some(0.0)).min_by(f64::total_cmp);
        let most = end.map(|end| end + self.program.robot.period * ROUNDING);
        self.conditions.clock(leaf).zip(most).map(|(v, most)| (v, Interval::new(0.0, most))).into_iter().collect()
    }

    /// True for the time since the entry of a state.
    pub(super) fn is_clock(&self, value: usize) -> bool {
        match &self.conditions.variables[value].key {
            Key::Number(terms) => matches!(terms.as_slice(), [(term, _)] if term.node == CLOCK),
            _ => false,
        }
    }
}
