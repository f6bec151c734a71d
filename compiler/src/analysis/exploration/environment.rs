//! Variables of the machine whose values are known: initial values, and those that actions set to constants or compute
//! from other known values. A variable with many values counts as unknown.

use std::collections::{BTreeMap, BTreeSet};

use runtime::program::{Interface, MachineAction, MachineProgram, Op, Program, Tape};

use crate::analysis::conditions::{CLOCK, Conditions, Key, Leaf, Value};
use crate::expr::Graph;

/// Largest number of values of a variable that are told apart.
const VALUES: usize = 16;

/// Knowledge of a variable.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Held {
    /// Bits of its numbers.
    Known(Vec<u64>),
    /// It has no value.
    Absent,
    /// It may have any value.
    Unknown,
}

/// All environments that were found, by their index.
pub(super) struct Environments<'e> {
    interface: &'e Interface,
    graph: &'e Graph,
    /// Variables that are known at times, by their index among the signals.
    tracked: Vec<usize>,
    /// Assignments of `set`, by action.
    settings: BTreeMap<usize, Setting<'e>>,
    /// For each value that conditions read, the nodes that it needs, if it depends on tracked variables alone.
    needs: Vec<Option<Vec<usize>>>,
    all: Vec<Vec<Held>>,
    /// For each environment, the values that conditions read, where they are known.
    values: Vec<Vec<Option<Value>>>,
    index: BTreeMap<Vec<Held>, usize>,
    /// Values of each tracked variable so far.
    seen: Vec<BTreeSet<Vec<u64>>>,
}

/// An assignment.
struct Setting<'e> {
    variable: usize,
    /// Operations of the table of values that the expression reads.
    tape: Tape,
    initial: &'e [f64],
    expression: &'e stdlib_tasks::expression::Expression,
}

/// Results of operations, as far as they are known.
fn results(ops: &[Op], leaf: impl Fn(Op) -> Option<f64>) -> Vec<Option<f64>> {
    let mut known: Vec<Option<f64>> = Vec::with_capacity(ops.len());
    for &op in ops {
        known.push(result(op, |a| known[a], &leaf));
    }
    known
}

fn result(op: Op, operand: impl Fn(usize) -> Option<f64>, leaf: &impl Fn(Op) -> Option<f64>) -> Option<f64> {
    match op {
        Op::T | Op::Time | Op::Input(_) | Op::State(_) | Op::Signal(_) | Op::Trajectory(_) => leaf(op),
        _ => {
            let known = op.operands().into_iter().flatten().all(|a| operand(a).is_some());
            known.then(|| op.value(|a| operand(a).unwrap_or(f64::NAN), |_| f64::NAN))
        }
    }
}

