//! Judgement of properties: the proof that one holds at every tick of a machine, or a run that violates it.
//!
//! A property is judged after the machine has done its step, with the values of that tick: at the tick at which a state is
//! entered, and at those at which it is not left. It is proven if no values violate it. A run that violates it is one only
//! if all values on the way can occur, independently of each other; otherwise nothing is decided.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use runtime::program::{MachineAction, Trigger};

use super::steps::{Demands, Meanwhile};
use super::{Exploration, Step, Way};
use crate::analysis::conditions::{Claim, Formula, Key, Leaf, Search, Value};

/// Part of the machine itself that a property reads.
#[derive(Clone, Copy, Debug)]
pub(crate) enum OfMachine {
    /// True while a state is active.
    In(usize),
    /// True while there is a fault.
    Fault,
}

/// Result for a property.
#[derive(Clone, Debug)]
pub(crate) enum Verdict {
    /// It holds at every tick.
    Holds,
    /// A run violates it.
    Violated(Run),
    /// The machine is too large.
    TooLarge,
    /// Values may violate it, and it is not known whether they can occur.
    Open,
    /// It depends on regions that are active beside each other.
    Beside,
}

/// A run that violates a property.
#[derive(Clone, Debug)]
pub(crate) struct Run {
    /// The transitions, in their order.
    pub steps: Vec<Taken>,
    /// The innermost state at the end.
    pub leaf: usize,
    /// Values at the end, where they matter.
    pub values: Vec<(usize, Value)>,
}

/// A transition of a run.
#[derive(Clone, Debug)]
pub(crate) struct Taken {
    /// The innermost state that it leaves.
    pub leaf: usize,
    /// The transition.
    pub way: Way,
    /// Values at which it is taken, where they matter.
    pub values: Vec<(usize, Value)>,
}

/// A property with what it reads.
struct Judged<'p> {
    formula: &'p Formula,
    /// State in which it holds.
    state: usize,
    of_machine: &'p BTreeMap<usize, OfMachine>,
    /// For each innermost state, the presences without which its stack is faulty; a tick with a fault is not judged.
    needs: BTreeMap<usize, Vec<Formula>>,
    /// Presences of signals whose absence is a fault, but for the beginning of a run.
    expected: Vec<Formula>,
}

/// Way to a node: the node before, and the transition; `None` if an event passed unheard.
type Parent = Option<(usize, Option<Step>)>;

