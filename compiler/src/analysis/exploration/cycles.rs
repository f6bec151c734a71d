//! States between which a machine goes back and forth at every tick while no value changes.
//!
//! At given values a machine does the same in the same situation. A transition happens at once if its condition holds at
//! the tick after its state was entered and no transition before it does. A cycle of such transitions, at values that
//! meet all their conditions, never ends by itself.

use std::collections::{BTreeMap, BTreeSet};

use runtime::program::{MachineAction, Trigger};

use super::steps::ROUNDING;
use super::{Change, Exploration, Node, Way};
use crate::analysis::conditions::{Claim, Formula, Leaf, Search, Truth, Value};
use crate::expr::Interval;

/// Largest number of transitions of a cycle.
const LENGTH: usize = 12;

/// Largest number of transitions that are followed in the search of cycles.
const FOLLOWED: usize = 5_000;

/// A cycle of transitions that happen at once, one at each tick.
#[derive(Clone, Debug)]
pub(crate) struct Cycle {
    /// The innermost states, each with the transition that leaves it.
    pub steps: Vec<(usize, Way)>,
    /// Values at which it happens, where they matter.
    pub values: Vec<(usize, Value)>,
}

impl Cycle {
    /// Its states.
    fn states(&self) -> BTreeSet<usize> {
        self.steps.iter().map(|s| s.0).collect()
    }
}

/// A transition that happens at once, under conditions.
struct Immediate {
    way: Way,
    to: usize,
    /// True if its condition must have held for a time, which it has if it holds at all ticks of the cycle.
    lasts: bool,
    /// Formulas that hold.
    holds: Vec<Formula>,
    /// Formulas that do not.
    fails: Vec<Formula>,
}

/// A path of such transitions.
struct Path<'p> {
    edges: &'p [Vec<Immediate>],
    /// Nodes, each with the index of the transition that leaves it.
    steps: Vec<(usize, usize)>,
    /// Transitions that may still be followed.
    left: usize,
    found: Vec<Cycle>,
    /// Sets of states of the cycles found.
    told: BTreeSet<BTreeSet<usize>>,
}