impl<'e> Environments<'e> {
    /// The environment at the start, before any action.
    pub fn new(
        program: &'e Program,
        machine: &'e MachineProgram,
        graph: &'e Graph,
        conditions: &Conditions,
        elsewhere: &BTreeSet<usize>,
    ) -> Environments<'e> {
        let interface = &program.interface;
        let (mut changed, mut settings) = (BTreeSet::new(), BTreeMap::new());
        for (a, action) in machine.actions.iter().enumerate() {
            match &action.own {
                Some(MachineAction::Set { variable, value }) => {
                    changed.insert(*variable);
                    let tape = program.values.tape.only(&value.inputs.iter().copied().collect());
                    let initial = &program.values.initial;
                    settings.insert(a, Setting { variable: *variable, tape, initial, expression: value });
                }
                Some(MachineAction::Clear(variable)) => {
                    changed.insert(*variable);
                }
                Some(MachineAction::Tare(_)) | None => {}
            }
        }
        let starts = |s: usize| interface.signals[s].variable.as_ref().is_some_and(|v| v.value.is_some());
        // One that is set elsewhere may have any value at any tick.
        let known = |s: usize| (changed.contains(&s) || starts(s)) && !elsewhere.contains(&s);
        let tracked: Vec<usize> = (0..interface.signals.len()).filter(|&s| known(s)).collect();
        let initial = tracked.iter().map(|&s| {
            let value = interface.signals[s].variable.as_ref().and_then(|v| v.value.as_ref());
            value.map_or(Held::Absent, |v| Held::Known(v.iter().map(|x| x.to_bits()).collect()))
        });
        let initial: Vec<Held> = initial.collect();
        let seen = vec![BTreeSet::new(); tracked.len()];
        let (all, values, index) = (Vec::new(), Vec::new(), BTreeMap::new());
        let mut out = Environments { interface, graph, tracked, settings, needs: Vec::new(), all, values, index, seen };
        out.needs = conditions.variables.iter().map(|v| out.needed(&v.key)).collect();
        out.intern(initial, conditions);
        out
    }

    /// Nodes that a value needs, operands first; `None` if it depends on anything but tracked variables.
    fn needed(&self, key: &Key) -> Option<Vec<usize>> {
        let roots: Vec<usize> = match key {
            Key::Present(signal) => return self.tracked.contains(signal).then(Vec::new),
            Key::Flag(term) => vec![term.node],
            Key::Number(terms) => terms.iter().map(|t| t.0.node).collect(),
        };
        let (mut needed, mut open) = (BTreeSet::new(), roots);
        while let Some(node) = open.pop() {
            if node == CLOCK {
                return None;
            }
            let op = self.graph.ops()[node];
            let known = match op {
                Op::Signal(k) if k >= self.interface.width() => false,
                Op::Signal(k) => self.interface.signal_of(k).is_some_and(|s| self.tracked.contains(&s)),
                Op::T | Op::Time | Op::Input(_) | Op::State(_) | Op::Trajectory(_) => false,
                _ => true,
            };
            if !known {
                return None;
            }
            if needed.insert(node) {
                open.extend(op.operands().into_iter().flatten());
            }
        }
        Some(needed.into_iter().collect())
    }

    /// Knowledge of a variable.
    fn held<'a>(&self, held: &'a [Held], signal: usize) -> &'a Held {
        self.tracked.iter().position(|&s| s == signal).map_or(&Held::Unknown, |i| &held[i])
    }

    /// A number of the table of signals.
    fn number(&self, held: &[Held], k: usize) -> Option<f64> {
        let signal = self.interface.signal_of(k)?;
        let of = &self.interface.signals[signal];
        match (self.held(held, signal), k - of.at) {
            (Held::Unknown, _) => None,
            (Held::Absent, 0) => Some(-1.0),
            (Held::Absent, _) => Some(f64::NAN),
            (Held::Known(_), 0) => Some(1.0),
            (Held::Known(numbers), i) => numbers.get(i - 1).map(|&b| f64::from_bits(b)),
        }
    }

    /// Index of an environment.
    fn intern(&mut self, held: Vec<Held>, conditions: &Conditions) -> usize {
        if let Some(&known) = self.index.get(&held) {
            return known;
        }
        let values = conditions.variables.iter().zip(&self.needs).map(|(v, needs)| {
            let needs = needs.as_ref()?;
            self.value(&held, &v.key, needs)
        });
        self.values.push(values.collect());
        self.all.push(held.clone());
        self.index.insert(held, self.all.len() - 1);
        self.all.len() - 1
    }

    /// A value that conditions read.
    fn value(&self, held: &[Held], key: &Key, needs: &[usize]) -> Option<Value> {
        let mut known: BTreeMap<usize, f64> = BTreeMap::new();
        for &node in needs {
            let leaf = |op| match op {
                Op::Signal(k) => self.number(held, k),
                _ => None,
            };
            let x = result(self.graph.ops()[node], |a| known.get(&a).copied(), &leaf)?;
            known.insert(node, x);
        }
        match key {
            Key::Present(signal) => match self.held(held, *signal) {
                Held::Unknown => None,
                is => Some(Value::Truth(*is != Held::Absent)),
            },
            Key::Flag(term) => match known.get(&term.node)? {
                x if x.is_nan() => Some(Value::Absent),
                x => Some(Value::Truth(*x > 0.0)),
            },
            Key::Number(terms) => {
                let mut sum = 0.0;
                for (term, factor) in terms {
                    sum += f64::from_bits(*factor) * known.get(&term.node)?;
                }
                Some(if sum.is_nan() { Value::Absent } else { Value::Number(sum) })
            }
        }
    }

    /// The values that conditions read, where the environment knows them.
    pub fn values(&self, environment: usize) -> &[Option<Value>] {
        &self.values[environment]
    }

    /// The environment after some actions, in their order.
    pub fn after(
        &mut self,
        environment: usize,
        machine: &MachineProgram,
        actions: &[usize],
        conditions: &Conditions,
    ) -> usize {
        if !actions.iter().any(|&a| machine.actions[a].own.is_some()) {
            return environment;
        }
        let mut held = self.all[environment].clone();
        for &a in actions {
            match &machine.actions[a].own {
                Some(MachineAction::Set { variable, .. }) => {
                    let value = self.assigned(&held, &self.settings[&a]);
                    self.put(&mut held, *variable, value);
                }
                Some(MachineAction::Clear(variable)) => self.put(&mut held, *variable, Held::Absent),
                Some(MachineAction::Tare(_)) | None => {}
            }
        }
        self.intern(held, conditions)
    }

    fn put(&mut self, held: &mut [Held], signal: usize, value: Held) {
        let Some(i) = self.tracked.iter().position(|&s| s == signal) else { return };
        held[i] = match value {
            Held::Known(bits) if !self.seen[i].contains(&bits) && self.seen[i].len() >= VALUES => Held::Unknown,
            Held::Known(bits) => {
                self.seen[i].insert(bits.clone());
                Held::Known(bits)
            }
            other => other,
        };
    }

    fn assigned(&self, held: &[Held], setting: &Setting) -> Held {
        let leaf = |op| match op {
            Op::Signal(k) => self.number(held, k),
            _ => None,
        };
        let tape = results(&setting.tape.ops, leaf);
        let table = |at: usize| match setting.tape.outputs.iter().find(|o| o.at == at) {
            Some(o) => tape[o.value],
            None => setting.initial.get(at).copied(),
        };
        let own = results(&setting.expression.ops, |op| match op {
            Op::Input(k) => setting.expression.inputs.get(k).and_then(|&at| table(at)),
            _ => None,
        });
        let numbers: Option<Vec<f64>> =
            setting.expression.outputs.iter().map(|&o| own.get(o).copied().flatten()).collect();
        match numbers {
            Some(numbers) if numbers.iter().all(|x| x.is_finite()) => {
                Held::Known(numbers.into_iter().map(f64::to_bits).collect())
            }
            Some(_) if self.interface.signals[setting.variable].optional => Held::Absent,
            // The variable keeps its value, and a fault occurs.
            _ => Held::Unknown,
        }
    }

    /// Variables that are known at times.
    pub fn tracked(&self) -> BTreeSet<usize> {
        self.tracked.iter().copied().collect()
    }

    /// True if the value that conditions read depends on a variable among these signals.
    pub fn reads(&self, conditions: &Conditions, value: usize, signals: &BTreeSet<usize>) -> bool {
        let leaves = &conditions.variables[value].leaves.all;
        leaves.iter().any(|leaf| matches!(leaf, Leaf::Signal(s, _) if signals.contains(s)))
    }
}
