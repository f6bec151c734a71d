//! All that a machine can do, explored from its initial state: states with what is known of the variables of the machine
//! and with the events that it has raised itself. Signals may take any value at any tick.
//!
//! A transition that is found to be impossible is proven to be: values that differ are taken as independent, events of the
//! host may occur at every tick, and the time in a state is any that its `after` transitions permit. Beyond a limit of
//! effort nothing is claimed.

mod cycles;
mod environment;
mod properties;
mod steps;

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use runtime::program::{MachineProgram, Program, Trigger};

pub(crate) use cycles::Cycle;
use environment::Environments;
pub(crate) use properties::{OfMachine, Run, Taken, Verdict};
pub(crate) use steps::Refusal;

use super::conditions::{Conditions, Value};
use super::regions::Elsewhere;
use super::stacks::Stacks;
use crate::expr::Graph;

/// Largest number of nodes.
const NODES: usize = 5_000;

/// Largest number of choices in all searches.
const EFFORT: usize = 300_000;

/// Largest number of comparisons of transitions with others.
const COMPARED: usize = 1_000_000;

/// A situation of the machine after a tick.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Node {
    /// The innermost state that it is in.
    pub leaf: usize,
    /// Knowledge of the variables.
    environment: usize,
    /// Events that it has raised, seen at the next tick.
    raised: Vec<usize>,
}

/// A transition of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Way {
    /// The state that has it.
    pub state: usize,
    /// Its index there.
    pub index: usize,
}

/// The machine after a transition.
struct Change {
    /// Its innermost state.
    leaf: usize,
    /// Actions that the transition causes, in their order.
    actions: Vec<usize>,
}

/// A transition that can be taken at a node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Step {
    /// The transition.
    pub way: Way,
    /// The node to which it leads.
    pub to: usize,
}

/// The exploration of a machine.
pub(crate) struct Exploration<'e> {
    program: &'e Program,
    stacks: &'e Stacks<'e>,
    machine: &'e MachineProgram,
    conditions: &'e Conditions,
    environments: Environments<'e>,
    /// Effects that regions beside those of the machine may have.
    elsewhere: &'e Elsewhere,
    /// Number of events that are declared, and which the host may raise at any time; the others are outcomes of actions,
    /// or raised by the machine.
    declared_events: usize,
    /// The nodes, in the order in which they were found.
    pub nodes: Vec<Node>,
    /// For each node, the transitions that can be taken.
    pub steps: Vec<Vec<Step>>,
    /// For nodes with an event that nothing waits for, the node at the tick after.
    quiet: BTreeMap<usize, usize>,
    /// Tasks whose outputs are signals, by the signal.
    outputs: BTreeMap<usize, usize>,
    /// For each innermost state, outcomes of actions that may arrive there.
    arriving: BTreeMap<usize, BTreeSet<usize>>,
    /// Answers of searches, by the state, the transition and the values that are known.
    known: BTreeMap<steps::Question, bool>,
    left: usize,
    complete: bool,
}

impl<'e> Exploration<'e> {
    /// Explores a machine.
    pub fn new(
        program: &'e Program,
        stacks: &'e Stacks<'e>,
        machine: &'e MachineProgram,
        graph: &'e Graph,
        conditions: &'e Conditions,
        (declared_events, elsewhere): (usize, &'e Elsewhere),
    ) -> Exploration<'e> {
        let mut out = Exploration {
            program,
            stacks,
            machine,
            conditions,
            environments: Environments::new(program, machine, graph, conditions, &elsewhere.variables),
            elsewhere,
            declared_events,
            nodes: Vec::new(),
            steps: Vec::new(),
            quiet: BTreeMap::new(),
            outputs: outputs(program),
            arriving: BTreeMap::new(),
            known: BTreeMap::new(),
            left: EFFORT,
            complete: true,
        };
        out.run();
        out
    }