impl Exploration<'_> {
    /// Judges a property of a state; `of_machine` are the values that it reads of the machine itself.
    pub fn judge(&mut self, formula: &Formula, state: usize, of_machine: &BTreeMap<usize, OfMachine>) -> Verdict {
        if !self.is_complete() {
            return Verdict::TooLarge;
        }
        let mut read = Vec::new();
        formula.variables(&mut read);
        if read.iter().any(|v| !of_machine.contains_key(v) && self.is_of_motion(*v)) {
            return Verdict::Open;
        }
        let leaves = self.leaves().into_iter();
        let needed = |l: usize| {
            let needs = self.needs(l);
            self.present(|s| needs.contains(&s))
        };
        let needs = leaves.map(|l| (l, needed(l))).collect();
        let signals = &self.program.interface.signals;
        let expected = self.present(|s| !signals[s].optional && signals[s].timeout.is_some());
        let judged = Judged { formula, state, of_machine, needs, expected };
        let (sure, parents) = self.certain_nodes();
        let mut doubt = None;
        for &node in &sure {
            if node == 0
                && let Some(run) = self.violated(&judged, node, None, &parents, &mut doubt)
            {
                return Verdict::Violated(run);
            }
            for step in self.steps[node].clone() {
                if let Some(run) = self.violated(&judged, step.to, Some((node, step)), &parents, &mut doubt) {
                    return Verdict::Violated(run);
                }
            }
            if let Some(run) = self.stays_violated(&judged, node, &parents, &mut doubt) {
                return Verdict::Violated(run);
            }
        }
        // Nodes that may not be reachable cannot violate it, but nothing is proven of them.
        for node in (0..self.nodes.len()).filter(|n| !sure.contains(n)) {
            for step in self.steps[node].clone() {
                let found = self.violated(&judged, step.to, Some((node, step)), &parents, &mut doubt);
                doubt = doubt.or(found.map(|_| Verdict::Open));
            }
            let found = self.stays_violated(&judged, node, &parents, &mut doubt);
            doubt = doubt.or(found.map(|_| Verdict::Open));
        }
        doubt.unwrap_or(Verdict::Holds)
    }

    /// True for a value that the tick itself changes after the step of the machine: of the robot, of a task, of a sensor
    /// that is tared, or a time.
    fn is_of_motion(&self, value: usize) -> bool {
        let own = |s: &usize| {
            let tared = self.machine.actions.iter().any(|a| a.own == Some(MachineAction::Tare(*s)));
            tared || self.outputs.contains_key(s) || self.machine.measured.iter().any(|m| m.signal == *s)
        };
        self.conditions.variables[value].leaves.all.iter().any(|leaf| match leaf {
            Leaf::Signal(s, _) => own(s),
            Leaf::State(_) | Leaf::Clock(_) | Leaf::Other => true,
        })
    }

    /// Presences of some signals, where conditions depend on them.
    fn present(&self, of: impl Fn(usize) -> bool) -> Vec<Formula> {
        let all = self.conditions.variables.iter().enumerate();
        let wanted = all.filter(|(_, v)| matches!(v.key, Key::Present(s) if of(s)));
        wanted.map(|(v, _)| Formula::Flag(v)).collect()
    }

    /// Signals that the stack of an innermost state needs.
    fn needs(&self, leaf: usize) -> Vec<usize> {
        self.machine.stack(leaf).map(|stack| self.stacks.needs(stack)).unwrap_or_default()
    }

    /// Nodes that the machine reaches at values that can occur, in the order of the length of the way, each with the node
    /// before it.
    fn certain_nodes(&mut self) -> (Vec<usize>, Vec<Parent>) {
        let mut parents: Vec<Parent> = vec![None; self.nodes.len()];
        let (mut order, mut seen) = (Vec::new(), BTreeSet::from([0]));
        let mut open = VecDeque::from([0]);
        while let Some(node) = open.pop_front() {
            order.push(node);
            let mut next: Vec<(usize, Option<Step>)> = Vec::new();
            for step in self.steps[node].clone() {
                if !seen.contains(&step.to) && self.is_certain(node, step) {
                    next.push((step.to, Some(step)));
                }
            }
            next.extend(self.quiet.get(&node).map(|&to| (to, None)));
            for (to, step) in next {
                if seen.insert(to) {
                    parents[to] = Some((node, step));
                    open.push_back(to);
                }
            }
        }
        (order, parents)
    }

    /// True if the values of a step can occur, also while its time passes.
    fn is_certain(&mut self, node: usize, step: Step) -> bool {
        let leaf = self.nodes[node].leaf;
        let demands = self.demands(node, step.way);
        let Meanwhile { at_once, later } = self.meanwhile(node, step.way).unwrap_or_default();
        let mut read = Vec::new();
        demands.all().chain(&at_once).chain(&later).for_each(|f| f.variables(&mut read));
        if !self.is_exact(leaf, &read) {
            return false;
        }
        let held = matches!(self.trigger(step.way), Trigger::When { .. });
        let own = demands.holds.iter().take(usize::from(held)).map(Claim::Holds);
        let claims: Vec<Claim> = own.chain(at_once.iter().chain(&later).map(Claim::Fails)).collect();
        let nothing = at_once.is_empty() && later.is_empty();
        nothing || matches!(self.conditions.search_within(&claims, &BTreeMap::new(), &mut self.left), Search::Found(_))
    }

    /// True if these values can all take every value in a state, independently of each other.
    fn is_exact(&self, leaf: usize, read: &[usize]) -> bool {
        let own: Vec<usize> = read.iter().copied().filter(|&v| self.conditions.clock(leaf) != Some(v)).collect();
        let silent = |v: &usize| {
            let leaves = &self.conditions.variables[*v].leaves.all;
            leaves.iter().any(|l| matches!(l, Leaf::Signal(s, _) if self.is_silent(leaf, *s)))
        };
        self.can_occur(&own, &self.environments.tracked()) && !own.iter().any(silent)
    }

    /// The property at a node, negated; `None` if it does not apply there.
    fn at(&self, judged: &Judged, node: usize) -> Option<Formula> {
        let leaf = self.nodes[node].leaf;
        if !self.machine.path(leaf).any(|s| s == judged.state) {
            return None;
        }
        let values = self.environments.values(self.nodes[node].environment);
        Some(judged.formula.given(&|v| match judged.of_machine.get(&v) {
            Some(OfMachine::In(s)) => Some(Value::Truth(self.machine.path(leaf).any(|p| p == *s))),
            Some(OfMachine::Fault) => Some(Value::Truth(false)),
            None => values[v],
        }))
    }

    /// A run to a node, by a step or from the start, at whose last tick the property is false. Where that is not certain,
    /// `doubt` says so.
    fn violated(
        &mut self,
        judged: &Judged,
        node: usize,
        by: Option<(usize, Step)>,
        parents: &[Parent],
        doubt: &mut Option<Verdict>,
    ) -> Option<Run> {
        let property = self.at(judged, node)?;
        let demands = by.map_or_else(Demands::default, |(from, step)| self.demands(from, step.way));
        let leaf = by.map_or(self.nodes[node].leaf, |(from, _)| self.nodes[from].leaf);
        let ranges = by.map_or_else(BTreeMap::new, |(from, step)| self.clock_at(from, step.way));
        let needs = &judged.needs[&self.nodes[node].leaf];
        let mut claims = demands.claims();
        claims.push(Claim::Fails(&property));
        claims.extend(needs.iter().map(Claim::Holds));
        let weaker = self.conditions.search_within(&claims, &ranges, &mut self.left);
        claims.extend(judged.expected.iter().map(Claim::Holds));
        let values = match (weaker, self.conditions.search_within(&claims, &ranges, &mut self.left)) {
            (Search::Impossible, _) => return None,
            (_, Search::Found(values)) => values,
            (Search::TooLarge, _) | (_, Search::TooLarge) => {
                *doubt = Some(Verdict::TooLarge);
                return None;
            }
            (Search::Found(_), Search::Impossible) => {
                doubt.get_or_insert(Verdict::Open);
                return None;
            }
        };
        let mut read = Vec::new();
        demands.all().chain([&property]).for_each(|f| f.variables(&mut read));
        if !self.is_exact(leaf, &read) || by.is_some_and(|(from, step)| !self.is_certain(from, step)) {
            doubt.get_or_insert(Verdict::Open);
            return None;
        }
        let mut steps = by.map_or_else(Vec::new, |(from, _)| self.way_to(from, parents));
        steps.extend(by.map(|(_, step)| Taken { leaf, way: step.way, values: Vec::new() }));
        Some(Run { steps, leaf: self.nodes[node].leaf, values })
    }

    /// A run at whose last tick the machine stays in a state and the property is false.
    fn stays_violated(
        &mut self,
        judged: &Judged,
        node: usize,
        parents: &[Parent],
        doubt: &mut Option<Verdict>,
    ) -> Option<Run> {
        let property = self.at(judged, node)?;
        let leaf = self.nodes[node].leaf;
        let ways = self.ways(leaf);
        let heard = |w: &Way| matches!(self.trigger(*w), Trigger::Event(e) if self.nodes[node].raised.contains(e));
        if ways.iter().any(|w| heard(w) || self.is_over(*w)) {
            return None;
        }
        let values = self.environments.values(self.nodes[node].environment);
        let (mut none, mut perhaps) = (Vec::new(), Vec::new());
        let behind = self.behind_keeping(leaf);
        for &way in ways.iter().filter(|w| !self.stays(leaf, **w)) {
            let Trigger::When { hold, .. } = self.trigger(way) else { continue };
            let Some(condition) = self.condition(way).filter(|_| *hold == 0.0) else { continue };
            let list = if self.may_wait(way) || behind.contains(&way) { &mut perhaps } else { &mut none };
            list.push(condition.given(&|v| values[v]));
        }
        let found = |fails: &[&Formula], present: &[Formula], own: &Self, left: &mut usize| {
            let mut claims: Vec<Claim> = fails.iter().map(|f| Claim::Fails(f)).collect();
            claims.push(Claim::Fails(&property));
            claims.extend(present.iter().map(Claim::Holds));
            own.conditions.search_within(&claims, &BTreeMap::new(), left)
        };
        let all: Vec<&Formula> = none.iter().chain(&perhaps).collect();
        let least: Vec<&Formula> = none.iter().collect();
        let mut left = self.left;
        let needs = &judged.needs[&leaf];
        let strict: Vec<Formula> = needs.iter().chain(&judged.expected).cloned().collect();
        let result = found(&all, &strict, self, &mut left);
        let weaker = found(&least, needs, self, &mut left);
        self.left = left;
        let mut read = Vec::new();
        all.iter().copied().chain([&property]).for_each(|f| f.variables(&mut read));
        match (result, weaker) {
            (Search::Found(values), _) if self.is_exact(leaf, &read) => {
                Some(Run { steps: self.way_to(node, parents), leaf, values })
            }
            (_, Search::Impossible) => None,
            (Search::TooLarge, _) | (_, Search::TooLarge) => {
                *doubt = Some(Verdict::TooLarge);
                None
            }
            _ => {
                doubt.get_or_insert(Verdict::Open);
                None
            }
        }
    }

    /// Transitions from the start to a node, with values at which they are taken.
    fn way_to(&mut self, node: usize, parents: &[Parent]) -> Vec<Taken> {
        let mut steps = Vec::new();
        let mut at = node;
        while let Some((before, step)) = parents.get(at).copied().flatten() {
            if let Some(step) = step {
                let demands = self.demands(before, step.way);
                let ranges = self.clock_at(before, step.way);
                let values = match self.conditions.search_within(&demands.claims(), &ranges, &mut self.left) {
                    Search::Found(values) => values,
                    Search::Impossible | Search::TooLarge => Vec::new(),
                };
                steps.push(Taken { leaf: self.nodes[before].leaf, way: step.way, values });
            }
            at = before;
        }
        steps.reverse();
        steps
    }
}