impl Exploration<'_> {
    /// Cycles without time, at most one for each set of states. `ranges` are those of values of the robot's state.
    pub fn cycles(&mut self, ranges: &BTreeMap<usize, Interval>) -> Vec<Cycle> {
        let mut edges: Vec<Vec<Immediate>> = (0..self.nodes.len()).map(|n| self.immediate(n, ranges)).collect();
        prune(&mut edges);
        let mut path =
            Path { edges: &edges, steps: Vec::new(), left: FOLLOWED, found: Vec::new(), told: BTreeSet::new() };
        for start in 0..edges.len() {
            self.follow(start, start, &mut path, ranges);
        }
        // A cycle within another one says enough.
        let told = path.told;
        let is_least = |c: &Cycle| {
            let own = c.states();
            !told.iter().any(|o| o.len() < own.len() && o.iter().all(|s| own.contains(s)))
        };
        path.found.into_iter().filter(is_least).collect()
    }

    /// Follows the transitions from a node on, back to the first node of the path.
    fn follow(&mut self, at: usize, start: usize, path: &mut Path, ranges: &BTreeMap<usize, Interval>) {
        let edges = path.edges;
        for (i, edge) in edges[at].iter().enumerate() {
            // Each cycle is found from its first node.
            let inside = path.steps.iter().any(|s| s.0 == edge.to);
            if edge.to < start || (inside && edge.to != start) || path.steps.len() >= LENGTH || path.left == 0 {
                continue;
            }
            path.left -= 1;
            path.steps.push((at, i));
            if edge.to == start {
                self.close(path, ranges);
            } else if !edges[edge.to].is_empty() && self.meets(path, &[], ranges).is_some() {
                self.follow(edge.to, start, path, ranges);
            }
            path.steps.pop();
        }
    }

    /// Values that meet the conditions of a path.
    fn meets(
        &mut self,
        path: &Path,
        lasting: &[Formula],
        ranges: &BTreeMap<usize, Interval>,
    ) -> Option<Vec<(usize, Value)>> {
        let mut claims: Vec<Claim> = lasting.iter().map(Claim::Holds).collect();
        for &(node, i) in &path.steps {
            let edge = &path.edges[node][i];
            claims.extend(edge.holds.iter().map(Claim::Holds));
            claims.extend(edge.fails.iter().map(Claim::Fails));
        }
        match self.conditions.search_within(&claims, ranges, &mut self.left) {
            Search::Found(values) => Some(values),
            Search::Impossible | Search::TooLarge => None,
        }
    }

    /// Adds the cycle of a path that leads back to its first node, if its values can all occur.
    fn close(&mut self, path: &mut Path, ranges: &BTreeMap<usize, Interval>) {
        let edges = path.edges;
        let own: BTreeSet<usize> = path.steps.iter().map(|s| self.nodes[s.0].leaf).collect();
        if path.told.contains(&own) {
            return;
        }
        let Some(lasting) = self.lasting(path) else { return };
        let formulas = path.steps.iter().map(|&(n, i)| &edges[n][i]).flat_map(|e| e.holds.iter().chain(&e.fails));
        let formulas = formulas.chain(&lasting);
        let mut read = Vec::new();
        formulas.for_each(|f| f.variables(&mut read));
        let mut changed = BTreeSet::new();
        for &(node, i) in &path.steps {
            let Change { actions, .. } = self.change(self.nodes[node].leaf, edges[node][i].way);
            changed.extend(actions.iter().filter_map(|&a| match &self.machine.actions[a].own {
                Some(MachineAction::Set { variable, .. } | MachineAction::Clear(variable)) => Some(*variable),
                Some(MachineAction::Tare(signal)) => Some(*signal),
                None => None,
            }));
        }
        if !self.can_occur(&read, &changed) {
            return;
        }
        let Some(values) = self.meets(path, &lasting, ranges) else { return };
        let steps = path.steps.iter().map(|&(n, i)| (self.nodes[n].leaf, edges[n][i].way)).collect();
        path.told.insert(own);
        path.found.push(Cycle { steps, values });
    }

    /// Conditions that must hold at all ticks of a cycle, because they must have held for a time; `None` if the cycle
    /// leaves their states.
    fn lasting(&self, path: &Path) -> Option<Vec<Formula>> {
        let m = self.machine;
        let edges = || path.steps.iter().map(|&(n, i)| &path.edges[n][i]);
        let mut out = Vec::new();
        for edge in edges().filter(|e| e.lasts) {
            let stays = |&Way { state, index }: &Way| {
                let kept = self.kept(state, m.states[state].transitions[index].target);
                m.path(kept).any(|s| s == edge.way.state)
            };
            if !edges().all(|e| stays(&e.way)) {
                return None;
            }
            let condition = self.condition(edge.way)?;
            out.extend(path.steps.iter().map(|&(node, _)| self.given(node, condition)));
        }
        Some(out)
    }

    /// True if these values can all take every value, independently of each other and of what the cycle changes.
    pub(super) fn can_occur(&self, read: &[usize], changed: &BTreeSet<usize>) -> bool {
        let mut seen: BTreeSet<Leaf> = BTreeSet::new();
        let mut of_robot = 0;
        for &v in read {
            let of = &self.conditions.variables[v];
            if !of.leaves.single || self.environments.reads(self.conditions, v, changed) {
                return false;
            }
            of_robot += usize::from(of.leaves.all.iter().any(|l| matches!(l, Leaf::State(_))));
            for leaf in &of.leaves.all {
                let counted = |s: usize| self.machine.measured.iter().any(|m| m.signal == s && m.since.is_some());
                let unsteady = match leaf {
                    Leaf::Clock(_) | Leaf::Other => true,
                    Leaf::Signal(s, _) => counted(*s),
                    Leaf::State(_) => false,
                };
                if unsteady || !seen.insert(*leaf) {
                    return false;
                }
            }
        }
        // Several quantities of the robot depend on each other through its configuration.
        of_robot <= 1
    }

    /// Transitions of a node that can happen at the tick after the entry.
    fn immediate(&mut self, node: usize, ranges: &BTreeMap<usize, Interval>) -> Vec<Immediate> {
        let mut out = Vec::new();
        let leaf = self.nodes[node].leaf;
        for step in self.steps[node].clone() {
            let raised = |way| matches!(self.trigger(way), Trigger::Event(e) if self.nodes[node].raised.contains(e));
            let at_once = match self.trigger(step.way) {
                Trigger::When { hold, .. } if *hold > 0.0 => step.way.state != leaf,
                Trigger::When { .. } => !self.may_wait(step.way),
                Trigger::After(_) => self.is_over(step.way),
                Trigger::Event(_) => raised(step.way),
                Trigger::Reached(_) | Trigger::Ended(_) | Trigger::Fault(_) => false,
            };
            let blockers = self.blockers(leaf, step.way);
            if !at_once || blockers.iter().any(|b| self.is_over(*b)) {
                continue;
            }
            let condition = |way| match self.trigger(way) {
                Trigger::When { .. } => self.condition(way).map(|f| self.given(node, f)),
                _ => None,
            };
            let own = condition(step.way);
            // The state was just entered, so that its conditions have not held for a time and those that re-enter it
            // wait.
            let before = blockers.iter().filter(|b| match self.trigger(**b) {
                Trigger::When { hold, .. } => b.state != leaf || (*hold == 0.0 && !self.may_wait(**b)),
                _ => false,
            });
            let fails: Vec<Formula> = before.filter_map(|b| condition(*b)).collect();
            let holds: Vec<Formula> = own.into_iter().collect();
            let met = |f: &Formula, wanted: bool| match f {
                Formula::Constant(truth) => (*truth == Truth::Yes) == wanted,
                _ => true,
            };
            if !holds.iter().all(|f| met(f, true)) || !fails.iter().all(|f| met(f, false)) {
                continue;
            }
            let varies = |f: &Formula| !matches!(f, Formula::Constant(_));
            let (holds, fails) = (
                holds.into_iter().filter(varies).collect::<Vec<_>>(),
                fails.into_iter().filter(varies).collect::<Vec<_>>(),
            );
            let claims: Vec<Claim> = holds.iter().map(Claim::Holds).chain(fails.iter().map(Claim::Fails)).collect();
            if matches!(self.conditions.search_within(&claims, ranges, &mut self.left), Search::Found(_)) {
                let lasts = matches!(self.trigger(step.way), Trigger::When { hold, .. } if *hold > 0.0);
                out.push(Immediate { way: step.way, to: step.to, lasts, holds, fails });
            }
        }
        out
    }

    /// True for a time that is over at the tick after the entry.
    pub(super) fn is_over(&self, way: Way) -> bool {
        let over = |time: f64| time <= self.program.robot.period * ROUNDING;
        matches!(self.trigger(way), Trigger::After(time) if over(*time)) && !self.may_wait(way)
    }

    /// A formula with what is known at a node, at the tick after the entry of its state.
    fn given(&self, node: usize, formula: &Formula) -> Formula {
        let Node { leaf, environment, .. } = self.nodes[node];
        let values = self.environments.values(environment);
        formula.given(&|v| match self.conditions.variables[v].leaves.all.as_slice() {
            [Leaf::Clock(state)] if *state == leaf && self.is_clock(v) => {
                Some(Value::Number(self.program.robot.period))
            }
            [Leaf::Signal(signal, _), ..] if self.is_silent(leaf, *signal) => Some(Value::Absent),
            _ => values[v],
        })
    }

    /// True for an output of a task that the stack of a state does not have.
    pub(super) fn is_silent(&self, leaf: usize, signal: usize) -> bool {
        self.outputs.get(&signal).is_some_and(|&task| !self.runs(leaf, task))
    }
}

/// Removes transitions that are part of no cycle: those to nodes that none leaves, and from nodes to which none leads.
fn prune(edges: &mut [Vec<Immediate>]) {
    loop {
        let led: BTreeSet<usize> = edges.iter().flatten().map(|e| e.to).collect();
        let left: BTreeSet<usize> = (0..edges.len()).filter(|&n| !edges[n].is_empty()).collect();
        let before: usize = edges.iter().map(Vec::len).sum();
        for (n, own) in edges.iter_mut().enumerate() {
            own.retain(|e| led.contains(&n) && left.contains(&e.to));
        }
        if edges.iter().map(Vec::len).sum::<usize>() == before {
            return;
        }
    }
}