    /// Conditions of the machine.
    pub fn conditions(&self) -> &'e Conditions {
        self.conditions
    }

    /// True if everything was explored; otherwise nothing follows from what was not found.
    pub fn is_complete(&self) -> bool {
        self.complete
    }

    fn run(&mut self) {
        let m = self.machine;
        let leaf = m.leaf(0);
        let mut entered: Vec<usize> = m.path(leaf).collect();
        entered.reverse();
        let actions: Vec<usize> = entered.iter().flat_map(|&s| self.entering(s)).collect();
        let mut index: BTreeMap<Node, usize> = BTreeMap::new();
        let mut open: VecDeque<usize> = VecDeque::new();
        let first = self.node(leaf, 0, &actions);
        self.arrive(None, leaf, &actions);
        self.found(first, &mut index, &mut open);
        let mut compared = 0;
        while let Some(at) = open.pop_front() {
            let mut found = Vec::new();
            let ways = self.ways(self.nodes[at].leaf);
            // Each way is compared with all others of its state, and some with all states.
            let work = ways.len() + m.states.len() / 8;
            for way in ways {
                compared += work;
                if self.left == 0 || compared > COMPARED || self.nodes.len() > NODES {
                    self.complete = false;
                    return;
                }
                if !self.can_take(at, way) {
                    continue;
                }
                let Change { leaf: target, actions } = self.change(self.nodes[at].leaf, way);
                let next = self.node(target, self.nodes[at].environment, &actions);
                let grown = self.arrive(Some(self.nodes[at].leaf), target, &actions);
                // More outcomes may arrive in this state than when its nodes were examined.
                if grown {
                    open.extend((0..self.nodes.len()).filter(|&n| self.nodes[n].leaf == target));
                }
                let to = self.found(next, &mut index, &mut open);
                found.push(Step { way, to });
            }
            // An event that nothing waits for is lost.
            let Node { leaf, environment, ref raised } = self.nodes[at];
            let waits = |way: &Way| matches!(self.trigger(*way), Trigger::Event(e) if raised.contains(e));
            if !raised.is_empty() && !self.ways(leaf).iter().any(waits) {
                let quiet = self.found(Node { leaf, environment, raised: Vec::new() }, &mut index, &mut open);
                self.quiet.insert(at, quiet);
            }
            self.steps[at] = found;
        }
    }

    /// Index of a node, which is examined if it is new.
    fn found(&mut self, node: Node, index: &mut BTreeMap<Node, usize>, open: &mut VecDeque<usize>) -> usize {
        if let Some(&known) = index.get(&node) {
            return known;
        }
        let new = self.nodes.len();
        index.insert(node.clone(), new);
        self.nodes.push(node);
        self.steps.push(Vec::new());
        open.push_back(new);
        new
    }

    /// The node after some actions.
    fn node(&mut self, leaf: usize, environment: usize, actions: &[usize]) -> Node {
        let environment = self.environments.after(environment, self.machine, actions, self.conditions);
        let raised: BTreeSet<usize> = actions.iter().filter_map(|&a| self.machine.actions[a].event).collect();
        Node { leaf, environment, raised: raised.into_iter().collect() }
    }

    /// Adds the outcomes that may arrive in a state that is entered. Returns true if there are new ones.
    fn arrive(&mut self, from: Option<usize>, to: usize, actions: &[usize]) -> bool {
        let mut all: BTreeSet<usize> = from.and_then(|f| self.arriving.get(&f)).cloned().unwrap_or_default();
        let outcomes = actions.iter().flat_map(|&a| &self.machine.actions[a].outcomes);
        all.extend(outcomes.map(|(_, event)| *event));
        let known = self.arriving.entry(to).or_default();
        let before = known.len();
        known.extend(all);
        known.len() > before
    }

    /// Actions at the entry of a state.
    fn entering(&self, state: usize) -> Vec<usize> {
        let of = &self.machine.states[state];
        of.enter.iter().chain(&of.activities).copied().collect()
    }

    /// Transitions that are examined in an innermost state, in their order.
    pub fn ways(&self, leaf: usize) -> Vec<Way> {
        let m = self.machine;
        let of = |state: usize| {
            let all = m.states[state].transitions.iter().enumerate().filter(move |(_, t)| m.permits(leaf, state, t));
            all.map(move |(index, _)| Way { state, index })
        };
        m.path(leaf).flat_map(of).collect()
    }

    /// Takes a transition in an innermost state.
    fn change(&self, leaf: usize, way: Way) -> Change {
        let m = self.machine;
        let target = m.states[way.state].transitions[way.index].target;
        let mut actions = Vec::new();
        let stays = self.kept(way.state, target);
        for s in m.path(leaf).take_while(|&s| s != stays) {
            actions.extend(&m.states[s].exit);
        }
        for s in self.entered(stays, target) {
            actions.extend(self.entering(s));
        }
        Change { leaf: m.leaf(target), actions }
    }

    /// The innermost state that a transition does not leave: it contains both the transition and its target.
    fn kept(&self, state: usize, target: usize) -> usize {
        let m = self.machine;
        m.path(state).find(|&s| m.is_around(s, target)).unwrap_or(0)
    }

    /// States that are entered from `stays` on, from the outside in.
    fn entered(&self, stays: usize, target: usize) -> Vec<usize> {
        let m = self.machine;
        let mut entered: Vec<usize> = m.path(m.leaf(target)).take_while(|&s| s != stays).collect();
        entered.reverse();
        entered
    }

    /// Innermost states that the machine can be in.
    pub fn leaves(&self) -> BTreeSet<usize> {
        self.nodes.iter().map(|n| n.leaf).collect()
    }

    /// Nodes of an innermost state.
    pub fn nodes_of(&self, leaf: usize) -> impl Iterator<Item = usize> + '_ {
        (0..self.nodes.len()).filter(move |&n| self.nodes[n].leaf == leaf)
    }

    /// The values that conditions read at a node, where they follow from the variables of the machine.
    pub fn values_at(&self, node: usize) -> &[Option<Value>] {
        self.environments.values(self.nodes[node].environment)
    }

    /// True if an event may occur in an innermost state, besides those that the machine has raised before.
    pub fn may_occur(&self, leaf: usize, event: usize) -> bool {
        event < self.declared_events
            || self.elsewhere.raised.contains(&event)
            || self.arriving.get(&leaf).is_some_and(|all| all.contains(&event))
    }

    /// True if the stack of an innermost state has a task.
    fn runs(&self, leaf: usize, task: usize) -> bool {
        let levels = self.machine.stack(leaf).map(|s| &self.program.stacks[s].levels);
        let beside = self.elsewhere.beside(self.machine, leaf).flat_map(|s| &self.program.stacks[s].levels);
        levels.into_iter().flatten().chain(beside).flat_map(|l| &l.members).any(|m| m.task == task)
    }

    fn trigger(&self, way: Way) -> &'e Trigger {
        &self.machine.states[way.state].transitions[way.index].trigger
    }
}

/// Tasks whose outputs are signals, by the signal.
fn outputs(program: &Program) -> BTreeMap<usize, usize> {
    let task = |name: &str| {
        let (task, output) = name.rsplit_once('.')?;
        program.tasks.iter().position(|t| {
            t.name == task && stdlib_tasks::find(&t.kind).is_some_and(|k| k.outputs.iter().any(|o| o.name == output))
        })
    };
    let signals = program.interface.signals.iter().enumerate();
    signals.filter_map(|(s, signal)| Some((s, task(&signal.name)?))).collect()
}
